"""The pages of the survey in sequence, from the consent to the thanks."""

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import replace

from flask import Blueprint, abort, g, redirect, render_template, request, url_for
from werkzeug.wrappers import Response

from emovid.survey import codes, session
from emovid.survey.database import DatabaseBusyError
from emovid.survey.forms import MAX_CHARACTERS, about_of, answer_of, response_ms_of
from emovid.survey.records import Participant
from emovid.survey.rules import Page, Step, after_video, before, current, is_open
from emovid.survey.session import survey

pages = Blueprint("pages", __name__)
Reply = Response | str | tuple[str, int]


@pages.get("/")
def start() -> Reply:
    """Ask for consent, or continue where the participant left off."""
    person = session.participant()
    return render_template("consent.html") if person is None else _to_current(person)


@pages.post("/consent")
def consent() -> Reply:
    """Enroll a participant who agrees, once; tell others that nothing was recorded."""
    if survey().store.has_withdrawn(codes.digest(g.code)):  # the page is older than the withdrawal
        session.use_code(codes.fresh_code())
        abort(403)
    person = session.participant()
    if request.form.get("consent") == "agree":
        return _to_current(person or _enroll())
    if person is None:
        return render_template("message.html", text=survey().manifest.consent.declined)
    return redirect(url_for("access.ask_to_withdraw"), 303)  # consented before, in another tab


@pages.get("/about")
def about() -> Reply:
    """Ask the questions about the participant."""
    person = _allowed(Step(Page.ABOUT))
    return _about_page(person, person.about or {})


@pages.post("/about")
def tell() -> Reply:
    """Record the answers about the participant."""
    person = _allowed(Step(Page.ABOUT))
    about, missing = about_of(survey().manifest.demographics, request.form)
    if missing:
        return _about_page(person, about, missing), 400
    survey().store.tell(person.id, about)
    return _to(Step(Page.INSTRUCTIONS))


@pages.get("/instructions")
def instructions() -> Reply:
    """Show the instructions and the notice of motion."""
    person = _allowed(Step(Page.INSTRUCTIONS))
    back = _back(Step(Page.INSTRUCTIONS), person)
    return render_template("instructions.html", back=back, ahead=person.videos)


@pages.post("/instructions")
def instruct() -> Reply:
    """Record that the participant has read the instructions."""
    person = _allowed(Step(Page.INSTRUCTIONS))
    survey().store.instruct(person.id)
    return _to(Step(Page.VIDEO, 1))


@pages.get("/video/<int:place>")
def video(place: int) -> Reply:
    """Show a video and ask the question of the study."""
    person = _allowed(Step(Page.VIDEO, place))
    with suppress(DatabaseBusyError):  # the report of the first playback records it, too
        survey().store.show(person.id, place)
    given = person.answers.get(place)
    return _video_page(person, place, given.response if given else "", given.ratings if given else {})


@pages.post("/video/<int:place>")
def answer(place: int) -> Reply:
    """Record an answer; it is on the disk before the reply is sent."""
    person = _allowed(Step(Page.VIDEO, place))
    response, ratings, missing = answer_of(person.choices, survey().manifest.ratings, request.form)
    if place not in person.opened:
        return _video_page(person, place, "", {}), 409
    if missing:
        return _video_page(person, place, response, ratings, missing), 400
    if not survey().store.answer(person.id, place, response, ratings, response_ms_of(request.form)):
        return redirect(url_for(".start"), 303)  # submitted or withdrawn in another tab meanwhile
    done = replace(session.progress(person), answered={*person.answers, place})
    return _to(after_video(place, done))


@pages.get("/review")
def review() -> Reply:
    """Show all answers, to be changed or submitted."""
    person = _allowed(Step(Page.REVIEW))
    answers = [(place, _text_of(answer.response)) for place, answer in sorted(person.answers.items())]
    return render_template("review.html", answers=answers, back=_back(Step(Page.REVIEW), person))


@pages.post("/submit")
def submit() -> Reply:
    """Submit the answers of a participant who has answered all questions; a repetition changes nothing."""
    person = session.participant()
    if person is None:
        abort(403)
    survey().store.submit(person.id)
    return redirect(url_for(".start"), 303)


@pages.get("/thanks")
def thanks() -> Reply:
    """Thank the participant."""
    _allowed(Step(Page.THANKS))
    return render_template("thanks.html")


def _enroll() -> Participant:
    kit, store, digest = survey().kit, survey().store, codes.digest(g.code)
    labels = tuple(answer.label for answer in kit.manifest.choices.labels)
    choices = {row: kit.choices.get(row, labels) for row in kit.orders}
    return store.enroll(digest, kit.orders, choices, kit.manifest.consent.version, survey().release)


def _allowed(step: Step) -> Participant:
    """Return the participant if the page is open; otherwise redirect to the page where they can continue."""
    person = session.participant()
    if person is None and request.method == "POST":
        abort(403)
    if person is None:
        abort(redirect(url_for("access.resume"), 303))
    if not is_open(step, session.progress(person)):
        abort(_to_current(person))
    return person


def _to_current(person: Participant) -> Response:
    return _to(current(session.progress(person)))


def _to(step: Step) -> Response:
    return redirect(_address(step), 303)


def _back(step: Step, person: Participant) -> str:
    """Return the address of the page before, or ""."""
    previous = before(step, session.progress(person))
    return _address(previous) if previous else ""


def _address(step: Step) -> str:
    if step.page is Page.VIDEO:
        return url_for("pages.video", place=step.place)
    return url_for(f"pages.{step.page.name.lower()}")


def _about_page(person: Participant, about: Mapping[str, str], missing: Collection[str] = ()) -> str:
    return render_template(
        "about.html",
        answers=about,
        missing=missing,
        max_characters=MAX_CHARACTERS,
        ahead=person.videos,
    )


def _video_page(
    person: Participant, place: int, response: str, ratings: Mapping[str, int], missing: Collection[str] = ()
) -> str:
    manifest, code = survey().manifest, person.videos[place - 1]
    return render_template(
        "video.html",
        heading=manifest.texts.place.replace("{place}", str(place)).replace("{count}", str(len(person.videos))),
        place=place,
        count=len(person.videos),
        video=next(item for item in manifest.videos if item.code == code),
        choices=[(label, _text_of(label)) for label in person.choices],
        response=response,
        ratings=ratings,
        missing=missing,
        opened=place in person.opened,
        back=_back(Step(Page.VIDEO, place), person),
        ahead=person.videos[place:],
    )


def _text_of(label: str) -> str:
    """Return the text that participants read for a label."""
    return next(answer.text for answer in survey().manifest.choices.labels if answer.label == label)
