"""The pages of the survey in sequence, from the consent to the thanks."""

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import replace

from flask import Blueprint, abort, g, redirect, render_template, request, url_for
from werkzeug.wrappers import Response

from emovid.kit.manifest import PublicCheck
from emovid.kit.study import Question
from emovid.survey import codes, recruitment, session
from emovid.survey.database import DatabaseBusyError
from emovid.survey.forms import answer_of, answers_of, is_suitable, response_ms_of, typed_of
from emovid.survey.records import Participant
from emovid.survey.rules import Page, Step, after_video, before, current, is_open, with_extras
from emovid.survey.session import survey

pages = Blueprint("pages", __name__)
Reply = Response | str | tuple[str, int]


@pages.get("/")
def start() -> Reply:
    """Ask for consent, or continue where the participant left off."""
    person, given = session.participant(), recruitment.parameters_of(request.args)
    if person is not None and recruitment.is_someone_else(given):
        session.use_code(codes.fresh_code())  # a second member of a panel at the same computer
        person = None
    return _to_current(person) if person else render_template("consent.html", recruit=given)


@pages.post("/consent")
def consent() -> Reply:
    """Enroll a participant who agrees, once; tell others that nothing was recorded."""
    if survey().store.has_withdrawn(codes.digest(g.code)):  # the page is older than the withdrawal
        session.use_code(codes.fresh_code())
        abort(403)
    person, manifest = session.participant(), session.manifest()
    if request.form.get("consent") == "agree":
        if person is None and not is_suitable(manifest.requirements, request.form, request.user_agent.string):
            text = "\n\n".join(filter(None, (manifest.texts.unsuitable, manifest.requirements.text)))
            return render_template("message.html", text=text)
        person = person or _enroll()
        recruitment.record_start()  # also where a former request enrolled, and could not write this
        return _to_current(person)
    if person is None:
        given = recruitment.parameters_of(request.form)
        back = recruitment.way_back(survey().kit.server.declined, given)
        return render_template("message.html", text=manifest.consent.declined, way_back=back)
    return redirect(url_for("access.ask_to_withdraw"), 303)  # consented before, in another tab


@pages.get("/about")
def about() -> Reply:
    """Ask the questions about the participant."""
    person = _allowed(Step(Page.ABOUT))
    return _questions_page(Page.ABOUT, person, person.about or {})


@pages.post("/about")
def tell() -> Reply:
    """Record the answers about the participant."""
    person = _allowed(Step(Page.ABOUT))
    answers, wrong = answers_of(survey().manifest.demographics, request.form)
    if wrong:
        return _questions_page(Page.ABOUT, person, answers | typed_of(wrong, request.form), wrong), 400
    survey().store.tell(person.id, answers)
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
    """Show a video and ask its question."""
    person = _allowed(Step(Page.VIDEO, place))
    with suppress(DatabaseBusyError):  # the report of the first playback records it, too
        survey().store.show(person.id, place)
    given = person.answers.get(place)
    return _video_page(person, place, given.response if given else "", given.ratings if given else {})


@pages.post("/video/<int:place>")
def answer(place: int) -> Reply:
    """Record an answer; it is on the disk before the reply is sent."""
    person = _allowed(Step(Page.VIDEO, place))
    check = _check_at(person, place)
    choices, ratings = (check.choices, ()) if check else (person.choices, survey().manifest.ratings)
    response, rated, missing = answer_of(choices, ratings, request.form)
    if place not in person.opened:
        return _video_page(person, place, "", {}), 409
    if missing:
        return _video_page(person, place, response, rated, missing), 400
    if not survey().store.answer(person.id, place, response, rated, response_ms_of(request.form)):
        return redirect(url_for(".start"), 303)  # submitted or withdrawn in another tab meanwhile
    done = replace(session.progress(person), answered={*person.answers, place})
    return _to(after_video(place, done))


@pages.get("/after")
def after() -> Reply:
    """Ask the questions after the videos."""
    person = _allowed(Step(Page.AFTER))
    return _questions_page(Page.AFTER, person, person.after or {})


@pages.post("/after")
def tell_after() -> Reply:
    """Record the answers to the questions after the videos."""
    person = _allowed(Step(Page.AFTER))
    answers, wrong = answers_of(survey().manifest.questions_after, request.form)
    if wrong:
        return _questions_page(Page.AFTER, person, answers | typed_of(wrong, request.form), wrong), 400
    survey().store.tell_after(person.id, answers)
    return _to(Step(Page.REVIEW))


@pages.get("/review")
def review() -> Reply:
    """Show all answers, to be changed or submitted."""
    person = _allowed(Step(Page.REVIEW))
    answers = [
        (place, _heading(person, place), _text_of(person, place, answer.response))
        for place, answer in sorted(person.answers.items())
    ]
    return render_template("review.html", answers=answers, back=_back(Step(Page.REVIEW), person))


