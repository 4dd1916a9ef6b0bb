"""Participants: who they are, which of them are left out, and the groups they belong to."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Table
from emovid.errors import SourceError
from emovid.responses.dialects.columns import column, named
from emovid.responses.dialects.parsed_export import Column, Known
from emovid.responses.labels import number, plain
from emovid.responses.mapping import EACH_ROW

# What surveys call a person, and what may follow it: the likelier first.
_PERSONS = (
    "participant", "prolific", "worker", "subject", "subj", "respondent", "proband", "versuchsperson", "teilnehmer",
    "vp", "vpn", "ppt", "pp", "person", "user", "observer", "rater", "judge",
)  # fmt: skip
_MARKS = ("", "_id", "id", "_code", "code", "_nr", "nr", "_no", "_number", "number", "_pid", "_name", "name")
NUMBERS = ("response_id", "session", "session_id", "sessionid", "id")  # names that may number rows instead
PARTICIPANT = (*(person + mark for person in _PERSONS for mark in _MARKS), "pid", "case", *NUMBERS)
_TRAIT_WORDS = "gender sex age background robotics experience education country nationality language"
# Words of columns that say something of the session, of a trial, or of the person that no table of a paper should hold.
_PRIVATE_WORDS = (
    "ip email mail name phone latitude longitude location address date time timestamp url browser agent version seed "
    "token referrer referer user key status progress finished duration collector started ended created modified "
    "prolific pid worker assignment index file hash comment comments seconds rt "
    "plays choices confidence valence arousal"
)
TRAITS, _PRIVATE = frozenset(_TRAIT_WORDS.split()), frozenset(_PRIVATE_WORDS.split())
MOST_LEVELS = 12  # of a group


@dataclass(frozen=True, eq=False)
class People:
    """The participants of a table's rows.

    Attributes:
        ids: of each row.
        place: the column that names them, None where there is none.
        dropped: participants whose rows are no more in the table, by reason.
        numbered: whether they are the numbers of their rows.
        note: as in `Raw`.
    """

    ids: Column
    place: int | None
    dropped: Mapping[str, int]
    numbered: bool = False
    note: str = ""


def who(table: Table, known: Known, *names: str, alone: str = "") -> People:
    """Return the participant of each row, from the first of these columns that there is.

    Args:
        table: the file.
        known: whose map may say the column.
        names: of columns.
        alone: where no column tells, all rows are of this participant; if "", each row is of its own.

    Raises:
        SourceError: if the map's column is not there.
    """
    said = known.mapping.participant
    each_row = said == EACH_ROW and column(table, said) is None
    place = named(table, said, "participant") if said and not each_row else None if said else column(table, *names)
    if place is not None:
        return People(table.cells[place], place, {})
    if alone and not each_row:
        return People(pd.Series(alone, index=table.cells.index, dtype="str"), None, {})
    numbers = pd.Series(np.arange(1, len(table.lines) + 1).astype(str), index=table.cells.index)
    return People(numbers, None, {}, numbered=True)


def without(table: Table, known: Known, people: People, reasons: Mapping[str, Column]) -> tuple[Table, People]:
    """Leave out participants as a whole.

    Args:
        table: the file.
        known: whose map may drop the values of columns; those that nobody has are counted, too, lest one be misspelled.
        people: of its rows.
        reasons: rows (True) whose participants go, by reason; a participant is counted under the first.

    Returns:
        the table and the people without them.
    """
    said = _dropped_by_map(table, known)
    masks = {reason: np.asarray(mask, dtype=bool) for reason, mask in reasons.items()} | said
    codes, names = pd.factorize(people.ids)
    out = np.zeros(len(names), dtype=bool)
    dropped = dict(people.dropped)
    for reason, mask in masks.items():
        hit = np.zeros(len(names), dtype=bool)
        hit[codes[mask]] = True
        count = int((hit & ~out).sum())
        if count or reason in said:
            dropped[reason] = dropped.get(reason, 0) + count
        out |= hit
    kept = ~out[codes]
    return table.rows(kept), replace(people, ids=people.ids[kept].reset_index(drop=True), dropped=dropped)


def groups_of(table: Table, known: Known, ids: Column, used: Collection[int | None] = ()) -> pd.DataFrame:
    """Return the groups of each participant: those of the map, those asked for, and columns that look like one.

    Raises:
        SourceError: if a group that is asked for changes within a participant.
    """
    codes, people = pd.factorize(ids)
    frame = pd.DataFrame(index=pd.Index(people, name="participant", dtype="str"))
    chosen = _asked(table, known)
    for name, place in chosen.items():
        if not _is_constant(codes, table.cells[place]):
            message = "changes within a participant; expected one value: it is no group"
            raise SourceError(table.file, message, 1, table.names[place])
        frame[name] = _first(codes, len(people), table.cells[place])
    for place, title in enumerate(table.names):
        if place not in used and place not in chosen.values() and title not in frame and _is_group(table, place, codes):
            frame[title] = _first(codes, len(people), table.cells[place])
    return frame


def groups_of_pairs(rows: Iterable[tuple[str, str, str]]) -> pd.DataFrame:
    """Return the groups of each participant from triples of participant, group and value; the first value counts."""
    frame = pd.DataFrame(list(rows), columns=["participant", "group", "value"], dtype="str")
    frame = frame[frame["value"].str.strip() != ""].drop_duplicates(["participant", "group"])
    order = frame["group"].unique()
    wide = frame.pivot_table(index="participant", columns="group", values="value", aggfunc="first")
    return wide.reindex(columns=order).fillna("").astype("str").rename_axis(columns=None)


def joined(first: pd.DataFrame, second: pd.DataFrame) -> pd.DataFrame:
    """Return the groups of both, of the first where both tell."""
    extra = second[[name for name in second.columns if name not in first.columns]]
    return first.join(extra, how="left").fillna("").astype("str")


def _dropped_by_map(table: Table, known: Known) -> dict[str, NDArray[np.bool_]]:
    masks: dict[str, NDArray[np.bool_]] = {}
    for title, values in known.mapping.drop.items():
        place = column(table, title)
        if place is not None:
            cells = table.cells[place]
            spelled = cells.map(lambda cell: number(cell).casefold())
            masks |= {f"{title} = {value}": (spelled == number(value).casefold()).to_numpy() for value in values}
    return masks


def _asked(table: Table, known: Known) -> dict[str, int]:
    chosen: dict[str, int] = {}
    for name, title in known.mapping.groups.items():
        place = column(table, title)
        if place is not None:
            chosen[name] = place
    for name in known.groups:
        place = _about(table, name)
        if name not in chosen and place is not None:
            chosen[name] = place
    return chosen


def _about(table: Table, name: str) -> int | None:
    """Return the column of that name, or the only one whose header or question has all its words."""
    place = column(table, name)
    if place is not None:
        return place
    words = set(plain(name).split())
    titles = [set(plain(f"{n} {t}").split()) for n, t in zip(table.names, table.texts, strict=True)]
    places = [place for place, title in enumerate(titles) if words <= title]
    return places[0] if len(places) == 1 and words else None


def _is_group(table: Table, place: int, codes: NDArray[np.intp]) -> bool:
    title, cells = set(plain(table.names[place]).split()), table.cells[place]
    levels = cells[cells != ""].nunique()
    if not levels or title & _PRIVATE or not table.names[place]:
        return False
    return bool(levels <= MOST_LEVELS or title & TRAITS) and _is_constant(codes, cells)


def _is_constant(codes: NDArray[np.intp], cells: Column) -> bool:
    """Return whether no participant has two different values, empty cells left out."""
    filled = (cells != "").to_numpy(dtype=bool)
    values, words = pd.factorize(cells[filled])
    people = codes[filled]
    return len(pd.unique(people * max(len(words), 1) + values)) == len(pd.unique(people))


def _first(codes: NDArray[np.intp], people: int, cells: Column) -> list[str]:
    """Return the first value of each participant that is not empty, else ""."""
    filled = (cells != "").to_numpy(dtype=bool)
    values, words = pd.factorize(cells[filled])
    found = np.full(people, len(words))
    found[codes[filled][::-1]] = values[::-1]  # of equal places the last that is written stays: the first row
    texts = [*(number(str(word)) for word in words), ""]
    return [texts[i] for i in found]
