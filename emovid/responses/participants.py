"""Participants: the column that identifies them, and the groups they belong to."""

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Table, cells_that, coded
from emovid.errors import SourceError, quoted
from emovid.responses.columns import POSITION, TRUTH, column, is_named, named
from emovid.responses.exclusions import Mask, dropped_by_map
from emovid.responses.labels import number, plain
from emovid.responses.mapping import EACH_FILE, EACH_ROW
from emovid.responses.parsed_export import Column, Known

# Names of a person in surveys, and endings of these names; likely ones first.
_PERSONS = (
    "participant", "prolific", "worker", "subject", "subj", "respondent", "proband", "versuchsperson", "teilnehmer",
    "vp", "vpn", "ppt", "pp", "person", "user", "observer", "rater", "judge", "ptcp", "ppn",
    "teilnehmerin", "teilnehmende", "participante", "sujeto", "sujet", "partecipante", "soggetto", "sujeito",
    "proefpersoon", "deelnemer", "deltager", "deltagare", "forsøksperson", "försöksperson", "osallistuja",
    "koehenkilö", "uczestnik", "osoba", "badany", "účastník", "résztvevő", "katılımcı", "участник", "испытуемый",
    "参加者", "被験者", "実験参加者", "被试", "参与者", "參與者", "受试者", "참가자", "피험자",
)  # fmt: skip
_ENDINGS = ("", "_id", "id", "_code", "code", "_nr", "nr", "_no", "_number", "number", "_pid", "_name", "name")
NUMBERS = ("response_id", "session", "session_id", "sessionid", "id")  # names that can number rows instead
PARTICIPANT = (*(person + ending for person in _PERSONS for ending in _ENDINGS), "pid", "case", *NUMBERS)
_TRAIT_WORDS = "gender sex age background robotics experience education country nationality language"
# Words of columns about the session or a trial, and of personal data that no published table should show.
_PRIVATE_WORDS = (
    "ip email mail name phone latitude longitude location address date time timestamp url browser agent version seed "
    "token referrer referer user key status progress finished duration collector started ended created modified "
    "prolific pid worker assignment index file hash comment comments seconds rt "
    "plays choices confidence valence arousal consent"
)
TRAITS, _PRIVATE = frozenset(_TRAIT_WORDS.split()), frozenset(_PRIVATE_WORDS.split())
# Words of columns that are measured and do not name a person.
_MEASURED = frozenset((
    "date", "time", "timestamp", "seconds", "duration", "rt", "started", "ended", "created", "modified", "progress",
    "index", "trial", "row", "plays", "confidence", "valence", "arousal", "rating", "comment", "comments",
))  # fmt: skip
MOST_LEVELS = 12  # of a group
_FILLED = 0.9  # of the rows: smallest share that a column of participants fills
_REPEATED = 0.1  # of the rows: largest share of answers that were sent again
_MOST_REPEATED = 0.5  # of the rows: largest such share in a column that may name participants at all
_SEVERAL = 0.5  # of the rows: smallest share that belongs to participants with several rows
_SHOWN = 4  # names in a message
_DAMAGED = re.compile(r"[+-]?\d([.,]\d+)?[Ee]\+?\d{2,}")  # a long number as spreadsheets show and save it


@dataclass(frozen=True, eq=False)
class People:
    """The participants of a table's rows.

    Attributes:
        ids: participant of each row.
        place: column that names them, None if there is none.
        dropped: number of participants whose rows are no longer in the table, by reason.
        numbered: whether they are the numbers of their rows.
        note: as in `ParsedExport`.
    """

    ids: Column
    place: int | None
    dropped: Mapping[str, int]
    numbered: bool = False
    note: str = ""


@dataclass(frozen=True)
class _Candidate:
    """A column that can name the participants; complete if each has one answer to each video, and no other."""

    place: int
    people: int
    again: int
    is_complete: bool


def who(table: Table, known: Known, *names: str, by_file: bool = False) -> People:
    """Return the participant of each row, from the first of these columns that exists and is not empty.

    Args:
        table: the file.
        known: whose map can name the column.
        names: names of columns.
        by_file: whether each file belongs to one participant if no column names them; otherwise each row does.

    Raises:
        SourceError: if the map's column does not exist, or a spreadsheet has damaged the ids in a column.
    """
    said = known.mapping.participant
    stated = said in (EACH_ROW, EACH_FILE) and column(table, said) is None
    place = named(table, said, "participant") if said and not stated else None if said else _filled(table, names)
    if place is not None and not said and by_file and _is_in_several_files(table, place):
        place = None
    if place is not None:
        _check_ids(table, place)
        return People(table.cells[place], place, {})
    if said == EACH_FILE or (by_file and said != EACH_ROW):
        return _by_file(table, known)
    numbers = pd.Series(np.arange(1, len(table.lines) + 1).astype(str), index=table.cells.index)
    return People(numbers, None, {}, numbered=True)


