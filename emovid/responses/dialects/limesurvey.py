"""LimeSurvey: question codes, texts or both in the header; answers in full or as codes; perhaps times."""

import re
from dataclasses import replace

from emovid.csv_reader import Table
from emovid.responses.dialects.columns import column
from emovid.responses.dialects.generic import read_wide
from emovid.responses.dialects.parsed_export import Known, Raw
from emovid.responses.labels import plain

_TOOL = (
    ("id", "response id"),
    ("submitdate", "date submitted"),
    ("lastpage", "last page"),
    ("startlanguage", "start language"),
    ("seed", "seed"),
    ("startdate", "date started"),
    ("datestamp", "date last action"),
    ("ipaddr", "ip address"),
    ("refurl", "referrer url"),
    ("interviewtime", "total time"),
)


def recognises(table: Table, _: Known) -> bool:
    """Return whether a table has an id, a date of submission, and one of the tool's other columns."""
    names = {plain(name) for name in _split(table).names}
    first, submitted, *others = (bool(names & set(either)) for either in _TOOL)
    return first and submitted and any(others)


def read(table: Table, known: Known) -> Raw:
    """Read one row for each response; those never submitted are left out."""
    table = _split(table)
    place = column(table, *_TOOL[1])
    assert place is not None  # it was recognised by it
    skip = [name for either in _TOOL for name in either]
    skip += [name for name in table.names if re.search(r"time\W*$|^(question|group) ?time", name.casefold())]
    return read_wide(table, known, *_TOOL[0], reasons={"partial": table.cells[place] == ""}, skip=skip)


def _split(table: Table) -> Table:
    """Return a table whose header is `code. text` with the codes as names and the texts as texts."""
    parts = [re.fullmatch(r"(\w+(?:\[\w+\])*)\. (.*)", name) for name in table.names]
    if not (parts[0] and parts[0][1] == "id"):
        return table
    names = tuple(part[1] if part else name for part, name in zip(parts, table.names, strict=True))
    texts = tuple(part[2] if part else name for part, name in zip(parts, table.names, strict=True))
    return replace(table, names=names, texts=texts)
