"""The recorded answers as the table that `study analyze` reads, and the progress of the survey."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields

from emovid.csv_writer import csv_text
from emovid.kit.manifest import Manifest
from emovid.kit.orders import balance_of
from emovid.survey.records import Answer, Participant, Viewing
from emovid.survey.store import Store

FINISHED, IN_PROGRESS, ABANDONED = "finished", "in progress", "abandoned"


@dataclass(frozen=True)
class ResponseRow:
    """The columns of responses.csv, in this order; a column for each question about the participant follows.

    Times are seconds since the participant's enrollment: the time of day is not told.
    """

    participant: str
    video: str
    position: int
    response: str
    first_response: str
    changes: int
    confidence: int | str
    valence: int | str
    arousal: int | str
    choices: str
    plays: int
    watched_share: str
    shown_seconds: str
    played_seconds: str
    first_answer_seconds: str
    answer_seconds: str
    width: int | str
    height: int | str
    frames: int
    dropped_frames: int
    ended_seconds: str
    stalls: int
    stalled_ms: int
    play_ms: int
    response_ms: int | str
    device: str
    order_row: str
    consent_version: str
    status: str
    mode: str


@dataclass(frozen=True)
class SurveyProgress:
    """Progress of a survey.

    Attributes:
        finished: participants who have submitted.
        in_progress: unfinished participants with recent activity.
        abandoned: unfinished participants without recent activity.
        withdrawn: participants who had their answers deleted.
        answers: answers to videos by all participants who have not withdrawn.
        rows: number of finished participants with each row of the orders.
        places: least and most often that a video was shown in a place, among finished participants.
        neighbors: least and most often that a video was shown right after another one.
    """

    finished: int
    in_progress: int
    abandoned: int
    withdrawn: int
    answers: int
    rows: Mapping[str, int]
    places: tuple[int, int]
    neighbors: tuple[int, int]

    @property
    def enrolled(self) -> int:
        """Participants who gave consent."""
        return self.finished + self.in_progress + self.abandoned + self.withdrawn

    def as_json(self) -> dict[str, object]:
        """Return the progress in plain types."""
        return asdict(self) | {"enrolled": self.enrolled}

    def __str__(self) -> str:
        used = sorted(self.rows.values())
        names = ("enrolled", "finished", "in progress", "abandoned", "withdrawn", "answers")
        lines = [f"{name:12} {getattr(self, name.replace(' ', '_')):5d}" for name in names]
        lines.append(
            f"Orders of finished participants: each row {used[0]} to {used[-1]} times, each video {self.places[0]} to "
            f"{self.places[1]} times in each place, {self.neighbors[0]} to {self.neighbors[1]} times right after each "
            "other one"
        )
        return "\n".join(lines)


def responses_csv(store: Store, manifest: Manifest, *, pilot: bool, release: float) -> str:
    """Return all answers of participants who have not withdrawn, one row per participant and video.

    Args:
        store: store of the answers.
        manifest: manifest of the kit, for the names of the questions.
        pilot: whether these are pilot answers, which the analysis leaves out.
        release: seconds without activity after which a participant counts as abandoned.
    """
    questions = [item.name for item in manifest.demographics]
    head = [*(field.name for field in fields(ResponseRow)), *questions]
    now = store.clock()
    rows: list[list[object]] = []
    for person, viewings in store.participants():
        about = [(person.about or {}).get(name, "") for name in questions]
        status = status_of(person, now, release)
        rows += [[*asdict(row).values(), *about] for row in _rows(person, viewings, status, "pilot" if pilot else "")]
    return csv_text(head, rows)


def status_of(person: Participant, now: float, release: float) -> str:
    """Return "finished", "in progress", or "abandoned" after `release` seconds without activity."""
    if person.submitted is not None:
        return FINISHED
    return IN_PROGRESS if person.seen >= now - release else ABANDONED


def progress_of(store: Store, rows: Sequence[str], codes: Sequence[str], release: float) -> SurveyProgress:
    """Return the progress of a survey.

    Args:
        store: store of the answers.
        rows: rows of the orders.
        codes: codes of the videos.
        release: seconds without activity after which a participant counts as abandoned.
    """
    people = [person for person, _ in store.participants()]
    counts = Counter(status_of(person, store.clock(), release) for person in people)
    done = [person for person in people if person.submitted is not None]
    taken = Counter(person.order_row for person in done)
    shown = max((len(person.videos) for person in people), default=len(codes))
    balance = balance_of([person.videos for person in done], codes, shown)
    return SurveyProgress(
        finished=counts[FINISHED],
        in_progress=counts[IN_PROGRESS],
        abandoned=counts[ABANDONED],
        withdrawn=store.withdrawals(),
        answers=sum(len(person.answers) for person in people),
        rows={row: taken[row] for row in rows},
        places=balance.places_range,
        neighbors=balance.pairs_range,
    )


def _rows(person: Participant, viewings: Mapping[int, Viewing], status: str, pilot: str) -> Iterator[ResponseRow]:
    for place, answer in sorted(person.answers.items()):
        yield _row(person, place, answer, viewings[place], status, pilot)


def _row(person: Participant, place: int, answer: Answer, view: Viewing, status: str, pilot: str) -> ResponseRow:
    return ResponseRow(
        participant=f"{pilot or 'p'}-{person.id:04d}",
        video=person.videos[place - 1],
        position=place,
        response=answer.response,
        first_response=answer.first,
        changes=answer.changes,
        confidence=answer.ratings.get("confidence", ""),
        valence=answer.ratings.get("valence", ""),
        arousal=answer.ratings.get("arousal", ""),
        choices="|".join(person.choices),
        plays=view.plays,
        watched_share=f"{view.share:.3f}",
        shown_seconds=_since(person, view.shown),
        played_seconds=_since(person, view.started),
        first_answer_seconds=_since(person, answer.first_given),
        answer_seconds=_since(person, answer.given),
        width=view.screen.width if view.screen else "",
        height=view.screen.height if view.screen else "",
        frames=view.frames,
        dropped_frames=view.dropped,
        ended_seconds=_since(person, view.ended),
        stalls=view.watched.stalls,
        stalled_ms=view.watched.stalled_ms,
        play_ms=view.watched.play_ms,
        response_ms="" if answer.first_ms is None else answer.first_ms,
        device=view.screen.device if view.screen else "",
        order_row=person.order_row,
        consent_version=person.consent_version,
        status=status,
        mode=pilot or "study",
    )


def _since(person: Participant, moment: float | None) -> str:
    return "" if moment is None else f"{max(moment - person.enrolled, 0.0):.3f}"
