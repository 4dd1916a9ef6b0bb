"""What the database tells of participants."""

from collections.abc import Mapping
from dataclasses import dataclass

Order = tuple[str, ...]


@dataclass(frozen=True)
class Answer:
    """The answer to a video that counts, and the first one; `given` and `first_given` are seconds since 1970."""

    response: str
    ratings: Mapping[str, int]
    given: float
    first: str
    first_given: float
    changes: int


@dataclass(frozen=True)
class Participant:
    """A participant.

    Attributes:
        id: counts up from 1; never given again.
        order_row: of the orders.
        videos: the codes, by place.
        choices: the labels, in the order of the page.
        consent_version: that was agreed to.
        enrolled: when [s since 1970].
        seen: when something was last recorded.
        about: the answers about the participant; None before they are given.
        instructed: whether the instructions were read.
        submitted: when; None before.
        answers: by place, from 1.
        opened: the places of the videos that may be answered.
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


@dataclass(frozen=True)
class Screen:
    """What a video was shown on: class of device, and displayed size [CSS pixels]."""

    device: str
    width: int
    height: int


@dataclass(frozen=True)
class Viewing:
    """How a participant saw a video.

    Attributes:
        shown: when its page was shown first [s since 1970].
        started: when its first play began; None before.
        plays: how often it was begun.
        share: of its length that was watched, of the play that showed most.
        screen: of the first play.
        frames: shown in all plays, and dropped of them.
    """

    shown: float
    started: float | None
    plays: int
    share: float
    screen: Screen | None
    frames: tuple[int, int]
