"""Finding columns, by their names and by what their cells hold."""

from collections.abc import Callable, Collection, Sequence

import pandas as pd

from emovid.csv_reader import Table
from emovid.errors import SourceError, nearest
from emovid.responses.dialects.parsed_export import Column, Known, numeric
from emovid.responses.labels import plain

VIDEO = ("video", "video_code", "video code", "stimulus", "stimulus_id", "video_id", "video_file", "clip", "movie")
ANSWER = ("response", "answer", "perceived", "perceived_emotion", "choice", "emotion", "selected", "rating", "label")
POSITION = ("position", "order", "presentation_order", "trial_position", "trial", "trial_number", "trial_index")
TRUTH = ("signalled", "signaled", "true_emotion", "true_label", "correct_answer", "correctanswer", "intended")

_SAMPLE = 2000  # cells that tell what a column holds


def column(table: Table, *names: str) -> int | None:
    """Return the place of the first of these names that is a header or question text, however it is spelled."""
    spelled: list[dict[str, int]] = [{}, {}]
    for places, titles in zip(spelled, (table.names, table.texts), strict=True):
        for place, title in enumerate(titles):
            places.setdefault(plain(title), place)
    return next((places[plain(name)] for name in names for places in spelled if plain(name) in places), None)


def named(table: Table, title: str, key: str) -> int:
    """Return the place of a column that map.yaml names.

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
        raise SourceError(table.file, f"no such column{hint}; expected those of the map's {key}", 1, title)
    return place


def says(table: Table, words: Collection[str], *names: str) -> Column:
    """Return the rows (True) in which the first of these columns says one of the words; none without the column."""
    place = column(table, *names)
    if place is None:
        return pd.Series(False, index=table.cells.index)
    cells = table.cells[place]
    return cells.isin([word for word in cells.unique() if plain(str(word)) in words])


def below(table: Table, bound: float, *names: str) -> Column:
    """Return the rows (True) in which the first of these columns has a number below a bound."""
    place = column(table, *names)
    if place is None:
        return pd.Series(False, index=table.cells.index)
    return numeric(table.cells[place]) < bound


def share(table: Table, place: int, test: Callable[[str], bool]) -> float:
    """Return the share of a column's first cells that pass a test, empty ones left out; 0 if all are empty."""
    cells = table.cells[place]
    filled = cells[cells != ""].head(_SAMPLE)
    counts = filled.value_counts()
    passed = sum(int(count) for word, count in counts.items() if test(str(word)))
    return passed / len(filled) if len(filled) else 0.0


def holds_answers(table: Table, place: int, known: Known) -> bool:
    """Return whether at least half of a column's cells are labels."""
    return share(table, place, known.labels.is_label) >= 0.5


def holds_videos(table: Table, place: int, known: Known) -> bool:
    """Return whether at least half of a column's cells are video codes."""
    return share(table, place, lambda cell: known.emotion(cell) is not None) >= 0.5


def check_named(table: Table, known: Known) -> None:
    """Refuse a map whose columns of videos and answers are not there, or there twice (SourceError)."""
    for key, title in (("video", known.mapping.video), ("response", known.mapping.response)):
        if title:
            named(table, title, key)


def video_column(table: Table, known: Known, *first: str) -> int | None:
    """Return the column that holds video codes: the map's; a named one that does, any other, a named one."""
    if known.mapping.video:
        return column(table, known.mapping.video)
    holding = [place for place in range(len(table.names)) if holds_videos(table, place, known)]
    place = _named_among(table, (*first, *VIDEO), holding)
    if place is None and known.codes and len(holding) == 1:
        place = holding[0]
    return column(table, *first, *VIDEO) if place is None else place


def answer_column(table: Table, known: Known, video: int | None, *first: str) -> int | None:
    """Return the column that holds answers: the map's; a named one that does, the only other one, a named one."""
    if known.mapping.response:
        return column(table, known.mapping.response)
    beside = {place for place, name in enumerate(table.names) if plain(name) in map(plain, TRUTH) or place == video}
    others = [place for place in range(len(table.names)) if place not in beside]
    holding = [place for place in others if holds_answers(table, place, known)]
    place = _named_among(table, (*first, *ANSWER), holding)
    if place is None and len(holding) == 1:
        place = holding[0]
    if place is None and not holding:
        place = _named_among(table, (*first, *ANSWER), others)
    return place


def _named_among(table: Table, names: Sequence[str], places: Sequence[int]) -> int | None:
    for name in names:
        for place in places:
            if plain(table.names[place]) == plain(name):
                return place
    return None
