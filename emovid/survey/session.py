"""The session of a browser: the code in its cookie, its participant, and the token of its forms."""

from dataclasses import dataclass
from datetime import timedelta

from flask import Response, current_app, g, request

from emovid.kit.folder import Kit
from emovid.kit.manifest import Manifest, localized
from emovid.survey import codes
from emovid.survey.records import Participant
from emovid.survey.rules import Progress
from emovid.survey.store import Store

FORM_FIELD = "form-token"  # with a hyphen: no question can have this name
FORM_HEADER = "X-Form-Token"
_COOKIE_AGE = timedelta(days=90)


@dataclass(frozen=True)
class Survey:
    """The survey that the application shows.

    Attributes:
        kit: kit, without its private folder.
        store: store of the answers.
        https: whether a proxy in front speaks TLS with participants; the cookie is then sent over TLS only.
        release: seconds without activity after which an unfinished participant's row of the orders is free again.
        pilot: whether answers are those of a pilot.
        kiosk: whether participants share this computer: the last page leads to the next person by itself.
        prefix: path of the survey's address, as in /study1; "" for none.
    """

    kit: Kit
    store: Store
    https: bool
    release: float
    pilot: bool = False
    kiosk: bool = False
    prefix: str = ""

    @property
    def manifest(self) -> Manifest:
        """Public manifest of the kit."""
        return self.kit.manifest

    @property
    def cookie(self) -> str:
        """Name of the cookie; browsers let no other host set one that begins with __Host-, whose path is /."""
        if not self.https:
            return "emovid"
        return "__Secure-emovid" if self.prefix else "__Host-emovid"


def survey() -> Survey:
    """Return the survey of the running application."""
    found: Survey = current_app.extensions["survey"]
    return found


def load_code() -> None:
    """Take the code from the cookie, or draw a new one; nothing is recorded before the consent."""
    given = codes.normalized(request.cookies.get(survey().cookie, ""))
    g.code, g.new = given or codes.fresh_code(), not given


def use_code(code: str) -> None:
    """Make this the code of the browser."""
    g.code, g.new = code, True


def set_cookie(response: Response) -> Response:
    """Set the cookie where the browser does not have it yet."""
    if g.get("new") and request.endpoint != "static":
        https, path = survey().https, survey().prefix or "/"
        response.set_cookie(
            survey().cookie, g.code, max_age=_COOKIE_AGE, httponly=True, samesite="Lax", secure=https, path=path
        )
    return response


def participant() -> Participant | None:
    """Return the participant with this code; None before the consent and after a withdrawal."""
    return survey().store.find(codes.digest(g.code))


def progress(person: Participant) -> Progress:
    """Return the progress of a participant."""
    return Progress(
        has_questions=bool(survey().manifest.demographics),
        told=person.about is not None,
        instructed=person.instructed,
        videos=len(person.videos),
        answered=person.answers.keys(),
        submitted=person.submitted is not None,
        has_questions_after=bool(survey().manifest.questions_after),
        told_after=person.after is not None,
    )


def form_token() -> str:
    """Return the token that a form of this browser must send."""
    return codes.form_token(survey().store.secret, g.code)


def has_cookie() -> bool:
    """Return whether the browser sent the survey's cookie."""
    return survey().cookie in request.cookies


def has_form_token() -> bool:
    """Return whether the request has the right token, in a field or in a header."""
    given = request.headers.get(FORM_HEADER) or request.form.get(FORM_FIELD, "")
    return codes.is_form_token(given, survey().store.secret, g.code)


def manifest() -> Manifest:
    """Return the manifest in the language of the participant, or the one that was chosen on the first page."""
    own = survey().manifest
    if not own.translations:
        return own
    if "manifest" not in g:
        person = participant() if "code" in g else None
        g.manifest = localized(own, person.language if person else request.values.get("language", ""))
    found: Manifest = g.manifest
    return found
