"""Frames from a finished video of any kind that ffmpeg reads."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np

from emovid.errors import InputError, RenderError
from emovid.swarm.arrays import Array, Indices
from emovid.video import ffmpeg
from emovid.video.canvas import Pixels
from emovid.video.encoder import PICTURE

_FRAME_TIMEOUT = 60  # seconds for one frame


class FrameTimes(NamedTuple):
    """Times at which a video shows its frames, and its size.

    Attributes:
        times: at which each frame appears (F,), from 0 [s].
        end: of the last frame [s].
        width, height: as shown [pixels].
    """

    times: Array
    end: float
    width: int
    height: int

    def frames_at(self, times: Array) -> Indices:
        """Return the indices (K,) of the frames that are shown at times (K,) from 0 to the end [s]."""
        half = np.diff(self.times, append=self.end).min() / 2  # of a frame: times of frames are rounded in files
        return np.searchsorted(self.times - min(half, 1e-3), times, side="right") - 1


def frame_times(video: Path) -> FrameTimes:
    """Return the times of all frames of a video file.

    Raises:
        InputError: if it is not a video.
    """
    # Decoded, not only unpacked: the decoder applies edit lists and the order of B-frames.
    listing = ["-i", ffmpeg.address(video), "-map", "0:v:0", "-fps_mode", "passthrough", "-f", "framecrc", "-"]
    done = ffmpeg.run(["-v", "error", "-nostdin", *listing])
    lines = done.data.decode(errors="replace").splitlines() if done.status == 0 else []
    head = dict(line[1:].split(": ", 1) for line in lines if line.startswith("#"))
    frames = [tuple(map(int, line.split(",")[2:4])) for line in lines if line[:1].isdigit()]  # start and length [ticks]
    if not frames:
        raise InputError(f"{video}: cannot be read as a video")
    tick, (width, height) = Fraction(head["tb 0"]), map(int, head["dimensions 0"].split("x"))
    aspect = head.get("sar 0", "0/1")  # of a pixel, width by height; 0/1 if unknown
    (first, _), (last, length) = frames[0], frames[-1]
    times = np.array([start - first for start, _ in frames]) * float(tick)
    end = float((last - first + max(length, 1)) * tick)  # rounded once, so that a video of 3 s ends at exactly 3
    return FrameTimes(times, end, round(width * (Fraction(aspect) or 1)), height)


def read_frames(video: Path, indices: Sequence[int], width: int, height: int) -> Pixels:
    """Return frames of a video file as (K, height, width, 3) RGB, scaled to fit on white.

    Raises:
        RenderError: if they cannot be read.
    """
    numbers, places = np.unique(indices, return_inverse=True)
    which = "+".join(f"eq(n,{number})" for number in numbers)
    source = ["-i", ffmpeg.address(video), "-map", "0:v:0", "-fps_mode", "passthrough"]
    filters = f"select='{which}',{_fitted(width, height)}"
    return _read(video, [*source, "-vf", filters], len(numbers), width, height)[places]


def read_last_frame(video: Path, frames: int, fps: int, width: int, height: int) -> Pixels:
    """Return the last frame of a file, or of a folder of pictures, as (height, width, 3) RGB, scaled to fit on white.

    Args:
        video: written by `render_video`.
        frames: number of frames in it.
        fps: frames per second.
        width: of the result [pixels].
        height: of the result [pixels].

    Raises:
        RenderError: if it cannot be read.
    """
    if video.is_dir():
        source = ["-i", ffmpeg.address(video / (PICTURE % (frames - 1)))]
    else:
        source = ["-ss", f"{max((frames - 1.5) / fps, 0):.6f}", "-i", ffmpeg.address(video)]
    try:
        return _read(video, [*source, "-vf", _fitted(width, height)], 1, width, height, _FRAME_TIMEOUT)[0]
    except RenderError:
        raise RenderError(f"{video}: its last frame cannot be read: make it again with --force") from None


def _fitted(width: int, height: int) -> str:
    """Return the filters that fit a frame into a white picture."""
    fit = (
        f"scale={width}:{height}:force_original_aspect_ratio=decrease:flags=area+accurate_rnd+full_chroma_int+bitexact"
    )
    return f"{fit},format=rgb24,pad={width}:{height}:-1:-1:white"


def _read(
    video: Path, arguments: Sequence[str], count: int, width: int, height: int, timeout: float | None = None
) -> Pixels:
    """Return the first frames of ffmpeg's output (count, height, width, 3)."""
    output = ["-frames:v", str(count), "-threads", "1", "-f", "rawvideo", "-"]
    done = ffmpeg.run(["-v", "error", "-nostdin", *arguments, *output], timeout)
    if len(done.data) != 3 * count * height * width:
        raise RenderError(f"{video}: its frames cannot be read")
    return np.frombuffer(done.data, np.uint8).reshape(count, height, width, 3)
