"""The key of blinded videos: which emotion each code stands for."""

import re
from pathlib import Path

from emovid.csv_reader import Table, read_bytes, read_table
from emovid.errors import SourceError, nearest, quoted
from emovid.responses.labels import NONE, Labels

_CODE = ("video_code", "code", "video")
_EMOTION = ("true_emotion", "emotion", "signalled")


def read_key(path: Path, labels: Labels) -> dict[str, str]:
    """Return the emotion of each code in a file with the columns `video_code` and `true_emotion`.

    Raises:
        SourceError: for another file, a code that stands twice or is missing, an emotion that is no label.
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
                f"{quoted(emotion)} is no emotion{hint}; expected {', '.join(labels.signalled)}, or others by --labels "
                "or the map's labels"
            )
            raise SourceError(str(path), message, line, _EMOTION[0])
        if not code or code in key:
            message = f"{quoted(written)} stands twice" if code else "empty"
            raise SourceError(str(path), f"{message}; expected a code for each video", line, _CODE[0])
        key[code] = found
    if not key:
        raise SourceError(str(path), "a header alone; expected a row for each video")
    return key


def code_of(text: str) -> str:
    """Return the code in what a tool wrote of a video: `["videos/Z8r4.mp4"]` is z8r4."""
    bare = text.strip().strip("[]").strip().strip("\"'")
    name = re.split(r"[?#]", bare)[0].replace("\\", "/").rsplit("/", 1)[-1]
    return re.sub(r"\.(mp4|webm|mov|avi|mkv|gif|m4v|ogv)$", "", name.strip().casefold())


def _column(table: Table, names: tuple[str, ...]) -> list[str]:
    for name in names:
        for place, title in enumerate(table.names):
            if title.casefold() == name:
                return [str(cell) for cell in table.cells[place]]
    hint = nearest(names[0], table.names)
    raise SourceError(table.file, f"no column {names[0]}{hint}; expected video_code,true_emotion", 1)
