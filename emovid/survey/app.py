"""The survey as a Flask application: checks of every request, headers of every response, pages for every error."""

from flask import Flask, Response, current_app, g, render_template, request
from werkzeug.exceptions import Forbidden, HTTPException

from emovid.kit.folder import Kit
from emovid.survey import codes, session
from emovid.survey.access import access
from emovid.survey.database import DatabaseBusyError
from emovid.survey.forms import body_limit
from emovid.survey.pages import pages
from emovid.survey.player import player
from emovid.survey.session import Survey
from emovid.survey.store import Store

Reply = tuple[str, int, dict[str, str]]
RELEASE = 2 * 60 * 60.0  # s
_RIGHT_TO_LEFT = ("ar", "arc", "ckb", "dv", "fa", "he", "iw", "ks", "ku", "nqo", "ps", "sd", "syr", "ug", "ur", "yi")
_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "media-src 'self' blob:; connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


def create_app(kit: Kit, store: Store, *, https: bool = False, release: float = RELEASE) -> Flask:
    """Return the application.

    Args:
        kit: kit, as `open_public` returns it.
        store: store of the answers.
        https: whether participants connect over TLS.
        release: seconds without activity after which an unfinished participant's row of the orders is free again.
    """
    app = Flask(__name__)
    limit = body_limit(kit.manifest.demographics)
    app.config.update(MAX_CONTENT_LENGTH=limit, MAX_FORM_MEMORY_SIZE=limit, MAX_FORM_PARTS=200)
    app.jinja_env.trim_blocks = app.jinja_env.lstrip_blocks = True
    app.url_map.merge_slashes = False  # only the exact addresses of the pages exist
    app.extensions["survey"] = Survey(kit, store, https, release)
    for blueprint in (pages, access, player):
        app.register_blueprint(blueprint)
    app.before_request(_check)
    app.after_request(session.set_cookie)
    app.after_request(_secure)
    app.register_error_handler(Exception, _error_page)
    app.context_processor(_shared_context)
    return app


def _check() -> None:
    """Refuse requests that change something and do not come from one of our pages in this browser."""
    session.load_code()
    if request.method not in ("GET", "HEAD", "OPTIONS") and not session.has_form_token():
        raise Forbidden


def _secure(response: Response) -> Response:
    response.headers.update(_HEADERS)
    response.headers.setdefault("Cache-Control", "no-store")
    return response


def _error_page(error: Exception) -> Reply:
    """Return a page that explains an error in the study's words, without technical details."""
    texts = session.survey().manifest.texts
    if isinstance(error, DatabaseBusyError):
        page = render_template("message.html", text=texts.busy, has_next=True)
        return page, 503, {"Retry-After": "2", "X-Survey": "busy"}
    status = (error.code if isinstance(error, HTTPException) else None) or 500
    if status >= 500:
        current_app.logger.error("a request failed", exc_info=error)
    text = {403: texts.out_of_date, 404: texts.not_found, 413: texts.too_long}.get(status, texts.failed)
    if status == 403 and not session.has_cookie():
        text = texts.cookies
    return render_template("message.html", text=text, has_next=True), status, {}


def _shared_context() -> dict[str, object]:
    manifest = session.survey().manifest
    return {
        "manifest": manifest,
        "texts": manifest.texts,
        "direction": "rtl" if manifest.language.split("-")[0] in _RIGHT_TO_LEFT else "ltr",
        "form_field": session.FORM_FIELD,
        "form_token": session.form_token() if "code" in g else "",
        "code": codes.readable(g.code) if "code" in g else "",
    }