def _filled(table: Table, names: Iterable[str]) -> int | None:
    """Return the first of these columns that is not empty; one that numbers sessions must differ between rows."""
    found = [place for name in names if (place := column(table, name)) is not None and (table.cells[place] != "").any()]
    differing = [p for p in found if not is_named(table, p, NUMBERS) or table.cells[p].nunique() > 1]
    return next(iter([*differing, *found]), None)


def _is_in_several_files(table: Table, place: int) -> bool:
    """Return whether a column that may number rows or sessions has one value in several files."""
    if table.origins is None or not is_named(table, place, NUMBERS):
        return False
    pairs = pd.DataFrame({"value": table.cells[place], "file": table.origins}).drop_duplicates()
    return bool(pairs.loc[pairs["value"] != "", "value"].duplicated().any())


def _by_file(table: Table, known: Known, note: str = "") -> People:
    names = [known.file_names.get(file, file) for file in table.files or (table.file,)]
    origins = np.zeros(len(table.lines), dtype=np.int64) if table.origins is None else table.origins
    ids = pd.Series(np.array(names, dtype=object)[origins], index=table.cells.index, dtype="str")
    return People(ids, None, {}, note=note)


def _check_ids(table: Table, place: int) -> None:
    cells = table.cells[place]
    damaged = cells_that(cells, lambda text: bool(_DAMAGED.fullmatch(text))).to_numpy()
    if damaged.any():
        line = int(table.lines[damaged][0])
        message = (
            f"{quoted(str(cells[damaged].iloc[0]))} in {int(damaged.sum())} rows: a spreadsheet has shortened the ids; "
            "expected the file as the survey tool exported it"
        )
        raise SourceError(table.file, message, line, table.names[place])


def who_answered(table: Table, known: Known, codes: Column, used: Collection[int | None]) -> People:
    """Return the participant of each row: by a column with a known name, otherwise by the only one beyond doubt.

    Beyond doubt is a column each of whose values has one answer to each video. If no column can name participants, a
    file that shows each video once belongs to one participant; in any other, each row belongs to another one. The note
    of the result says so.

    Args:
        table: one row for each answer.
        known: whose map can name the column.
        codes: code of the video of each row.
        used: columns with another role.

    Raises:
        SourceError: if columns could name the participants, and none or several are beyond doubt.
    """
    people = who(table, known, *PARTICIPANT)
    doubt = "" if known.mapping.participant or len(table.lines) < 2 else _doubt(table, people, codes)
    if not doubt:
        return people
    found = _candidates(table, known, codes, {*used, people.place})
    certain = [candidate for candidate in found if candidate.is_complete]
    if len(certain) == 1 and people.place is None:
        return _by(table, certain[0], codes.nunique())
    if found:
        raise SourceError(table.file, f"{doubt}, and {_which(table, certain or found)}", 1)
    if people.ids.duplicated().any():
        return people  # repeated answers are rejected later
    alone = "no column identifies participants, and no video is repeated"
    several = f"{alone} within a file: each file is taken as one participant"
    one = f"{alone}: all answers are taken as those of one person"
    by_file = _by_file(table, known, several if len(table.files) > 1 else one)
    if people.place is None and not pd.DataFrame({"file": by_file.ids, "code": codes}).duplicated().any():
        return by_file
    if people.place is None and len(table.files) > 1:
        message = f"{doubt}; expected map.yaml: participant: {EACH_FILE} if a file is one person's, or {EACH_ROW}"
        raise SourceError(table.file, message, 1)
    return replace(people, note=f"{doubt}: each row is taken as another participant")


def likely_participant(table: Table, known: Known, codes: Column, used: Collection[int | None]) -> int | None:
    """Return the column that names the participants, by the map or a known name, or the likeliest of those that can."""
    if known.mapping.participant:
        return column(table, known.mapping.participant)
    people = who(table, known, *PARTICIPANT)
    if not _doubt(table, people, codes):
        return people.place
    found = _candidates(table, known, codes, {*used, people.place})
    return found[0].place if found else people.place


def _by(table: Table, found: _Candidate, videos: int) -> People:
    _check_ids(table, found.place)
    name = quoted(table.names[found.place])
    note = f"participants are identified by {name}: each of its {found.people} values answers all {videos} videos once"
    return People(table.cells[found.place], found.place, {}, note=note)


