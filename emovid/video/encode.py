"""Frames to a video: ffmpeg owned from start to end, and nothing under the name that is not whole.

imageio-ffmpeg brings the binary and nothing else: its writer ignores the exit status of ffmpeg, and an interrupted run
leaves a short but playable file under the final name.
"""

import errno
import os
import re
import select
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import IO

import imageio_ffmpeg

from emovid.atomic_io import cause, whole_file, whole_folder
from emovid.errors import InputError, RenderError, reason
from emovid.signals import held_signals
from emovid.video.canvas import Pixels
from emovid.video.formats import PICTURE, is_picture

_GRACE = 60  # seconds ffmpeg may take to accept more of a frame, and to finish a file once it has all of them
_INSTALL = "reinstall imageio-ffmpeg, or set IMAGEIO_FFMPEG_EXE"
_SYSTEM_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EACCES, errno.ENOENT)
_PATIENCE = 600  # seconds ffmpeg may take to say its version, or how many frames a file has


def write_video(
    frames: Iterable[Pixels],
    count: int,
    arguments: list[str],
    target: Path,
    on_frame: Callable[[int], None] | None = None,
) -> None:
    """Encode `count` frames into `target`, which appears only when ffmpeg has succeeded and the frames are counted.

    Args:
        frames: as the encoder takes them; a frame may reuse the buffer of the one before.
        count: how many.
        arguments: see `encoder_arguments`.
        target: in a folder that exists. What was there stays until it is replaced whole.
        on_frame: called with the number of frames handed over; what it raises ends the encoding.

    Raises:
        RenderError: with ffmpeg's own words.
    """
    with whole_file(target) as part:
        _encode(frames, [*arguments, address(part)], target, on_frame)
        _check_count(count_frames(part), count, target)


def write_pictures(
    frames: Iterable[Pixels],
    count: int,
    arguments: list[str],
    target: Path,
    on_frame: Callable[[int], None] | None = None,
) -> None:
    """Encode `count` frames into the folder `target`, as 00000.png and so on. See `write_video`.

    Raises:
        InputError: if `target` is there and is no folder of such pictures.
        RenderError: with ffmpeg's own words.
    """
    check_sequence(target)
    with whole_folder(target) as part:
        _encode(frames, [*arguments, address(part).replace("%", "%%") + f"/{PICTURE}"], target, on_frame)
        _check_count(len(list(part.iterdir())), count, target)


@cache
def ffmpeg() -> str:
    """Return the ffmpeg executable.

    Raises:
        RenderError: if there is none.
    """
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:
        raise RenderError(f"no ffmpeg found: {_INSTALL}") from None


@cache
def ffmpeg_version() -> str:
    """Return the version that ffmpeg reports of itself."""
    found = re.match(r"ffmpeg version (\S+)", _ask(["-version"]).stdout)
    return found[1] if found else "unknown"


def address(path: Path) -> str:
    """Return a path as ffmpeg takes it: in a name like 10:30.mp4 or concat:a it would see a protocol."""
    return f"file:{path}"


def count_frames(video: Path) -> int:
    """Return the number of frames in a file, by walking through its packets; 0 for a file that is no video."""
    arguments = ["-v", "error", "-nostdin", "-i", address(video), "-map", "0:v:0", "-c", "copy", "-f", "null"]
    done = _ask([*arguments, "-progress", "pipe:1", "-"])
    counts = re.findall(r"^frame=\s*(\d+)", done.stdout, re.MULTILINE)
    return int(counts[-1]) if counts and done.returncode == 0 else 0


def _ask(arguments: list[str]) -> "subprocess.CompletedProcess[str]":
    """Return what ffmpeg answers."""
    try:
        return subprocess.run(
            [ffmpeg(), *arguments], capture_output=True, text=True, errors="replace", check=False, timeout=_PATIENCE
        )
    except OSError as error:
        raise RenderError(f"ffmpeg cannot be started: {ffmpeg()}: {reason(error)}: {_INSTALL}") from None
    except subprocess.TimeoutExpired:
        raise RenderError(f"ffmpeg does not answer: {ffmpeg()}") from None


def check_sequence(target: Path) -> None:
    """Raise an `InputError` if `target` is there and is no folder of a sequence's pictures: it would be replaced."""
    if target.is_dir() and (others := sorted(path.name for path in target.iterdir() if not is_picture(path))):
        raise InputError(f"{target}: holds {others[0]}, which is no picture of a sequence; expected a new folder")
    if target.exists() and not target.is_dir():
        raise InputError(f"{target}: is a file; expected a folder for pictures")


def _encode(
    frames: Iterable[Pixels], arguments: list[str], target: Path, on_frame: Callable[[int], None] | None
) -> None:
    with tempfile.TemporaryFile() as log:
        process = None
        try:
            with held_signals():
                process = _start([ffmpeg(), *arguments], target, log)
            _feed(process, frames, on_frame)
            status = process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            raise RenderError(f"{target}: ffmpeg hangs: it did nothing for {_GRACE} s") from None
        finally:
            with held_signals():
                _end(process)
        if status:
            raise RenderError(f"{target}: ffmpeg failed with exit status {status}: {_cause(log, status)}")


def _check_count(found: int, wanted: int, target: Path) -> None:
    if found != wanted:
        raise RenderError(f"{target}: ffmpeg wrote {found} of {wanted} frames")


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
        why = f"{command[0]}: {reason(error)}: {_INSTALL}"
        raise RenderError(f"{target}: ffmpeg cannot be started: {why}") from None


def _feed(process: "subprocess.Popen[bytes]", frames: Iterable[Pixels], on_frame: Callable[[int], None] | None) -> None:
    pipe = process.stdin
    assert pipe is not None
    os.set_blocking(pipe.fileno(), False)  # so that an ffmpeg that takes no more is noticed
    try:
        for k, frame in enumerate(frames, start=1):
            rest = frame.data.cast("B")
            while rest:
                _wait_for_room(pipe)
                rest = rest[pipe.write(rest) or 0 :]
            if on_frame:
                on_frame(k)
        pipe.close()
    except BrokenPipeError:  # ffmpeg has gone; its exit status says why
        pass


def _wait_for_room(pipe: IO[bytes]) -> None:
    """Wait until a pipe takes more; give up after many short waits, since time passes for a suspended process too."""
    poll = select.poll()
    poll.register(pipe, select.POLLOUT)
    if not any(poll.poll(1000 * _GRACE / 60) for _ in range(60)):
        raise subprocess.TimeoutExpired("ffmpeg", _GRACE)


def _end(process: "subprocess.Popen[bytes] | None") -> None:
    """Leave no ffmpeg behind, whatever happened."""
    if process and process.stdin:
        process.stdin.close()
    if process and process.poll() is None:
        process.kill()
        process.wait()


def _cause(log: IO[bytes], status: int) -> str:
    """Return what ffmpeg says went wrong, first of all the system's reason; or the signal that ended it."""
    log.seek(0)
    lines = log.read().decode(errors="replace").strip().splitlines()
    for number in _SYSTEM_ERRORS:
        if any(line.endswith(os.strerror(number)) for line in lines):
            return cause(number)
    if lines:
        return re.sub(r"^\[.* @ 0x[0-9a-f]+\] ", "", lines[-1])  # who says so, and at which address
    if status == -signal.SIGXFSZ:
        return cause(errno.EFBIG)
    return (signal.strsignal(-status) or "").lower() if status < 0 else "no message"
