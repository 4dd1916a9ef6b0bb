"""Columns of an export: the one step that decides which column holds videos, answers and true emotions.

The cells decide, names only break ties. In a table with one row for each answer:

1. The map names a column, or the format of a tool defines it: this column is taken.
2. A column of videos holds codes of the key, or emotions if there is no key.
3. A column of labels that agrees with the key on every row, or that has one label for each video, holds true emotions.
   It is never taken for answers. Nor is a column that is constant within each participant, which describes them.
4. One column of labels remains: it holds the answers. None or several remain: the table is refused, with the names and
   the line of map.yaml that decides. Columns that say the same in every row count as one.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Table, coded, translated
from emovid.errors import SourceError, nearest, quoted
from emovid.responses.labels import NONE, plain
from emovid.responses.parsed_export import Column, Known

VIDEO = ("video", "video_code", "video code", "stimulus", "stimulus_id", "video_id", "video_file", "clip", "movie")
ANSWER = ("response", "answer", "perceived", "perceived_emotion", "choice", "emotion", "selected", "rating", "label")
POSITION = ("position", "order", "presentation_order", "trial_position", "trial", "trial_number", "trial_index")
TRUTH = (
    "signalled", "signaled", "true_emotion", "true_label", "truth", "correct_answer", "correctanswer",
    "correct_response", "correctresponse", "intended", "intended_emotion", "target_emotion", "ground_truth", "expected",
)  # fmt: skip
# Words in names of columns that are measured or counted, so that digits in them are no coded answers.
_COUNTED = frozenset((
    "rt", "time", "date", "timestamp", "seconds", "duration", "trial", "index", "position", "order", "block", "row",
    "count", "n", "number", "age", "session", "run", "correct", "accuracy", "score", "confidence", "valence", "arousal",
    "intensity", "id", "code", "plays",
))  # fmt: skip
_SAMPLE = 2000  # cells that show the content of a column
_FEWEST = 3  # answers from which agreement with the key, or constancy, is evidence

Codes: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True)
class Format:
    """The columns that the format of a tool defines.

    Attributes:
        videos: names that the column of videos can have, likely ones first.
        answers: columns in which the tool itself records responses.
        order: columns that count trials.
        participants: columns that name participants.
        is_tool: whether a column is the tool's own and no group.
    """

    videos: tuple[str, ...] = ()
    answers: tuple[str, ...] = ()
    order: tuple[str, ...] = ()
    participants: tuple[str, ...] = ()
    is_tool: Callable[[str], bool] = lambda _: False


@dataclass(frozen=True)
class Layout:
    """The roles of the columns of a table with one row for each answer.

    Attributes:
        video: column of videos.
        answers: columns of answers; each row has its answer in at most one of them.
        truth: columns of true emotions.
        evidence: why a column has its role.
        warnings: sentences for readers of the results.
        codes: emotion of each video, if a column of true emotions replaces the key.
    """

    video: int
    answers: tuple[int, ...]
    truth: tuple[int, ...] = ()
    evidence: Mapping[int, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    codes: Mapping[str, str] = field(default_factory=dict)


def column(table: Table, *names: str) -> int | None:
    """Return the index of the first of these names that is a header or a question text.

    An exact match comes before one that ignores case and punctuation.
    """
    for spell in (str, plain):
        spelled: list[dict[str, int]] = [{}, {}]
        for places, titles in zip(spelled, (table.names, table.texts), strict=True):
            for place, title in enumerate(titles):
                places.setdefault(spell(title), place)
        for name in names:
            found = next((places[spell(name)] for places in spelled if spell(name) in places), None)
            if found is not None:
                return found
    return None


def named(table: Table, title: str, key: str) -> int:
    """Return the index of a column that map.yaml names.

    Raises:
        SourceError: if there is none, or several.
    """
    for titles in (table.names, table.texts):
        places = [place for place, name in enumerate(titles) if name == " ".join(title.split())]
        if len(places) > 1:
            message = f"{len(places)} columns have this name; expected one: list the codes in their order"
            raise SourceError(table.file, message, 1, title)
        if places:
            return places[0]
    place = column(table, title)
    if place is None:
        hint = nearest(title, (*table.names, *table.texts))
        raise SourceError(table.file, f"no such column{hint}; expected the one of the map's {key}", 1, title)
    return place


def is_named(table: Table, place: int, names: Iterable[str]) -> bool:
    """Return whether a column has one of these names, ignoring case and punctuation."""
    return plain(table.names[place]) in {plain(name) for name in names}


def share(table: Table, place: int, test: Callable[[str], bool]) -> float:
    """Return the share of a column's cells that pass a test, empty ones left out; 0 if all are empty.

    Of a long column, cells at equal distances are tested.
    """
    cells = table.cells[place]
    filled = cells[cells != ""]
    sample = filled.iloc[:: max(1, len(filled) // _SAMPLE)].tolist()
    passed = sum(count for word, count in Counter(sample).items() if test(str(word)))
    return passed / len(sample) if len(sample) else 0.0


def holds_answers(table: Table, place: int, known: Known) -> bool:
    """Return whether at least half of a column's cells are labels."""
    return share(table, place, known.labels.is_label) >= 0.5


