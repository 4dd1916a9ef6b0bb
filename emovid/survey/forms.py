"""Validation of what forms and the player send: values that our pages cannot send are replaced or refused."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from emovid.kit.manifest import NamedRating
from emovid.kit.study import Question
from emovid.survey.records import Screen

MAX_CHARACTERS = 500  # of a line of text
DEVICES = ("phone", "tablet", "desktop")
_MAX_COUNT = 100_000  # pixels or frames: more is an error


@dataclass(frozen=True)
class PlayerReport:
    """A report of the player.

    Attributes:
        play: name of the playback.
        screen: device that shows it; zeros and "" where the report does not say.
        share: reported share of the video's length that was watched.
        frames: number of frames shown, and of frames dropped.
    """

    play: str
    screen: Screen
    share: float
    frames: tuple[int, int]


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
    frames = _count(data.get("frames")), _count(data.get("dropped"))
    return PlayerReport(play, screen, _clipped(data.get("share"), 1.0), frames)


def _text(item: Question, given: str) -> str:
    """Return an answer: one of the choices, or a line of text without unprintable characters; else ""."""
    if item.choices is not None:
        return given if given in item.choices else ""
    return " ".join("".join(mark if mark.isprintable() else " " for mark in given).split())[:MAX_CHARACTERS]


def _rating(given: str, steps: int) -> int:
    value = int(given) if re.fullmatch("[0-9]{1,3}", given) else 0
    return value if value <= steps else 0


def _count(value: Any) -> int:
    return round(_clipped(value, _MAX_COUNT))


def _clipped(value: Any, maximum: float) -> float:
    """Return a number clipped to the range from 0 to the maximum; 0 for anything else."""
    return float(min(max(0, value), maximum)) if isinstance(value, int | float) else 0.0  # max(0, NaN) is 0
