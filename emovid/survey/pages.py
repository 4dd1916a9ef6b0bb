"""The pages that participants read and answer, from the consent to the thanks."""

from collections.abc import Collection, Mapping
from dataclasses import replace

from flask import Blueprint, abort, g, redirect, render_template, request, url_for
from werkzeug.wrappers import Response

from emovid.survey import codes, session
from emovid.survey.flow import Page, Step, after_video, before, current, is_open
from emovid.survey.forms import MOST_MARKS, about_of, answer_of
from emovid.survey.records import Participant
from emovid.survey.session import survey

pages = Blueprint("pages", __name__)
Reply = Response | str | tuple[str, int]


@pages.get("/")
def start() -> Reply:
    """Ask for consent, or go on from where the participant was."""
    person = session.participant()
    return render_template("consent.html") if person is None else _to_current(person)


@pages.post("/consent")
def consent() -> Reply:
    """Enrol who agrees; a second time it is the same participant."""
    if survey().store.has_withdrawn(codes.digest(g.code)):  # a page from before that
        session.take(codes.fresh_code())
        abort(403)
    person = session.participant()
    if request.form.get("consent") == "agree":
        return _to_current(person or _enrol())
    if person is None:
        return render_template("message.html", text=survey().manifest.consent.declined)
    return redirect(url_for("doors.ask_to_withdraw"), 303)  # agreed before, as in another tab


@pages.get("/about")
def about() -> Reply:
    """Ask the questions about the participant."""
    person = _allowed(Step(Page.ABOUT))
    return _about_page(person.about or {})


@pages.post("/about")
def tell() -> Reply:
    """Record the answers about the participant."""
    person = _allowed(Step(Page.ABOUT))
    said, missing = about_of(survey().manifest.demographics, request.form)
    if missing:
        return _about_page(said, missing), 400
    survey().store.tell(person.id, said)
    return _to(Step(Page.INSTRUCTIONS))


@pages.get("/instructions")
def instructions() -> Reply:
    """Show the instructions and the notice of motion."""
    person = _allowed(Step(Page.INSTRUCTIONS))
    return render_template("instructions.html", back=_back(Step(Page.INSTRUCTIONS), person))


@pages.post("/instructions")
def instruct() -> Reply:
    """Record that they were read."""
    person = _allowed(Step(Page.INSTRUCTIONS))
    survey().store.instruct(person.id)
    return _to(Step(Page.VIDEO, 1))


@pages.get("/video/<int:place>")
def video(place: int) -> Reply:
    """Show a video and ask the question of the study."""
    person = _allowed(Step(Page.VIDEO, place))
    survey().store.show(person.id, place)
    given = person.answers.get(place)
    return _video_page(person, place, given.response if given else "", given.ratings if given else {})


@pages.post("/video/<int:place>")
def answer(place: int) -> Reply:
    """Record an answer; the reply is sent when it is on the disk."""
    person = _allowed(Step(Page.VIDEO, place))
    response, ratings, missing = answer_of(person.choices, survey().manifest.ratings, request.form)
    if place not in person.opened:
        return _video_page(person, place, "", {}), 409
    if missing:
        return _video_page(person, place, response, ratings, missing), 400
    if not survey().store.answer(person.id, place, response, ratings):
        return redirect(url_for(".start"), 303)  # submitted or withdrawn in another tab meanwhile
    done = replace(session.progress(person), answered={*person.answers, place})
    return _to(after_video(place, done))


@pages.get("/review")
def review() -> Reply:
    """Show all answers, to be changed or submitted."""
    person = _allowed(Step(Page.REVIEW))
    given = [(place, _words(said.response)) for place, said in sorted(person.answers.items())]
    return render_template("review.html", given=given, back=_back(Step(Page.REVIEW), person))


@pages.post("/submit")
def submit() -> Reply:
    """End the survey of a participant who has answered all; a second time nothing changes."""
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


def _enrol() -> Participant:
    kit, store, digest = survey().kit, survey().store, codes.digest(g.code)
    labels = tuple(answer.label for answer in kit.manifest.choices.labels)
    choices = {row: kit.choices.get(row, labels) for row in kit.orders}
    return store.enrol(digest, kit.orders, choices, kit.manifest.consent.version, survey().release)


def _allowed(step: Step) -> Participant:
    """Return the participant, who may see this page; send who may not to where they can go on."""
    person = session.participant()
    if person is None and request.method == "POST":
        abort(403)
    if person is None:
        abort(redirect(url_for("doors.resume"), 303))
    if not is_open(step, session.progress(person)):
        abort(_to_current(person))
    return person


def _to_current(person: Participant) -> Response:
    return _to(current(session.progress(person)))


def _to(step: Step) -> Response:
    return redirect(_address(step), 303)


def _back(step: Step, person: Participant) -> str:
    """Return the address of the page before, "" where there is none."""
    former = before(step, session.progress(person))
    return _address(former) if former else ""


def _address(step: Step) -> str:
    if step.page is Page.VIDEO:
        return url_for("pages.video", place=step.place)
    return url_for(f"pages.{step.page.name.lower()}")


def _about_page(said: Mapping[str, str], missing: Collection[str] = ()) -> str:
    return render_template("about.html", said=said, missing=missing, most=MOST_MARKS)


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
        choices=[(label, _words(label)) for label in person.choices],
        response=response,
        ratings=ratings,
        missing=missing,
        opened=place in person.opened,
        back=_back(Step(Page.VIDEO, place), person),
    )


def _words(label: str) -> str:
    """Return what participants read for a label."""
    return next(answer.text for answer in survey().manifest.choices.labels if answer.label == label)
