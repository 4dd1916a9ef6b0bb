"""The one module that runs ffmpeg: executable, time limits, exit status, error messages.

imageio-ffmpeg provides the executable and nothing else: its writer ignores the exit status of ffmpeg, and an
interrupted run leaves a short but playable file under the final name.
"""

import errno
import fcntl
import os
import re
import select
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO, NamedTuple

import imageio_ffmpeg
import numpy as np

from emovid.atomic_io import cause
from emovid.errors import RenderError, reason
from emovid.signals import held_signals
from emovid.video.canvas import Pixels

IDLE_TIMEOUT = 60.0  # seconds without progress, after which ffmpeg counts as hung
RUN_TIMEOUT = 600.0  # seconds for a whole run that only reads a file
_VARIABLE = "IMAGEIO_FFMPEG_EXE"  # environment variable of imageio-ffmpeg for another executable
_INSTALL = f"reinstall imageio-ffmpeg, or set {_VARIABLE}"
_SYSTEM_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EACCES, errno.ENOENT)

Process = subprocess.Popen[bytes]


class Output(NamedTuple):
    """Result of a finished run.

    Attributes:
        status: exit status.
        data: bytes on its standard output.
        messages: text on its standard error.
    """

    status: int
    data: bytes
    messages: str


@cache
def executable() -> str:
    """Return the path of the ffmpeg executable.

    Raises:
        RenderError: if there is none.
    """
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:
        raise RenderError(f"no ffmpeg found: {_INSTALL}") from None


@cache
def version() -> str:
    """Return the version that ffmpeg reports."""
    found = re.match(rb"ffmpeg version (\S+)", run(["-version"]).data)
    return found[1].decode() if found else "unknown"


def address(path: Path) -> str:
    """Return a path as ffmpeg takes it: a name such as 10:30.mp4 would be read as a protocol."""
    return f"file:{path}"


def run(arguments: Sequence[str], timeout: float | None = None) -> Output:
    """Run ffmpeg to its end and return its output, whatever its exit status.

    Args:
        arguments: all arguments after the executable.
        timeout: time limit [s], `RUN_TIMEOUT` by default.

    Raises:
        RenderError: if it cannot be started or exceeds the time limit.
    """
    limit = RUN_TIMEOUT if timeout is None else timeout
    try:
        done = subprocess.run([executable(), *arguments], capture_output=True, check=False, timeout=limit)
    except OSError as error:
        raise _not_started(executable(), error) from None
    except subprocess.TimeoutExpired:
        raise RenderError(f"ffmpeg does not answer within {limit:g} s: {executable()}") from None
    return Output(done.returncode, done.stdout, done.stderr.decode(errors="replace"))


def count_frames(video: Path) -> int:
    """Return the number of frames in a file, from its packets; 0 for a file that is not a video."""
    arguments = ["-v", "error", "-nostdin", "-i", address(video), "-map", "0:v:0", "-c", "copy", "-f", "null"]
    done = run([*arguments, "-progress", "pipe:1", "-"])
    counts = re.findall(rb"^frame=\s*(\d+)", done.data, re.MULTILINE)
    return int(counts[-1]) if counts and done.status == 0 else 0


def encode(
    frames: Iterable[Pixels], arguments: Sequence[str], target: Path, on_frame: Callable[[int], None] | None = None
) -> None:
    """Run ffmpeg with frames on its standard input.

    Args:
        frames: arrays of bytes; a frame may reuse the buffer of the one before.
        arguments: all arguments after the executable.
        target: file to name in error messages.
        on_frame: called with the number of frames written; an exception of it ends ffmpeg.

    Raises:
        RenderError: if ffmpeg hangs or fails, with its own message.
    """
    with _running(arguments, target, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL) as process:
        assert process.stdin is not None
        try:
            for k, frame in enumerate(frames, start=1):
                rest = frame.data.cast("B")
                while rest:
                    _wait_for(process.stdin, select.POLLOUT)
                    rest = rest[process.stdin.write(rest) or 0 :]
                if on_frame:
                    on_frame(k)
            process.stdin.close()
        except BrokenPipeError:  # ffmpeg has ended; its exit status is reported
            pass


