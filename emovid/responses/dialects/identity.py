"""Who gave the answers of a table with a row for each, where no column has a name that says so."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from emovid.csv_reader import Table
from emovid.errors import SourceError, quoted
from emovid.responses.dialects.columns import POSITION, TRUTH, column
from emovid.responses.dialects.parsed_export import Column, Known
from emovid.responses.dialects.people import NUMBERS, PARTICIPANT, TRAITS, People, who
from emovid.responses.key import code_of
from emovid.responses.labels import plain
from emovid.responses.mapping import EACH_ROW

# Words of columns that are measured and name nobody.
_MEASURED_WORDS = (
    "date time timestamp seconds duration rt started ended created modified progress index trial row plays confidence "
    "valence arousal rating comment comments"
)
_MEASURED = frozenset(_MEASURED_WORDS.split())
_SAID = 0.9  # of the rows: those of a column that names people are filled
_AGAIN = 0.1  # of the rows: answers that were sent again, at most
_SEVERAL = 0.5  # of the rows: those of people with several, at least
_SHOWN = 4  # names in a message


@dataclass(frozen=True)
class _Candidate:
    """A column that may name the participants: how many, and whether each has an answer to each video, and no other."""

    place: int
    people: int
    again: int
    is_complete: bool


def who_answered(table: Table, known: Known, video: int, answer: int) -> People:
    """Return the participant of each row: by a column with a known name, else by the only one that is beyond doubt.

    Beyond doubt is a column each of whose values has one answer to each video. Without any column that could name
    participants, a table that shows each video once is one participant's, and in any other each row is another's;
    whatever is not said by a name is said in `note`.

    Raises:
        SourceError: if columns could name the participants, and none or several are beyond doubt.
    """
    people = who(table, known, *PARTICIPANT)
    videos = _codes(table.cells[video])
    doubt = "" if known.mapping.participant or len(table.lines) < 2 else _doubt(table, people, videos)
    if not doubt:
        return people
    found = _candidates(table, known, videos, {video, answer, people.place})
    certain = [candidate for candidate in found if candidate.is_complete]
    if len(certain) == 1 and people.place is None:
        return _by(table, certain[0], videos.nunique())
    if found:
        raise SourceError(table.file, f"{doubt}, and {_which(table, certain or found)}", 1)
    if people.ids.duplicated().any():
        return people  # answers that are given again are rejected, and said
    if people.place is None and not videos.duplicated().any():
        note = "no column tells participants apart, and no video stands twice: all answers are taken as one person's"
        alone = pd.Series(Path(table.file).stem, index=table.cells.index, dtype="str")
        return People(alone, None, {}, note=note)
    return replace(people, note=f"{doubt}: each row is taken as another person's")


def likely_participant(table: Table, known: Known, video: int, answer: int) -> int | None:
    """Return the column that names the participants, by the map or a known name, or the likeliest of those that may."""
    if known.mapping.participant:
        return column(table, known.mapping.participant)
    people, videos = who(table, known, *PARTICIPANT), _codes(table.cells[video])
    if not _doubt(table, people, videos):
        return people.place
    found = _candidates(table, known, videos, {video, answer, people.place})
    return found[0].place if found else people.place


def _codes(videos: Column) -> Column:
    return videos.map({cell: code_of(str(cell)) for cell in videos.unique()})


def _by(table: Table, found: _Candidate, videos: int) -> People:
    name = quoted(table.names[found.place])
    note = f"participants are told apart by {name}: each of its {found.people} values answers all {videos} videos once"
    return People(table.cells[found.place], found.place, {}, note=note)


def _doubt(table: Table, people: People, videos: Column) -> str:
    """Return why a column may not name the participants though it is called so, or that there is none; else ""."""
    if people.place is None:
        return "no known column tells participants apart"
    name = table.names[people.place]
    if plain(name) not in map(plain, NUMBERS):
        return ""
    if not people.ids.duplicated().any():
        return f"{quoted(name)} differs in each row"
    again = pd.DataFrame({"person": people.ids, "video": videos})[videos != ""].duplicated().mean()
    return f"{quoted(name)} has many answers to one video" if again > _AGAIN else ""


def _which(table: Table, found: list[_Candidate]) -> str:
    names = [table.names[candidate.place] for candidate in found]
    could = " or ".join(map(quoted, names[:_SHOWN])) + (" ..." if len(names) > _SHOWN else "")
    return (
        f"{could} may; expected map.yaml: participant: {names[0]}, or {EACH_ROW} if no two are one person's (emovid "
        "study columns writes a map)"
    )


def _candidates(table: Table, known: Known, videos: Column, beside: Collection[int | None]) -> list[_Candidate]:
    """Return the columns that may name the participants, the likeliest first."""
    said = (*known.mapping.groups.values(), *known.groups, *POSITION, *TRUTH)
    taken = {*beside, *(column(table, title) for title in said)}
    found = [_candidate(table, place, videos) for place in range(len(table.names)) if place not in taken]
    return sorted((one for one in found if one), key=lambda one: (not one.is_complete, one.again, one.place))


def _candidate(table: Table, place: int, videos: Column) -> _Candidate | None:
    if set(plain(table.names[place]).split()) & (_MEASURED | TRAITS):
        return None
    rows = pd.DataFrame({"person": table.cells[place], "video": videos})[videos != ""]
    filled = rows[rows["person"] != ""]
    if filled.empty or len(filled) < _SAID * len(rows) or _is_measured(filled["person"]):
        return None
    people, again = filled["person"].nunique(), int(filled.duplicated().sum())
    if people < 2 or again > _AGAIN * len(filled) or filled["person"].duplicated(keep=False).mean() < _SEVERAL:
        return None
    is_complete = not again and len(filled) == len(rows) == people * rows["video"].nunique()
    return _Candidate(place, people, again, is_complete)


def _is_measured(cells: Column) -> bool:
    """Return whether most cells are decimal numbers: nobody is called 0.77."""
    return bool(cells.str.fullmatch(r"[+-]?\d*[.,]\d+").mean() > 0.5)
