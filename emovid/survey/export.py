"""What is recorded, as the tidy table that `study analyze` reads: codes of videos, no address, nothing of the key."""

from collections.abc import Iterator

from emovid.csv_writer import csv_text
from emovid.kit.manifest import Manifest
from emovid.responses.dialects.own import FIRST, RECORDED
from emovid.survey.progress import status_of
from emovid.survey.records import Participant, Viewing
from emovid.survey.store import Store

Recorded = tuple[Participant, dict[int, Viewing]]


def responses_csv(store: Store, manifest: Manifest, *, pilot: bool, release: float) -> str:
    """Return all answers of those who have not withdrawn, a row for each participant and video.

    Times are seconds since the participant's enrolment: when somebody took part is not told.

    Args:
        store: of the answers.
        manifest: of the kit, for the names of the questions.
        pilot: whether these are pilot answers, which the analysis leaves out.
        release: seconds without a sign after which a participant counts as abandoned.
    """
    recorded = store.participants()
    head = (*FIRST, *RECORDED, *(item.name for item in manifest.demographics))
    now = store.clock()
    rows = []
    for person, viewings in recorded:
        status = status_of(person, now, release)
        shared = {
            "participant": f"{'pilot' if pilot else 'p'}-{person.id:04d}",
            "choices": "|".join(person.choices),
            "order_row": person.order_row,
            "consent_version": person.consent_version,
            "status": status,
            "mode": "pilot" if pilot else "study",
        } | dict(person.about or {})
        rows += [[str((shared | row).get(name, "")) for name in head] for row in _rows(person, viewings)]
    return csv_text(head, rows)


def _rows(person: Participant, viewings: dict[int, Viewing]) -> Iterator[dict[str, object]]:
    for place, answer in sorted(person.answers.items()):
        view = viewings[place]
        screen = view.screen
        yield {
            "video": person.videos[place - 1],
            "position": place,
            "response": answer.response,
            "first_response": answer.first,
            "changes": answer.changes,
            **answer.ratings,
            "plays": view.plays,
            "watched_share": f"{view.share:.3f}",
            "shown_seconds": _since(person, view.shown),
            "played_seconds": _since(person, view.started),
            "first_answer_seconds": _since(person, answer.first_given),
            "answer_seconds": _since(person, answer.given),
            "width": screen.width if screen else "",
            "height": screen.height if screen else "",
            "frames": view.frames[0],
            "dropped_frames": view.frames[1],
            "device": screen.device if screen else "",
        }


def _since(person: Participant, moment: float | None) -> str:
    return "" if moment is None else f"{moment - person.enrolled:.1f}"
