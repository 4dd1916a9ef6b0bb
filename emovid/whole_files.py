"""Files that appear under their name whole or not at all, whatever interrupts the writing; and what is in them."""

import glob
import hashlib
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from emovid.errors import EmovidError

_SUFFIX = ".part"


@contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Give a path beside `target` to write to; on leaving without an error it takes the place of `target`.

    What a killed process has left there for the same target is removed first.

    Raises:
        EmovidError: if the file cannot be written, with the system's reason.
    """
    host = socket.gethostname()
    stem = f".{target.name}.{host}-"
    for left in target.parent.glob(f"{glob.escape(stem)}*{_SUFFIX}"):
        if not _is_alive(left.name.removeprefix(stem).removesuffix(_SUFFIX)):
            left.unlink(missing_ok=True)
    part = target.with_name(f"{stem}{os.getpid()}{_SUFFIX}")
    try:
        yield part
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(target)
    except OSError as error:
        raise EmovidError(f"{target}: cannot be written: {reason(error)}") from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


@contextmanager
def writing(target: Path) -> Iterator[IO[bytes]]:
    """Open a file that takes the place of `target` once it is written whole. Raises as `whole_file`."""
    with whole_file(target) as part, part.open("wb") as file:
        yield file


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, if missing.

    Raises:
        EmovidError: if it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EmovidError(f"{folder}: cannot be made: {reason(error)}") from None


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise EmovidError(f"{path}: cannot be read: {reason(error)}") from None


def reason(error: OSError) -> str:
    """Return what the system says went wrong, in lower case."""
    return (error.strerror or str(error)).lower()


def _is_alive(pid: str) -> bool:
    try:
        os.kill(int(pid), 0)
    except (ProcessLookupError, ValueError):
        return False
    except PermissionError:  # it is another user's
        return True
    try:  # one that has ended but was not waited for still has its number
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (OSError, IndexError):  # ended meanwhile, or a system without /proc
        return True
