"""The manifest of a folder of results, `manifest.json`, and the journals of the runs that write there.

A run has its own journal. Its lines are

- `{"plan": DIGEST}`, first: which sweep the run makes; another sweep must wait or go to another folder,
- `[NAME]`: the run starts to make this result; parallel runs of the same sweep make others,
- `[NAME, RECORD]`: the result is finished.

Parallel runs never wait for each other to write, and a killed run loses nothing. At its end a run merges all journals
into the manifest, then removes its own and those of dead runs. Readers read the manifest and the journals.
"""

import errno
import fcntl
import json
import os
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from emovid.atomic_io import is_local, is_written, not_written, owner, replace_if_changed, writing
from emovid.batch.job import Record
from emovid.batch.versions import RecordKind
from emovid.errors import EmovidError, InputError

NAME, PLAN = "manifest.json", "plan.json"
_PACE = 0.5  # seconds between two checks for the journals of other runs
_HEARTBEAT, _LIFETIME = 5.0, 60.0  # seconds between two updates of a journal; without an update, its run is dead
_JOURNAL, _LOCK = f".{NAME}.*.journal", f".{NAME}.lock"
SECTIONS: Mapping[RecordKind, str] = {
    "video": "videos",
    "trajectory": "trajectories",
    "measure": "measurements",
    "sheet": "sheets",
}

Records = dict[str, Record]  # by the name of the result


@dataclass(frozen=True)
class Plan:
    """The plan of a sweep: its text, and a digest that is equal for equal sweeps."""

    text: str
    digest: str


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
    """The records of one run into an existing folder; as a context it merges them into the manifest at its end.

    Attributes:
        folder: of the results.
        records: of the folder, as they were when the run began, and those added since by this run and the others.

    Args:
        folder: of the results.
        plan: of the sweep that the run makes, to claim the folder for and to write there.
    """

    def __init__(self, folder: Path, plan: Plan | None = None) -> None:
        self.folder = folder
        self.records = read_manifest(folder)
        self._plan = plan
        self._path = folder / f".{NAME}.{owner()}.journal"
        self._file: IO[bytes] | None = None
        self._others: dict[Path, _OtherRun] = {}
        self._looked = 0.0
        self._is_over = threading.Event()

    def add(self, name: str, record: Record) -> None:
        """Add the record of a finished job.

        Raises:
            EmovidError: if the journal cannot be written.
        """
        self._write([name, record.to_json()])
        self.records[name] = record

    def claim(self, name: str) -> None:
        """Tell the other runs that this one starts to make a result. Raises as `add`."""
        self._write([name])

    def claimed_elsewhere(self) -> set[str]:
        """Return the names of unfinished results that other live runs make; `records` gets their finished ones."""
        if time.monotonic() - self._looked >= _PACE:
            self._looked = time.monotonic()
            paths = {path for path in self.folder.glob(_JOURNAL) if self._is_live(path)}
            if self._others.keys() - paths:  # merged into the manifest, or dead
                self.records |= read_manifest(self.folder)
            self._others = {path: self._others.get(path) or _OtherRun() for path in paths}
        claimed: set[str] = set()
        for path, other in self._others.items():
            self.records |= other.read(path)
            claimed |= other.claimed
        return claimed

    def _is_live(self, path: Path) -> bool:
        """Return whether a journal is of another run that still works.

        Runs on other machines and in other containers show that they work by touching their journals.
        """
        if path == self._path or not is_written(path):
            return False
        try:
            now = self._path.stat().st_mtime if self._file else time.time()  # by the clock of the file system
            return is_local(path) or now - path.stat().st_mtime < _LIFETIME
        except OSError:  # it has just been merged
            return False

    def _touch(self) -> None:
        while not self._is_over.wait(_HEARTBEAT):
            with suppress(OSError):
                os.utime(self._path)

    def __enter__(self) -> Self:
        threading.Thread(target=self._touch, daemon=True).start()
        if self._plan:
            with _lock(self.folder):
                for path in self.folder.glob(_JOURNAL):
                    if self._is_live(path) and _plan_of(path) not in ("", self._plan.digest):
                        raise InputError(
                            f"{self.folder}: another sweep is being made there; expected another folder (-o), or wait"
                        )
                self._write({"plan": self._plan.digest})
                replace_if_changed(self.folder / PLAN, self._plan.text.encode())
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._is_over.set()
        if self._file:
            self._file.close()
        try:
            merge_journals(self.folder, self._path)
        except EmovidError:
            if error is None:  # otherwise the first error is more informative; the next run merges the journal
                raise

    def _write(self, entry: Any) -> None:
        try:
            self._file = self._file or self._path.open("ab", buffering=0)
            # The line break in front ends a half-written line that an interrupted write may have left.
            line = b"\n" + json.dumps(entry).encode() + b"\n"
            while line:  # a full disk takes a part, and raises its error for the rest
                written = self._file.write(line)
                if not written:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                line = line[written:]
        except OSError as error:
            raise not_written(self.folder / NAME, error) from None


class _OtherRun:
    """The journal of another run, read as it grows."""

    def __init__(self) -> None:
        self.claimed: set[str] = set()
        self._offset = 0

    def read(self, path: Path) -> Records:
        """Return the records that are new, and update the names that are claimed and not finished."""
        try:
            with path.open("rb") as file:
                file.seek(self._offset)
                data = file.read()
        except OSError:  # it has just been merged
            return {}
        data = data[: data.rfind(b"\n") + 1]
        self._offset += len(data)
        claims, records = _entries(data)
        self.claimed = (self.claimed | claims) - records.keys()
        return records


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
        finished = [path for path in journals if path == own or not is_written(path)]
        new: Records = {}
        for path in journals:
            new |= _read_journal(path)
        if new:
            known = (_read_merged(folder) | new).items()
            records = {name: record for name, record in known if not record.has_file or (folder / name).exists()}
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
    with suppress(OSError):  # it has just been merged
        return _entries(path.read_bytes())[1]
    return {}


def _entries(data: bytes) -> tuple[set[str], Records]:
    """Return the claims and the records in lines of a journal; a killed run may have left its last line unfinished."""
    claims: set[str] = set()
    records: Records = {}
    for line in data.splitlines():
        with suppress(ValueError, TypeError):
            entry = json.loads(line)
            if not isinstance(entry, list):
                continue
            name, *rest = entry
            if not rest:
                claims.add(str(name))
            elif record := Record.from_json(*rest):
                records[str(name)] = record
    return claims, records


def _plan_of(path: Path) -> str:
    """Return the digest of the plan in a journal, or ""."""
    with suppress(OSError, ValueError, TypeError, KeyError, IndexError), path.open("rb") as file:
        return str(json.loads(file.read(200).splitlines()[1])["plan"])
    return ""


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
