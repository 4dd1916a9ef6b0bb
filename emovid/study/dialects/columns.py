"""Finding columns: by their names, by what their cells hold, by the video that their question is about."""

import re
from collections.abc import Callable, Collection, Sequence

import pandas as pd

from emovid.errors import nearest
from emovid.study.dialects.raw import Column, Known, whole_numbers
from emovid.study.errors import StudyError, quoted
from emovid.study.key import code_of
from emovid.study.labels import plain
from emovid.study.tables import Table

VIDEO = ("video", "video_code", "video code", "stimulus", "stimulus_id", "video_id", "video_file", "clip", "movie")
ANSWER = ("response", "answer", "perceived", "perceived_emotion", "choice", "emotion", "selected", "rating", "label")
POSITION = ("position", "order", "presentation_order", "trial_position", "trial", "trial_number", "trial_index")
TRUTH = ("signalled", "signaled", "true_emotion", "true_label", "correct_answer", "correctanswer", "intended")

_SAMPLE = 2000  # cells that tell what a column holds
# Words of columns that stand beside an answer and are none.
_BESIDE = re.compile(
    r"\b(time|timing|times|rt|duration|clicks?|plays?|watched|submit|page|comments?|other|correct|confidence|"
    r"position|order|rank|seconds|changed?|do|started|answered|at|text)\b|time$"
)
_PLACE = re.compile(r"\b(position|order|rank)\b")


def column(table: Table, *names: str) -> int | None:
    """Return the place of the first of these names that is a header or question text, however it is spelled."""
    for name in names:
        for titles in (table.names, table.texts):
            for place, title in enumerate(titles):
                if plain(title) == plain(name):
                    return place
    return None


def named(table: Table, title: str, key: str) -> int:
    """Return the place of a column that map.yaml names.

    Raises:
        StudyError: if there is none, or several.
    """
    for titles in (table.names, table.texts):
        places = [place for place, name in enumerate(titles) if name == " ".join(title.split())]
        if len(places) > 1:
            message = f"{len(places)} columns have this name; expected one: list the codes in their order"
            raise StudyError(table.file, message, 1, title)
        if places:
            return places[0]
    place = column(table, title)
    if place is None:
        hint = nearest(title, (*table.names, *table.texts))
        raise StudyError(table.file, f"no such column{hint}; expected those of the map's {key}", 1, title)
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
    return pd.to_numeric(table.cells[place], errors="coerce") < bound


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


def video_column(table: Table, known: Known, *first: str) -> int | None:
    """Return the place of the column that holds video codes: a named one that does, any other, a named one."""
    holding = [place for place in range(len(table.names)) if holds_videos(table, place, known)]
    place = _named_among(table, (*first, *VIDEO), holding)
    if place is None and known.codes and len(holding) == 1:
        place = holding[0]
    return column(table, *first, *VIDEO) if place is None else place


def answer_column(table: Table, known: Known, video: int | None, *first: str) -> int | None:
    """Return the place of the column that holds answers: a named one that does, the only other one, a named one."""
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


def video_columns(table: Table, known: Known, skip: Sequence[int | None] = ()) -> dict[int, str]:
    """Return the place and the code of each column with the answers to one video; none if no header tells.

    Raises:
        StudyError: if the map's columns are not there, or several columns could be meant.
    """
    if known.mapping.videos:
        return {named(table, title, "videos"): code for title, code in known.mapping.videos.items()}
    if known.mapping.in_order:
        return dict(zip(_alike(table, known, skip), known.mapping.in_order, strict=True))
    found: dict[str, list[int]] = {}
    for place in range(len(table.names)):
        code = _code_in_header(table, place, known)
        if code and place not in skip and not _stands_beside(table, place, known):
            found.setdefault(code, []).append(place)
    chosen = {code: _chosen(table, known, code, places) for code, places in found.items()}
    return {place: code for code, place in chosen.items() if place is not None}


