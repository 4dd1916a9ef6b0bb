"""The recorded answers of a kit's participants; once a method returns, its record is on the disk."""

import json
import sqlite3
import time
from collections.abc import Callable, Mapping
from dataclasses import astuple
from enum import IntEnum
from pathlib import Path

from emovid.errors import InputError
from emovid.kit.folder import Kit, KitFolder, open_public
from emovid.survey.codes import site_name
from emovid.survey.database import Database
from emovid.survey.records import (
    Order,
    Participant,
    Playback,
    Screen,
    Viewing,
    all_participants,
    find_participant,
    opened_by,
    plays_of,
)
from emovid.survey.rules import Play, may_answer, next_row

_PATIENCE = 30.0  # seconds that a command waits while another program holds the write lock
_MAX_PLAYS = 500  # recorded per video and participant; more would only fill the disk


class Withdrawal(IntEnum):
    """Outcome of a withdrawal."""

    UNKNOWN = 0  # no participant has the code
    DELETED = 1  # neither the file nor its log holds anything of the participant
    PENDING = 2  # deleted, but another program reads the file and keeps its log


class Store:
    """The answers to one kit.

    Args:
        path: file of the database, created if missing.
        commitment: commitment to the key of the kit, which identifies the kit.
        clock: returns the seconds since 1970; by default one that never goes back.
        patience: seconds to wait while another program holds the write lock.

    Raises:
        InputError, EmovidError: as `Database`.
    """

    def __init__(
        self, path: Path, commitment: str, clock: Callable[[], float] | None = None, *, patience: float = _PATIENCE
    ) -> None:
        self._data = Database(path, commitment, patience)
        self.secret = self._data.secret
        self.site = site_name(self.secret)
        self.clock = clock or self._steady_clock()

    def close(self) -> None:
        """Close the database."""
        self._data.close()

    def enroll(
        self,
        digest: str,
        orders: Mapping[str, Order],
        choices: Mapping[str, Order],
        version: str,
        release: float,
        kit_version: int = 1,
        language: str = "",
    ) -> Participant:
        """Add a participant, unless the code has one already; return the participant with this code.

        Args:
            digest: digest of the participant's code.
            orders: codes of the videos, by row.
            choices: labels in the order of the page, by row.
            version: version of the consent text.
            release: seconds without activity after which an unfinished participant's row is free again.
            kit_version: version of the kit's texts.
            language: language of the pages; "" for that of the kit.
        """
        now = self.clock()
        with self._data.writing() as sql:
            taken = sql.execute(
                "SELECT order_row, count(*) FROM participants WHERE submitted NOTNULL OR seen >= ? GROUP BY order_row",
                (now - release,),
            )
            row = next_row(list(orders), dict(taken.fetchall()))
            sql.execute(
                "INSERT OR IGNORE INTO participants"
                " (digest, order_row, videos, choices, consent_version, enrolled, seen, kit_version, language)"
                " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?6, ?7, ?8)",
                (digest, row, json.dumps(orders[row]), json.dumps(choices[row]), version, now, kit_version, language),
            )
            person = find_participant(sql, digest)
        assert person is not None  # inserted above, or earlier
        return person

    def find(self, digest: str) -> Participant | None:
        """Return the participant with a code of this digest."""
        with self._data.reading() as sql:
            return find_participant(sql, digest)

    def participants(self) -> list[tuple[Participant, dict[int, Viewing]]]:
        """Return all participants in the sequence of their enrollment, with their viewings by place."""
        with self._data.reading() as sql:
            return all_participants(sql)

    def tell(self, participant: int, about: Mapping[str, str]) -> None:
        """Record the answers about a participant who has not submitted."""
        now, text = self.clock(), json.dumps(dict(about), ensure_ascii=False)
        change = "UPDATE participants SET about = ?, seen = ? WHERE id = ? AND submitted ISNULL"
        with self._data.writing() as sql:
            sql.execute(change, (text, now, participant))

    def tell_after(self, participant: int, after: Mapping[str, str]) -> None:
        """Record the answers to the questions after the videos, of a participant who has not submitted."""
        now, text = self.clock(), json.dumps(dict(after), ensure_ascii=False)
        change = "UPDATE participants SET after = ?, seen = ? WHERE id = ? AND submitted ISNULL"
        with self._data.writing() as sql:
            sql.execute(change, (text, now, participant))

    def add_recruit(self, recruit: str, parameters: Mapping[str, str]) -> None:
        """Record the parameters of a recruitment service, apart from the answers, unless they are there."""
        with self._data.writing() as sql:
            sql.execute(
                "INSERT OR IGNORE INTO recruits VALUES (?, ?, 'started')",
                (recruit, json.dumps(dict(parameters), ensure_ascii=False)),
            )

    def recruit_parameters(self, recruit: str) -> dict[str, str]:
        """Return the parameters recorded of a recruit; empty without any."""
        with self._data.reading() as sql:
            row = sql.execute("SELECT parameters FROM recruits WHERE digest = ?", (recruit,)).fetchone()
        return json.loads(row[0]) if row else {}

    def end_recruit(self, recruit: str, outcome: str) -> None:
        """Record that a recruit has finished, or failed an attention check."""
        with self._data.writing() as sql:
            sql.execute("UPDATE recruits SET outcome = ? WHERE digest = ?", (outcome, recruit))

    def recruits(self) -> list[tuple[dict[str, str], str]]:
        """Return parameters and outcome of all recruits, in an order unrelated to their time."""
        with self._data.reading() as sql:
            rows = sql.execute("SELECT parameters, outcome FROM recruits ORDER BY parameters").fetchall()
        return [(json.loads(parameters), outcome) for parameters, outcome in rows]

    def instruct(self, participant: int) -> None:
        """Record that a participant has read the instructions."""
        change = "UPDATE participants SET instructed = coalesce(instructed, ?1), seen = ?1 WHERE id = ?2"
        with self._data.writing() as sql:
            sql.execute(change, (self.clock(), participant))

    def show(self, participant: int, place: int) -> None:
        """Record when a video's page was first shown, unless the participant has withdrawn meanwhile."""
        shown = "INSERT OR IGNORE INTO views (participant, place, shown) SELECT id, ?, ? FROM participants WHERE id = ?"
        with self._data.writing() as sql:
            sql.execute(shown, (place, self.clock(), participant))

    def start_play(self, participant: int, place: int, play: str, screen: Screen) -> None:
        """Record the start of a playback once, unless the participant has withdrawn meanwhile."""
        now = self.clock()
        with self._data.writing() as sql:
            # After the clock was put back, earlier playbacks would have to wait for longer than the video's length.
            sql.execute(
                "UPDATE plays SET started = ?1 WHERE participant = ?2 AND place = ?3 AND started > ?1",
                (now, participant, place),
            )
            sql.execute(
                "INSERT OR IGNORE INTO plays (participant, place, play, started, device, width, height)"
                " SELECT id, ?2, ?3, ?4, ?5, ?6, ?7 FROM participants"
                " WHERE id = ?1 AND (SELECT count(*) FROM plays WHERE participant = ?1 AND place = ?2) < ?8",
                (participant, place, play, now, screen.device, screen.width, screen.height, _MAX_PLAYS),
            )
            _mark_seen(sql, participant, now)

    def play(self, participant: int, place: int, play: str) -> Play | None:
        """Return a playback."""
        with self._data.reading() as sql:
            return plays_of(sql, participant, place).get(play)

    def end_play(
        self, participant: int, place: int, play: str, share: float, playback: Playback, duration: float
    ) -> bool:
        """Record the share of a video that a playback has shown; return whether the video may now be answered.

        Args:
            participant: number of the participant.
            place: place of the video.
            play: name of the playback.
            share: credited share, see `rules.credited`.
            playback: what the browser counted and measured.
            duration: length of the video [s].
        """
        now = self.clock()
        with self._data.writing() as sql:
            sql.execute(
                "UPDATE plays SET share = max(share, ?), frames = max(frames, ?), dropped = max(dropped, ?),"
                " stalls = max(stalls, ?), stalled_ms = max(stalled_ms, ?), play_ms = max(play_ms, ?)"
                " WHERE participant = ? AND place = ? AND play = ?",
                (share, *astuple(playback), participant, place, play),
            )
            if may_answer(plays_of(sql, participant, place).values(), now, duration):
                sql.execute(
                    "UPDATE views SET opened = coalesce(opened, ?) WHERE participant = ? AND place = ?",
                    (now, participant, place),
                )
            return place in opened_by(sql, participant)

    def answer(
        self, participant: int, place: int, response: str, ratings: Mapping[str, int], response_ms: int | None = None
    ) -> bool:
        """Record an answer, unless it repeats the last one; return whether it counts now.

        It does not count after the submission, before the video was watched, and after a withdrawal. The browser's
        response time [ms] is dropped where it is longer than the time since the video's page was first shown.
        """
        now, answer = self.clock(), (response, json.dumps(dict(ratings)))
        with self._data.writing() as sql:
            person = sql.execute("SELECT 1 FROM participants WHERE id = ? AND submitted ISNULL", (participant,))
            if person.fetchone() is None or place not in opened_by(sql, participant):
                return False
            last = sql.execute(
                "SELECT response, ratings FROM answers WHERE participant = ? AND place = ? ORDER BY id DESC LIMIT 1",
                (participant, place),
            ).fetchone()
            if last != answer:
                sql.execute(
                    "INSERT INTO answers (participant, place, response, ratings, given, response_ms)"
                    " SELECT ?1, ?2, ?3, ?4, ?5, CASE WHEN ?6 <= 1000 * (?5 - shown) + 1000 THEN ?6 END FROM views"
                    " WHERE participant = ?1 AND place = ?2",
                    (participant, place, *answer, now, response_ms),
                )
            _mark_seen(sql, participant, now)
            return True

    def submit(self, participant: int) -> bool:
        """Submit a participant's answers if every video has one; return whether they are submitted, now or before."""
        with self._data.writing() as sql:
            sql.execute(
                "UPDATE participants SET submitted = ?1, seen = ?1 WHERE id = ?2 AND submitted ISNULL AND"
                " json_array_length(videos) = (SELECT count(DISTINCT place) FROM answers WHERE participant = ?2)",
                (self.clock(), participant),
            )
            submitted = "SELECT 1 FROM participants WHERE id = ? AND submitted NOTNULL"
            return sql.execute(submitted, (participant,)).fetchone() is not None

    def withdraw(self, digest: str, recruit: str = "") -> Withdrawal:
        """Delete a participant from the file and its log; a repetition completes what another program has kept.

        Args:
            digest: digest of the participant's code.
            recruit: digest of the code among recruits.
        """
        with self._data.writing() as sql:
            sql.execute("DELETE FROM recruits WHERE digest = ?", (recruit,))
            if sql.execute("DELETE FROM participants WHERE digest = ?", (digest,)).rowcount:
                sql.execute("INSERT OR IGNORE INTO withdrawn VALUES (?)", (digest,))
            elif not sql.execute("SELECT 1 FROM withdrawn WHERE digest = ?", (digest,)).fetchone():
                return Withdrawal.UNKNOWN
        return Withdrawal.DELETED if self._data.checkpoint() else Withdrawal.PENDING

    def has_withdrawn(self, digest: str) -> bool:
        """Return whether the participant with a code of this digest has withdrawn."""
        with self._data.reading() as sql:
            return sql.execute("SELECT 1 FROM withdrawn WHERE digest = ?", (digest,)).fetchone() is not None

    def withdrawals(self) -> int:
        """Return the number of withdrawn participants."""
        with self._data.reading() as sql:
            return int(sql.execute("SELECT count(*) FROM withdrawn").fetchone()[0])

    def _steady_clock(self) -> Callable[[], float]:
        """Return a clock that starts at the system's time, not before the last record, and only moves forward."""
        with self._data.reading() as sql:
            (latest,) = sql.execute("SELECT max(seen) FROM participants").fetchone()
        # Unlike CLOCK_MONOTONIC, CLOCK_BOOTTIME counts the time for which a computer sleeps.
        which = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)
        offset = max(time.time(), latest or 0.0) - time.clock_gettime(which)
        return lambda: time.clock_gettime(which) + offset


