"""Files and folders that appear under their name completely or not at all, even if the process is killed."""

import ctypes
import errno
import glob
import hashlib
import os
import re
import shutil
import socket
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO

from emovid.errors import MORE_FILES, EmovidError, InputError, reason

_SUFFIX = ".part"
_FORMER = f".former{_SUFFIX}"
_LEFT = re.compile(r"\..+\.[^.].*-\d+\.part(\.former\.part)?")  # .NAME.OWNER.part
_TARGET = re.compile(r"\.(.+)\.[0-9a-f]{12}-\d+-\d+\.part\.former\.part")
_OWNER = re.compile(r"\.([0-9a-f]{12})-(\d+)-(\d+)\.(?!.*-\d+\.)")  # the last part of a name that is an owner
_DAY = 86_400  # seconds
_HERE, _EXCHANGE = -100, 2  # AT_FDCWD and RENAME_EXCHANGE of renameat2(2)
_REMEDIES = {
    errno.ENOSPC: "free some space",
    errno.EDQUOT: "free some of your quota",
    errno.EFBIG: "raise the limit on the size of files (ulimit -f)",
    errno.EROFS: "choose another folder",
    errno.EACCES: "choose another folder",
    errno.EPERM: "choose another folder",
    errno.ENOENT: "is its folder still there?",
    errno.EMFILE: MORE_FILES,
    errno.ENAMETOOLONG: "choose a shorter name",
}


@contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Yield a path beside `target` to write to; on leaving without an error, the file replaces `target` in one step.

    If `target` is a link, the file that it points to is replaced. Parts that killed processes left for the same target
    are removed first.

    Raises:
        EmovidError: if the file cannot be written, with the system's reason.
    """
    actual = _followed(target)
    part = _part_beside(actual)
    try:
        yield part
        _sync(part)
        _copy_mode(actual, part)
        part.replace(actual)
        _sync(actual.parent)
    except OSError as error:
        raise not_written(target, error) from None
    finally:
        _remove(part)


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """Yield a new folder beside `target` to fill; on leaving without an error, it replaces `target` and all inside it.

    At every instant either the old or the new folder is complete on disk. On Linux the two change places in one step;
    elsewhere the old one has another name for a moment, and `clear_leftovers` and the next run restore it after a kill.
    Links and errors as in `whole_file`.
    """
    actual = _followed(target)
    part = _part_beside(actual)
    try:
        part.mkdir()
        yield part
        for inside in part.iterdir():
            _sync(inside)
        _sync(part)
        _copy_mode(actual, part)
        _replace_folder(actual, part)
        _sync(actual.parent)
    except OSError as error:
        raise not_written(target, error) from None
    finally:
        _restore(_former(part))
        _remove(part)


@contextmanager
def writing(target: Path) -> Iterator[IO[bytes]]:
    """Open a file that replaces `target` once it is written completely. Raises as `whole_file`."""
    with whole_file(target) as part, part.open("wb") as file:
        yield file


def replace_if_changed(target: Path, data: bytes) -> None:
    """Write a file unless it has this content already. Raises as `whole_file`."""
    with suppress(OSError):  # a missing file; any other problem is raised when the file is written
        if target.read_bytes() == data:
            return
    with writing(target) as file:
        file.write(data)


def check_existing(files: Mapping[Path, bytes], *, force: bool) -> None:
    """Check that files of the given contents replace no other ones, unless with `force`.

    Raises:
        InputError: for an existing file with other content, or a folder in the place of a file.
    """
    for target, data in files.items():
        if target.is_dir():
            raise InputError(f"{target}: is a folder; expected a file that can be replaced")
        if target.exists() and not force and target.read_bytes() != data:
            raise other_content(target)


def other_content(target: Path) -> InputError:
    """Return the error of an existing file whose content would change."""
    return InputError(f"{target} exists with other content; use --force to overwrite it, or -o")


def make_folder(folder: Path) -> None:
    """Create a folder and its parents, if missing.

    Raises:
        EmovidError: if it cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(folder, error, "made") from None


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file; of a folder, the SHA-256 of its files' names and digests."""
    try:
        if path.is_dir():
            listed = "".join(f"{file_digest(inside)}  {inside.name}\n" for inside in sorted(path.iterdir()))
            return hashlib.sha256(listed.encode()).hexdigest()
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise EmovidError(f"{path}: cannot be read: {reason(error)}") from None


