"""What is inside an MP4 file (ISO/IEC 14496-12), box by box; and files made equally long."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from emovid.atomic_io import writing
from emovid.errors import RenderError

_HEAD = 8  # bytes of a box's size and name
_CONTAINERS = ("moov", "trak", "mdia", "minf", "stbl", "dinf", "edts")


@dataclass(frozen=True)
class Box:
    """A part of a file.

    Attributes:
        kind: its four letters.
        start: its place in the file.
        body: what it holds, without its head.
    """

    kind: str
    start: int
    body: bytes


def boxes(data: bytes, offset: int = 0) -> Iterator[Box]:
    """Yield the boxes of a file, those inside a container after it.

    Raises:
        ValueError: where the bytes are no boxes.
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
    """Return the bytes of a file without the free box at its end, if it has one. Raises ValueError as `boxes`."""
    ends = [box for box in boxes(data) if box.kind == "free" and box.start + _HEAD + len(box.body) == len(data)]
    return ends[0].start if ends else len(data)


def pad_alike(files: list[Path]) -> None:
    """Make files equally long by a free box of zeros at the end of each, which players skip; again if need be.

    Raises:
        RenderError: for a file that is no MP4.
    """
    contents = {}
    for path in files:
        data = path.read_bytes()
        try:
            contents[path] = len(data), content_size(data)
        except ValueError as error:
            raise RenderError(f"{path}: no MP4 file: {error}") from None
    size = max(content for _, content in contents.values()) + _HEAD
    for path, (whole, content) in contents.items():
        if whole != size:
            data = path.read_bytes()[:content]
            with writing(path) as file:
                file.write(data + struct.pack(">I4s", size - content, b"free") + bytes(size - content - _HEAD))
