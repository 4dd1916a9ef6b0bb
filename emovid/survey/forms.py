"""Validation of what forms and the player send: values that our pages cannot send are replaced or refused."""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from emovid.kit.manifest import NamedRating
from emovid.kit.study import Question
from emovid.survey.records import Playback, Screen

MAX_CHARACTERS = 500  # of a line of text
MIN_BODY = 64 * 1024  # bytes of a request that are always accepted
_BYTES_PER_CHARACTER = 12  # of a character outside the Basic Multilingual Plane, percent-encoded
_MAX_MS = 24 * 60 * 60 * 1000  # of a time measured by the browser
DEVICES = ("phone", "tablet", "desktop")
_NOT_IN_A_LINE = ("Cc", "Zl", "Zp", "Cs")  # controls, line and paragraph separators, halves of a character
_MAX_COUNT = 100_000  # pixels or frames: more is an error


@dataclass(frozen=True)
class PlayerReport:
    """A report of the player.

    Attributes:
        play: name of the playback.
        screen: device that shows it; zeros and "" where the report does not say.
        share: reported share of the video's length that was watched.
        playback: what the browser counted and measured.
    """

    play: str
    screen: Screen
    share: float
    playback: Playback


def about_of(items: Sequence[Question], form: Mapping[str, str]) -> tuple[dict[str, str], set[str]]:
    """Return the answers about a participant, and the names of required questions without an answer."""
    answers = {item.name: _text(item, form.get(item.name, "")) for item in items}
    return answers, {item.name for item in items if item.required and not answers[item.name]}


def answer_of(
    choices: Sequence[str], ratings: Sequence[NamedRating], form: Mapping[str, str]
) -> tuple[str, dict[str, int], set[str]]:
    """Return the label and the ratings of an answer to a video, and the names of missing parts."""
    response = form.get("response", "")
    response = response if response in choices else ""
    rated = {item.name: _rating(form.get(item.name, ""), item.steps) for item in ratings}
    missing = {name for name, value in rated.items() if not value}
    return response, rated, missing if response else missing | {"response"}


def report_of(data: Any) -> PlayerReport | None:
    """Return a report of the player; None if it does not name a playback."""
    play = data.get("play") if isinstance(data, dict) else None
    if not (isinstance(play, str) and re.fullmatch("[0-9a-f]{16}", play)):
        return None
    device = data.get("device")
    screen = Screen(device if device in DEVICES else "", _count(data.get("width")), _count(data.get("height")))
    playback = Playback(
        frames=_count(data.get("frames")),
        dropped=_count(data.get("dropped")),
        stalls=_count(data.get("stalls")),
        stalled_ms=round(_clipped(data.get("stalled-ms"), _MAX_MS)),
        play_ms=round(_clipped(data.get("play-ms"), _MAX_MS)),
    )
    return PlayerReport(play, screen, _clipped(data.get("share"), 1.0), playback)


def body_limit(items: Sequence[Question]) -> int:
    """Return the size [bytes] of the largest request that the study's longest form can make."""
    lines = sum(item.choices is None for item in items)
    return MIN_BODY + lines * MAX_CHARACTERS * _BYTES_PER_CHARACTER


def response_ms_of(form: Mapping[str, str]) -> int | None:
    """Return the response time that the browser measured [ms], if the form has one."""
    given = form.get("response-ms", "")
    return int(given) if re.fullmatch("[0-9]{1,8}", given) and int(given) <= _MAX_MS else None


def _text(item: Question, given: str) -> str:
    """Return an answer: one of the choices, or a line of text; "" without one.

    Control characters and line ends become spaces. Joiners and marks of direction (category Cf) belong to the words of
    many scripts, and stay.
    """
    if item.choices is not None:
        return given if given in item.choices else ""
    return "".join(" " if unicodedata.category(c) in _NOT_IN_A_LINE else c for c in given).strip()[:MAX_CHARACTERS]


def _rating(given: str, steps: int) -> int:
    value = int(given) if re.fullmatch("[0-9]{1,3}", given) else 0
    return value if value <= steps else 0


def _count(value: Any) -> int:
    return round(_clipped(value, _MAX_COUNT))


def _clipped(value: Any, maximum: float) -> float:
    """Return a number clipped to the range from 0 to the maximum; 0 for anything else."""
    return float(min(max(0, value), maximum)) if isinstance(value, int | float) else 0.0  # max(0, NaN) is 0
