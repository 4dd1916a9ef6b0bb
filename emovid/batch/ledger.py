"""What is known of the finished jobs of a folder: `manifest.json`, and the journals of runs that write there.

A run appends the record of each finished job to a journal of its own, so that runs into one folder never wait for each
other and a killed one loses nothing. At its end it merges all journals into the manifest and removes its own and those
of runs that are dead. Whoever reads takes both: what is finished is known at once, and for ever.
"""

import errno
import fcntl
import json
import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from emovid.atomic_io import is_written, not_written, writing
from emovid.batch.job import Record
from emovid.errors import EmovidError

NAME = "manifest.json"
_JOURNAL, _LOCK = f".{NAME}.*.journal", f".{NAME}.lock"
_SECTIONS = {"video": "videos", "trajectory": "trajectories", "measure": "measurements", "sheet": "sheets"}


def read_ledger(folder: Path) -> dict[str, Record]:
    """Return the records of a folder by name; none from a manifest that is missing or not ours."""
    journals = [_read_journal(path) for path in sorted(folder.glob(_JOURNAL))]
    records = _read_manifest(folder)  # after the journals: one that is gone by now was merged into it before
    for journal in journals:
        records |= journal
    return records


def is_growing(folder: Path) -> bool:
    """Return whether there are journals in a folder: of runs that have not ended."""
    return any(folder.glob(_JOURNAL))


class Ledger:
    """Takes the records of one run into a folder that exists; as a context it merges them at the end.

    Attributes:
        records: of the folder, by name, as they were when the run began, and those added since.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.records = read_ledger(folder)
        self._path = folder / f".{NAME}.{socket.gethostname()}-{os.getpid()}.journal"
        self._journal: IO[bytes] | None = None

    def add(self, name: str, record: Record) -> None:
        """Record a finished job.

        Raises:
            EmovidError: if the journal cannot be written.
        """
        try:
            self._journal = self._journal or self._path.open("ab", buffering=0)
            # It begins a line too: a dead process with our number may have left half of one.
            line = b"\n" + json.dumps([name, record]).encode() + b"\n"
            if self._journal.write(line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            raise not_written(self.folder / NAME, error) from None
        self.records[name] = record

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._journal:
            self._journal.close()
        try:
            merge(self.folder, self._path)
        except EmovidError:
            if error is None:  # else the first error says more; the journal stays for the next run
                raise


def merge(folder: Path, own: Path | None = None) -> None:
    """Merge the journals in a folder into its manifest, and remove those that nobody else writes to.

    Records of files that are gone go too.

    Args:
        folder: that holds them.
        own: a journal that is finished.

    Raises:
        EmovidError: if the manifest cannot be written.
    """
    if not is_growing(folder) and not (folder / _LOCK).exists():
        return
    with _lock(folder):
        journals = list(folder.glob(_JOURNAL))
        if not journals:
            return
        over = [path for path in journals if path == own or not is_written(path)]
        records = {
            name: record
            for name, record in read_ledger(folder).items()
            if record.get("only") == "measure" or (folder / name).exists()
        }
        with writing(folder / NAME) as file:
            file.write(_manifest(records).encode())
        for path in over:
            path.unlink(missing_ok=True)


@contextmanager
def _lock(folder: Path) -> Iterator[None]:
    """Keep other runs from merging meanwhile, where the file system can; the kernel frees a dead run's lock.

    Without it, a merge that began before another and ends after it would undo that, and what it had merged would have
    to be made again.
    """
    path = folder / _LOCK
    try:
        while True:
            file = path.open("ab")
            with suppress(OSError):  # a file system without locks
                fcntl.flock(file, fcntl.LOCK_EX)
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                    break
            file.close()  # who had the lock before has removed its file: take a new one
    except OSError as error:
        raise not_written(folder / NAME, error) from None
    with file:
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


def _read_manifest(folder: Path) -> dict[str, Record]:
    try:
        sections = json.loads((folder / NAME).read_text(encoding="utf-8"))
        return {
            str(name): dict(record) | {"only": only}
            for only, section in _SECTIONS.items()
            for name, record in sections.get(section, {}).items()
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def _read_journal(path: Path) -> dict[str, Record]:
    """Return the records of a journal, but for a last line that a killed run may have left half written."""
    records: dict[str, Record] = {}
    with suppress(OSError):  # it has just been merged
        for line in path.read_bytes().splitlines():
            with suppress(ValueError, TypeError, KeyError):
                name, record = json.loads(line)
                if record["only"] in _SECTIONS:
                    records[str(name)] = record
    return records


def _manifest(records: Mapping[str, Record]) -> str:
    """Return the text of a manifest: a line for each key of a record."""
    sections: dict[str, dict[str, Record]] = {}
    for name, record in sorted(records.items()):
        sections.setdefault(_SECTIONS[record["only"]], {})[name] = record

    def keys(record: Record) -> str:
        return ",\n".join(f"      {_json(key)}: {_json(value)}" for key, value in record.items() if key != "only")

    def section(records: Mapping[str, Record]) -> str:
        return ",\n".join(f"    {_json(name)}: {{\n{keys(record)}\n    }}" for name, record in records.items())

    text = ",\n".join(f"  {_json(name)}: {{\n{section(of)}\n  }}" for name, of in sections.items())
    return f"{{\n{text}\n}}\n"


def _json(value: Any) -> str:
    return json.dumps(value)
