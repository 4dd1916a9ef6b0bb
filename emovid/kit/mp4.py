"""Boxes of MP4 files (ISO/IEC 14496-12), and padding to equal size."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from emovid.atomic_io import writing
from emovid.errors import RenderError

_HEAD = 8  # bytes of the size and the name of a box
_OFFSETS = {"stco": ">I", "co64": ">Q"}  # tables of offsets of data in the file, and the format of a number
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
            raise ValueError(f"no complete box at byte {offset + place}")
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
    """Pad files to equal size by free boxes of zeros, which players skip; earlier padding is replaced.

    One box at the end of moov makes the tables of frames equally large, whose sizes follow the motion; another one at
    the end of the file makes the files equally large.

    Raises:
        RenderError: for a file that is not an MP4 file.
    """
    before = {path: path.read_bytes() for path in files}
    bare: dict[Path, bytes] = {}
    for path, data in before.items():
        try:
            bare[path] = _with_moov_padding(data[: content_size(data)], 0)
        except ValueError as error:
            raise RenderError(f"{path}: not an MP4 file: {error}") from None
    largest = max(map(moov_size, bare.values())) + _HEAD
    padded = {path: _with_moov_padding(data, largest - moov_size(data)) for path, data in bare.items()}
    size = max(map(len, padded.values())) + _HEAD
    for path, data in padded.items():
        whole = data + _free(size - len(data))
        if whole != before[path]:
            with writing(path) as file:
                file.write(whole)


def moov_size(data: bytes) -> int:
    """Return the size of the box of tables, moov [bytes]; 0 without one. Raises ValueError as `boxes`."""
    return next((_HEAD + len(box.body) for box in boxes(data) if box.kind == "moov"), 0)


def _free(size: int) -> bytes:
    return struct.pack(">I4s", size, b"free") + bytes(size - _HEAD) if size else b""


def _with_moov_padding(data: bytes, padding: int) -> bytes:
    """Return a file whose moov box ends in a free box of so many bytes (0: none), in place of an earlier one."""
    parts = list(boxes(data))
    moov = next((box for box in parts if box.kind == "moov"), None)
    if moov is None:
        return data
    start, end = moov.start, moov.start + _HEAD + len(moov.body)
    old = next(
        (b for b in parts if b.kind == "free" and start < b.start and b.start + _HEAD + len(b.body) == end), None
    )
    kept = data[start + _HEAD : old.start if old else end]
    body = kept + _free(padding)
    head = struct.pack(">I4s", _HEAD + len(body), b"moov")
    whole = bytearray(data[:start] + head + body + data[end:])
    shift = len(whole) - len(data)
    for box in parts:  # tables of offsets, in the part of moov that stays
        if box.kind in _OFFSETS and box.start < start + _HEAD + len(kept):
            _shift(whole, box, end, shift)
    return bytes(whole)


def _shift(data: bytearray, table: Box, after: int, shift: int) -> None:
    """Move the offsets of a table that point behind a place."""
    number, first = struct.Struct(_OFFSETS[table.kind]), table.start + _HEAD + 8
    (count,) = struct.unpack_from(">I", table.body, 4)
    for place in range(first, first + number.size * count, number.size):
        (offset,) = number.unpack_from(data, place)
        number.pack_into(data, place, offset + shift if offset >= after else offset)
