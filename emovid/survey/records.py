"""Typed records of participants, and the queries that read them from the database."""

import json
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from emovid.survey.rules import WATCHED, Play

Order = tuple[str, ...]


@dataclass(frozen=True)
class Answer:
    """The answer to a video that counts, and the first one.

    `given` and `first_given` are seconds since 1970; `first_ms` is the time that the first answer took, measured by the
    browser from the moment when the question could be answered [ms].
    """

    response: str
    ratings: Mapping[str, int]
    given: float
    first: str
    first_given: float
    first_ms: int | None
    changes: int


@dataclass(frozen=True)
class Participant:
    """A participant.

    Attributes:
        id: number of the participant, counted from 1; never used twice.
        order_row: row of the orders.
        videos: codes of the videos, by place.
        choices: labels, in the order of the page.
        consent_version: version of the consent text.
        enrolled: time of the consent [s since 1970].
        seen: time of the last record [s since 1970].
        about: answers to the questions about the participant; None before they are given.
        instructed: whether the participant has read the instructions.
        submitted: time of the submission [s since 1970]; None before.
        answers: answers by place, counted from 1.
        opened: places of the videos that may be answered.
        after: answers to the questions after the videos; None before they are given.
        language: language of the pages; "" for that of the kit.
        kit_version: version of the kit's texts at the consent.
    """

    id: int
    order_row: str
    videos: Order
    choices: Order
    consent_version: str
    enrolled: float
    seen: float
    about: Mapping[str, str] | None
    instructed: bool
    submitted: float | None
    answers: Mapping[int, Answer]
    opened: frozenset[int]
    after: Mapping[str, str] | None = None
    language: str = ""
    kit_version: int = 1


@dataclass(frozen=True)
class Screen:
    """Device that shows a video: its class, and the displayed size of the video [CSS pixels]."""

    device: str
    width: int
    height: int


@dataclass(frozen=True)
class Playback:
    """Quality of one playback, as the browser counts and measures it.

    Attributes:
        frames: frames shown.
        dropped: frames dropped.
        stalls: number of times that the video stood still, waiting for data.
        stalled_ms: time for which it stood still [ms].
        play_ms: time from the first frame to the last one, without pauses [ms].
    """

    frames: int = 0
    dropped: int = 0
    stalls: int = 0
    stalled_ms: int = 0
    play_ms: int = 0


@dataclass(frozen=True)
class Viewing:
    """How a participant saw a video.

    Attributes:
        shown: time when the page was first shown [s since 1970].
        started: time when the first playback began [s since 1970]; None before.
        ended: time when the first full playback was reported [s since 1970]; None before.
        plays: number of playbacks.
        share: largest share of the video's length watched in one playback.
        screen: device of the first playback.
        frames: frames shown in all playbacks.
        dropped: frames dropped in all playbacks.
        watched: quality of the first full playback, or of the longest one.
    """

    shown: float
    started: float | None
    ended: float | None
    plays: int
    share: float
    screen: Screen | None
    frames: int
    dropped: int
    watched: Playback


class _ViewRow(NamedTuple):
    shown: float
    opened: float | None


class _PlayRow(NamedTuple):
    started: float
    share: float
    device: str
    width: int
    height: int
    frames: int
    dropped: int
    stalls: int
    stalled_ms: int
    play_ms: int

    @property
    def playback(self) -> Playback:
        return Playback(self.frames, self.dropped, self.stalls, self.stalled_ms, self.play_ms)


class _AnswerRow(NamedTuple):
    response: str
    ratings: str
    given: float
    response_ms: int | None


_PARTICIPANTS = (
    "SELECT id, order_row, videos, choices, consent_version, enrolled, seen, about, instructed, submitted,"
    " after, language, kit_version FROM participants"
)


def find_participant(sql: sqlite3.Connection, digest: str) -> Participant | None:
    """Return the participant with a code of this digest."""
    row = sql.execute(_PARTICIPANTS + " WHERE digest = ?", (digest,)).fetchone()
    return None if row is None else _participant(sql, *row)


