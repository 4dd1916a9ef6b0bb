"""The SQLite file of a survey: once a transaction has ended, its changes survive a crash of process or machine."""

import os
import secrets
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from emovid.atomic_io import make_folder
from emovid.errors import EmovidError, InputError, reason

_OWNER_ONLY = 0o600
# Write-ahead log: readers do not wait for writers. FULL: the log is on the disk at each commit.
_PRAGMAS = ("journal_mode = WAL", "synchronous = FULL", "foreign_keys = ON", "secure_delete = ON")
_ADDED = {  # columns that files of version 0.1.0 do not have
    "plays": (
        "stalls INTEGER NOT NULL DEFAULT 0",
        "stalled_ms INTEGER NOT NULL DEFAULT 0",
        "play_ms INTEGER NOT NULL DEFAULT 0",
    ),
    "answers": ("response_ms INTEGER",),
    "participants": (
        "after TEXT",
        "language TEXT NOT NULL DEFAULT ''",
        "kit_version INTEGER NOT NULL DEFAULT 1",
    ),
}


class DatabaseBusyError(EmovidError):
    """Another program holds the write lock of the database."""


class Database:
    """The open database of one kit's survey: a connection for writing, and one for reading in each thread.

    Args:
        path: file of the database, created if missing, readable by its owner only.
        commitment: commitment to the key of the kit, which identifies the kit.
        patience: seconds to wait while another program holds the write lock.

    Raises:
        InputError: if the file is not the database of a survey, or belongs to another kit.
        DatabaseBusyError: if another program holds the lock.
        EmovidError: if the file cannot be opened.
    """

    def __init__(self, path: Path, commitment: str, patience: float) -> None:
        self._path, self._patience = path, patience
        self._lock, self._local = threading.Lock(), threading.local()
        self._open: list[sqlite3.Connection] = []
        self._unfinished = False  # whether the log still holds deleted content
        make_folder(path.parent)
        try:
            os.close(os.open(path, os.O_RDWR | os.O_CREAT, _OWNER_ONLY))
        except OSError as error:
            raise EmovidError(f"{path}: cannot be opened: {reason(error)}") from None
        try:
            self._writer = self._connect()
            self._set_up(commitment)
            found = self._fact("commitment")
        except sqlite3.DatabaseError as error:
            self.close()
            raise InputError(f"{path}: {error}; expected the database of a survey") from None
        except DatabaseBusyError:
            self.close()
            raise
        if found != commitment:
            self.close()
            raise InputError(f"{path}: holds the answers to another kit; expected those to this kit, or no such file")
        self.secret = bytes.fromhex(self._fact("secret"))

    def close(self) -> None:
        """Close the file."""
        for connection in self._open:
            connection.close()

    @contextmanager
    def reading(self) -> Iterator[sqlite3.Connection]:
        """Provide a connection for statements that see the same state; it waits for no writer."""
        reader = getattr(self._local, "reader", None)
        if reader is None:
            reader = self._local.reader = self._connect()
        with self._transaction(reader, "BEGIN"):
            yield reader

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """Provide the connection for statements that take effect together on exit, or not at all."""
        if not self._lock.acquire(timeout=self._patience):
            raise self._busy()
        try:
            with self._transaction(self._writer, "BEGIN IMMEDIATE"):
                yield self._writer
            if self._unfinished:
                self._truncate_log(0)
        finally:
            self._lock.release()

    def checkpoint(self) -> bool:
        """Move the write-ahead log into the file and empty it; return whether neither holds deleted content now.

        A reader of an older state keeps the log; later transactions then try again.
        """
        with self._lock:
            self._truncate_log(self._patience)
        return not self._unfinished

    def _truncate_log(self, patience: float) -> None:
        self._writer.execute(f"PRAGMA busy_timeout = {round(1000 * patience)}")
        try:
            busy, _, _ = self._writer.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
            self._unfinished = bool(busy)
        except sqlite3.OperationalError:
            self._unfinished = True
        finally:
            self._writer.execute(f"PRAGMA busy_timeout = {round(1000 * self._patience)}")

    @contextmanager
    def _transaction(self, connection: sqlite3.Connection, begin: str) -> Iterator[None]:
        try:
            connection.execute(begin)
            yield
            connection.execute("COMMIT")
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode & 0xFF in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
                raise self._busy() from None
            raise
        finally:
            if connection.in_transaction:
                connection.execute("ROLLBACK")

    def _busy(self) -> DatabaseBusyError:
        return DatabaseBusyError(f"{self._path}: locked by another program; close that program and try again")

    def _connect(self) -> sqlite3.Connection:
        connection = sqlite3.connect(self._path, timeout=self._patience, isolation_level=None, check_same_thread=False)
        self._open.append(connection)
        return connection

    def _set_up(self, commitment: str) -> None:
        for pragma in _PRAGMAS:
            self._writer.execute(f"PRAGMA {pragma}")
        schema = Path(__file__).with_name("schema.sql").read_text(encoding="utf-8")
        facts = {"commitment": commitment, "secret": secrets.token_hex(32)}
        with self.writing() as sql:
            for statement in schema.split(";\n"):
                sql.execute(statement)
            for table, columns in _ADDED.items():
                known = {name for _, name, *_ in sql.execute(f"PRAGMA table_info({table})")}
                for column in columns:
                    if column.split()[0] not in known:
                        sql.execute(f"ALTER TABLE {table} ADD COLUMN {column}")
            sql.executemany("INSERT OR IGNORE INTO facts VALUES (?, ?)", facts.items())

    def _fact(self, name: str) -> str:
        with self.reading() as sql:
            return str(sql.execute("SELECT value FROM facts WHERE name = ?", (name,)).fetchone()[0])
