"""What forms and reports of a page say, checked: nothing of them is believed that the page could not have sent."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from emovid.kit.manifest import NamedRating
from emovid.kit.study import Question
from emovid.survey.records import Screen

MOST_MARKS = 500  # of a line of text
DEVICES = ("phone", "tablet", "desktop")
_MOST = 100_000  # pixels or frames: more is a slip


def about_of(items: Sequence[Question], form: Mapping[str, str]) -> tuple[dict[str, str], set[str]]:
    """Return the answers about a participant, and the names of questions without one that must have one."""
    said = {item.name: _text(item, form.get(item.name, "")) for item in items}
    return said, {item.name for item in items if item.required and not said[item.name]}


def answer_of(
    choices: Sequence[str], ratings: Sequence[NamedRating], form: Mapping[str, str]
) -> tuple[str, dict[str, int], set[str]]:
    """Return the label and the ratings of an answer to a video, and the names of what is missing."""
    response = form.get("response", "")
    response = response if response in choices else ""
    rated = {item.name: _whole(form.get(item.name, ""), item.steps) for item in ratings}
    missing = {name for name, value in rated.items() if not value}
    return response, rated, missing if response else missing | {"response"}


def play_of(report: Any) -> str | None:
    """Return the play that a report is of; None where it names none."""
    play = report.get("play") if isinstance(report, dict) else None
    return play if isinstance(play, str) and re.fullmatch("[0-9a-f]{16}", play) else None


def screen_of(report: Mapping[str, Any]) -> Screen:
    """Return what a video is shown on, zeros and "" for what a report does not say."""
    device = report.get("device")
    return Screen(device if device in DEVICES else "", _count(report.get("width")), _count(report.get("height")))


def watched_of(report: Mapping[str, Any]) -> tuple[float, tuple[int, int]]:
    """Return the share of a video that a report claims, and the frames shown and dropped."""
    return _within(report.get("share"), 1.0), (_count(report.get("frames")), _count(report.get("dropped")))


def _text(item: Question, given: str) -> str:
    """Return an answer: one of the choices, or a line of text without marks that do not print; else ""."""
    if item.choices is not None:
        return given if given in item.choices else ""
    return " ".join("".join(mark if mark.isprintable() else " " for mark in given).split())[:MOST_MARKS]


def _whole(given: str, most: int) -> int:
    value = int(given) if re.fullmatch("[0-9]{1,3}", given) else 0
    return value if value <= most else 0


def _count(value: Any) -> int:
    return round(_within(value, _MOST))


def _within(value: Any, most: float) -> float:
    """Return the number that is nearest to a value from 0 to the most; 0 for what is no number."""
    return float(min(max(0, value), most)) if isinstance(value, int | float) else 0.0  # max(0, NaN) is 0
