"""Boxes of MP4 files (ISO/IEC 14496-12), and padding to equal size."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from emovid.atomic_io import writing
from emovid.errors import RenderError

_HEAD = 8  # bytes of the size and the name of a box
_CONTAINERS = ("moov", "trak", "mdia", "minf", "stbl", "dinf", "edts")


@dataclass(frozen=True)
class Box:
    """A box: its four-letter name, its offset in the file, and its content without the header."""

    kind: str
    start: int
    body: bytes


def boxes(data: bytes, offset: int = 0) -> Iterator[Box]:
    """Yield the boxes of a file, each container before the boxes inside it.

    Raises:
        ValueError: for bytes that are not a box.
    """
    place = 0
    while place < len(data):
        if place + _HEAD > len(data):
            raise ValueError(f"no box at byte {offset + place}")
        size, name = struct.unpack_from(">I4s", data, place)
        head = _HEAD
        if size == 1 and place + 16 <= len(data):
            size, head = struct.unpack_from(">Q", data, place + _HEAD)[0], 16
        if size < head or place + size > len(data):
            raise ValueError(f"no whole box at byte {offset + place}")
        kind, body = name.decode("latin-1"), data[place + head : place + size]
        yield Box(kind, offset + place, body)
        if kind in _CONTAINERS:
            yield from boxes(body, offset + place + head)
        place += size


def content_size(data: bytes) -> int:
    """Return the size of a file without a free box at its end [bytes]. Raises ValueError as `boxes`."""
    ends = [box for box in boxes(data) if box.kind == "free" and box.start + _HEAD + len(box.body) == len(data)]
    return ends[0].start if ends else len(data)


def pad_to_equal_size(files: list[Path]) -> None:
    """Pad files to equal size by a free box of zeros at the end, which players skip; earlier padding is replaced.

    Raises:
        RenderError: for a file that is not an MP4 file.
    """
    contents = {}
    for path in files:
        data = path.read_bytes()
        try:
            contents[path] = len(data), content_size(data)
        except ValueError as error:
            raise RenderError(f"{path}: not an MP4 file: {error}") from None
    size = max(content for _, content in contents.values()) + _HEAD
    for path, (whole, content) in contents.items():
        if whole != size:
            data = path.read_bytes()[:content]
            with writing(path) as file:
                file.write(data + struct.pack(">I4s", size - content, b"free") + bytes(size - content - _HEAD))
