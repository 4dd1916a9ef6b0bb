"""Who is asking: the code in the cookie, the participant it stands for, and the form that only our pages can send."""

from dataclasses import dataclass
from datetime import timedelta

from flask import Response, current_app, g, request

from emovid.kit.manifest import Manifest
from emovid.kit.read import Kit
from emovid.survey import codes
from emovid.survey.flow import Progress
from emovid.survey.records import Participant
from emovid.survey.store import Store

FORM_FIELD = "form-token"  # with a hyphen: no question can have this name
FORM_HEADER = "X-Form-Token"
_COOKIE_AGE = timedelta(days=90)


@dataclass(frozen=True)
class Survey:
    """What the pages are made from.

    Attributes:
        kit: without its private folder.
        store: of the answers.
        https: whether participants come by TLS, spoken by a proxy in front; the cookie then travels by TLS only.
        release: after so many seconds without a sign of who has it, a row of the orders is free again.
    """

    kit: Kit
    store: Store
    https: bool
    release: float

    @property
    def manifest(self) -> Manifest:
        """The public manifest of the kit."""
        return self.kit.manifest

    @property
    def cookie(self) -> str:
        """The name of the cookie; browsers let no other host set one that begins with __Host-."""
        return "__Host-emovid" if self.https else "emovid"


def survey() -> Survey:
    """Return what the pages of the running application are made from."""
    found: Survey = current_app.extensions["survey"]
    return found


def meet() -> None:
    """Take the code from the cookie, or draw one; nothing is recorded of it before the consent."""
    given = codes.normal(request.cookies.get(survey().cookie, ""))
    g.code, g.new = given or codes.fresh_code(), not given


def take(code: str) -> None:
    """Make this the code of the browser from now on."""
    g.code, g.new = code, True


def keep(response: Response) -> Response:
    """Set the cookie where the browser does not have it yet."""
    if g.get("new") and request.endpoint != "static":
        own = survey()
        response.set_cookie(own.cookie, g.code, max_age=_COOKIE_AGE, httponly=True, samesite="Lax", secure=own.https)
    return response


def participant() -> Participant | None:
    """Return the participant with this code; None before the consent and after a withdrawal."""
    return survey().store.find(codes.digest(g.code))


def progress(person: Participant) -> Progress:
    """Return what a participant has done."""
    return Progress(
        asked=bool(survey().manifest.demographics),
        told=person.about is not None,
        instructed=person.instructed,
        videos=len(person.videos),
        answered=person.answers.keys(),
        submitted=person.submitted is not None,
    )


def form_token() -> str:
    """Return what a form of this browser must bring along."""
    return codes.form_token(survey().store.secret, g.code)


def brings_token() -> bool:
    """Return whether a request brought it, in a field or in a header."""
    given = request.headers.get(FORM_HEADER) or request.form.get(FORM_FIELD, "")
    return codes.is_form_token(given, survey().store.secret, g.code)
