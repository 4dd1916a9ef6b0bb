"""Which column holds the answers to which video, where each video has a column."""

import re
from collections.abc import Sequence

from emovid.csv_reader import Table
from emovid.errors import SourceError, quoted
from emovid.responses.dialects.columns import holds_answers, named, share
from emovid.responses.dialects.parsed_export import Column, Known, whole_numbers
from emovid.responses.key import code_of
from emovid.responses.labels import number, plain

# Words of columns that stand beside an answer and are none.
_BESIDE = re.compile(
    r"\b(time|timing|times|rt|duration|clicks?|plays?|watched|submit|page|comments?|other|correct|confidence|"
    r"position|order|rank|seconds|changed?|do|started|answered|at|text)\b|time$"
)
_PLACE = re.compile(r"\b(position|order|rank)\b")


def video_columns(table: Table, known: Known, skip: Sequence[int | None] = ()) -> dict[int, str]:
    """Return the place and the code of each column with the answers to one video; none if no header tells.

    Raises:
        SourceError: if the map's columns are not there, or several columns could be meant.
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
        if code and _PLACE.search(plain(name)) and share(table, place, lambda cell: number(cell).isdecimal()) == 1:
            found[code] = whole_numbers(table.cells[place])
    from_zero = int(any((column == 0).any() for column in found.values()))
    return {code: column + from_zero for code, column in found.items()}


def about_videos(table: Table, known: Known) -> set[int]:
    """Return the places of columns that say something of a video, such as `z8r4_position`, and nothing of a person.

    A code in its header tells; the name of an emotion alone does not, as in "fear of robots".
    """
    coded = {place: bool(_code_in_header(table, place, known)) for place in range(len(table.names))}
    return {
        place for place, is_coded in coded.items() if is_coded and (known.codes or _stands_beside(table, place, known))
    }


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
            raise SourceError(table.file, message, 1)
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
        raise SourceError(table.file, message, 1, "videos")
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
    said = f"{'' if known.codes else 'a key, or '}map.yaml: videos (or video and response, if each row is one answer)"
    return f"{len(holding)} columns {what} ({first} ...), none named by {where}; expected {said}"


def question(text: str) -> str:
    """Return a question without the number that a tool adds where it is asked again."""
    return plain(re.sub(r"[\s_.(]*\d+\)?$", "", text))
