"""Finished videos as stimuli: checks, and encoding like all other videos."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from emovid.errors import SourceError
from emovid.kit.seeded_random import draw
from emovid.kit.study import Look
from emovid.scene.video import Video
from emovid.video import ffmpeg
from emovid.video.canvas import Pixels
from emovid.video.encoder import video_arguments, write_video

# Of the first frame with the rotation of the file applied: shape of a pixel, and size.
_SHOWN = re.compile(r"showinfo.* sar:(\d+)/(\d+) s:(\d+x\d+) ")
_RATE = re.compile(r"Stream #.*Video:.*?([\d.]+) fps")
_BLOCK = 16  # side [pixels] of the squares with changed luma: a macroblock of H.264


def check_video(video: Path, look: Look) -> None:
    """Check that a finished video has the format of all others.

    Raises:
        SourceError: for a file that is not a video, or has another size, frame rate, number of frames or pixel shape.
    """
    if not video.is_file():
        raise SourceError(str(video), "no such file")
    found = ffmpeg.count_frames(video)
    source = ["-hide_banner", "-nostdin", "-i", ffmpeg.address(video), "-map", "0:v:0", "-frames:v", "1"]
    messages = ffmpeg.run([*source, "-vf", "showinfo", "-f", "null", "-"]).messages
    shown, rate = _SHOWN.search(messages), _RATE.search(messages)
    if not (found and shown and rate):
        raise SourceError(str(video), "cannot be decoded as a video")
    across, down, size = shown.groups()
    if across not in ("0", down):  # 0: unknown, which players take as square
        raise SourceError(str(video), f"has pixels of {across}:{down}; expected square pixels")
    given = f"{size}, {float(rate[1]):g} fps, {found} frames"
    wanted = f"{look.size}, {look.fps} fps, {look.frames} frames"
    if given != wanted:
        raise SourceError(str(video), f"has {given}; expected {wanted}, as for all videos of the study")


def reencode(video: Path, target: Path, look: Look, seed: int) -> None:
    """Encode a finished video like all others, without sound and metadata.

    The lowest bit of the luma changes in random squares, by the private seed. The change is invisible, and the
    file cannot be reproduced from the public video.

    Raises:
        RenderError: if it cannot be decoded or encoded.
    """
    width, height = map(int, look.size.split("x"))
    planes = _planes(video, width, height, grain(width, height, seed))
    write_video(planes, look.frames, video_arguments(Video(size=look.size, fps=look.fps)), target)


def grain(width: int, height: int, seed: int) -> Pixels:
    """Return 1 for pixels whose lowest bit of luma changes, otherwise 0, (height, width): constant in squares."""
    rows, columns = -(-height // _BLOCK), -(-width // _BLOCK)
    numbers = [draw(seed, "grain", i) for i in range(-(-rows * columns // 256))]
    bits = np.unpackbits(np.frombuffer(b"".join(n.to_bytes(32) for n in numbers), np.uint8))[: rows * columns]
    return bits.reshape(rows, columns).repeat(_BLOCK, axis=0).repeat(_BLOCK, axis=1)[:height, :width]


def _planes(video: Path, width: int, height: int, changed: Pixels) -> Iterator[Pixels]:
    """Yield the frames as yuv420p, in one buffer."""
    conversion = "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+bitexact,format=yuv420p"
    for planes in ffmpeg.decode(video, conversion, width * height * 3 // 2):
        planes[: width * height] ^= changed.ravel()
        yield planes
