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
_BUSY = 30.0  # seconds to wait for another process, such as one that withdraws a participant
# Write-ahead log: readers of other processes do not wait for writers. FULL: the log is on the disk at each commit.
_PRAGMAS = ("journal_mode = WAL", "synchronous = FULL", "foreign_keys = ON", "secure_delete = ON")


class Database:
    """The open database of one kit's survey: one connection, which threads use in turn.

    Args:
        path: file of the database, created if missing, readable by its owner only.
        commitment: commitment to the key of the kit, which identifies the kit.

    Raises:
        InputError: if the file is not the database of a survey, or belongs to another kit.
        EmovidError: if the file cannot be opened.
    """

    def __init__(self, path: Path, commitment: str) -> None:
        self._lock = threading.Lock()
        make_folder(path.parent)
        try:
            os.close(os.open(path, os.O_RDWR | os.O_CREAT, _OWNER_ONLY))
        except OSError as error:
            raise EmovidError(f"{path}: cannot be opened: {reason(error)}") from None
        self._connection = sqlite3.connect(path, timeout=_BUSY, isolation_level=None, check_same_thread=False)
        try:
            self._set_up(commitment)
        except sqlite3.DatabaseError as error:
            self.close()
            raise InputError(f"{path}: {error}; expected the database of a survey") from None
        if self._fact("commitment") != commitment:
            self.close()
            raise InputError(f"{path}: holds the answers to another kit; expected those to this kit, or no such file")
        self.secret = bytes.fromhex(self._fact("secret"))

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    @contextmanager
    def reading(self) -> Iterator[sqlite3.Connection]:
        """Provide the connection for statements that see the same state."""
        with self._transaction("BEGIN") as connection:
            yield connection

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """Provide the connection for statements that take effect together on exit, or not at all."""
        with self._transaction("BEGIN IMMEDIATE") as connection:
            yield connection

    def checkpoint(self) -> None:
        """Move the write-ahead log into the file, so that neither of them holds deleted content."""
        with self._lock:
            self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    @contextmanager
    def _transaction(self, begin: str) -> Iterator[sqlite3.Connection]:
        with self._lock:
            self._connection.execute(begin)
            try:
                yield self._connection
                self._connection.execute("COMMIT")
            finally:
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")

    def _set_up(self, commitment: str) -> None:
        for pragma in _PRAGMAS:
            self._connection.execute(f"PRAGMA {pragma}")
        schema = Path(__file__).with_name("schema.sql").read_text(encoding="utf-8")
        self._connection.executescript(f"BEGIN IMMEDIATE;\n{schema}\nCOMMIT;")
        facts = {"commitment": commitment, "secret": secrets.token_hex(32)}
        with self.writing() as sql:
            sql.executemany("INSERT OR IGNORE INTO facts VALUES (?, ?)", facts.items())

    def _fact(self, name: str) -> str:
        with self.reading() as sql:
            return str(sql.execute("SELECT value FROM facts WHERE name = ?", (name,)).fetchone()[0])