@pages.post("/submit")
def submit() -> Reply:
    """Submit the answers of a participant who has answered all questions; a repetition changes nothing."""
    person = session.participant()
    if person is None:
        abort(403)
    if is_open(Step(Page.REVIEW), session.progress(person)):
        survey().store.submit(person.id)
        person = session.participant() or person
    if person.submitted is not None:
        recruitment.record_end(person)  # also where a former request submitted, and could not write this
    if not survey().kiosk or current(session.progress(person)).page < Page.REVIEW:
        return redirect(url_for(".start"), 303)
    session.use_code(codes.fresh_code())  # the computer belongs to the next person from now on
    return redirect(url_for(".thanks"), 303)


@pages.get("/thanks")
def thanks() -> Reply:
    """Thank the participant; give the completion code, and the way back to the recruitment service."""
    if survey().kiosk and session.participant() is None:
        return render_template("thanks.html", way_back=None)
    person = _allowed(Step(Page.THANKS))
    return render_template("thanks.html", way_back=recruitment.way_back_of(person))


def _enroll() -> Participant:
    kit, store, digest = survey().kit, survey().store, codes.digest(g.code)
    labels = tuple(answer.label for answer in kit.manifest.choices.labels)
    choices = {row: kit.choices.get(row, labels) for row in kit.orders}
    practice = kit.manifest.practice.code if kit.manifest.practice else None
    checks = [(check.video.code, check.after) for check in kit.manifest.checks]
    orders = {row: with_extras(order, practice, checks) for row, order in kit.orders.items()}
    versions = kit.manifest.consent.version, survey().release, kit.manifest.version
    return store.enroll(digest, orders, choices, *versions, session.manifest().language)


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


def _questions_page(page: Page, person: Participant, answers: Mapping[str, str], wrong: Collection[str] = ()) -> str:
    """Return the page of the questions about the participant, or after the videos."""
    manifest, shown = survey().manifest, session.manifest()
    first = page is Page.ABOUT
    questions: tuple[Question, ...] = manifest.demographics if first else manifest.questions_after
    texts = shown.demographics if first else shown.questions_after
    return render_template(
        "questions.html",
        heading=shown.texts.about_you if first else shown.texts.more_questions,
        action=url_for("pages.tell" if first else "pages.tell_after"),
        questions=list(zip(questions, texts, strict=True)),
        answers=answers,
        wrong=wrong,
        ahead=person.videos if first else (),
        back=_back(Step(page), person),
    )


def _video_page(
    person: Participant, place: int, response: str, ratings: Mapping[str, int], missing: Collection[str] = ()
) -> str:
    manifest, check = session.manifest(), _check_at(person, place)
    labels = _choices_of(place, person)
    return render_template(
        "video.html",
        heading=_heading(person, place),
        place=place,
        count=len(person.videos),
        practice=_is_practice(person, place),
        video=manifest.all_videos[person.videos[place - 1]],
        question=_shown(check).question if check else manifest.question,
        choices=[(label, _text_of(person, place, label)) for label in labels],
        rated=() if check else manifest.ratings,
        response=response,
        ratings=ratings,
        missing=missing,
        opened=place in person.opened,
        back=_back(Step(Page.VIDEO, place), person),
        ahead=person.videos[place:],
    )


def _is_practice(person: Participant, place: int) -> bool:
    practice = survey().manifest.practice
    return practice is not None and person.videos[place - 1] == practice.code


def _check_at(person: Participant, place: int) -> PublicCheck | None:
    """Return the attention check at a place, if there is one."""
    return next((check for check in survey().manifest.checks if check.video.code == person.videos[place - 1]), None)


def _choices_of(place: int, person: Participant) -> tuple[str, ...]:
    check = _check_at(person, place)
    return check.choices if check else person.choices


def _heading(person: Participant, place: int) -> str:
    """Return the heading of a video's page; the practice video is not counted."""
    texts = session.manifest().texts
    if _is_practice(person, place):
        return texts.practice
    first = int(_is_practice(person, 1))
    return texts.place.replace("{place}", str(place - first)).replace("{count}", str(len(person.videos) - first))


def _text_of(person: Participant, place: int, label: str) -> str:
    """Return the text that participants read for an answer to a video."""
    check = _check_at(person, place)
    if check is None:
        return next(answer.text for answer in session.manifest().choices.labels if answer.label == label)
    return _shown(check).choices[check.choices.index(label)]


def _shown(check: PublicCheck) -> PublicCheck:
    """Return an attention check in the participant's language."""
    return next(item for item in session.manifest().checks if item.name == check.name)
