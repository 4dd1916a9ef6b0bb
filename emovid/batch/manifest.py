"""The manifest of a folder of results, `manifest.json`, and the journals of the runs that write there.

A run appends the record of each finished job to its own journal: parallel runs never wait for each other, and a killed
run loses nothing. At its end a run merges all journals into the manifest, then removes its own and those of dead runs.
Readers read the manifest and the journals.
"""

import errno
import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from emovid.atomic_io import is_written, not_written, owner, writing
from emovid.batch.job import Record, RecordKind
from emovid.errors import EmovidError

NAME = "manifest.json"
_JOURNAL, _LOCK = f".{NAME}.*.journal", f".{NAME}.lock"
SECTIONS: Mapping[RecordKind, str] = {
    "video": "videos",
    "trajectory": "trajectories",
    "measure": "measurements",
    "sheet": "sheets",
}

Records = dict[str, Record]  # by the name of the result


def read_manifest(folder: Path) -> Records:
    """Return the records of a folder, those in journals included; none from a file that is not a manifest."""
    journals = [_read_journal(path) for path in sorted(folder.glob(_JOURNAL))]
    records = _read_merged(folder)  # after the journals: a journal that is gone by now was merged into it before
    for journal in journals:
        records |= journal
    return records


def has_journals(folder: Path) -> bool:
    """Return whether runs into a folder have not ended, or were killed."""
    return any(folder.glob(_JOURNAL))


class Journal:
    """The records of one run into an existing folder; leaving it as a context merges them into the manifest.

    Attributes:
        records: of the folder, as they were when the run began, and those added since.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.records = read_manifest(folder)
        self._path = folder / f".{NAME}.{owner()}.journal"
        self._file: IO[bytes] | None = None

    def add(self, name: str, record: Record) -> None:
        """Add the record of a finished job.

        Raises:
            EmovidError: if the journal cannot be written.
        """
        try:
            self._file = self._file or self._path.open("ab", buffering=0)
            # The line break in front ends a half-written line that an interrupted write may have left.
            line = b"\n" + json.dumps([name, record.to_json()]).encode() + b"\n"
            if self._file.write(line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            raise not_written(self.folder / NAME, error) from None
        self.records[name] = record

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file:
            self._file.close()
        try:
            merge_journals(self.folder, self._path)
        except EmovidError:
            if error is None:  # otherwise the first error says more; the next run merges the journal
                raise


def merge_journals(folder: Path, own: Path | None = None) -> None:
    """Merge the journals in a folder into its manifest, and remove those that no other run is writing.

    Records of files that no longer exist are dropped.

    Args:
        folder: of the journals.
        own: a finished journal.

    Raises:
        EmovidError: if the manifest cannot be written.
    """
    if not has_journals(folder) and not (folder / _LOCK).exists():
        return
    with _lock(folder):
        journals = list(folder.glob(_JOURNAL))
        if not journals:
            return
        finished = [path for path in journals if path == own or not is_written(path)]
        records = {
            name: record
            for name, record in read_manifest(folder).items()
            if not record.has_file or (folder / name).exists()
        }
        with writing(folder / NAME) as file:
            file.write(_manifest_text(records).encode())
        for path in finished:
            path.unlink(missing_ok=True)


@contextmanager
def _lock(folder: Path) -> Iterator[None]:
    """Keep other runs from merging at the same time, where the file system has locks; a dead run's lock is free.

    Without the lock, a merge that starts before another one and ends after it would undo the other one, and its results
    would have to be made again.
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
            file.close()  # the previous holder of the lock removed this file: open the new one
    except OSError as error:
        raise not_written(folder / NAME, error) from None
    with file:
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


def _read_merged(folder: Path) -> Records:
    records: Records = {}
    with suppress(OSError, ValueError, TypeError, AttributeError):
        sections = json.loads((folder / NAME).read_text(encoding="utf-8"))
        for kind, section in SECTIONS.items():
            for name, values in sections.get(section, {}).items():
                if record := Record.from_json(dict(values) | {"only": kind}):
                    records[name] = record
    return records


def _read_journal(path: Path) -> Records:
    """Return the records of a journal; a killed run may have left its last line unfinished."""
    records: Records = {}
    with suppress(OSError):  # it has just been merged
        for line in path.read_bytes().splitlines():
            with suppress(ValueError, TypeError):
                name, values = json.loads(line)
                if record := Record.from_json(values):
                    records[str(name)] = record
    return records


def _manifest_text(records: Mapping[str, Record]) -> str:
    """Return the text of a manifest: one line for each key of a record."""
    sections: dict[str, dict[str, Record]] = {}
    for name, record in sorted(records.items()):
        sections.setdefault(SECTIONS[record.only], {})[name] = record

    def keys(record: Record) -> str:
        return ",\n".join(
            f"      {_text(key)}: {_text(value)}" for key, value in record.to_json().items() if key != "only"
        )

    def section(records: Mapping[str, Record]) -> str:
        return ",\n".join(f"    {_text(name)}: {{\n{keys(record)}\n    }}" for name, record in records.items())

    text = ",\n".join(f"  {_text(name)}: {{\n{section(of)}\n  }}" for name, of in sections.items())
    return f"{{\n{text}\n}}\n"


def _text(value: Any) -> str:
    return json.dumps(value)