def decode(video: Path, filters: str, size: int) -> Iterator[Pixels]:
    """Yield the frames of a file, each overwritten by the next.

    Args:
        video: file of any kind that ffmpeg reads.
        filters: from the file's frames to the wanted ones, for ffmpeg's option -vf.
        size: bytes of a frame.

    Raises:
        RenderError: if ffmpeg hangs or fails, or the last frame is incomplete.
    """
    arguments = [
        "-v",
        "error",
        "-nostdin",
        "-i",
        address(video),
        "-map",
        "0:v:0",
        "-vf",
        filters,
        "-f",
        "rawvideo",
        "-",
    ]
    frame = np.empty(size, np.uint8)
    with _running(arguments, video, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        while (filled := _read_into(process.stdout, frame)) == size:
            yield frame
    if filled:
        raise RenderError(f"{video}: cannot be decoded to its end")


@contextmanager
def _running(arguments: Sequence[str], target: Path, *, stdin: int, stdout: int) -> Iterator[Process]:
    """Start ffmpeg and, after the block, wait for it and check its exit status; end it in any case."""
    with tempfile.TemporaryFile() as log:
        process = None
        try:
            with held_signals():
                process = _start([executable(), *arguments], target, stdin, stdout, log)
            for pipe in filter(None, (process.stdin, process.stdout)):
                os.set_blocking(pipe.fileno(), False)  # so that a process without progress is noticed
                _enlarge(pipe)
            yield process
            status = process.wait(IDLE_TIMEOUT)
        except subprocess.TimeoutExpired:
            raise RenderError(f"{target}: ffmpeg hangs: it did nothing for {IDLE_TIMEOUT:g} s") from None
        finally:
            with held_signals():
                _end(process)
        if status:
            raise RenderError(f"{target}: ffmpeg failed with exit status {status}: {_failure(log, status)}")


def _start(command: list[str], target: Path, stdin: int, stdout: int, log: IO[bytes]) -> Process:
    try:
        return subprocess.Popen(
            command,
            stdin=stdin,
            stdout=stdout,
            stderr=log,  # a file: a full pipe would block ffmpeg
            bufsize=0,
            process_group=0,  # Ctrl-C reaches emovid alone, which then ends ffmpeg
        )
    except OSError as error:
        raise RenderError(f"{target}: {_not_started(command[0], error)}") from None


def _not_started(program: str, error: OSError) -> RenderError:
    """Return the error of an executable that the system does not start, with a remedy if the executable is at fault."""
    remedy = ""
    if error.errno in (errno.ENOENT, errno.EACCES, errno.ENOEXEC, errno.ENOTDIR):
        remedy = f": {_VARIABLE} names it: unset this variable" if _VARIABLE in os.environ else f": {_INSTALL}"
    return RenderError(f"ffmpeg cannot be started: {program}: {reason(error)}{remedy}")


def _enlarge(pipe: IO[bytes]) -> None:
    """Let a pipe hold 1 MiB, where the system can: frames then pass with fewer switches between processes."""
    if hasattr(fcntl, "F_SETPIPE_SZ"):
        with suppress(OSError):
            fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, 1 << 20)


def _wait_for(pipe: IO[bytes], event: int) -> None:
    """Wait until a pipe is ready; many short waits, since time passes for a suspended process too."""
    poll = select.poll()
    poll.register(pipe, event)
    if not any(poll.poll(1000 * IDLE_TIMEOUT / 60) for _ in range(60)):
        raise subprocess.TimeoutExpired("ffmpeg", IDLE_TIMEOUT)


def _read_into(pipe: IO[bytes], frame: Pixels) -> int:
    """Fill a frame from a pipe; return the number of bytes, fewer only at the end of the data."""
    filled = 0
    while filled < frame.size:
        _wait_for(pipe, select.POLLIN)
        part = pipe.read(frame.size - filled)
        if not part:
            break
        frame[filled : filled + len(part)] = np.frombuffer(part, np.uint8)
        filled += len(part)
    return filled


def _end(process: Process | None) -> None:
    """End ffmpeg if it still runs."""
    if process is None:
        return
    for pipe in filter(None, (process.stdin, process.stdout)):
        pipe.close()
    if process.poll() is None:
        process.kill()
        process.wait()


def _failure(log: IO[bytes], status: int) -> str:
    """Return the reason of a failure: the system's error, ffmpeg's last message, or the signal that ended it."""
    log.seek(0)
    lines = log.read().decode(errors="replace").strip().splitlines()
    for number in _SYSTEM_ERRORS:
        if any(line.endswith(os.strerror(number)) for line in lines):
            return cause(number)
    if lines:
        return re.sub(r"^\[.* @ 0x[0-9a-f]+\] ", "", lines[-1])  # without the component and its address
    if status == -signal.SIGXFSZ:
        return cause(errno.EFBIG)
    return (signal.strsignal(-status) or "").lower() if status < 0 else "no message"
