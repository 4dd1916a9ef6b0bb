"""The ways in and out beside the survey's own: with a code, for another person, and by withdrawing."""

from flask import Blueprint, g, redirect, render_template, request, url_for
from werkzeug.wrappers import Response

from emovid.survey import codes, session
from emovid.survey.session import survey

doors = Blueprint("doors", __name__)
Reply = Response | str | tuple[str, int]


@doors.get("/resume")
def resume() -> Reply:
    """Ask for a code. An address that ends in # and the code fills it in; no server ever sees that part."""
    return _ask()


@doors.post("/resume")
def enter() -> Reply:
    """Go on as the participant with the code that was given."""
    code = codes.normal(request.form.get("code", ""))
    if not code or survey().store.find(codes.digest(code)) is None:
        return _refuse(code)
    session.take(code)
    return redirect(url_for("pages.start"), 303)


@doors.get("/withdraw")
def ask_to_withdraw() -> Reply:
    """Ask for the code whose answers are to be deleted, filled in where the browser has one."""
    return render_template(
        "withdraw.html", given=codes.readable(g.code) if session.participant() else "", unknown=False
    )


@doors.post("/withdraw")
def withdraw() -> Reply:
    """Delete all of a participant; a second time it is done already."""
    given = request.form.get("code", "")
    code = codes.normal(given)
    if not code or not survey().store.withdraw(codes.digest(code)):
        return render_template("withdraw.html", given=given, unknown=True), 404
    if code == g.code:
        session.take(codes.fresh_code())
    return render_template("message.html", text=survey().manifest.texts.withdrawn)


@doors.get("/new")
def ask_for_another() -> Reply:
    """Offer to begin anew, where several participants share a computer."""
    return render_template("new.html")


@doors.post("/new")
def another() -> Reply:
    """Forget the participant in this browser; what was recorded stays."""
    session.take(codes.fresh_code())
    return redirect(url_for("pages.start"), 303)


def _ask(given: str = "", *, unknown: bool = False) -> str:
    return render_template("resume.html", given=given, unknown=unknown)


def _refuse(code: str) -> Reply:
    if code and survey().store.has_withdrawn(codes.digest(code)):
        return render_template("message.html", text=survey().manifest.texts.withdrawn), 410
    return _ask(request.form.get("code", ""), unknown=True), 404
