"""Frames out of a finished video, small."""

import subprocess
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np

from emovid.errors import InputError, RenderError
from emovid.swarm.arrays import Array, Indices
from emovid.video.canvas import Pixels
from emovid.video.encode import address, ffmpeg
from emovid.video.formats import PICTURE

_PATIENCE, _LONG = 60, 600  # seconds that reading a frame, or a whole video, may take


class Film(NamedTuple):
    """When the frames of a video are shown, and how large they are.

    Attributes:
        times: at which each appears (F,), from 0 [s].
        end: of the last [s].
        width: as shown [pixels].
        height: likewise.
    """

    times: Array
    end: float
    width: int
    height: int

    def shown_at(self, times: Array) -> Indices:
        """Return which frame is there at each of the times (K,) from 0 to the end [s]."""
        half = np.diff(self.times, append=self.end).min() / 2  # of a frame: times of frames are rounded in files
        return np.searchsorted(self.times - min(half, 1e-3), times, side="right") - 1


def read_film(video: Path) -> Film:
    """Return what there is in a video file of any kind that ffmpeg reads.

    Raises:
        InputError: if it is none.
    """
    # Decoded, not only unpacked: what an edit list hides, and where B-frames come to stand, the decoder knows.
    listed = _asked(["-i", address(video), "-map", "0:v:0", "-fps_mode", "passthrough", "-f", "framecrc"])
    lines = listed.stdout.decode(errors="replace").splitlines() if listed.returncode == 0 else []
    head = dict(line[1:].split(": ", 1) for line in lines if line.startswith("#"))
    frames = [tuple(map(int, line.split(",")[2:4])) for line in lines if line[:1].isdigit()]  # start and length [ticks]
    if not frames:
        raise InputError(f"{video}: no video that can be read")
    tick, (width, height) = Fraction(head["tb 0"]), map(int, head["dimensions 0"].split("x"))
    shape = head.get("sar 0", "0/1")  # of a pixel, width by height; 0/1 is not known
    (first, _), (last, length) = frames[0], frames[-1]
    times = np.array([start - first for start, _ in frames]) * float(tick)
    end = float((last - first + max(length, 1)) * tick)  # rounded once: 3 s of video end at 3, and not a little before
    return Film(times, end, round(width * (Fraction(shape) or 1)), height)


def film_frames(video: Path, chosen: Sequence[int], width: int, height: int) -> Pixels:
    """Return some frames of a video file as (K, height, width, 3) RGB, fitted in on white.

    Raises:
        RenderError: if they cannot be read.
    """
    numbers, places = np.unique(chosen, return_inverse=True)
    which = "+".join(f"eq(n,{number})" for number in numbers)
    source = ["-i", address(video), "-map", "0:v:0", "-fps_mode", "passthrough"]
    filters = f"select='{which}',{_fitted(width, height)}"
    return _pictures(video, [*source, "-vf", filters], len(numbers), width, height, _LONG)[places]


def last_frame(video: Path, frames: int, fps: int, width: int, height: int) -> Pixels:
    """Return the last frame of a file, or of a folder of pictures, as (height, width, 3) RGB, fitted in on white.

    Args:
        video: as `render_video` made it.
        frames: how many it has.
        fps: how many a second.
        width: of the result [pixels].
        height: likewise.

    Raises:
        RenderError: if it cannot be read.
    """
    source = ["-i", address(video / (PICTURE % (frames - 1)))] if video.is_dir() else _from((frames - 1.5) / fps, video)
    try:
        return _pictures(video, [*source, "-vf", _fitted(width, height)], 1, width, height, _PATIENCE)[0]
    except RenderError:
        raise RenderError(f"{video}: its last frame cannot be read: make it again with --force") from None


def _from(seconds: float, video: Path) -> list[str]:
    return ["-ss", f"{max(seconds, 0):.6f}", "-i", address(video)]


def _fitted(width: int, height: int) -> str:
    """Return the filters that fit a frame into a white picture."""
    fit = (
        f"scale={width}:{height}:force_original_aspect_ratio=decrease:flags=area+accurate_rnd+full_chroma_int+bitexact"
    )
    return f"{fit},format=rgb24,pad={width}:{height}:-1:-1:white"


def _pictures(video: Path, arguments: Sequence[str], count: int, width: int, height: int, patience: int) -> Pixels:
    """Return the first frames that ffmpeg makes (count, height, width, 3)."""
    done = _asked([*arguments, "-frames:v", str(count), "-threads", "1", "-f", "rawvideo"], patience)
    try:
        return np.frombuffer(done.stdout, np.uint8).reshape(count, height, width, 3)
    except ValueError:
        raise RenderError(f"{video}: its frames cannot be read") from None


def _asked(arguments: Sequence[str], patience: int = _LONG) -> "subprocess.CompletedProcess[bytes]":
    """Return what ffmpeg says of, or makes from, an input.

    Raises:
        RenderError: if it does not answer.
    """
    command = [ffmpeg(), "-v", "error", "-nostdin", *arguments, "-"]
    try:
        return subprocess.run(command, capture_output=True, check=False, timeout=patience)
    except (OSError, subprocess.SubprocessError):
        raise RenderError(f"ffmpeg does not answer: {ffmpeg()}") from None
