"""Validation of what forms and the player send: values that our pages cannot send are replaced or refused."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from werkzeug.datastructures import MultiDict

from emovid.kit.manifest import NamedRating
from emovid.kit.study import Question, Requirements
from emovid.survey.records import Playback, Screen

MAX_CHARACTERS = 500  # of a line of text
MAX_LONG = 5000  # of several lines
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


def answers_of(items: Sequence[Question], form: MultiDict[str, str]) -> tuple[dict[str, str], set[str]]:
    """Return the answers to questions, and the names of those whose answer is missing or invalid.

    Several choices are separated by |.
    """
    answers = {item.name: _answer(item, form.getlist(item.name)) for item in items}
    given = {item.name for item in items if item.number and "".join(form.getlist(item.name)).strip()}
    return answers, {item.name for item in items if not answers[item.name] and (item.required or item.name in given)}


def typed_of(names: Iterable[str], form: Mapping[str, str]) -> dict[str, str]:
    """Return invalid answers as they were typed, to be corrected."""
    return {name: _line(form.get(name, ""))[:MAX_CHARACTERS] for name in names}


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


def max_characters(item: Question) -> int:
    """Return the length of the longest answer to a question for text."""
    return MAX_LONG if item.long else MAX_CHARACTERS


def body_limit(items: Sequence[Question]) -> int:
    """Return the size [bytes] of the largest request that a form with these questions can make."""
    return MIN_BODY + _BYTES_PER_CHARACTER * sum(max_characters(item) for item in items if item.choices is None)


def is_suitable(requirements: Requirements, form: Mapping[str, str], user_agent: str) -> bool:
    """Return whether a device and browser meet the study's requirements, as far as they are known.

    Args:
        requirements: of the study.
        form: device and width of the window [CSS pixels], as the script of the first page adds them.
        user_agent: of the browser.
    """
    device, width = form.get("device", ""), form.get("width", "")
    if device in DEVICES and device not in requirements.devices:
        return False
    if re.fullmatch("[0-9]{1,6}", width) and int(width) < requirements.min_width:
        return False
    return not requirements.browsers or browser_of(user_agent) in requirements.browsers


def browser_of(user_agent: str) -> str:
    """Return the family of a browser: edge, firefox, chrome, safari, or "" for another one."""
    families = {
        "edge": r"Edg(e|A|iOS)?/",
        "firefox": r"(Firefox|FxiOS)/",
        "chrome": r"(Chrome|Chromium|CriOS)/",
        "safari": r"Version/.* Safari/",
    }
    return next((name for name, pattern in families.items() if re.search(pattern, user_agent)), "")


def response_ms_of(form: Mapping[str, str]) -> int | None:
    """Return the response time that the browser measured [ms], if the form has one."""
    given = form.get("response-ms", "")
    return int(given) if re.fullmatch("[0-9]{1,8}", given) and int(given) <= _MAX_MS else None


def _answer(item: Question, given: Sequence[str]) -> str:
    """Return an answer: one or several of the choices, a number in the range, or text; "" without one."""
    if item.choices is not None:
        chosen = [choice for choice in item.choices if choice in given]
        return "|".join(chosen if item.several else chosen[:1])
    text = given[0] if given else ""
    if item.number:
        number = int(text) if re.fullmatch(r"\s*[+-]?[0-9]{1,12}\s*", text, re.ASCII) else item.number.low - 1
        return str(number) if item.number.low <= number <= item.number.high else ""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return ("\n" if item.long else " ").join(map(_line, lines)).strip()[: max_characters(item)]


def _line(text: str) -> str:
    """Return text without control characters and line separators.

    Joiners and marks of direction (category Cf) belong to the words of many scripts, and stay.
    """
    return "".join(" " if unicodedata.category(character) in _NOT_IN_A_LINE else character for character in text)


def _rating(given: str, steps: int) -> int:
    value = int(given) if re.fullmatch("[0-9]{1,3}", given) else 0
    return value if value <= steps else 0


def _count(value: Any) -> int:
    return round(_clipped(value, _MAX_COUNT))


def _clipped(value: Any, maximum: float) -> float:
    """Return a number clipped to the range from 0 to the maximum; 0 for anything else."""
    return float(min(max(0, value), maximum)) if isinstance(value, int | float) else 0.0  # max(0, NaN) is 0
