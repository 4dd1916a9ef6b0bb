"""`emovid study columns`: the role of each column of an export with the evidence, and a map.yaml to edit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from emovid.csv_reader import Table, coded, joined_table
from emovid.errors import SourceError, quoted
from emovid.responses.choice_columns import with_choices
from emovid.responses.columns import column, holds_answers, label_columns, video_column
from emovid.responses.dialects.registry import Dialect, dialect_of
from emovid.responses.dialects.tables import code_in, codes_of_rows
from emovid.responses.export_files import files_in, open_table, short_names
from emovid.responses.labels import number
from emovid.responses.mapping import EACH_FILE, map_text
from emovid.responses.parsed_export import ANSWER_TO, Known, ParsedExport
from emovid.responses.participants import PARTICIPANT, likely_participant
from emovid.responses.read import known_from, read_pooled

_EXAMPLES = 3
_MOST_CODES = 12


@dataclass(frozen=True)
class ColumnDescription:
    """One column of an export.

    Attributes:
        name: its header.
        text: its question, if the file has one besides the header, otherwise "".
        role: "participant", "video", "answer", "answer to z8r4", "true emotion", "order", "group", or ""; with a
            question mark where the table cannot be read yet.
        evidence: why it has this role.
        examples: some of its values.
    """

    name: str
    text: str
    role: str
    evidence: str
    examples: tuple[str, ...]


@dataclass(frozen=True)
class Description:
    """Roles detected in an export.

    Attributes:
        file: its name.
        dialect: in words, or "" if none was recognized.
        problem: why it cannot be read as it is, or "".
        columns: in the order of the file.
        map_yaml: text of a map.yaml to edit; it works as it is unless there is a problem, which it names.
    """

    file: str
    dialect: str
    problem: str
    columns: tuple[ColumnDescription, ...]
    map_yaml: str


def describe_columns(
    path: Path, key: Path | None = None, mapping: Path | None = None, labels: Sequence[str] | None = None
) -> Description:
    """Return what is detected in one export, or in a folder whose files have the format of its first export.

    Raises:
        SourceError: for a file that is not a table, and for an invalid key or map.
    """
    known = known_from(key, mapping, labels)
    tables = _tables(path, known) if path.is_dir() else [(with_choices(open_table(path)[0], known), None)]
    known = replace(known, file_names=short_names(table.file for table, _ in tables))
    dialect, problem, raw = "", "", None
    try:
        pairs = [(table, found or dialect_of(table, known)) for table, found in tables]
        dialect = pairs[0][1].name
        raw = next(read_pooled(pairs, known))[1]
    except SourceError as error:
        problem = error.message
    names = tables[0][0].names
    table = joined_table([table for table, _ in tables if table.names == names])
    roles = _roles(table, known, raw)
    evidence = {} if raw is None else raw.evidence
    columns = tuple(_column(table, place, roles, evidence) for place in range(len(table.names)))
    return Description(tables[0][0].file, dialect, problem, columns, _map(table, known, raw, columns, problem))


def _tables(folder: Path, known: Known) -> list[tuple[Table, Dialect | None]]:
    """Return the tables of a folder that have the format of the first export."""
    found: list[tuple[Table, Dialect | None]] = []
    for file in files_in(folder):
        try:
            table = with_choices(open_table(file)[0], known)
            dialect = dialect_of(table, known)
        except SourceError:
            continue
        if not found or found[0][1] == dialect:
            found.append((table, dialect))
    if not found:
        raise SourceError(str(folder), "no file here is an export of a survey; name one of them")
    return found


def _roles(table: Table, known: Known, raw: ParsedExport | None) -> Mapping[str, str]:
    """Return the role of each column; likely ones with a question mark if the table cannot be read."""
    if raw is not None:
        places = [column(table, title) for title in _groups(table, known, raw).values()]
        return {table.names[place]: "group" for place in places if place is not None} | dict(raw.roles)
    roles = {name: "answer?" for place, name in enumerate(table.names) if holds_answers(table, place, known)}
    try:
        video = video_column(table, known)
    except SourceError:
        return roles
    person = column(table, *PARTICIPANT)
    if video is not None:
        truth, answers = label_columns(table, known, video, person)
        codes = codes_of_rows(table, known, video)
        try:
            person = likely_participant(table, known, codes, {video, *answers, *truth})
        except SourceError:
            person = None
        roles = {table.names[video]: "video?"} | {table.names[place]: "answer?" for place in answers}
        roles |= {table.names[place]: "true emotion?" for place in truth}
    return roles if person is None else roles | {table.names[person]: "participant?"}


def _column(table: Table, place: int, roles: Mapping[str, str], evidence: Mapping[str, str]) -> ColumnDescription:
    cells = table.cells[place]
    examples = tuple(quoted(cell, 30)[1:-1] for cell in list(filter(None, coded(cells)[1]))[:_EXAMPLES])
    name, text = table.names[place], table.texts[place]
    role = roles.get(name, "")
    return ColumnDescription(name, "" if text == name else text, role, evidence.get(name, ""), examples)


def _map(
    table: Table, known: Known, raw: ParsedExport | None, columns: Sequence[ColumnDescription], problem: str
) -> str:
    """Return a map.yaml with what was found; texts of answers that are not labels are listed to be given one."""
    places = [place for place, c in enumerate(columns) if c.role.startswith("answer")]
    answers = [table.cells[place] for place in places] if raw is None else [raw.answers["answer"]]
    words = sorted({number(word) for cells in answers for word in coded(cells)[1] if word})
    unknown = [word for word in words if known.labels.find(word) is None][:_MOST_CODES]
    named = _named(columns, known)
    if raw is not None and set(raw.participants.index) <= set(known.file_names.values()):
        named = {"participant": known.mapping.participant or EACH_FILE} | named
    text = map_text(named, _videos(known, columns), _groups(table, known, raw), unknown)
    labels = "the label of each text under answers; a text without one is a missing answer" if unknown else ""
    decision = " ".join(problem.split()) or labels
    return f"# To decide: {decision}\n{text}" if decision else text


def _named(columns: Sequence[ColumnDescription], known: Known) -> dict[str, str]:
    """Return the columns of participants, and of videos, answers and true emotions where there is one, by their key."""
    found: dict[str, list[str]] = {}
    for c in columns:
        found.setdefault(c.role.rstrip("?"), []).append(c.name)
    keys = {"participant": "participant"}
    names = [c.name for c in columns]
    if all(len(found.get(role, ())) == 1 == names.count(found[role][0]) for role in ("video", "answer")):
        keys |= {"video": "video", "answer": "response"}
        if not known.codes and len(found.get("true emotion", ())) == 1:
            keys |= {"true emotion": "truth"}
    elif len(found.get("video", ())) == 1:
        keys |= {"video": "video"}
    return {key: found[role][0] for role, key in keys.items() if role in found}


def _groups(table: Table, known: Known, raw: ParsedExport | None) -> dict[str, str]:
    """Return the column of each group that has one."""
    names = [] if raw is None else list(map(str, raw.participants.columns))
    titles = {name: known.mapping.groups.get(name, name) for name in names}
    return {name: title for name, title in titles.items() if column(table, title) is not None}


def _videos(known: Known, columns: Sequence[ColumnDescription]) -> dict[str, str] | list[str]:
    """Return the code of each column of answers ("" where it is unknown), a list if columns have one name."""
    asked = [c for c in columns if c.role.startswith("answer")]
    if len(asked) < 2:
        return {}
    if len({c.name for c in asked}) < len(asked):
        return list(known.mapping.codes_in_order) or [""] * len(asked)
    return {c.name: c.role.partition(ANSWER_TO)[2] or code_in(c.name, known) or code_in(c.text, known) for c in asked}
