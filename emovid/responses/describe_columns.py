"""What was detected in an export, and a map.yaml to edit: `emovid study columns`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from emovid.csv_reader import Table
from emovid.errors import SourceError, quoted
from emovid.responses.dialects.columns import answer_column, column, holds_answers, video_column
from emovid.responses.dialects.identity import likely_participant
from emovid.responses.dialects.parsed_export import ANSWER_TO, Known, Raw
from emovid.responses.dialects.people import PARTICIPANT
from emovid.responses.dialects.registry import dialect_of
from emovid.responses.dialects.videos import code_in
from emovid.responses.labels import number
from emovid.responses.mapping import map_text
from emovid.responses.read import files_in, known_from, open_table

_EXAMPLES = 3
_MOST_CODES = 12


@dataclass(frozen=True)
class Column:
    """One column of an export.

    Attributes:
        name: its header.
        text: its question, where the file has one apart, else "".
        role: what it was taken as ("participant", "video", "answer", "answer to z8r4", "order", "group"), or "".
        examples: a few of its values.
    """

    name: str
    text: str
    role: str
    examples: tuple[str, ...]


@dataclass(frozen=True)
class Description:
    """What was detected in an export.

    Attributes:
        file: its name.
        dialect: in words, or "" if none was recognised.
        problem: why it cannot be read as it stands, or "".
        columns: in the order of the file.
        map_yaml: the text of a map.yaml to edit.
    """

    file: str
    dialect: str
    problem: str
    columns: tuple[Column, ...]
    map_yaml: str


def describe_columns(
    path: Path, key: Path | None = None, mapping: Path | None = None, labels: Sequence[str] | None = None
) -> Description:
    """Return what is detected in one export, of a folder in the first file that is one.

    Raises:
        SourceError: if it is no table of text, or the key or the map cannot be meant.
    """
    known = known_from(key, mapping, labels)
    path, table = _first_table(path, known) if path.is_dir() else (path, open_table(path)[0])
    dialect, problem, raw = "", "", None
    try:
        found = dialect_of(table, known)
        dialect = found.name
        raw = found.read(table, known)
    except SourceError as error:
        problem = error.message
    roles = _roles(table, known, raw)
    columns = tuple(_column(table, place, roles.get(name, "")) for place, name in enumerate(table.names))
    return Description(str(path), dialect, problem, columns, _map(table, known, raw, columns))


def _first_table(folder: Path, known: Known) -> tuple[Path, Table]:
    for file in files_in(folder):
        try:
            table, _ = open_table(file)
            dialect_of(table, known)
        except SourceError:
            continue
        return file, table
    raise SourceError(str(folder), "no file here is an export of a survey; name one of them")


def _roles(table: Table, known: Known, raw: Raw | None) -> dict[str, str]:
    """Return the role of each column; what only looks like one has a question mark."""
    if raw is not None:
        places = [column(table, title) for title in _groups(table, known, raw).values()]
        return {table.names[place]: "group" for place in places if place is not None} | dict(raw.roles)
    roles = {name: "answer?" for place, name in enumerate(table.names) if holds_answers(table, place, known)}
    video, person = video_column(table, known), column(table, *PARTICIPANT)
    answer = answer_column(table, known, video)
    if video is not None and answer is not None:  # a row for each answer
        person = likely_participant(table, known, video, answer)
        roles = {table.names[video]: "video?", table.names[answer]: "answer?"}
    return roles if person is None else roles | {table.names[person]: "participant?"}


def _column(table: Table, place: int, role: str) -> Column:
    cells = table.cells[place]
    examples = tuple(quoted(str(cell), 30)[1:-1] for cell in cells[cells != ""].unique()[:_EXAMPLES])
    name, text = table.names[place], table.texts[place]
    return Column(name, "" if text == name else text, role, examples)


def _map(table: Table, known: Known, raw: Raw | None, columns: Sequence[Column]) -> str:
    """Return a map.yaml with what was found; the words of answers that are no labels are listed to be given one."""
    places = [place for place, c in enumerate(columns) if c.role.startswith("answer")]
    answers = [table.cells[place] for place in places] if raw is None else [raw.answers["answer"]]
    words = sorted({number(str(word)) for cells in answers for word in cells.unique() if word})
    unknown = [word for word in words if known.labels.find(word) is None][:_MOST_CODES]
    return map_text(_named(columns), _videos(known, columns), _groups(table, known, raw), unknown)


def _named(columns: Sequence[Column]) -> dict[str, str]:
    """Return the columns of participants, and of videos and answers where each has one, by their key in the map."""
    found = {c.role.rstrip("?"): c.name for c in reversed(columns)}
    keys = {"participant": "participant"}
    names = [c.name for c in columns]
    if all(names.count(found.get(role, "")) == 1 for role in ("video", "answer")):
        keys |= {"video": "video", "answer": "response"}
    return {key: found[role] for role, key in keys.items() if role in found}


def _groups(table: Table, known: Known, raw: Raw | None) -> dict[str, str]:
    """Return the column of each group that has one."""
    names = [] if raw is None else list(map(str, raw.participants.columns))
    titles = {name: known.mapping.groups.get(name, name) for name in names}
    return {name: title for name, title in titles.items() if column(table, title) is not None}


def _videos(known: Known, columns: Sequence[Column]) -> dict[str, str] | list[str]:
    """Return the code of each column of answers ("" where it is to be said), a list where columns are named alike."""
    asked = [c for c in columns if c.role.startswith("answer")]
    if len(asked) < 2:
        return {}
    if len({c.name for c in asked}) < len(asked):
        return list(known.mapping.in_order) or [""] * len(asked)
    return {c.name: c.role.partition(ANSWER_TO)[2] or code_in(c.name, known) or code_in(c.text, known) for c in asked}
