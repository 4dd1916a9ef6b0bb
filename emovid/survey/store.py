"""What is recorded of participants. What a method has returned from is on the disk."""

import json
import sqlite3
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from emovid.survey.database import Database
from emovid.survey.enrolment import next_row
from emovid.survey.queries import all_participants, opened_by, participant_of, plays_of
from emovid.survey.records import Order, Participant, Screen, Viewing
from emovid.survey.watch_rules import Play, is_open

_MOST_PLAYS = 500  # recorded of one video and participant; the rest would only fill the disk


class Store:
    """The answers to one kit.

    Args:
        path: of the database, made if missing.
        commitment: to the key of the kit, which tells kits apart.
        clock: seconds since 1970.

    Raises:
        InputError, EmovidError: as `Database`.
    """

    def __init__(self, path: Path, commitment: str, clock: Callable[[], float] = time.time) -> None:
        self.clock = clock
        self._data = Database(path, commitment)
        self.secret = self._data.secret

    def close(self) -> None:
        """Close the database."""
        self._data.close()

    def enrol(
        self, digest: str, orders: Mapping[str, Order], choices: Mapping[str, Order], version: str, release: float
    ) -> Participant:
        """Add a participant, unless there is one with this code; return who has it.

        Args:
            digest: of the participant's code.
            orders: the codes of the videos, by row.
            choices: the labels in the order of the page, by row.
            version: of the consent.
            release: after so many seconds without a sign, who has not finished gives the row back.
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
                " (digest, order_row, videos, choices, consent_version, enrolled, seen) VALUES (?, ?, ?, ?, ?, ?, ?)",
                (digest, row, json.dumps(orders[row]), json.dumps(choices[row]), version, now, now),
            )
            person = participant_of(sql, digest)
        assert person is not None  # added just now, if not before
        return person

    def find(self, digest: str) -> Participant | None:
        """Return the participant with a code of this digest."""
        with self._data.reading() as sql:
            return participant_of(sql, digest)

    def participants(self) -> list[tuple[Participant, dict[int, Viewing]]]:
        """Return all participants in the sequence of their enrolment, with how they saw the videos."""
        with self._data.reading() as sql:
            return all_participants(sql)

    def tell(self, participant: int, about: Mapping[str, str]) -> None:
        """Record the answers about a participant who has not submitted."""
        now, said = self.clock(), json.dumps(dict(about), ensure_ascii=False)
        change = "UPDATE participants SET about = ?, seen = ? WHERE id = ? AND submitted ISNULL"
        with self._data.writing() as sql:
            sql.execute(change, (said, now, participant))

    def instruct(self, participant: int) -> None:
        """Record that a participant has read the instructions."""
        change = "UPDATE participants SET instructed = coalesce(instructed, ?1), seen = ?1 WHERE id = ?2"
        with self._data.writing() as sql:
            sql.execute(change, (self.clock(), participant))

    def show(self, participant: int, place: int) -> None:
        """Record when a video's page was shown first, unless the participant has withdrawn meanwhile."""
        shown = "INSERT OR IGNORE INTO views (participant, place, shown) SELECT id, ?, ? FROM participants WHERE id = ?"
        with self._data.writing() as sql:
            sql.execute(shown, (place, self.clock(), participant))

    def start_play(self, participant: int, place: int, play: str, screen: Screen) -> None:
        """Record that a video has begun to play; the second report of one play says nothing new.

        Nothing is recorded of who has withdrawn meanwhile.
        """
        now, at = self.clock(), (participant, place)
        with self._data.writing() as sql:
            # After a clock was put back, who began before would wait for longer than a video lasts.
            sql.execute(
                "UPDATE plays SET started = ? WHERE participant = ? AND place = ? AND started > ?", (now, *at, now)
            )
            sql.execute(
                "INSERT OR IGNORE INTO plays (participant, place, play, started, device, width, height)"
                " SELECT id, ?, ?, ?, ?, ?, ? FROM participants"
                " WHERE id = ? AND (SELECT count(*) FROM plays WHERE participant = ? AND place = ?) < ?",
                (place, play, now, screen.device, screen.width, screen.height, participant, *at, _MOST_PLAYS),
            )
            _sign(sql, participant, now)

    def play(self, participant: int, place: int, play: str) -> Play | None:
        """Return what is known of a play."""
        with self._data.reading() as sql:
            return plays_of(sql, (participant, place)).get(play)

    def end_play(
        self, participant: int, place: int, play: str, share: float, frames: tuple[int, int], duration: float
    ) -> bool:
        """Record how much of a video a play has shown; return whether the video may now be answered.

        Args:
            participant: who plays.
            place: of the video.
            play: which was begun.
            share: that is believed, see `gate.credited`.
            frames: shown, and dropped of them.
            duration: of the video [s].
        """
        now, at = self.clock(), (participant, place)
        with self._data.writing() as sql:
            sql.execute(
                "UPDATE plays SET share = max(share, ?), frames = max(frames, ?), dropped = max(dropped, ?)"
                " WHERE participant = ? AND place = ? AND play = ?",
                (share, *frames, *at, play),
            )
            if is_open(plays_of(sql, at).values(), now, duration):
                sql.execute(
                    "UPDATE views SET opened = coalesce(opened, ?) WHERE participant = ? AND place = ?", (now, *at)
                )
            return place in opened_by(sql, participant)

    def answer(self, participant: int, place: int, response: str, ratings: Mapping[str, int]) -> bool:
        """Record an answer, unless it is the one that counts already; return whether it counts now.

        It does not where all was submitted, where the video was not watched, and where the participant has withdrawn.
        """
        now, at, said = self.clock(), (participant, place), (response, json.dumps(dict(ratings)))
        with self._data.writing() as sql:
            who = sql.execute("SELECT 1 FROM participants WHERE id = ? AND submitted ISNULL", (participant,)).fetchone()
            if who is None or place not in opened_by(sql, participant):
                return False
            last = sql.execute(
                "SELECT response, ratings FROM answers WHERE participant = ? AND place = ? ORDER BY id DESC LIMIT 1", at
            ).fetchone()
            if last != said:
                sql.execute(
                    "INSERT INTO answers (participant, place, response, ratings, given) VALUES (?, ?, ?, ?, ?)",
                    (*at, *said, now),
                )
            _sign(sql, participant, now)
            return True

    def submit(self, participant: int) -> bool:
        """End a participant's survey if every video has an answer; return whether it has ended, now or before."""
        with self._data.writing() as sql:
            sql.execute(
                "UPDATE participants SET submitted = ?1, seen = ?1 WHERE id = ?2 AND submitted ISNULL AND"
                " json_array_length(videos) = (SELECT count(DISTINCT place) FROM answers WHERE participant = ?2)",
                (self.clock(), participant),
            )
            ended = "SELECT 1 FROM participants WHERE id = ? AND submitted NOTNULL"
            return sql.execute(ended, (participant,)).fetchone() is not None

    def withdraw(self, digest: str) -> bool:
        """Delete all of a participant, from the file and its log; return whether there is or was such a one."""
        with self._data.writing() as sql:
            if sql.execute("DELETE FROM participants WHERE digest = ?", (digest,)).rowcount:
                sql.execute("INSERT OR IGNORE INTO withdrawn VALUES (?)", (digest,))
        self._data.fold()
        return self.has_withdrawn(digest)

    def has_withdrawn(self, digest: str) -> bool:
        """Return whether the participant with a code of this digest has withdrawn."""
        with self._data.reading() as sql:
            return sql.execute("SELECT 1 FROM withdrawn WHERE digest = ?", (digest,)).fetchone() is not None

    def withdrawals(self) -> int:
        """Return how many have withdrawn."""
        with self._data.reading() as sql:
            return int(sql.execute("SELECT count(*) FROM withdrawn").fetchone()[0])


def _sign(sql: sqlite3.Connection, participant: int, now: float) -> None:
    sql.execute("UPDATE participants SET seen = ? WHERE id = ?", (now, participant))
