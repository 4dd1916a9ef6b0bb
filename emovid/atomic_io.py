"""Files that appear under their name whole or not at all, whatever interrupts the writing; and what is in them."""

import errno
import glob
import hashlib
import os
import re
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO

from emovid.errors import EmovidError, reason

_SUFFIX = ".part"
_LEFT = re.compile(r"\..+\.[^.].*-\d+\.part(\.former\.part)?")  # .NAME.OWNER.part
_OWNER = re.compile(r"\.([0-9a-f]{12})-(\d+)-(\d+)\.(?!.*-\d+\.)")  # the last part of a name that is an owner
_DAY = 86_400  # seconds
_REMEDIES = {
    errno.ENOSPC: "free some space",
    errno.EDQUOT: "free some of your quota",
    errno.EFBIG: "raise the limit on the size of files (ulimit -f)",
    errno.EROFS: "choose another folder",
    errno.EACCES: "choose another folder",
    errno.EPERM: "choose another folder",
    errno.ENOENT: "is its folder still there?",
}


@contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Give a path beside `target` to write to; on leaving without an error it takes the place of `target`.

    What a killed process has left there for the same target is removed first.

    Raises:
        EmovidError: if the file cannot be written, with the system's reason.
    """
    part = _part_beside(target)
    try:
        yield part
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(target)
    except OSError as error:
        raise not_written(target, error) from None
    finally:
        _remove(part)


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """Give a new folder beside `target` to fill; on leaving without an error it takes the place of `target`.

    A folder that is at `target` goes, with all that is in it. Raises as `whole_file`.
    """
    part = _part_beside(target)
    former = part.with_name(f"{part.name}.former{_SUFFIX}")
    try:
        part.mkdir()
        yield part
        with suppress(FileNotFoundError):  # a full folder cannot be replaced in one step, as a file can
            target.rename(former)
        part.rename(target)
    except OSError as error:
        raise not_written(target, error) from None
    finally:
        if former.exists() and not target.exists():
            former.rename(target)
        _remove(part)
        _remove(former)


@contextmanager
def writing(target: Path) -> Iterator[IO[bytes]]:
    """Open a file that takes the place of `target` once it is written whole. Raises as `whole_file`."""
    with whole_file(target) as part, part.open("wb") as file:
        yield file


def replace_if_changed(target: Path, data: bytes) -> None:
    """Write a file whole, unless it says this already. Raises as `whole_file`."""
    with suppress(OSError):  # missing, or what is wrong with it shows when it is written
        if target.read_bytes() == data:
            return
    with writing(target) as file:
        file.write(data)


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, if missing.

    Raises:
        EmovidError: if it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(folder, error, "made") from None


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file; of a folder, that of the names and the SHA-256 of the files in it."""
    try:
        if path.is_dir():
            listed = "".join(f"{file_digest(inside)}  {inside.name}\n" for inside in sorted(path.iterdir()))
            return hashlib.sha256(listed.encode()).hexdigest()
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise EmovidError(f"{path}: cannot be read: {reason(error)}") from None


def clear_leftovers(folder: Path) -> None:
    """Remove what killed processes have left unfinished in a folder, whatever it was to become."""
    for left in folder.glob(f".*{_SUFFIX}"):
        if _LEFT.fullmatch(left.name) and not is_written(left):
            _remove(left)


def is_written(left: Path) -> bool:
    """Return whether the owner of a hidden file, as in ``.NAME.OWNER.SUFFIX``, may still write it.

    This process cannot see the processes of other machines and containers: they count as alive for a day after the file
    changed.
    """
    found = _OWNER.search(left.name)
    if found and found[1] == _process_space():
        return _is_alive(int(found[2]), int(found[3]))
    try:
        return time.time() - left.stat().st_mtime < _DAY
    except OSError:  # the file has just been renamed
        return True


def owner(pid: int | None = None) -> str:
    """Return a name for a process, by default this one, that no process of another machine, container or time has.

    The name has three parts: a digest of host, boot and process namespace, the process number, and the start time.
    """
    number = os.getpid() if pid is None else pid
    return f"{_process_space()}-{number}-{(_process_state(number) or ('', 0))[1]}"


@cache
def _process_space() -> str:
    """Return a digest of all that makes process numbers unique: the machine, its boot and the process namespace."""
    known = [socket.gethostname()]
    with suppress(OSError):  # a system without /proc
        known.append(Path("/proc/sys/kernel/random/boot_id").read_text())
        known.append(str(Path("/proc/self/ns/pid").stat().st_ino))
    return hashlib.sha256("\n".join(known).encode()).hexdigest()[:12]


def cause(number: int) -> str:
    """Return what the system says of an error number in writing, and what to do about it where that can be said."""
    return os.strerror(number).lower() + (f": {_REMEDIES[number]}" if number in _REMEDIES else "")


def not_written(target: Path, error: OSError, how: str = "written") -> EmovidError:
    """Return the error of a file that cannot be written: which, why, and what to do about it."""
    return EmovidError(f"{target}: cannot be {how}: {cause(error.errno) if error.errno else reason(error)}")


def _part_beside(target: Path) -> Path:
    """Return the path to write at in place of `target`, after removing what killed processes have left there."""
    stem = f".{target.name}."
    for left in target.parent.glob(f"{glob.escape(stem)}*{_SUFFIX}"):
        if _LEFT.fullmatch(left.name) and not is_written(left):
            _remove(left)
    part = target.with_name(f"{stem}{owner()}{_SUFFIX}")
    _remove(part)
    return part


def _remove(path: Path) -> None:
    with suppress(OSError):
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def _is_alive(pid: int, start: int) -> bool:
    """Return whether a process of this machine that started at a time, in ticks since boot, still runs."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # it belongs to another user
        pass
    known = _process_state(pid)
    # A process that has ended but was not waited for still has its number.
    return known is None or (known[0] != "Z" and start in (0, known[1]))


def _process_state(pid: int) -> tuple[str, int] | None:
    """Return the state and the start time of a process; None on a system without a /proc of this namespace."""
    try:
        if str(Path("/proc/self").readlink()) != str(os.getpid()):
            return None
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return fields[0], int(fields[19])
    except (OSError, IndexError, ValueError):
        return None
