"""A reader of MP4 boxes and frames: metadata and content of a file."""

import struct
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from emovid.video import ffmpeg

_CONTAINERS = {b"moov", b"trak", b"mdia", b"minf", b"stbl"}


@dataclass
class Box:
    kind: str
    start: int
    body: bytes


def boxes(path: Path) -> list[Box]:
    """Return all boxes of a file in order, those inside containers after them."""
    return list(_walk(path.read_bytes(), 0))


def _walk(data: bytes, offset: int) -> Iterator[Box]:
    place = 0
    while place < len(data):
        size, kind = struct.unpack_from(">I4s", data, place)
        head = 8
        if size == 1:
            size, head = struct.unpack_from(">Q", data, place + 8)[0], 16
        body = data[place + head : place + size]
        yield Box(kind.decode("latin1"), offset + place, body)
        if kind in _CONTAINERS:
            yield from _walk(body, offset + place + head)
        place += size


def only(path: Path, kind: str) -> Box:
    found = [box for box in boxes(path) if box.kind == kind]
    assert len(found) == 1, f"{len(found)} boxes {kind}"
    return found[0]


def table(box: Box, form: str) -> list[tuple[int, ...]]:
    """Return the rows of a full box that consists of a count and a table."""
    count = struct.unpack_from(">I", box.body, 4)[0]
    return [struct.unpack_from(form, box.body, 8 + i * struct.calcsize(form)) for i in range(count)]


def decode(path: Path, width: int, height: int) -> np.ndarray:
    """Return all frames (F, height, width, 3), RGB by the bt709 matrix."""
    return np.stack(list(decoded(path, width, height)))


def decoded(path: Path, width: int, height: int) -> Iterator[np.ndarray]:
    """Yield the frames (height, width, 3) one by one."""
    conversion = "scale=in_color_matrix=bt709:in_range=tv:flags=accurate_rnd+full_chroma_int,format=rgb24"
    command = [ffmpeg.executable(), "-v", "error", "-xerror", "-i", str(path), "-vf", conversion, "-f", "rawvideo", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout
        while raw := process.stdout.read(3 * width * height):
            yield np.frombuffer(raw, np.uint8).reshape(height, width, 3)
    assert process.returncode == 0


def stream_line(path: Path) -> str:
    """Return the line of ffmpeg about the only stream."""
    said = subprocess.run(
        [ffmpeg.executable(), "-hide_banner", "-i", str(path)], capture_output=True, text=True, check=False
    ).stderr
    streams = [line.strip() for line in said.splitlines() if line.strip().startswith("Stream #")]
    assert len(streams) == 1, streams
    return streams[0]