def positions(table: Table, known: Known) -> dict[str, Column]:
    """Return the position of each video from columns such as `z8r4_position`."""
    found: dict[str, Column] = {}
    for place, name in enumerate(table.names):
        code = _code_in_header(table, place, known)
        if code and _PLACE.search(plain(name)) and share(table, place, str.isdigit) == 1:
            found[code] = whole_numbers(table.cells[place])
    return found


def code_in(text: str, known: Known) -> str:
    """Return the one video code that a text names, or ""."""
    folded = text.casefold()
    if code_of(text) in known.codes:
        return code_of(text)
    if known.codes:
        found = {code for code in known.codes if _stands_in(code, folded)}
        found = {code for code in found if not any(code != other and code in other for other in found)}
    else:
        found = {label for word in plain(text).split() if (label := known.emotion(word))}
    return found.pop() if len(found) == 1 else ""


def _stands_in(code: str, text: str) -> bool:
    """Return whether a code is a word of a text; a number or a letter only after "video" or the like."""
    before = r"(?:video|clip|stimulus|movie)\s*[_#:-]?\s*" if len(code) < 3 or code.isdigit() else r"(?<![^\W_])"
    return code in text and re.search(before + re.escape(code) + r"(?![^\W_])", text) is not None


def _code_in_header(table: Table, place: int, known: Known) -> str:
    return code_in(table.names[place], known) or code_in(table.texts[place], known)


def _stands_beside(table: Table, place: int, known: Known) -> bool:
    name = plain(table.names[place])
    if not _BESIDE.search(name):
        return False
    is_count = len(name.split()) <= 5 and share(table, place, str.isdigit) == 1  # whatever the map makes of numbers
    return is_count or not holds_answers(table, place, known)


def _chosen(table: Table, known: Known, code: str, places: list[int]) -> int | None:
    """Return the one of the columns that name a video which holds its answers."""
    exact = [place for place in places if code_of(table.names[place]) == code]
    holding = [place for place in places if holds_answers(table, place, known)]
    for candidates in (holding, exact, places if known.codes else []):
        if len(candidates) == 1:
            return candidates[0]
        if candidates:
            names = " and ".join(quoted(table.names[place]) for place in candidates[:2])
            message = f"columns {names} both name the video {code}; expected one: say which in map.yaml: videos"
            raise StudyError(table.file, message, 1)
    return None


def _alike(table: Table, known: Known, skip: Sequence[int | None]) -> list[int]:
    """Return the columns that ask one question, as many as the map lists codes."""
    wanted = len(known.mapping.in_order)
    bases: dict[str, list[int]] = {}
    for place, text in enumerate(table.texts):
        if place not in skip and holds_answers(table, place, known):
            bases.setdefault(question(text), []).append(place)
    fitting = [places for places in bases.values() if len(places) == wanted]
    together = [place for places in bases.values() for place in places]
    if len(fitting) != 1 and len(together) != wanted:
        message = f"{len(together)} columns hold answers; the map lists {wanted} codes"
        raise StudyError(table.file, message, 1, "videos")
    return fitting[0] if len(fitting) == 1 else sorted(together)


def no_videos(table: Table, known: Known) -> str:
    """Return what is wrong with a table in which no column names a video, or "" if no two columns hold answers."""
    holding = [place for place in range(len(table.names)) if holds_answers(table, place, known)]
    if len(holding) < 2:
        return ""
    alone = len({question(table.texts[place]) for place in holding}) == 1
    what = "ask one question" if alone else "hold answers"
    where = "a code of the key" if known.codes else "an emotion"
    first = quoted(table.texts[holding[0]])
    return f"{len(holding)} columns {what} ({first} ...), none named by {where}; expected a key, or map.yaml: videos"


def question(text: str) -> str:
    """Return a question without the number that a tool adds where it is asked again."""
    return plain(re.sub(r"[\s_.(]*\d+\)?$", "", text))
