"""The sequence of pages: where a participant is, and which pages are open."""

from collections.abc import Collection
from dataclasses import dataclass
from enum import IntEnum


class Page(IntEnum):
    """The pages in their sequence."""

    ABOUT = 1
    INSTRUCTIONS = 2
    VIDEO = 3
    REVIEW = 4
    THANKS = 5


@dataclass(frozen=True, order=True)
class Step:
    """A page; of the videos, the place from 1."""

    page: Page
    place: int = 0


@dataclass(frozen=True)
class Progress:
    """What a participant has done since the consent.

    Attributes:
        asked: whether there are questions about the participant.
        told: whether these are answered.
        instructed: whether the instructions were read.
        videos: how many are shown.
        answered: the places of those that have an answer.
        submitted: whether all was submitted.
    """

    asked: bool
    told: bool
    instructed: bool
    videos: int
    answered: Collection[int]
    submitted: bool


def current(done: Progress) -> Step:
    """Return where a participant goes on: the first page that is not done."""
    if done.submitted:
        return Step(Page.THANKS)
    if done.asked and not done.told:
        return Step(Page.ABOUT)
    if not done.instructed:
        return Step(Page.INSTRUCTIONS)
    open_places = (place for place in range(1, done.videos + 1) if place not in done.answered)
    place = next(open_places, 0)
    return Step(Page.VIDEO, place) if place else Step(Page.REVIEW)


def is_open(step: Step, done: Progress) -> bool:
    """Return whether a page may be seen: all pages up to the current one, and after submission the last one alone."""
    exists = done.asked if step.page is Page.ABOUT else step.page is not Page.VIDEO or 1 <= step.place <= done.videos
    return exists and (step == current(done) if done.submitted else step <= current(done))


def after_video(place: int, done: Progress) -> Step:
    """Return the page after a video's answer: the next video, or the review once all have an answer."""
    whole = len(done.answered) == done.videos or place == done.videos
    return current(done) if whole else Step(Page.VIDEO, place + 1)


def before(step: Step, done: Progress) -> Step | None:
    """Return the page that the link back leads to; None where there is none."""
    match step.page:
        case Page.INSTRUCTIONS if done.asked:
            return Step(Page.ABOUT)
        case Page.VIDEO:
            return Step(Page.VIDEO, step.place - 1) if step.place > 1 else Step(Page.INSTRUCTIONS)
        case Page.REVIEW:
            return Step(Page.VIDEO, done.videos)
        case _:
            return None
