"""One frame out of a finished video, small."""

import subprocess
from pathlib import Path

import numpy as np

from emovid.errors import RenderError
from emovid.video.canvas import Pixels
from emovid.video.encode import ffmpeg
from emovid.video.formats import PICTURE

_PATIENCE = 60  # seconds


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
    source = ["-i", str(video / (PICTURE % (frames - 1)))] if video.is_dir() else _from((frames - 1.5) / fps, video)
    fit = (
        f"scale={width}:{height}:force_original_aspect_ratio=decrease:flags=area+accurate_rnd+full_chroma_int+bitexact"
    )
    pad = f"format=rgb24,pad={width}:{height}:-1:-1:white"
    command = [ffmpeg(), "-v", "error", "-nostdin", *source, "-frames:v", "1", "-vf", f"{fit},{pad}"]
    try:
        done = subprocess.run(
            [*command, "-threads", "1", "-f", "rawvideo", "-"], capture_output=True, check=True, timeout=_PATIENCE
        )
        return np.frombuffer(done.stdout, np.uint8).reshape(height, width, 3)
    except (OSError, ValueError, subprocess.SubprocessError):
        raise RenderError(f"{video}: its last frame cannot be read: make it again with --force") from None


def _from(seconds: float, video: Path) -> list[str]:
    return ["-ss", f"{max(seconds, 0):.6f}", "-i", str(video)]
