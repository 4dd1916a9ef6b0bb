"""PCIbex and Ibex: results without a header; comments name the columns, and there is one row for each event.

A participant is one submission: the time of reception and the hash of the address. The video of an answer is a logged
column, or else the Video element of the same trial.
"""

import csv
import re
from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table, cells_that, table_of, translated
from emovid.responses.columns import Format, holds_videos
from emovid.responses.dialects.tables import read_long
from emovid.responses.exclusions import Marks, is_practice
from emovid.responses.parsed_export import Column, Known, ParsedExport
from emovid.responses.participants import PARTICIPANT

_COLUMN = re.compile(r"#\s*(\d+)\.\s*(.+?)\.?\s*$")
_ELEMENT, _NAME, _PARAMETER, _VALUE = "PennElementType", "PennElementName", "Parameter", "Value"
_RECEIVED = ("Results reception time", "Time results were received")
_HASH = "MD5 hash of participant's IP address"
_ITEM = ("Order number of item", "Item number")
_LABEL = ("Label", "Type")


def is_pcibex(text: bytes) -> bool:
    """Return whether a file has the comments that name the columns of PCIbex."""
    return text.lstrip().startswith(b"#") and b"Columns below this comment are as follows" in text


def pcibex_table(text: str, file: str) -> Table:
    """Return the rows of a results file; a column that a row lacks is empty."""
    names: dict[int, str] = {}
    rows: list[tuple[int, dict[str, str]]] = []
    for line, content in enumerate(text.splitlines(), start=1):
        if found := _COLUMN.match(content):
            place = int(found[1])
            names = {i: name for i, name in names.items() if i < place} | {place: found[2]}
        elif content.strip() and not content.startswith("#"):
            cells = next(csv.reader([content]))
            rows.append((line, {names.get(i, f"column {i}"): cell for i, cell in enumerate(cells, start=1)}))
    head = list(dict.fromkeys(name for _, row in rows for name in row)) or [_VALUE]
    return table_of(file, [(0, head), *((line, [row.get(name, "") for name in head]) for line, row in rows)])


def recognizes(table: Table, _: Known) -> bool:
    """Return whether a table has the columns of events of PennController."""
    return {_ELEMENT, _PARAMETER, _VALUE} <= set(table.names)


def read(table: Table, known: Known) -> ParsedExport:
    """Read the events whose value is a label, in trials that show a video; trials labeled practice are left out."""
    table = replace(table, cells=table.cells.mask(table.cells == "NULL", ""))
    submission = _cells(table, *_RECEIVED) + " " + _cells(table, _HASH)
    logged = [
        place
        for place, name in enumerate(table.names)
        if name not in (_NAME, _VALUE) and holds_videos(table, place, known)
    ]
    if not (known.mapping.video or logged):
        table = table.with_column("video", _video_of_trial(table, known, submission))
    table = table.with_column("submission", submission)
    is_tool = lambda name: name in _TOOL or name in ("video", "submission")  # noqa: E731
    form = Format((), (_VALUE,), _ITEM, (*(n for n in PARTICIPANT if n in table.names), "submission"), is_tool)
    return read_long(table, known, form, _marks, lambda rows, _, recognized: _is_choice(rows, known, recognized))


_TOOL = (*_RECEIVED, _HASH, "Controller name", *_ITEM, "Inner element number", "Element number", *_LABEL,
         "Latin Square Group", "Group", _ELEMENT, _NAME, _PARAMETER, _VALUE, "EventTime", "Comments")  # fmt: skip


def _cells(table: Table, *names: str) -> Column:
    place = next((table.names.index(name) for name in names if name in table.names), None)
    return pd.Series("", index=table.cells.index, dtype="str") if place is None else table.cells[place]


def _video_of_trial(table: Table, known: Known, submission: Column) -> Column:
    """Return the video of each trial: the only one that an event of the trial names."""
    trials = submission + " " + _cells(table, *_ITEM)
    named = pd.concat([_cells(table, _NAME), _cells(table, _VALUE)]).reset_index(drop=True)
    codes = translated(named, lambda text: known.code(text) if known.emotion(text) else "")
    pairs = pd.DataFrame({"trial": pd.concat([trials, trials]).to_numpy(), "code": codes})
    if not known.codes:  # the names of answers are emotions, too: only elements that are videos count
        is_video = (_cells(table, _ELEMENT) == "Video").to_numpy()
        pairs = pairs[[*is_video, *([False] * len(is_video))]]
    pairs = pairs[pairs["code"] != ""].drop_duplicates()
    pairs = pairs[~pairs["trial"].duplicated(keep=False)]
    videos = dict(zip(pairs["trial"], pairs["code"], strict=True))
    return translated(trials, lambda trial: videos.get(trial, ""))


def _is_choice(table: Table, known: Known, recognized: Column) -> Column:
    """Return the events in trials with a video whose value is a label."""
    return recognized & cells_that(_cells(table, _VALUE), known.labels.is_label)


def _marks(table: Table) -> Marks:
    return Marks(rows={"practice": cells_that(_cells(table, *_LABEL), is_practice)})
