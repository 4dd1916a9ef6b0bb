"""The survey as a Flask application: checks of every request, headers of every response, pages for every error."""

from collections.abc import Iterable
from http import HTTPStatus
from wsgiref.types import StartResponse, WSGIApplication, WSGIEnvironment

from flask import Flask, Response, current_app, g, render_template, request
from werkzeug.exceptions import Forbidden, HTTPException

from emovid.kit.folder import Kit
from emovid.survey import codes, session
from emovid.survey.access import access
from emovid.survey.database import DatabaseBusyError
from emovid.survey.forms import body_limit, max_characters
from emovid.survey.pages import pages
from emovid.survey.player import player
from emovid.survey.session import Survey
from emovid.survey.store import Store

Reply = tuple[str, int, dict[str, str]]
RELEASE = 2 * 60 * 60.0  # s
_RIGHT_TO_LEFT = ("ar", "arc", "ckb", "dv", "fa", "he", "iw", "ks", "ku", "nqo", "ps", "sd", "syr", "ug", "ur", "yi")
_LANGUAGES = {
    "ar": "العربية", "de": "Deutsch", "en": "English", "es": "Español", "fr": "Français", "it": "Italiano",
    "ja": "日本語", "pt": "Português", "zh": "中文",
}  # fmt: skip
_FROM_SCRIPT = "X-Survey-Script"
_KIOSK_SECONDS = 20  # until the last page leads to the next person
_KIOSK_IDLE = 300  # seconds without any action after which a participant at a kiosk has left
_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "media-src 'self' blob:; connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Prefix:
    """WSGI application under a path prefix, with or without a proxy that removes the prefix.

    Args:
        app: the application.
        prefix: path, as in /study1.
    """

    def __init__(self, app: WSGIApplication, prefix: str) -> None:
        self._app, self._prefix = app, prefix

    def __call__(self, environ: WSGIEnvironment, start_response: StartResponse) -> Iterable[bytes]:
        """Answer a request."""
        path = environ.get("PATH_INFO", "")
        if path == self._prefix or path.startswith(f"{self._prefix}/"):
            path = path[len(self._prefix) :]
        environ.update({"SCRIPT_NAME": self._prefix, "PATH_INFO": path or "/"})
        return self._app(environ, start_response)


def create_app(
    kit: Kit,
    store: Store,
    *,
    https: bool = False,
    release: float = RELEASE,
    pilot: bool = False,
    kiosk: bool = False,
    prefix: str = "",
) -> Flask:
    """Return the application.

    Args:
        kit: kit, as `open_public` returns it.
        store: store of the answers.
        https: whether participants connect over TLS.
        release: seconds without activity after which an unfinished participant's row of the orders is free again.
        pilot: whether answers are those of a pilot, which every page says.
        kiosk: whether participants share this computer: the last page leads to the next person by itself.
        prefix: path of the survey's address, as in /study1; "" for none.
    """
    app = Flask(__name__)
    if prefix:
        app.wsgi_app = Prefix(app.wsgi_app, prefix)  # type: ignore[method-assign]
    limit = max(map(body_limit, (kit.manifest.demographics, kit.manifest.questions_after)))
    app.config.update(MAX_CONTENT_LENGTH=limit, MAX_FORM_MEMORY_SIZE=limit, MAX_FORM_PARTS=200)
    app.jinja_env.trim_blocks = app.jinja_env.lstrip_blocks = True
    app.url_map.merge_slashes = False  # only the exact addresses of the pages exist
    app.extensions["survey"] = Survey(kit, store, https, release, pilot, kiosk, prefix)
    for blueprint in (pages, access, player):
        app.register_blueprint(blueprint)
    app.before_request(_check)
    app.after_request(session.set_cookie)
    app.after_request(_tell_script)
    app.after_request(_secure)
    app.register_error_handler(Exception, _error_page)
    app.context_processor(_shared_context)
    return app


def _check() -> None:
    """Refuse requests that change something and do not come from one of our pages in this browser."""
    session.load_code()
    if request.method not in ("GET", "HEAD", "OPTIONS") and not session.has_form_token():
        raise Forbidden


def _tell_script(response: Response) -> Response:
    """Name the next page in a header, to a script that sends a form: following the redirect would load it twice."""
    if _FROM_SCRIPT in request.headers and response.status_code == HTTPStatus.SEE_OTHER:
        response.status_code = HTTPStatus.OK
        response.headers["X-Next"] = response.headers.pop("Location")
        response.set_data(b"")
    return response


def _secure(response: Response) -> Response:
    response.headers.update(_HEADERS)
    response.headers.setdefault("Cache-Control", "no-store")
    return response


def _error_page(error: Exception) -> Reply:
    """Return a page that explains an error in the study's words, without technical details."""
    texts = session.manifest().texts
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
    manifest = session.manifest()
    return {
        "languages": (session.survey().manifest.language, *session.survey().manifest.translations),
        "pilot": session.survey().pilot,
        "kiosk": _KIOSK_SECONDS if session.survey().kiosk else 0,
        "idle": _KIOSK_IDLE if session.survey().kiosk else 0,
        "names_of_languages": _LANGUAGES,
        "max_characters": max_characters,
        "manifest": manifest,
        "texts": manifest.texts,
        "direction": "rtl" if manifest.language.split("-")[0] in _RIGHT_TO_LEFT else "ltr",
        "form_field": session.FORM_FIELD,
        "form_token": session.form_token() if "code" in g else "",
        "code": codes.readable(g.code) if "code" in g else "",
    }
