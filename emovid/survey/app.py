"""The survey as a Flask application: what every request must bring, every reply carries, and every failure says."""

from flask import Flask, Response, current_app, g, render_template, request
from werkzeug.exceptions import Forbidden, HTTPException

from emovid.kit.read import Kit
from emovid.survey import codes, session
from emovid.survey.access_routes import doors
from emovid.survey.pages import pages
from emovid.survey.player import player
from emovid.survey.session import Survey
from emovid.survey.store import Store

MOST_BYTES = 64 * 1024  # of a request; the longest form, a hundred lines of text, needs less
RELEASE = 2 * 60 * 60.0  # s
_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "media-src 'self'; connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


def create_app(kit: Kit, store: Store, *, https: bool = False, release: float = RELEASE) -> Flask:
    """Return the application.

    Args:
        kit: as `open_public` returns it.
        store: of the answers.
        https: whether participants come by TLS.
        release: after so many seconds without a sign of who has it, a row of the orders is free again.
    """
    app = Flask(__name__)
    app.config.update(MAX_CONTENT_LENGTH=MOST_BYTES, MAX_FORM_MEMORY_SIZE=MOST_BYTES, MAX_FORM_PARTS=200)
    app.jinja_env.trim_blocks = app.jinja_env.lstrip_blocks = True
    app.url_map.merge_slashes = False  # no address but those of the pages leads anywhere
    app.extensions["survey"] = Survey(kit, store, https, release)
    for part in (pages, doors, player):
        app.register_blueprint(part)
    app.before_request(_check)
    app.after_request(session.keep)
    app.after_request(_secure)
    app.register_error_handler(Exception, _failed)
    app.context_processor(_said_everywhere)
    return app


def _check() -> None:
    """Refuse what changes something and does not come from one of our pages in this browser."""
    session.meet()
    if request.method not in ("GET", "HEAD", "OPTIONS") and not session.brings_token():
        raise Forbidden


def _secure(response: Response) -> Response:
    response.headers.update(_HEADERS)
    response.headers.setdefault("Cache-Control", "no-store")
    return response


def _failed(error: Exception) -> tuple[str, int]:
    """Return a page that says what happened in the study's words, and nothing of the inside."""
    code = (error.code if isinstance(error, HTTPException) else None) or 500
    if code >= 500:
        current_app.logger.error("a request failed", exc_info=error)
    texts = session.survey().manifest.texts
    said = {403: texts.out_of_date, 404: texts.not_found}.get(code, texts.failed)
    return render_template("message.html", text=said, go_on=True), code


def _said_everywhere() -> dict[str, object]:
    manifest = session.survey().manifest
    return {
        "manifest": manifest,
        "texts": manifest.texts,
        "form_field": session.FORM_FIELD,
        "form_token": session.form_token() if "code" in g else "",
        "code": codes.readable(g.code) if "code" in g else "",
    }
