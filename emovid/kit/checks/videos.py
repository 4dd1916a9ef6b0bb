"""What is inside the stimuli besides the picture, and whether they are what the manifest says."""

import re
import struct
from collections.abc import Iterator
from pathlib import Path

from emovid.atomic_io import file_digest
from emovid.kit.checks.finding import Finding
from emovid.kit.checks.hints import Hints
from emovid.kit.manifest import Video
from emovid.kit.mp4 import Box, boxes
from emovid.kit.read import Kit
from emovid.video import ffmpeg

# Boxes of a file with one H.264 track and nothing else, and the kinds of units in its stream: slices, and what a
# decoder needs to read them.
_BOXES = (
    "ftyp", "moov", "mvhd", "trak", "tkhd", "edts", "elst", "mdia", "mdhd", "hdlr", "minf", "vmhd", "dinf", "dref",
    "stbl", "stsd", "stts", "stss", "stsc", "stsz", "stco", "udta", "free", "mdat",
)  # fmt: skip
_NO_TAGS = bytes.fromhex("00000035") + b"meta" + bytes(4) + bytes.fromhex("00000021") + b"hdlr" + bytes(8) + b"mdirappl"
_TIMED = ("mvhd", "tkhd", "mdhd")
_SLICES = (1, 5)
_SETTINGS = ("ftyp", "mdhd", "hdlr", "stts", "stss", "stsd")  # equal where format, encoder and its settings are


def check_content(kit: Kit, hints: Hints) -> Iterator[Finding]:
    """Check that the stimuli hold no metadata, no readable hint, and nothing hidden."""
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
    """Check that every stimulus is the file of the manifest and decodes to its last frame."""
    for video, path in _videos(kit):
        if path.stat().st_size != video.bytes or file_digest(path) != video.sha256:
            yield Finding("videos", video.file, "not the file that the manifest describes")
        if problem := _decoding_problem(path, video):
            yield Finding("videos", video.file, problem)


def check_alike(kit: Kit) -> Iterator[Finding]:
    """Check that stimuli are equal in length, size, rate and encoding, and that none is another's copy."""
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


def _videos(kit: Kit) -> Iterator[tuple[Video, Path]]:
    for video in kit.manifest.videos:
        path = kit.folder.public / video.file
        if path.is_file():
            yield video, path


def _oddities(box: Box) -> Iterator[str]:
    """Yield what a box holds that no stimulus should."""
    if box.kind not in _BOXES:
        yield f"a box {box.kind!r}"
    if box.kind in _TIMED and any(_times(box)):
        yield f"a time in {box.kind}"
    if box.kind == "free" and any(box.body):
        yield "something in the room that should be empty"
    if box.kind == "udta" and box.body != _NO_TAGS + bytes(9) + bytes.fromhex("00000008") + b"ilst":
        yield "tags"
    if box.kind == "hdlr" and box.body[24:].strip(b"\0") not in (b"", b"VideoHandler"):
        yield "a name of the track"
    if box.kind == "mdat" and (kinds := _units(box.body) - set(_SLICES)):
        yield f"units of kind {', '.join(map(str, sorted(kinds)))} in the stream: only slices are expected"


def _times(box: Box) -> tuple[int, ...]:
    """Return when a box says that it was made and changed; ISO/IEC 14496-12 counts seconds, 0 is none."""
    wide = box.body[:1] == b"\1"
    form = ">QQ" if wide else ">II"
    return struct.unpack_from(form, box.body, 4) if len(box.body) >= 4 + struct.calcsize(form) else (0,)


def _units(stream: bytes) -> set[int]:
    """Return the kinds of the units in an H.264 stream, each preceded by its length; -1 where that is no stream."""
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
    found["stsd"] = found.get("stsd", b"").partition(b"btrt")[0]  # what follows is the bit rate
    return tuple(found.get(kind, b"") for kind in _SETTINGS)


def _decoding_problem(path: Path, video: Video) -> str:
    source = ["-hide_banner", "-nostdin", "-nostats", "-xerror", "-i", ffmpeg.address(path), "-map", "0:v:0"]
    done = ffmpeg.run([*source, "-f", "null", "-progress", "pipe:1", "-"])
    if done.status or "rror" in done.messages:
        return "does not decode to its end"
    frames = int(re.findall(rb"^frame=\s*(\d+)", done.data, re.MULTILINE)[-1])
    if frames != video.frames:
        return f"{frames} frames; the manifest says {video.frames}"
    size = f"{video.width}x{video.height}"
    return "" if f" {size}" in done.messages else f"not {size} pixels large"
