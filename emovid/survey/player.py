"""Requests of the player: the videos, in parts, and the reports of playback."""

from flask import Blueprint, abort, request, send_file
from werkzeug.wrappers import Response

from emovid.survey import rules, session
from emovid.survey.forms import PlayerReport, report_of
from emovid.survey.records import Participant
from emovid.survey.rules import Page, Step, is_open
from emovid.survey.session import survey

player = Blueprint("player", __name__)
_MAX_AGE = 24 * 60 * 60  # seconds for which a browser caches a video


@player.get("/media/<name>.mp4")
def media(name: str) -> Response:
    """Send one of the participant's videos, or the requested range of its bytes."""
    person = session.participant()
    if person is None or name not in person.videos:
        abort(404)
    path = survey().kit.folder.video(name).resolve()
    reply = send_file(path, mimetype="video/mp4", conditional=True, etag=name, max_age=_MAX_AGE)
    reply.cache_control.public, reply.cache_control.private = False, True
    return reply


@player.post("/video/<int:place>/play")
def play(place: int) -> dict[str, object]:
    """Record that a playback starts: the server's clock starts."""
    person, report = _report(place)
    survey().store.show(person.id, place)
    survey().store.start_play(person.id, place, report.play, report.screen)
    return {}


@player.post("/video/<int:place>/watched")
def watched(place: int) -> dict[str, object]:
    """Record how much was watched; return whether the video may be answered, or when to report again."""
    person, report = _report(place)
    store = survey().store
    known = store.play(person.id, place, report.play)
    if known is None:
        abort(409)
    duration = survey().manifest.all_videos[person.videos[place - 1]].duration
    now = store.clock()
    share = rules.credited(report.share, known.started, now, duration)
    opened = store.end_play(person.id, place, report.play, share, report.playback, duration)
    return {"open": opened, "wait": 0 if opened else rules.wait(report.share, known.started, now, duration)}


def _report(place: int) -> tuple[Participant, PlayerReport]:
    """Return the participant and the report of this request."""
    person = session.participant()
    if person is None:
        abort(403)
    try:
        report = report_of(request.get_json())
    except RecursionError:  # deeply nested
        report = None
    if report is None:
        abort(400)
    if not is_open(Step(Page.VIDEO, place), session.progress(person)):
        abort(409)
    return person, report
