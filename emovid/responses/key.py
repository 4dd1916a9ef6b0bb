"""Codes of blinded videos: the key that gives the emotion of each code, and codes within longer texts."""

import re
from collections.abc import Collection
from functools import cache
from pathlib import Path

from emovid.csv_reader import Table, read_bytes, read_table
from emovid.errors import SourceError, nearest, quoted
from emovid.responses.labels import NONE, Labels

_CODE = ("video_code", "code", "video")
_EMOTION = ("true_emotion", "emotion", "signalled")
_EXTENSION = re.compile(r"\.(mp4|webm|mov|avi|mkv|gif|m4v|ogv)$")
_VIDEO_WORD = r"(?:video|vid|clip|stimulus|stim|movie|film)"


def read_key(path: Path, labels: Labels) -> dict[str, str]:
    """Return the emotion of each code in a file with the columns `video_code` and `true_emotion`.

    Raises:
        SourceError: for a file without these columns, a missing or repeated code, and an emotion that is not a label.
    """
    table = read_table(read_bytes(path), str(path))
    codes, emotions = (_column(table, names) for names in (_CODE, _EMOTION))
    if table.rejected:
        raise SourceError(str(path), f"{table.rejected[0].reason}; expected 2", table.rejected[0].row)
    key: dict[str, str] = {}
    for line, written, emotion in zip(table.lines.tolist(), codes, emotions, strict=True):
        found, code = labels.find(emotion), code_of(written)
        if not found or found == NONE:
            hint = nearest(emotion, labels.signalled)
            message = (
                f"{quoted(emotion)} is not an emotion{hint}; expected {', '.join(labels.signalled)}, or others by "
                "--labels or the map's labels"
            )
            raise SourceError(str(path), message, line, _EMOTION[0])
        if not code or code in key:
            message = f"{quoted(written)} is given twice" if code else "empty"
            raise SourceError(str(path), f"{message}; expected a code for each video", line, _CODE[0])
        key[code] = found
    if not key:
        raise SourceError(str(path), "a header alone; expected a row for each video")
    return key


def read_factors(path: Path, names: Collection[str]) -> dict[str, dict[str, str]]:
    """Return the level of each code, for columns of a key with more than two, such as the stimuli.csv of a kit.

    Raises:
        SourceError: for a column that the file does not have.
    """
    table = read_table(read_bytes(path), str(path))
    codes = [code_of(written) for written in _column(table, _CODE)]
    found = {}
    for name in names:
        if name not in table.names:
            hint = nearest(name, table.names)
            raise SourceError(str(path), f"no column {quoted(name)}{hint}; expected one of {', '.join(table.names)}", 1)
        found[name] = dict(zip(codes, map(str, table.cells[table.names.index(name)]), strict=True))
    return found


def code_of(text: str) -> str:
    """Return the code in the name of a video as tools write it: `["videos/Z8r4.mp4"]` is z8r4."""
    bare = text.strip().strip("[]").strip().strip("\"'")
    name = re.split(r"[?#]", bare)[0].replace("\\", "/").rsplit("/", 1)[-1]
    return _EXTENSION.sub("", name.strip().casefold())


def code_within(text: str, codes: Collection[str]) -> str:
    """Return the one code that a longer text names, as in "Vz8r4" or "stimuli/z8r4_final.mp4?x=1", or "".

    A number, or a code of one or two characters, counts only after "video" or the like.
    """
    folded = text.casefold()
    found = {code for code in codes if code in folded and _pattern(code).search(folded)}
    found = {code for code in found if not any(code != other and code in other for other in found)}
    return found.pop() if len(found) == 1 else ""


@cache
def _pattern(code: str) -> re.Pattern[str]:
    is_short = len(code) < 3 or code.isdigit()
    before = rf"{_VIDEO_WORD}\s*[_#:-]?\s*" if is_short else rf"(?<![^\W_])(?:{_VIDEO_WORD}|v|q)?"
    return re.compile(before + re.escape(code) + r"(?![^\W_])")


def _column(table: Table, names: tuple[str, ...]) -> list[str]:
    for name in names:
        for place, title in enumerate(table.names):
            if title.casefold() == name:
                return [str(cell) for cell in table.cells[place]]
    hint = nearest(names[0], table.names)
    raise SourceError(table.file, f"no column {names[0]}{hint}; expected video_code,true_emotion", 1)
