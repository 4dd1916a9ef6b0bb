"""The recorded answers as the table that `study analyze` reads, and the progress of the survey."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

from emovid.csv_reader import read_bytes, read_table
from emovid.csv_writer import csv_text
from emovid.kit.folder import Kit
from emovid.kit.manifest import Manifest
from emovid.kit.orders import balance_of
from emovid.kit.study import Counting
from emovid.responses.quality import SPEEDER, STRAIGHTLINER, is_speeder, is_straightliner
from emovid.responses.responses import FAILED_CHECK, SMOOTH, UNSUBMITTED
from emovid.survey.records import Answer, Participant, Playback, Viewing
from emovid.survey.store import Store

FINISHED, COMPLETE, IN_PROGRESS, ABANDONED = "finished", "complete", "in progress", "abandoned"


@dataclass(frozen=True)
class ResponseRow:
    """The columns of responses.csv, in this order; a column for each question about the participant follows.

    Times are seconds since the participant's enrollment: the time of day is not exported. A participant without answers
    has one row, without a video.
    """

    participant: str
    video: str = ""
    position: int | str = ""
    response: str = ""
    first_response: str = ""
    changes: int | str = ""
    confidence: int | str = ""
    valence: int | str = ""
    arousal: int | str = ""
    choices: str = ""
    plays: int | str = ""
    watched_share: str = ""
    shown_seconds: str = ""
    played_seconds: str = ""
    first_answer_seconds: str = ""
    answer_seconds: str = ""
    width: int | str = ""
    height: int | str = ""
    frames: int | str = ""
    dropped_frames: int | str = ""
    ended_seconds: str = ""
    stalls: int | str = ""
    stalled_ms: int | str = ""
    play_ms: int | str = ""
    response_ms: int | str = ""
    playback: str = ""
    device: str = ""
    checks: str = ""
    order_row: str = ""
    consent_version: str = ""
    language: str = ""
    kit_version: int | str = ""
    status: str = ""
    mode: str = ""


@dataclass(frozen=True)
class SurveyProgress:
    """Progress of a survey.

    Attributes:
        finished: participants who have submitted.
        in_progress: unfinished participants with recent activity.
        abandoned: unfinished participants without recent activity.
        complete: of these, participants who answered all videos and did not submit.
        began: participants with at least one answer to a video.
        withdrawn: participants who had their answers deleted.
        answers: answers to videos by all participants who have not withdrawn.
        rows: number of finished participants with each row of the orders.
        places: least and most often that a video was shown in a place, among finished participants.
        neighbors: least and most often that a video was shown right after another one.
    """

    finished: int
    in_progress: int
    abandoned: int
    complete: int
    began: int
    withdrawn: int
    answers: int
    rows: Mapping[str, int]
    places: tuple[int, int]
    neighbors: tuple[int, int]

    @property
    def enrolled(self) -> int:
        """Participants who gave consent."""
        return self.finished + self.in_progress + self.abandoned + self.withdrawn

    def flow(self) -> dict[str, int]:
        """Return the numbers of participants from the consent to the submission, and that of answers."""
        return {
            "enrolled": self.enrolled,
            "began": self.began,
            "finished": self.finished,
            "in progress": self.in_progress,
            "abandoned": self.abandoned,
            "complete": self.complete,
            "withdrawn": self.withdrawn,
            "answers": self.answers,
        }

    def as_json(self) -> dict[str, object]:
        """Return the progress in plain types."""
        return asdict(self) | {"enrolled": self.enrolled}

    def __str__(self) -> str:
        used = sorted(self.rows.values())
        lines = [f"{name:12} {count:5d}" for name, count in self.flow().items()]
        lines.append(
            f"Orders of finished participants: each row {used[0]} to {used[-1]} times, each video {self.places[0]} to "
            f"{self.places[1]} times in each place, {self.neighbors[0]} to {self.neighbors[1]} times right after each "
            "other one"
        )
        return "\n".join(lines)


def responses_csv(store: Store, kit: Kit, *, pilot: bool, release: float, mode: str = "") -> str:
    """Return all answers of participants who have not withdrawn, one row per participant and video.

    Args:
        store: store of the answers.
        kit: kit of the survey.
        pilot: whether these are pilot answers, which the analysis leaves out.
        release: seconds without activity after which a participant counts as abandoned.
        mode: value of the column `mode`, instead of "pilot" or "study".
    """
    manifest = kit.manifest
    before = [item.name for item in manifest.demographics]
    after = [item.name for item in manifest.questions_after]
    head = [*(field.name for field in fields(ResponseRow)), *before, *after]
    now = store.clock()
    rows: list[list[object]] = []
    for person, viewings in store.participants():
        about = [(person.about or {}).get(name, "") for name in before]
        about += [(person.after or {}).get(name, "") for name in after]
        shared = ResponseRow(
            participant=f"{'pilot' if pilot else 'p'}-{store.site}-{person.id:04d}",
            choices="|".join(person.choices),
            checks=_checks(person, kit),
            order_row=person.order_row,
            consent_version=person.consent_version,
            language=person.language or manifest.language,
            kit_version=person.kit_version,
            status=_exported_status(person, kit, now, release),
            mode=mode or ("pilot" if pilot else "study"),
        )
        rows += [[*asdict(row).values(), *about] for row in _rows(person, viewings, shared, manifest)]
    return csv_text(head, rows)


def status_of(person: Participant, now: float, release: float) -> str:
    """Return "finished", "complete" (all answered, not submitted), "in progress", or "abandoned".

    An unfinished participant counts as complete or abandoned after `release` seconds without activity.
    """
    if person.submitted is not None:
        return FINISHED
    if person.seen >= now - release:
        return IN_PROGRESS
    return COMPLETE if len(person.answers) == len(person.videos) else ABANDONED


def passed_checks(person: Participant, kit: Kit) -> tuple[int, int]:
    """Return the number of passed attention checks, and of those with an answer."""
    codes = {check.video.code: check.name for check in kit.manifest.checks}
    given = {
        codes[person.videos[place - 1]]: answer.response
        for place, answer in person.answers.items()
        if person.videos[place - 1] in codes
    }
    return sum(kit.server.answers.get(name) == response for name, response in given.items()), len(given)


def progress_of(store: Store, rows: Sequence[str], codes: Sequence[str], release: float) -> SurveyProgress:
    """Return the progress of a survey.

    Args:
        store: store of the answers.
        rows: rows of the orders.
        codes: codes of the videos.
        release: seconds without activity after which a participant counts as abandoned.
    """
    people, shown_codes = [person for person, _ in store.participants()], set(codes)
    counts = Counter(status_of(person, store.clock(), release) for person in people)
    done = [person for person in people if person.submitted is not None]
    taken = Counter(person.order_row for person in done)
    orders = [tuple(code for code in person.videos if code in shown_codes) for person in done]
    shown = max(map(len, orders), default=len(codes))
    balance = balance_of(orders, codes, shown)
    return SurveyProgress(
        finished=counts[FINISHED],
        in_progress=counts[IN_PROGRESS],
        abandoned=counts[ABANDONED] + counts[COMPLETE],
        complete=counts[COMPLETE],
        began=sum(bool(person.answers) for person in people),
        withdrawn=store.withdrawals(),
        answers=sum(person.videos[place - 1] in shown_codes for person in people for place in person.answers),
        rows={row: taken[row] for row in rows},
        places=balance.places_range,
        neighbors=balance.pairs_range,
    )


def _exported_status(person: Participant, kit: Kit, now: float, release: float) -> str:
    """Return the status of the export, which decides whether the analysis counts a participant."""
    counting, status = kit.manifest.counting, status_of(person, now, release)
    complete = person.submitted is None and len(person.answers) == len(person.videos)
    if complete:
        status = COMPLETE if counting.unsubmitted else UNSUBMITTED
    passed, given = passed_checks(person, kit)
    if passed < given and not counting.failed_checks:
        return FAILED_CHECK
    answered = {person.videos[place - 1]: answer for place, answer in person.answers.items()}
    shown = {code: answer for code, answer in answered.items() if code in set(kit.manifest.codes)}
    if not counting.straightliners and is_straightliner([answer.response for answer in shown.values()], list(shown)):
        return STRAIGHTLINER
    times = [answer.first_ms for answer in shown.values() if answer.first_ms is not None]
    return SPEEDER if is_speeder(times, counting.min_response_ms) else status


def _checks(person: Participant, kit: Kit) -> str:
    passed, given = passed_checks(person, kit)
    return f"{passed} of {given}" if given else ""


def _rows(
    person: Participant, viewings: Mapping[int, Viewing], shared: ResponseRow, manifest: Manifest
) -> Iterator[ResponseRow]:
    """Yield a row for each answer to a stimulus; positions count stimuli only."""
    stimuli = set(manifest.codes)
    places = [place for place, code in enumerate(person.videos, start=1) if code in stimuli]
    given = [(position, place) for position, place in enumerate(places, start=1) if place in person.answers]
    if not given:
        yield shared
    for position, place in given:
        answer = person.answers[place]
        yield _row(person, position, answer, viewings[place], replace(shared, video=person.videos[place - 1]), manifest)


def _row(
    person: Participant, position: int, answer: Answer, view: Viewing, shared: ResponseRow, manifest: Manifest
) -> ResponseRow:
    return replace(
        shared,
        position=position,
        response=answer.response,
        first_response=answer.first,
        changes=answer.changes,
        confidence=answer.ratings.get("confidence", ""),
        valence=answer.ratings.get("valence", ""),
        arousal=answer.ratings.get("arousal", ""),
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
        playback=_playback(view.watched, view.share, manifest.counting),
        device=view.screen.device if view.screen else "",
    )


def _playback(watched: Playback, share: float, counting: Counting) -> str:
    """Return "smooth", or why the study's rules leave an answer to this playback out."""
    if counting.max_stalled_ms is not None and watched.stalled_ms > counting.max_stalled_ms:
        return "stalled"
    if counting.max_dropped is not None and watched.dropped > counting.max_dropped * max(watched.frames, 1):
        return "dropped frames"
    if counting.min_watched is not None and share < counting.min_watched:
        return "not watched"
    return SMOOTH


def _since(person: Participant, moment: float | None) -> str:
    return "" if moment is None else f"{max(moment - person.enrolled, 0.0):.3f}"


def is_of_kit(file: Path, codes: Collection[str]) -> bool:
    """Return whether a file is a table of answers to the videos of a kit, which a later one may replace."""
    if not file.is_file():
        return False
    table = read_table(read_bytes(file), str(file))
    if "video" not in table.names or "participant" not in table.names:
        return False
    return set(table.cells[table.names.index("video")]) - {""} <= set(codes)
