"""Where the keys of a scene were written."""

from collections.abc import Mapping

KeyPath = tuple[str | int, ...]
Places = Mapping[KeyPath, str]


def key_path(key: str) -> KeyPath:
    """Return the path of a dotted key; numbers are places in a list."""
    return tuple(int(part) if part.isdecimal() and len(part) < 10 else part for part in key.split("."))


def place_of(path: KeyPath, places: Places) -> str:
    """Return the place of a key, or of the innermost group around it that was written."""
    return next((places[path[:n]] for n in range(len(path), -1, -1) if path[:n] in places), "")