def holds_videos(table: Table, place: int, known: Known) -> bool:
    """Return whether at least half of a column's cells are videos, or most videos of the key are in it."""
    if share(table, place, lambda cell: known.emotion(cell) is not None) >= 0.5:
        return True
    if not known.codes:
        return False
    cells = table.cells[place]
    sample = cells.iloc[:: max(1, len(cells) // _SAMPLE)].unique()
    found = {known.code(str(cell)) for cell in sample if cell} & set(known.codes)
    return len(found) >= max(2, 0.5 * len(known.codes))


def check_named(table: Table, known: Known) -> None:
    """Raise SourceError if the map names columns of videos, answers or truths that are missing or repeated."""
    mapping = known.mapping
    for key, titles in (("video", (mapping.video,)), ("response", mapping.response), ("truth", (mapping.truth,))):
        for title in filter(None, titles):
            named(table, title, key)


def video_column(table: Table, known: Known, form: Format = Format()) -> int | None:
    """Return the column of videos, or None.

    Raises:
        SourceError: if several columns hold different videos, and none of them alone has a usual name.
    """
    if known.mapping.video:
        return column(table, known.mapping.video)
    names = (*form.videos, *VIDEO)
    holding = [place for place in range(len(table.names)) if holds_videos(table, place, known)]
    if not known.codes:  # answers name emotions, too: the name of the column decides
        holding = [place for place in holding if is_named(table, place, names)]
    apart = _different(table, holding, lambda text: known.code(text) if known.emotion(text) else "")
    if len(apart) > 1:
        preferred = [place for place in apart if is_named(table, place, form.videos or names)]
        if len(preferred) != 1:
            several = " and ".join(quoted(table.names[place]) for place in apart)
            message = f"columns {several} hold codes of the key; expected map.yaml: video: one of them"
            raise SourceError(table.file, message, 1)
        apart = preferred
    return apart[0] if apart else column(table, *names)


def layout(table: Table, known: Known, video: int, form: Format = Format(), person: int | None = None) -> Layout:
    """Return the roles of the columns, by the steps in the docstring of this module.

    Args:
        table: one row for each answer.
        known: the key, the labels and the map.
        video: column of videos.
        form: columns that the tool defines.
        person: column that names the participants, if one is known.

    Raises:
        SourceError: if no column or several columns could hold the answers.
    """
    evidence = _Evidence.of(table, known, video, person)
    codes = {} if known.codes else evidence.stated_codes()
    if codes:
        evidence = replace(evidence, known=replace(known, codes=codes), is_stated=True)
    truth = evidence.truth()
    answers, why, warnings = _answers(evidence, truth, form)
    _check_choices(evidence, answers)
    return Layout(video, answers, tuple(truth), truth | dict.fromkeys(answers, why), warnings, codes)


@dataclass(frozen=True, eq=False)
class _Evidence:
    """The content of the columns that hold labels.

    Attributes:
        table: one row for each answer.
        known: the key, the labels and the map.
        video: column of videos.
        videos: video of each row, -1 where it is unknown or missing.
        people: participant of each row; None if no column names them.
        labels: label of each row in the columns that hold labels, -1 where there is none.
        names: names of the videos.
        is_stated: whether a column of the table replaces the key.
    """

    table: Table
    known: Known
    video: int
    videos: Codes
    names: tuple[str, ...]
    people: Codes | None
    labels: Mapping[int, Codes]
    is_stated: bool = False

    @classmethod
    def of(cls, table: Table, known: Known, video: int, person: int | None) -> "_Evidence":
        places, texts = coded(table.cells[video])
        codes = [known.code(text) if not known.codes or known.emotion(text) else "" for text in texts]
        names = tuple(dict.fromkeys(filter(None, codes)))
        index = {name: i for i, name in enumerate(names)}
        videos = np.array([index.get(code, -1) for code in codes], dtype=np.int64)[places]
        people = None if person is None else pd.factorize(table.cells[person])[0]
        shown = table.rows(videos >= 0) if (videos >= 0).any() else table
        labels = {}
        for place in range(len(table.names)):
            named_by_map = table.names[place] in (*known.mapping.response, known.mapping.truth)
            if place not in (video, person) and (named_by_map or holds_answers(shown, place, known)):
                if _is_coded(table, place, known) and not named_by_map and is_counted(table.names[place]):
                    continue
                labels[place] = _meanings(table.cells[place], known)
        return cls(table, known, video, videos, names, people, labels)

    def stated_codes(self) -> dict[str, str]:
        """Return the emotion of each video from a column of true emotions; none where a video has two or no label."""
        title = self.known.mapping.truth
        if title:
            place = named(self.table, title, "truth")
            return self._codes(self.labels.get(place, _meanings(self.table.cells[place], self.known)))
        if any(self.known.emotion(name) for name in self.names):
            return {}
        for place, labels in self.labels.items():
            if is_named(self.table, place, TRUTH) and (codes := self._codes(labels)):
                return codes
        answers = {column(self.table, title) for title in self.known.mapping.response}
        others = [labels for place, labels in self.labels.items() if place not in answers]
        found = [labels for labels in others if self._is_constant(labels, self.videos)]
        stated = [self._codes(labels) for labels in found]
        return stated[0] if stated and all(codes == stated[0] for codes in stated) else {}

    def _codes(self, labels: Codes) -> dict[str, str]:
        filled = (self.videos >= 0) & (labels >= 0)
        pairs = pd.DataFrame({"video": self.videos[filled], "label": labels[filled]}).drop_duplicates()
        if pairs["video"].duplicated().any():
            return {}
        signalled = self.known.labels.signalled
        found = {self.names[i]: j for i, j in pairs.to_numpy().tolist()}
        return {name: signalled[j] for name, j in found.items() if j < len(signalled)}

    def truth(self) -> dict[int, str]:
        """Return the columns of true emotions, with the evidence for each."""
        emotions = [self.known.emotion(name) for name in self.names]
        order = {label: i for i, label in enumerate(self.known.labels.signalled)}
        true = np.array([order.get(str(emotion), -1) for emotion in emotions] + [-1], dtype=np.int64)[self.videos]
        found = {}
        for place, labels in self.labels.items():
            filled = (labels >= 0) & (self.videos >= 0)
            if self.known.mapping.truth and place == column(self.table, self.known.mapping.truth):
                found[place] = "named by the map"
            elif is_named(self.table, place, TRUTH):
                found[place] = "its name"
            elif filled.sum() >= _FEWEST and (true[filled] >= 0).all() and (true == labels)[filled].all():
                found[place] = f"agrees with the key on all {filled.sum()} rows"
            elif self._is_constant(labels, self.videos):
                found[place] = "has one label for each video"
        return found

    def is_about_people(self, labels: Codes) -> bool:
        """Return whether a column has one label for each participant."""
        return self.people is not None and self._is_constant(labels, self.people)

    def _is_constant(self, labels: Codes, groups: Codes) -> bool:
        """Return whether each group has one label, and rows beyond the first of a group confirm it."""
        filled = (labels >= 0) & (groups >= 0) & (self.videos >= 0)
        of_groups = len(pd.unique(groups[filled]))
        pairs = len(pd.unique(groups[filled] * (int(labels.max(initial=0)) + 1) + labels[filled]))
        return bool(pairs == of_groups and filled.sum() - of_groups >= _FEWEST)


def label_columns(table: Table, known: Known, video: int, person: int | None) -> tuple[dict[int, str], list[int]]:
    """Return the columns of true emotions with the evidence, and those that can hold the answers."""
    evidence = _Evidence.of(table, known, video, person)
    truth = evidence.truth()
    return truth, _candidates(evidence, truth)


def _candidates(evidence: _Evidence, truth: Mapping[int, str]) -> list[int]:
    return [
        place
        for place, labels in evidence.labels.items()
        if place not in truth and not evidence.is_about_people(labels) and not is_named(evidence.table, place, POSITION)
    ]


def _answers(
    evidence: _Evidence, truth: Mapping[int, str], form: Format
) -> tuple[tuple[int, ...], str, tuple[str, ...]]:
    """Return the columns of answers, the evidence, and warnings. Raises SourceError if they are ambiguous."""
    table, mapping = evidence.table, evidence.known.mapping
    if mapping.response:
        places = tuple(named(table, title, "response") for title in mapping.response)
        _check_shared(table, places)
        perfect = [place for place in places if "agrees" in truth.get(place, "") or "one label" in truth.get(place, "")]
        warnings = (
            f"column {quoted(table.names[place])}, which the map names for the answers, {truth[place]}: check that it "
            "does not hold the true emotions"
            for place in perfect
        )
        return places, "named by the map", tuple(warnings)
    tool = [place for name in form.answers if (place := column(table, name)) is not None]
    from_tool = [place for place in dict.fromkeys(tool) if place in evidence.labels]
    candidates = from_tool or _candidates(evidence, truth)
    apart = _different(table, candidates, lambda text: evidence.known.labels.find(text) or "")
    if len(apart) > 1 and from_tool and not _is_shared_twice(table, apart):
        return tuple(apart), "each row has its answer in one of these columns of the tool", ()
    if len(apart) > 1:
        raise SourceError(table.file, _ambiguous(table, evidence.video, apart), 1)
    if apart:
        why = "the tool's column of responses" if from_tool else "the only column of labels that differ within a video"
        return (apart[0],), why, ()
    return (_unlabelled(evidence, truth, tool),), "its name; its cells are not labels", ()


def _unlabelled(evidence: _Evidence, truth: Mapping[int, str], tool: Sequence[int]) -> int:
    """Return the column of answers whose cells are not labels yet, by its name."""
    table = evidence.table
    usual = [place for name in ANSWER if (place := column(table, name)) is not None]
    shown = table.rows(evidence.videos >= 0)
    for place in (*tool, *usual):
        if place != evidence.video and place not in truth and (shown.cells[place] != "").any():
            return place
    only = [place for place, why in truth.items() if why not in {"its name", "named by the map"}]
    if len(only) > 1:
        names = " and ".join(quoted(table.names[place]) for place in only)
        message = (
            f"columns {names} have one label for each video, so each can hold the true emotions; expected map.yaml: "
            "response: the column of answers, and a key or truth: the column of true emotions"
        )
        raise SourceError(table.file, message, 1)
    if only and evidence.is_stated:
        message = (
            f"column {quoted(table.names[only[0]])} has one label for each video, which can be the true emotions or "
            "unanimous answers, and no other column holds labels; expected a key, and map.yaml: response"
        )
        raise SourceError(table.file, message, 1)
    if only:
        name, why = table.names[only[0]], truth[only[0]]
        message = (
            f"column {quoted(name)} {why}, so it seems to hold the true emotions, and no other column holds answers; "
            f"expected map.yaml: response: the column of answers ({name}, if all answers are right)"
        )
        raise SourceError(table.file, message, 1)
    labels = ", ".join(evidence.known.labels.signalled[:3])
    message = (
        f"videos in {quoted(table.names[evidence.video])}, but no column holds answers ({labels}, ...); expected "
        "map.yaml: response: their column, and answers: the label of each cell, or other --labels"
    )
    raise SourceError(table.file, message, 1)


def _ambiguous(table: Table, video: int, places: Sequence[int]) -> str:
    names = [table.names[place] for place in places]
    several = ", ".join(map(quoted, names[:-1])) + f" and {quoted(names[-1])}"
    return f"videos in {quoted(table.names[video])}, answers in {several}; expected map.yaml: response: one of them"


def _check_shared(table: Table, places: Sequence[int]) -> None:
    if len(places) > 1 and _is_shared_twice(table, places):
        names = " and ".join(quoted(table.names[place]) for place in places[:2])
        raise SourceError(table.file, f"{names} both have an answer in one row; expected map.yaml: response: one", 1)


def _is_shared_twice(table: Table, places: Sequence[int]) -> bool:
    """Return whether a row has cells in several of the columns."""
    return bool((sum((table.cells[place] != "").astype(int) for place in places) > 1).any())


def _different(table: Table, places: Sequence[int], meaning: Callable[[str], str]) -> list[int]:
    """Return the columns without those that mean the same as an earlier one in every row that both fill."""
    if len(places) < 2:
        return list(places)
    kept: list[int] = []
    meanings: dict[int, Column] = {}
    for place in places:
        cells = table.cells[place]
        meanings[place] = translated(cells, meaning)
        if not any(_agree(meanings[place], meanings[other]) for other in kept):
            kept.append(place)
    return kept


def _agree(first: Column, second: Column) -> bool:
    both = (first != "") & (second != "")
    return bool(both.any() and (first[both] == second[both]).all() and ((first != "") <= (second != "")).all())


def _meanings(cells: Column, known: Known) -> Codes:
    places, texts = coded(cells)
    order = {label: i for i, label in enumerate((*known.labels.signalled, NONE))}
    return np.array([order.get(known.labels.find(text) or "", -1) for text in texts], dtype=np.int64)[places]


def _check_choices(evidence: _Evidence, answers: Sequence[int]) -> None:
    """Raise SourceError if answers are numbers of choices whose order differs between rows."""
    table, known = evidence.table, evidence.known
    if not any(_is_coded(table, place, known) for place in answers):
        return
    order = {text: label for text, label in known.labels.words().items() if text != NONE}
    lists = [place for place in range(len(table.names)) if place not in (*answers, evidence.video)]
    named_by = next((place for place in lists if _lists_choices(table, place, order)), None)
    options = [place for place, labels in evidence.labels.items() if place not in answers and (labels >= 0).any()]
    if named_by is None and len(options) >= _FEWEST:
        rows = np.column_stack([evidence.labels[place] for place in options])
        rows = rows[(rows >= 0).all(axis=1)]
        distinct = np.unique(rows, axis=0)
        if len(distinct) > 1 and all(len(set(row)) == len(row) for row in distinct.tolist()):
            named_by = options[0]
    if named_by is not None:
        message = (
            f"column {quoted(table.names[named_by])} shows the choices in different orders, so the numbers in "
            f"{quoted(table.names[answers[0]])} have no fixed labels; expected a column with the chosen labels"
        )
        raise SourceError(table.file, message, 1)


def _lists_choices(table: Table, place: int, words: Mapping[str, str]) -> bool:
    """Return whether the cells of a column list labels, in different orders."""
    cells = table.cells[place]
    sample = coded(cells.iloc[:: max(1, len(cells) // _SAMPLE)])[1]
    if not sample or not any(mark in sample[-1] for mark in ",|;["):
        return False
    parts = ([plain(part) for part in re.split(r"[,|;]", cell)] for cell in sample)
    orders = {tuple(words[word] for word in found if word in words) for found in parts}
    return sum(len(set(order)) >= _FEWEST for order in orders) > 1


def _is_coded(table: Table, place: int, known: Known) -> bool:
    """Return whether the answers of a column are numbers."""
    return share(table, place, lambda cell: known.labels.is_label(cell) and not any(map(str.isalpha, cell))) >= 0.5


def is_counted(name: str) -> bool:
    """Return whether a column counts or measures, by its name."""
    return bool(set(plain(name).split()) & _COUNTED)


def texts_of(table: Table, places: Sequence[int]) -> tuple[Column, str | Column]:
    """Return the answer of each row in columns that share them, and the name of its column."""
    if len(places) == 1:
        return table.cells[places[0]], table.names[places[0]]
    cells = pd.Series("", index=table.cells.index, dtype="str")
    names = pd.Series(table.names[places[0]], index=table.cells.index, dtype="str")
    for place in places:
        filled = table.cells[place] != ""
        cells, names = cells.mask(filled, table.cells[place]), names.mask(filled, table.names[place])
    return cells, names
