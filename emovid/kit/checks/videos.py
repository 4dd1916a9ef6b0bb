"""Checks of the videos: no metadata, identical encoding, the files of the manifest, no run of a public scene."""

import re
import struct
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emovid.atomic_io import file_digest
from emovid.kit.checks.findings import Finding, Hints
from emovid.kit.folder import Kit
from emovid.kit.manifest import PublicVideo
from emovid.kit.mp4 import Box, boxes
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate
from emovid.video import ffmpeg
from emovid.video.canvas import Pixels
from emovid.video.painter import Painter

# Boxes of a file with a single H.264 track.
_BOXES = (
    "ftyp", "moov", "mvhd", "trak", "tkhd", "edts", "elst", "mdia", "mdhd", "hdlr", "minf", "vmhd", "dinf", "dref",
    "stbl", "stsd", "stts", "stss", "stsc", "stsz", "stco", "udta", "free", "mdat",
)  # fmt: skip
_NO_TAGS = bytes.fromhex("00000035") + b"meta" + bytes(4) + bytes.fromhex("00000021") + b"hdlr" + bytes(8) + b"mdirappl"
_TIMED = ("mvhd", "tkhd", "mdhd")
_SLICES = (1, 5)  # kinds of units in the stream
_SETTINGS = ("ftyp", "mdhd", "hdlr", "stts", "stss", "stsd")  # identical for identical formats and encoder settings

# Correlation of frames. One run before and after encoding: 0.999. A stimulus and the public run of its scene: at most
# 0.82 at 1280x720 and 0.984 at 160x90 (25 and 60 kits).
_SAME = 0.99
_SEEN = 20  # least difference in gray level between robots or trails and the stage
_WHEN = (0.0, 0.3, 0.6, 0.9)  # compared frames, as shares of the duration

Picture = NDArray[np.float64]


def check_content(kit: Kit, hints: Hints) -> Iterator[Finding]:
    """Check that the stimuli contain no metadata, no readable hint and no hidden data."""
    for video, path in _videos(kit):
        data = path.read_bytes()
        try:
            found = list(boxes(data))
        except ValueError as error:
            yield Finding("metadata", video.file, f"not an MP4 file: {error}")
            continue
        for box in found:
            for message in _oddities(box):
                yield Finding("metadata", video.file, message)
        outside = b"\n".join(
            box.body for box in found if box.kind not in ("mdat", "moov", "trak", "mdia", "minf", "stbl")
        )
        if named := hints.in_bytes(outside):
            yield Finding("strings", video.file, "names an emotion", tuple(sorted(named)))


def check_decoding(kit: Kit) -> Iterator[Finding]:
    """Check that every stimulus is the file that the manifest describes, and decodes completely."""
    for video, path in _videos(kit):
        if path.stat().st_size != video.bytes or file_digest(path) != video.sha256:
            yield Finding("videos", video.file, "not the file that the manifest describes")
        if problem := _decoding_problem(path, video):
            yield Finding("videos", video.file, problem)


def check_alike(kit: Kit) -> Iterator[Finding]:
    """Check that stimuli have equal length, size, rate and encoding, and that none is a copy of another."""
    known: dict[object, str] = {}
    for name in ("bytes", "frames", "fps", "width", "height", "duration"):
        values = [getattr(video, name) for video in kit.manifest.videos]
        if len(set(values)) > 1:
            yield Finding("alike", "public/manifest.json", f"videos differ in {name}: {min(values)} to {max(values)}")
    settings: dict[tuple[bytes, ...], str] = {}
    for video, path in _videos(kit):
        digest = file_digest(path)
        if digest in known:
            yield Finding("alike", video.file, f"the same file as {known[digest]}")
        known.setdefault(digest, video.file)
        settings.setdefault(_settings(path), video.file)
    if len(settings) > 1:
        yield Finding("alike", " and ".join(settings.values()), "encoded with different settings")


def _videos(kit: Kit) -> Iterator[tuple[PublicVideo, Path]]:
    for video in kit.manifest.videos:
        path = kit.folder.public / video.file
        if path.is_file():
            yield video, path


def _oddities(box: Box) -> Iterator[str]:
    """Yield the contents of a box that no stimulus should have."""
    if box.kind not in _BOXES:
        yield f"unexpected box {box.kind!r}"
    if box.kind in _TIMED and any(_times(box)):
        yield f"time stamp in {box.kind}"
    if box.kind == "free" and any(box.body):
        yield "data in the padding"
    if box.kind == "udta" and box.body != _NO_TAGS + bytes(9) + bytes.fromhex("00000008") + b"ilst":
        yield "tags"
    if box.kind == "hdlr" and box.body[24:].strip(b"\0") not in (b"", b"VideoHandler"):
        yield "name of a track"
    if box.kind == "mdat" and (kinds := _units(box.body) - set(_SLICES)):
        yield f"units of kind {', '.join(map(str, sorted(kinds)))} in the stream; expected only slices"


