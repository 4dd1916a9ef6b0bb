"""What the player asks and tells: the videos themselves, in parts, and the reports of what was watched."""

from typing import Any

from flask import Blueprint, abort, request, send_file
from werkzeug.wrappers import Response

from emovid.survey import session, watch_rules
from emovid.survey.flow import Page, Step, is_open
from emovid.survey.forms import play_of, screen_of, watched_of
from emovid.survey.records import Participant
from emovid.survey.session import survey

player = Blueprint("player", __name__)
_KEPT = 24 * 60 * 60  # seconds that a browser keeps a video


@player.get("/media/<name>.mp4")
def media(name: str) -> Response:
    """Send one of the participant's videos, or the bytes of it that are asked for."""
    person = session.participant()
    if person is None or name not in person.videos:
        abort(404)
    path = survey().kit.folder.video(name).resolve()
    reply = send_file(path, mimetype="video/mp4", conditional=True, etag=name, max_age=_KEPT)
    reply.cache_control.public, reply.cache_control.private = False, True
    return reply


@player.post("/video/<int:place>/play")
def play(place: int) -> tuple[dict[str, Any], int]:
    """Take the report that a video begins to play: the server's clock starts."""
    person, report, name = _report(place)
    survey().store.show(person.id, place)
    survey().store.start_play(person.id, place, name, screen_of(report))
    return {}, 200


@player.post("/video/<int:place>/watched")
def watched(place: int) -> tuple[dict[str, Any], int]:
    """Take the report of how much was watched; say whether the video may be answered, or when to report again."""
    person, report, name = _report(place)
    store = survey().store
    known = store.play(person.id, place, name)
    if known is None:
        abort(409)
    share, frames = watched_of(report)
    duration, now = _duration(person.videos[place - 1]), store.clock()
    believed = watch_rules.credited(share, known.started, now, duration)
    opened = store.end_play(person.id, place, name, believed, frames, duration)
    return {"open": opened, "wait": 0 if opened else watch_rules.wait(share, known.started, now, duration)}, 200


def _report(place: int) -> tuple[Participant, dict[str, Any], str]:
    """Return who reports, what, and of which play."""
    person = session.participant()
    if person is None:
        abort(403)
    report = request.get_json()
    name = play_of(report)
    if name is None:
        abort(400)
    if not is_open(Step(Page.VIDEO, place), session.progress(person)):
        abort(409)
    return person, report, name


def _duration(code: str) -> float:
    """Return how long a video is [s]."""
    return next(video.duration for video in survey().manifest.videos if video.code == code)