def _doubt(table: Table, people: People, codes: Column) -> str:
    """Return why a column may not name the participants in spite of its name, or that there is none; otherwise ""."""
    if people.place is None:
        return "no known column identifies participants"
    name = table.names[people.place]
    if plain(name) not in map(plain, NUMBERS):
        return ""
    if not people.ids.duplicated().any():
        return f"{quoted(name)} differs in each row"
    again = pd.DataFrame({"person": people.ids, "video": codes})[codes != ""].duplicated().mean()
    return f"{quoted(name)} has many answers to one video" if again > _REPEATED else ""


def _which(table: Table, found: list[_Candidate]) -> str:
    names = [table.names[candidate.place] for candidate in found]
    could = " or ".join(map(quoted, names[:_SHOWN])) + (" ..." if len(names) > _SHOWN else "")
    each_file = f" (or {EACH_FILE}, if a file is one person's)" if len(table.files) > 1 else ""
    return (
        f"{could} may; expected map.yaml: participant: {names[0]}, or {EACH_ROW} if no two are one person's{each_file} "
        "(emovid study columns writes a map)"
    )


def _candidates(table: Table, known: Known, codes: Column, used: Collection[int | None]) -> list[_Candidate]:
    """Return the columns that can name the participants, the likeliest first."""
    said = (*known.mapping.groups.values(), *known.groups, *POSITION, *TRUTH)
    taken = {*used, *(column(table, title) for title in said)}
    found = [_candidate(table, place, codes) for place in range(len(table.names)) if place not in taken]
    return sorted((one for one in found if one), key=lambda one: (not one.is_complete, one.again, one.place))


def _candidate(table: Table, place: int, codes: Column) -> _Candidate | None:
    if set(plain(table.names[place]).split()) & (_MEASURED | TRAITS):
        return None
    rows = pd.DataFrame({"person": table.cells[place], "video": codes})[codes != ""]
    filled = rows[rows["person"] != ""]
    if filled.empty or len(filled) < _FILLED * len(rows) or _is_measured(filled["person"]):
        return None
    people, again = filled["person"].nunique(), int(filled.duplicated().sum())
    if people < 2 or again > _MOST_REPEATED * len(filled) or filled["person"].duplicated(keep=False).mean() < _SEVERAL:
        return None
    is_complete = not again and len(filled) == len(rows) == people * rows["video"].nunique()
    return _Candidate(place, people, again, is_complete)


def _is_measured(cells: Column) -> bool:
    """Return whether most cells are decimal numbers, which do not name people."""
    return bool(cells.str.fullmatch(r"[+-]?\d*[.,]\d+").mean() > 0.5)


def without(table: Table, known: Known, people: People, reasons: Mapping[str, Mask]) -> tuple[Table, People]:
    """Leave out participants with all of their rows.

    Args:
        table: the file.
        known: whose map can drop the values of columns; values that nobody has are counted as 0: they can be typos.
        people: participants of its rows.
        reasons: rows (True) whose participants are left out, by reason; a participant counts under the first.

    Returns:
        the table and the people without them.
    """
    said = dropped_by_map(table, known, people.ids)
    codes, names = pd.factorize(people.ids)
    out = np.zeros(len(names), dtype=bool)
    dropped = dict(people.dropped)
    for reason, mask in {**reasons, **said}.items():
        hit = np.zeros(len(names), dtype=bool)
        hit[codes[mask]] = True
        count = int((hit & ~out).sum())
        if count or reason in said:
            dropped[reason] = dropped.get(reason, 0) + count
        out |= hit
    kept = ~out[codes]
    return table.rows(kept), replace(people, ids=people.ids[kept].reset_index(drop=True), dropped=dropped)


def groups_of(table: Table, known: Known, ids: Column, used: Collection[int | None] = ()) -> pd.DataFrame:
    """Return the groups of each participant: those of the map, requested ones, and columns that look like groups.

    Raises:
        SourceError: if a requested group changes within a participant.
    """
    codes, people = pd.factorize(ids)
    frame = pd.DataFrame(index=pd.Index(people, name="participant", dtype="str"))
    chosen = _requested(table, known)
    for name, place in chosen.items():
        if not _is_constant(codes, table.cells[place]):
            message = "changes within a participant; expected one value for each"
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
    """Return the groups of both, those of the first where both have one."""
    extra = second[[name for name in second.columns if name not in first.columns]]
    return first.join(extra, how="left").fillna("").astype("str")


def _requested(table: Table, known: Known) -> dict[str, int]:
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
    """Return the first value of each participant that is not empty, otherwise ""."""
    filled = (cells != "").to_numpy(dtype=bool)
    values, words = coded(cells[filled])
    found = np.full(people, len(words))
    found[codes[filled][::-1]] = values[::-1]  # a later assignment overwrites an earlier one: the first row counts
    texts = [*map(number, words), ""]
    return [texts[i] for i in found]
