"""What the database says, as records: all SQL that only reads participants."""

import json
import sqlite3
from typing import Any

from emovid.survey.records import Answer, Participant, Screen, Viewing
from emovid.survey.watch_rules import Play

_PEOPLE = (
    "SELECT id, order_row, videos, choices, consent_version, enrolled, seen, about, instructed, submitted"
    " FROM participants"
)


def participant_of(sql: sqlite3.Connection, digest: str) -> Participant | None:
    """Return the participant with a code of this digest."""
    row = sql.execute(_PEOPLE + " WHERE digest = ?", (digest,)).fetchone()
    return None if row is None else _participant(sql, row)


def all_participants(sql: sqlite3.Connection) -> list[tuple[Participant, dict[int, Viewing]]]:
    """Return all participants in the sequence of their enrolment, with how they saw the videos, by place."""
    rows = sql.execute(_PEOPLE + " ORDER BY id").fetchall()
    return [(_participant(sql, row), _viewings(sql, row[0])) for row in rows]


def plays_of(sql: sqlite3.Connection, at: tuple[int, int]) -> dict[str, Play]:
    """Return the plays of a participant and place, by name."""
    rows = sql.execute("SELECT play, started, share FROM plays WHERE participant = ? AND place = ?", at)
    return {name: Play(started, share) for name, started, share in rows}


def opened_by(sql: sqlite3.Connection, participant: int) -> frozenset[int]:
    """Return the places of the videos that a participant may answer."""
    rows = sql.execute("SELECT place FROM views WHERE participant = ? AND opened NOTNULL", (participant,))
    return frozenset(place for (place,) in rows)


def _participant(sql: sqlite3.Connection, row: Any) -> Participant:
    person, order_row, videos, choices, version, enrolled, seen, about, instructed, submitted = row
    return Participant(
        id=person,
        order_row=order_row,
        videos=tuple(json.loads(videos)),
        choices=tuple(json.loads(choices)),
        consent_version=version,
        enrolled=enrolled,
        seen=seen,
        about=None if about is None else json.loads(about),
        instructed=instructed is not None,
        submitted=submitted,
        answers=_answers(sql, person),
        opened=opened_by(sql, person),
    )


def _answers(sql: sqlite3.Connection, participant: int) -> dict[int, Answer]:
    query = "SELECT place, response, ratings, given FROM answers WHERE participant = ? ORDER BY id"
    given: dict[int, list[tuple[str, str, float]]] = {}
    for place, *said in sql.execute(query, (participant,)):
        given.setdefault(place, []).append((said[0], said[1], said[2]))
    return {
        place: Answer(each[-1][0], json.loads(each[-1][1]), each[-1][2], each[0][0], each[0][2], len(each) - 1)
        for place, each in given.items()
    }


def _viewings(sql: sqlite3.Connection, participant: int) -> dict[int, Viewing]:
    plays: dict[int, list[Any]] = {}
    query = (
        "SELECT place, started, share, device, width, height, frames, dropped FROM plays WHERE participant = ?"
        " ORDER BY started"
    )
    for row in sql.execute(query, (participant,)):
        plays.setdefault(row[0], []).append(row[1:])
    shown = sql.execute("SELECT place, shown FROM views WHERE participant = ?", (participant,))
    return {place: _viewing(first, plays.get(place, [])) for place, first in shown.fetchall()}


def _viewing(shown: float, plays: list[Any]) -> Viewing:
    return Viewing(
        shown=shown,
        started=plays[0][0] if plays else None,
        plays=len(plays),
        share=max((play[1] for play in plays), default=0.0),
        screen=Screen(*plays[0][2:5]) if plays else None,
        frames=(sum(play[5] for play in plays), sum(play[6] for play in plays)),
    )
