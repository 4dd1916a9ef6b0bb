"""Rules of the survey, without I/O: which pages are open, which order a participant gets, when a video is watched."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

WATCHED = 0.98  # share of a video's length that counts as all of it: a player may stop a frame or two before the end


class Page(IntEnum):
    """The pages in their sequence."""

    ABOUT = 1
    INSTRUCTIONS = 2
    VIDEO = 3
    AFTER = 4
    REVIEW = 5
    THANKS = 6


@dataclass(frozen=True, order=True)
class Step:
    """A page; for the page of a video, also its place, counted from 1."""

    page: Page
    place: int = 0


@dataclass(frozen=True)
class Progress:
    """Actions of a participant since giving consent.

    Attributes:
        has_questions: whether the study asks questions about the participant.
        told: whether the participant has answered these.
        instructed: whether the participant has read the instructions.
        videos: number of videos shown, practice and attention checks included.
        answered: places of the videos that have an answer.
        submitted: whether the participant has submitted all answers.
        has_questions_after: whether the study asks questions after the videos.
        told_after: whether the participant has answered these.
    """

    has_questions: bool
    told: bool
    instructed: bool
    videos: int
    answered: Collection[int]
    submitted: bool
    has_questions_after: bool = False
    told_after: bool = False


def current(done: Progress) -> Step:
    """Return the step where a participant continues: the first one that is not done."""
    if done.submitted:
        return Step(Page.THANKS)
    if done.has_questions and not done.told:
        return Step(Page.ABOUT)
    if not done.instructed:
        return Step(Page.INSTRUCTIONS)
    unanswered = (place for place in range(1, done.videos + 1) if place not in done.answered)
    place = next(unanswered, 0)
    if place:
        return Step(Page.VIDEO, place)
    return Step(Page.AFTER if done.has_questions_after and not done.told_after else Page.REVIEW)


def is_open(step: Step, done: Progress) -> bool:
    """Return whether a page may be seen: every page up to the current one, and after submission only the last one."""
    exists = {
        Page.ABOUT: done.has_questions,
        Page.VIDEO: 1 <= step.place <= done.videos,
        Page.AFTER: done.has_questions_after,
    }.get(step.page, True)
    return exists and (step == current(done) if done.submitted else step <= current(done))


def after_video(place: int, done: Progress) -> Step:
    """Return the step after the answer to a video: the next video, or the review once all videos have an answer."""
    last = len(done.answered) == done.videos or place == done.videos
    return current(done) if last else Step(Page.VIDEO, place + 1)


def before(step: Step, done: Progress) -> Step | None:
    """Return the step that the link "Back" leads to, or None."""
    match step.page:
        case Page.INSTRUCTIONS if done.has_questions:
            return Step(Page.ABOUT)
        case Page.VIDEO:
            return Step(Page.VIDEO, step.place - 1) if step.place > 1 else Step(Page.INSTRUCTIONS)
        case Page.REVIEW if done.has_questions_after:
            return Step(Page.AFTER)
        case Page.AFTER | Page.REVIEW:
            return Step(Page.VIDEO, done.videos)
        case _:
            return None


def with_extras(order: Sequence[str], practice: str | None, checks: Sequence[tuple[str, int]]) -> tuple[str, ...]:
    """Return the videos that a participant sees: the order, with the practice video and the attention checks in it.

    Args:
        order: codes of the stimuli.
        practice: code of the practice video, which comes first.
        checks: code of each attention check, and the number of stimuli before it.
    """
    places: list[list[str]] = [[] for _ in range(len(order) + 1)]
    for code, after in checks:
        places[min(after, len(order))].append(code)
    sequence = [code for i, extra in enumerate(places) for code in (*extra, *order[i : i + 1])]
    return (practice, *sequence) if practice else tuple(sequence)


def next_row(rows: Sequence[str], taken: Mapping[str, int]) -> str:
    """Return the row of the orders for a new participant: the first of those that the fewest participants have.

    Rows used in sequence fill one square after the other, so places and neighbors stay balanced at any number.

    Args:
        rows: all rows, in the sequence of orders.csv.
        taken: number of participants, finished or in progress, with each row; missing rows count as 0.
    """
    return min(rows, key=lambda row: taken.get(row, 0))


@dataclass(frozen=True)
class Play:
    """One playback of a video, as the server knows it.

    Attributes:
        started: time when the report of its start arrived, on the server's clock [s].
        share: share of the video's length that was watched; at most the share that the time since the start allows.
    """

    started: float
    share: float


def credited(share: float, started: float, now: float, duration: float) -> float:
    """Return the share of a video that the server credits: the reported one, limited by the time since the start.

    Args:
        share: reported share.
        started: start of this playback [s].
        now: current time on the same clock [s].
        duration: length of the video [s].
    """
    return min(max(share, 0.0), max(now - started, 0.0) / duration, 1.0)


def may_answer(plays: Iterable[Play], now: float, duration: float) -> bool:
    """Return whether a video may be answered: one full playback, and at least its length since the first start."""
    known = list(plays)
    watched = any(play.share >= WATCHED for play in known)
    return watched and now - min(play.started for play in known) >= WATCHED * duration


def wait(share: float, started: float, now: float, duration: float) -> float:
    """Return the time [s] after which the same report will be credited in full; 0 if waiting does not help."""
    return max(started + WATCHED * duration - now, 0.0) if share >= WATCHED else 0.0