def all_participants(sql: sqlite3.Connection) -> list[tuple[Participant, dict[int, Viewing]]]:
    """Return all participants in the sequence of their enrollment, with their viewings by place."""
    people = [_participant(sql, *row) for row in sql.execute(_PARTICIPANTS + " ORDER BY id").fetchall()]
    return [(person, _viewings(sql, person.id)) for person in people]


def plays_of(sql: sqlite3.Connection, participant: int, place: int) -> dict[str, Play]:
    """Return the playbacks of one video by one participant, by name."""
    query = "SELECT play, started, share FROM plays WHERE participant = ? AND place = ?"
    return {name: Play(started, share) for name, started, share in sql.execute(query, (participant, place))}


def opened_by(sql: sqlite3.Connection, participant: int) -> frozenset[int]:
    """Return the places of the videos that a participant may answer."""
    rows = sql.execute("SELECT place FROM views WHERE participant = ? AND opened NOTNULL", (participant,))
    return frozenset(place for (place,) in rows)


def _participant(
    sql: sqlite3.Connection,
    id_: int,
    order_row: str,
    videos: str,
    choices: str,
    consent_version: str,
    enrolled: float,
    seen: float,
    about: str | None,
    instructed: float | None,
    submitted: float | None,
    after: str | None,
    language: str,
    kit_version: int,
) -> Participant:
    return Participant(
        id=id_,
        order_row=order_row,
        videos=tuple(json.loads(videos)),
        choices=tuple(json.loads(choices)),
        consent_version=consent_version,
        enrolled=enrolled,
        seen=seen,
        about=None if about is None else json.loads(about),
        instructed=instructed is not None,
        submitted=submitted,
        answers=_answers(sql, id_),
        opened=opened_by(sql, id_),
        after=None if after is None else json.loads(after),
        language=language,
        kit_version=kit_version,
    )


def _answers(sql: sqlite3.Connection, participant: int) -> dict[int, Answer]:
    query = "SELECT place, response, ratings, given, response_ms FROM answers WHERE participant = ? ORDER BY id"
    rows: dict[int, list[_AnswerRow]] = {}
    for place, *row in sql.execute(query, (participant,)):
        rows.setdefault(place, []).append(_AnswerRow(*row))
    return {place: _answer(changes) for place, changes in rows.items()}


def _answer(changes: Sequence[_AnswerRow]) -> Answer:
    first, last = changes[0], changes[-1]
    return Answer(
        response=last.response,
        ratings=json.loads(last.ratings),
        given=last.given,
        first=first.response,
        first_given=first.given,
        first_ms=first.response_ms,
        changes=len(changes) - 1,
    )


def _viewings(sql: sqlite3.Connection, participant: int) -> dict[int, Viewing]:
    query = (
        "SELECT place, started, share, device, width, height, frames, dropped, stalls, stalled_ms, play_ms"
        " FROM plays WHERE participant = ? ORDER BY started"
    )
    plays: dict[int, list[_PlayRow]] = {}
    for place, *row in sql.execute(query, (participant,)):
        plays.setdefault(place, []).append(_PlayRow(*row))
    views = sql.execute("SELECT place, shown, opened FROM views WHERE participant = ?", (participant,))
    return {place: _viewing(_ViewRow(*row), plays.get(place, [])) for place, *row in views.fetchall()}


def _viewing(view: _ViewRow, plays: Sequence[_PlayRow]) -> Viewing:
    first = plays[0] if plays else None
    full = next(
        (play for play in plays if play.share >= WATCHED), max(plays, key=lambda play: play.share, default=None)
    )
    return Viewing(
        shown=view.shown,
        started=first.started if first else None,
        ended=view.opened,
        plays=len(plays),
        share=max((play.share for play in plays), default=0.0),
        screen=Screen(first.device, first.width, first.height) if first else None,
        frames=sum(play.frames for play in plays),
        dropped=sum(play.dropped for play in plays),
        watched=full.playback if full else Playback(),
    )