def clear_leftovers(folder: Path) -> None:
    """Remove the unfinished files of killed processes in a folder, and restore folders that they were replacing."""
    _clear(folder.glob(f".*{_SUFFIX}"))


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


def is_local(left: Path) -> bool:
    """Return whether the owner of a hidden file is a process that this one can see: of this machine and container."""
    found = _OWNER.search(left.name)
    return bool(found and found[1] == _process_space())


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
    """Return the system's description of an error number in writing, with a remedy if there is one."""
    return os.strerror(number).lower() + (f": {_REMEDIES[number]}" if number in _REMEDIES else "")


def not_written(target: Path, error: OSError, how: str = "written") -> EmovidError:
    """Return the error of a file that cannot be written: the file, the reason and the remedy."""
    kind = InputError if error.errno == errno.ENAMETOOLONG else EmovidError
    return kind(f"{target}: cannot be {how}: {cause(error.errno) if error.errno else reason(error)}")


def _part_beside(target: Path) -> Path:
    """Return the path to write to in place of `target`, after removing leftovers of killed processes."""
    stem = f".{target.name}."
    _clear(target.parent.glob(f"{glob.escape(stem)}*{_SUFFIX}"))
    part = target.with_name(f"{stem}{owner()}{_SUFFIX}")
    try:
        part.lstat()
    except FileNotFoundError:
        return part
    except OSError as error:  # such as a name that is too long
        raise not_written(target, error) from None
    _remove(part)
    return part


def _followed(target: Path) -> Path:
    """Return the file or folder that a link points to, existing or not; any other path unchanged."""
    if not target.is_symlink():
        return target
    try:
        target.stat()
    except FileNotFoundError:
        pass
    except OSError as error:  # such as links that point to each other
        raise not_written(target, error) from None
    return target.resolve()


def _sync(path: Path) -> None:
    """Wait until a file, or the list of files in a folder, is on disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _copy_mode(target: Path, part: Path) -> None:
    """Give a file the permissions of the one that it replaces, which may be more private than the default."""
    with suppress(OSError):  # there is none to replace, or a file system without permissions
        shutil.copymode(target, part)


def _replace_folder(target: Path, part: Path) -> None:
    """Put a finished folder in the place of `target`, which goes to the name of the part, or else of its former."""
    if _exchange(target, part):
        return
    with suppress(FileNotFoundError):  # there is no folder to replace
        target.rename(_former(part))
    part.rename(target)


def _exchange(first: Path, second: Path) -> bool:
    """Let two existing paths change places in one step; return False if they, or the system, do not allow it."""
    try:
        rename = ctypes.CDLL(None).renameat2
    except (AttributeError, OSError):  # not Linux, or an old C library
        return False
    return bool(rename(_HERE, os.fsencode(first), _HERE, os.fsencode(second), _EXCHANGE) == 0)


def _former(part: Path) -> Path:
    """Return the name of a folder that `part` is replacing, for the moment between two renames."""
    return part.with_name(f"{part.name}{_FORMER}")


def _restore(former: Path) -> None:
    """Give a replaced folder its name back if the folder that replaces it never got there; else remove it."""
    if found := _TARGET.fullmatch(former.name):
        target = former.with_name(found[1])
        if former.exists() and not target.exists():
            former.rename(target)
        _remove(former)


def _clear(parts: Iterable[Path]) -> None:
    for left in parts:
        if _LEFT.fullmatch(left.name) and not is_written(left):
            _restore(left) if left.name.endswith(_FORMER) else _remove(left)


def _remove(path: Path) -> None:
    with suppress(OSError):
        shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink(missing_ok=True)


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