def _mark_seen(sql: sqlite3.Connection, participant: int, now: float) -> None:
    sql.execute("UPDATE participants SET seen = ? WHERE id = ?", (now, participant))


def database_of(path: Path, *, pilot: bool) -> Path:
    """Return the database file of a kit's answers; a pilot has its own file."""
    return KitFolder(path).answers / ("pilot.sqlite" if pilot else "answers.sqlite")


def open_survey(path: Path, *, pilot: bool, create: bool = False, patience: float = _PATIENCE) -> tuple[Kit, Store]:
    """Return a kit, without its private folder, and the store of the answers to it.

    Args:
        path: folder of the kit.
        pilot: whether to open the answers of the pilot.
        create: whether to create a missing store.
        patience: seconds to wait while another program holds the write lock.

    Raises:
        InputError: if the folder is not a finished kit, the kit has no orders, its videos are not those of its
            manifest, or the store is missing or belongs to another kit.
        EmovidError: if the store cannot be opened.
    """
    kit = open_public(path)
    file = database_of(path, pilot=pilot)
    if create:
        _check_complete(kit)
    elif not file.is_file():
        raise InputError(f"{file}: no such file; expected answers: emovid study serve{' --pilot' * pilot} records them")
    return kit, Store(file, kit.manifest.key_commitment, patience=patience)


def _check_complete(kit: Kit) -> None:
    kit.need_orders()
    for video in kit.manifest.all_videos.values():
        path = kit.folder.video(video.code)
        if not path.is_file() or path.stat().st_size != video.bytes:
            raise InputError(
                f"{path}: not the video of the manifest; expected {video.bytes} bytes: build the kit again"
            )
    known = set(kit.manifest.codes)
    for name, order in kit.orders.items():
        if not set(order) <= known:
            message = f"{name} has videos that the manifest lacks; expected the orders of this kit: build it again"
            raise InputError(f"{kit.folder.orders}: {message}")
