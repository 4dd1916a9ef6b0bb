"""Finished videos as stimuli: checked, decoded, and encoded again like all others."""

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

# Of the first frame as it is shown, turned as the file says: width and height of a pixel, and of the picture.
_SHOWN = re.compile(r"showinfo.* sar:(\d+)/(\d+) s:(\d+x\d+) ")
_RATE = re.compile(r"Stream #.*Video:.*?([\d.]+) fps")
_BLOCK = 16  # side [pixels] of the squares whose luma is one level off: one macroblock of H.264


def check_video(video: Path, look: Look) -> None:
    """Check that a finished video is like all others.

    Raises:
        SourceError: if it is none, or has another size, frame rate or number of frames, or pixels that are not square.
    """
    if not video.is_file():
        raise SourceError(str(video), "no such file")
    found = ffmpeg.count_frames(video)
    source = ["-hide_banner", "-nostdin", "-i", ffmpeg.address(video), "-map", "0:v:0", "-frames:v", "1"]
    said = ffmpeg.run([*source, "-vf", "showinfo", "-f", "null", "-"]).messages
    shown, rate = _SHOWN.search(said), _RATE.search(said)
    if not (found and shown and rate):
        raise SourceError(str(video), "cannot be decoded as a video")
    across, down, size = shown.groups()
    if across not in ("0", down):  # 0: the file does not say, and players take them for square
        raise SourceError(str(video), f"has pixels of {across}:{down}; expected square ones")
    given = f"{size}, {float(rate[1]):g} fps, {found} frames"
    wanted = f"{look.size}, {look.fps} fps, {look.frames} frames"
    if given != wanted:
        raise SourceError(str(video), f"has {given}; expected {wanted}, as all videos of the study")


def reencode(video: Path, target: Path, look: Look, seed: int) -> None:
    """Encode a finished video again, by our arguments, without its sound and metadata.

    Squares of the picture have their luma's lowest bit changed or not, by the private seed: nobody sees it, and no hash
    of what can be made from the public file is that of the result.

    Raises:
        RenderError: if it cannot be decoded or encoded.
    """
    width, height = map(int, look.size.split("x"))
    planes = _planes(video, width, height, grain(width, height, seed))
    write_video(planes, look.frames, video_arguments(Video(size=look.size, fps=look.fps)), target)


def grain(width: int, height: int, seed: int) -> Pixels:
    """Return which pixels' luma (height, width) has its lowest bit changed, 0 or 1: equal within squares."""
    rows, columns = -(-height // _BLOCK), -(-width // _BLOCK)
    numbers = [draw(seed, "grain", i) for i in range(-(-rows * columns // 256))]
    bits = np.unpackbits(np.frombuffer(b"".join(n.to_bytes(32) for n in numbers), np.uint8))[: rows * columns]
    return bits.reshape(rows, columns).repeat(_BLOCK, axis=0).repeat(_BLOCK, axis=1)[:height, :width]


def _planes(video: Path, width: int, height: int, changed: Pixels) -> Iterator[Pixels]:
    """Yield the frames as yuv420p, each overwritten by the next."""
    conversion = "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+bitexact,format=yuv420p"
    for planes in ffmpeg.decode(video, conversion, width * height * 3 // 2):
        planes[: width * height] ^= changed.ravel()
        yield planes
