"""Frames to an H.264 file: ffmpeg owned from start to end, and no file under the name that is not whole.

imageio-ffmpeg brings the binary and nothing else: its writer ignores the exit status of ffmpeg, and an interrupted run
leaves a short but playable file under the final name.
"""

import re
import subprocess
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import IO

import imageio_ffmpeg

from emovid.errors import RenderError
from emovid.signals import held_signals
from emovid.video.draw import Pixels
from emovid.whole_files import reason, whole_file

_GRACE = 60  # seconds ffmpeg may take to finish a file once it has all frames


def encoder_arguments(width: int, height: int, fps: int) -> list[str]:
    """Return ffmpeg's arguments between the executable and the output: what decides the bytes of the video.

    RGBA frames on stdin become H.264 High, yuv420p, bt709 tagged in full, one closed GOP a second, no B-frames (every
    browser seeks to the frame), no audio, the index in front. One thread, `cpu-independent` and `bitexact` everywhere
    make equal bytes on every CPU; `filter_units` drops x264's banner. crf 16 is visually lossless.
    """
    colour = "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+bitexact,format=yuv420p"
    tags = "setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709:range=tv"
    return [
        *("-hide_banner", "-nostdin", "-v", "error", "-y"),
        *("-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{width}x{height}", "-r", str(fps), "-i", "pipe:0", "-an"),
        *("-vf", f"{colour},{tags}"),
        *("-c:v", "libx264", "-preset", "veryfast", "-crf", "16", "-profile:v", "high"),
        *("-g", str(fps), "-keyint_min", str(fps), "-sc_threshold", "0", "-bf", "0"),
        *("-threads", "1", "-x264-params", "cpu-independent=1:open-gop=0", "-bsf:v", "filter_units=remove_types=6"),
        *("-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", "-movflags", "+faststart"),
        *("-f", "mp4"),
    ]


def write_video(
    frames: Iterable[Pixels],
    count: int,
    arguments: list[str],
    target: Path,
    on_frame: Callable[[int], None] | None = None,
) -> None:
    """Encode `count` frames into `target`, which appears only when ffmpeg has succeeded and the frames are counted.

    Args:
        frames: each (height, width, 4), RGBA; a frame may reuse the buffer of the one before.
        count: how many.
        arguments: see `encoder_arguments`.
        target: in a folder that exists. What was there stays until it is replaced whole.
        on_frame: called with the number of frames handed over; what it raises ends the encoding.

    Raises:
        RenderError: with ffmpeg's own words.
    """
    with whole_file(target) as part, tempfile.TemporaryFile() as log:
        command = [ffmpeg(), *arguments, str(part)]
        process = None
        try:
            with held_signals():
                process = _start(command, target, log)
            _feed(process, frames, on_frame)
            status = process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            raise RenderError(f"{target}: ffmpeg did not finish within {_GRACE} s of the last frame") from None
        finally:
            with held_signals():
                _end(process)
        if status:
            raise RenderError(f"{target}: ffmpeg failed with exit status {status}: {_last_line(log)}")
        if (found := count_frames(part)) != count:
            raise RenderError(f"{target}: ffmpeg wrote {found} of {count} frames")


@cache
def ffmpeg() -> str:
    """Return the ffmpeg executable.

    Raises:
        RenderError: if there is none.
    """
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:
        raise RenderError("no ffmpeg found: reinstall imageio-ffmpeg, or set IMAGEIO_FFMPEG_EXE") from None


@cache
def ffmpeg_version() -> str:
    """Return the version that ffmpeg reports of itself."""
    said = subprocess.run([ffmpeg(), "-version"], capture_output=True, text=True, check=False).stdout
    found = re.match(r"ffmpeg version (\S+)", said)
    return found[1] if found else "unknown"


def count_frames(video: Path) -> int:
    """Return the number of frames in a file, by walking through its packets; 0 for a file that is no video."""
    command = [ffmpeg(), "-v", "error", "-nostdin", "-i", str(video), "-map", "0:v:0", "-c", "copy", "-f", "null"]
    done = subprocess.run([*command, "-progress", "pipe:1", "-"], capture_output=True, text=True, check=False)
    counts = re.findall(r"^frame=\s*(\d+)", done.stdout, re.MULTILINE)
    return int(counts[-1]) if counts and done.returncode == 0 else 0


def _start(command: list[str], target: Path, log: IO[bytes]) -> "subprocess.Popen[bytes]":
    try:
        return subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=log,  # a file: a full pipe would block ffmpeg
            bufsize=0,
            process_group=0,  # Ctrl-C is ours to handle
        )
    except OSError as error:
        raise RenderError(f"{target}: ffmpeg cannot be started: {command[0]}: {reason(error)}") from None


def _feed(process: "subprocess.Popen[bytes]", frames: Iterable[Pixels], on_frame: Callable[[int], None] | None) -> None:
    pipe = process.stdin
    assert pipe is not None
    try:
        for k, frame in enumerate(frames, start=1):
            rest = frame.data.cast("B")
            while rest:
                rest = rest[pipe.write(rest) :]
            if on_frame:
                on_frame(k)
        pipe.close()
    except BrokenPipeError:  # ffmpeg has gone; its exit status says why
        pass


def _end(process: "subprocess.Popen[bytes] | None") -> None:
    """Leave no ffmpeg behind, whatever happened."""
    if process and process.stdin:
        process.stdin.close()
    if process and process.poll() is None:
        process.kill()
        process.wait()


def _last_line(log: IO[bytes]) -> str:
    log.seek(0)
    lines = log.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else "no message"