def _times(box: Box) -> tuple[int, ...]:
    """Return the creation and modification times of a box [s], 0 for none (ISO/IEC 14496-12)."""
    wide = box.body[:1] == b"\1"
    form = ">QQ" if wide else ">II"
    return struct.unpack_from(form, box.body, 4) if len(box.body) >= 4 + struct.calcsize(form) else (0,)


def _units(stream: bytes) -> set[int]:
    """Return the kinds of units in an H.264 stream with length prefixes; -1 among them for other data."""
    kinds, place = set(), 0
    while place + 5 <= len(stream):
        kinds.add(stream[place + 4] & 0x1F)
        place += 4 + int(struct.unpack_from(">I", stream, place)[0])
    return kinds if place == len(stream) else {*kinds, -1}


def _settings(path: Path) -> tuple[bytes, ...]:
    try:
        found = {box.kind: box.body for box in boxes(path.read_bytes())}
    except ValueError:
        return ()
    found["stsd"] = found.get("stsd", b"").partition(b"btrt")[0]  # the bit rate follows
    return tuple(found.get(kind, b"") for kind in _SETTINGS)


def _decoding_problem(path: Path, video: PublicVideo) -> str:
    source = ["-hide_banner", "-nostdin", "-nostats", "-xerror", "-i", ffmpeg.address(path), "-map", "0:v:0"]
    done = ffmpeg.run([*source, "-f", "null", "-progress", "pipe:1", "-"])
    if done.status or "rror" in done.messages:
        return "does not decode completely"
    frames = int(re.findall(rb"^frame=\s*(\d+)", done.data, re.MULTILINE)[-1])
    if frames != video.frames:
        return f"{frames} frames; the manifest says {video.frames}"
    size = f"{video.width}x{video.height}"
    return "" if f" {size}" in done.messages else f"not {size} pixels large"


def check_scenes(kit: Kit) -> Iterator[Finding]:
    """Check that no stimulus shows the run of a public scene, which anybody can repeat and compare.

    Frames are compared rather than bytes, so that a copy with another encoding is found too.
    """
    like = kit.manifest.videos[0]
    paths = {video.file: kit.folder.public / video.file for video in kit.manifest.videos}
    decoded = {file: _decoded(path, like) for file, path in paths.items() if path.is_file()}
    everything = [picture for pictures in decoded.values() for picture in pictures]
    if not everything:
        return
    stage = np.median(everything, axis=0)
    for name in EMOTIONS:
        shown = _drawn(name, like.frames, like.fps, f"{like.width}x{like.height}")
        for file, pictures in decoded.items():
            if likeness(pictures, shown, stage) > _SAME:
                yield Finding("scenes", file, "shows the run of a public scene", (name,))


def likeness(first: Sequence[Picture], second: Sequence[Picture], stage: Picture) -> float:
    """Return the least correlation of corresponding frames of two videos, each minus the empty stage."""
    if len(first) != len(second):
        return 0.0
    return min(_correlation(a - stage, b - stage) for a, b in zip(first, second, strict=True))


@cache
def _drawn(emotion: str, frames: int, fps: int, size: str) -> list[Picture]:
    """Return the compared frames of a public scene with the duration of the videos."""
    keys = {"duration": frames / fps, "video.size": size, "video.fps": fps}
    scene = load_scene(emotion, [Setting(key, value, "manifest.json") for key, value in keys.items()])
    painter = Painter(simulate(scene))
    return [_gray(painter.frame(k / fps)[..., :3]) for k in _numbers(frames)]


def _decoded(path: Path, like: PublicVideo) -> list[Picture]:
    """Return the compared frames of a file, scaled to the size of `like`; fewer if the file has fewer."""
    chosen = "+".join(f"eq(n\\,{k})" for k in _numbers(like.frames))
    filters = f"select={chosen},scale={like.width}:{like.height}:in_color_matrix=bt709:in_range=tv,format=rgb24"
    source = ["-v", "error", "-nostdin", "-i", ffmpeg.address(path), "-vf", filters, "-fps_mode", "passthrough"]
    data = ffmpeg.run([*source, "-f", "rawvideo", "-"]).data
    size = 3 * like.width * like.height
    frames = [data[i : i + size] for i in range(0, len(data), size)]
    shape = like.height, like.width, 3
    return [_gray(np.frombuffer(frame, np.uint8).reshape(shape)) for frame in frames if len(frame) == size]


def _numbers(frames: int) -> list[int]:
    return sorted({int(share * frames) for share in _WHEN})


def _gray(picture: Pixels) -> Picture:
    return picture.astype(float) @ [0.2126, 0.7152, 0.0722]


def _correlation(first: Picture, second: Picture) -> float:
    seen = (np.abs(first) > _SEEN) | (np.abs(second) > _SEEN)
    scale = float(np.sqrt((first[seen] ** 2).sum() * (second[seen] ** 2).sum()))
    return float((first[seen] * second[seen]).sum()) / scale if scale else 0.0
