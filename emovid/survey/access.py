"""Pages beside the survey's sequence: continue with a code, start for another person, withdraw."""

from flask import Blueprint, g, redirect, render_template, request, url_for
from werkzeug.wrappers import Response

from emovid.survey import codes, session
from emovid.survey.export import progress_of
from emovid.survey.session import survey
from emovid.survey.store import Withdrawal

access = Blueprint("access", __name__)
Reply = Response | str | tuple[str, int]


@access.get("/resume")
def resume() -> Reply:
    """Ask for a code; the script fills in one that follows # in the address, which no server ever receives."""
    return render_template("resume.html", given="", unknown=False)


@access.post("/resume")
def enter() -> Reply:
    """Continue as the participant with the given code."""
    given = request.form.get("code", "")
    code = codes.normalized(given)
    store = survey().store
    if code and store.find(codes.digest(code)) is not None:
        session.use_code(code)
        return redirect(url_for("pages.start"), 303)
    if code and store.has_withdrawn(codes.digest(code)):
        return render_template("message.html", text=session.manifest().texts.withdrawn), 410
    return render_template("resume.html", given=given, unknown=True), 404


@access.get("/withdraw")
def ask_to_withdraw() -> Reply:
    """Ask for the code whose answers are to be deleted, filled in where the browser has one."""
    given = codes.readable(g.code) if session.participant() else ""
    return render_template("withdraw.html", given=given, unknown=False)


@access.post("/withdraw")
def withdraw() -> Reply:
    """Delete all records of a participant; a repetition changes nothing."""
    given = request.form.get("code", "")
    code = codes.normalized(given)
    outcome = survey().store.withdraw(codes.digest(code), codes.recruit_digest(code)) if code else Withdrawal.UNKNOWN
    if outcome is Withdrawal.UNKNOWN:
        return render_template("withdraw.html", given=given, unknown=True), 404
    if code == g.code:
        session.use_code(codes.fresh_code())
    texts = session.manifest().texts
    return render_template("message.html", text=texts.withdrawn if outcome is Withdrawal.DELETED else texts.erasing)


@access.get("/new")
def ask_for_another() -> Reply:
    """Offer to start for another person, where several participants share a computer."""
    return render_template("new.html")


@access.post("/new")
def start_for_another() -> Reply:
    """Remove the cookie of the participant from this browser; the records remain."""
    session.use_code(codes.fresh_code())
    return redirect(url_for("pages.start"), 303)


@access.get("/status")
def ask_for_status() -> Reply:
    """Ask researchers for the token of this page; the script fills in one that follows # in the address."""
    return render_template("status.html", progress=None, unknown=False)


@access.post("/status")
def status() -> Reply:
    """Show researchers the numbers of participants; no answers."""
    if not codes.is_status_token(request.form.get("code", ""), survey().store.secret):
        return render_template("status.html", progress=None, unknown=True), 403
    kit = survey().kit
    progress = progress_of(survey().store, list(kit.orders), kit.manifest.codes, survey().release)
    return render_template("status.html", progress=progress, unknown=False)
