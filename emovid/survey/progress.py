"""How a survey goes: who is where, and the balance of the orders so far."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from emovid.kit.orders import balance_of
from emovid.survey.records import Participant

FINISHED, UNDER_WAY, ABANDONED = "finished", "in progress", "abandoned"


@dataclass(frozen=True)
class SurveyProgress:
    """Where a survey is.

    Attributes:
        finished: participants who have submitted.
        in_progress: who were seen of late.
        abandoned: who were not.
        withdrawn: who had their answers deleted.
        answers: to videos, of all who have not withdrawn.
        rows: how many participants who finished have each row of the orders.
        places: least and most often that a video stood in a place, among those who finished.
        neighbours: least and most often that a video came right after another one.
    """

    finished: int
    in_progress: int
    abandoned: int
    withdrawn: int
    answers: int
    rows: dict[str, int]
    places: tuple[int, int]
    neighbours: tuple[int, int]

    @property
    def enrolled(self) -> int:
        """All who agreed to take part."""
        return self.finished + self.in_progress + self.abandoned + self.withdrawn


def status_of(person: Participant, now: float, release: float) -> str:
    """Return where a participant is: finished, in progress, or abandoned after `release` seconds without a sign."""
    if person.submitted is not None:
        return FINISHED
    return UNDER_WAY if person.seen >= now - release else ABANDONED


def progress_of(
    people: Sequence[Participant], withdrawn: int, rows: Sequence[str], codes: Sequence[str], now: float, release: float
) -> SurveyProgress:
    """Return where a survey is.

    Args:
        people: all who have not withdrawn.
        withdrawn: how many have.
        rows: of the orders.
        codes: of the videos.
        now: by the store's clock [s].
        release: see `status_of`.
    """
    counts = Counter(status_of(person, now, release) for person in people)
    done = [person for person in people if person.submitted is not None]
    taken = Counter(person.order_row for person in done)
    shown = max((len(person.videos) for person in people), default=len(codes))
    balance = balance_of([person.videos for person in done], codes, shown)
    return SurveyProgress(
        finished=counts[FINISHED],
        in_progress=counts[UNDER_WAY],
        abandoned=counts[ABANDONED],
        withdrawn=withdrawn,
        answers=sum(len(person.answers) for person in people),
        rows={row: taken[row] for row in rows},
        places=balance.places_range,
        neighbours=balance.pairs_range,
    )
