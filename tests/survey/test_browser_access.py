"""Accessibility of the survey: axe-core on every page, keyboard operation, names for screen readers."""

import os
import re
from dataclasses import replace
from urllib.parse import urlsplit

import pytest

from emovid.kit.folder import Kit, open_public
from emovid.kit.study import Requirements
from emovid.kit.texts import TRANSLATED
from emovid.survey import codes
from emovid.survey.app import create_app
from emovid.survey.store import Store
from tests.helpers.participant import DESKTOP, PHONE
from tests.helpers.served import serving
from tests.helpers.small_survey import LABELS, PARTS, STUDY, small_kit
from tests.helpers.visitor import Clock, Visitor

playwright_axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe-core: NOT TRIED")

MORE = """\
ratings: {confidence: {question: "How sure are you?", low: not at all, high: completely, steps: 7}}
recruitment: {service: prolific, automatic: 500}
translations:
"""
TRANSLATION = """\
  LANGUAGE:
    title: Small robots
    question: "Which emotion?"
    labels: {happiness: Happiness, surprise: Surprise, anger: Anger, fear: Fear, disgust: Disgust, sadness: Sadness}
    ratings: {confidence: {question: "How sure are you?", low: not at all, high: completely}}
    consent: You can stop.
    instructions: Watch.
    thanks: Thank you.
    debriefing: This was about motion.
    questions:
      gender: {question: "Gender?", choices: [Woman, Man, Another gender]}
      country: {question: "Where do you live?"}
      comments: {question: "Comments?"}
      age: {question: "Age?"}
      tools: {question: "Tools?", choices: [A, B, C]}
      shape: {question: "Which shape?", choices: [Circle, Star]}
"""
# The others are tried by `make rehearsal`: each needs 10 s.
LANGUAGES = ("en", *TRANSLATED) if os.environ.get("EMOVID_REHEARSAL") else ("en", "ar", "de")


@pytest.fixture
def server(kit):
    with serving(kit) as running:
        yield running


@pytest.fixture(scope="module")
def everything(tmp_path_factory) -> Kit:
    """Build a kit with all kinds of pages in all languages."""
    text = STUDY + PARTS + MORE + "".join(TRANSLATION.replace("LANGUAGE", name) for name in TRANSLATED)
    return open_public(small_kit(tmp_path_factory.mktemp("pages"), text))


class Shown:
    """A browser that shows replies of the application, without a server.

    Attributes:
        visitor: the participant whose replies are shown.
        names: pages that were checked.
    """

    def __init__(self, page, visitor: Visitor) -> None:
        self._page, self.visitor, self.names = page, visitor, set()
        self._reply = None
        self._page.unroute_all()
        self._page.route("**/*", self._answer)

    def _answer(self, route) -> None:
        path = urlsplit(route.request.url).path
        reply = self._reply if path == "/shown" else self.visitor.get(path)
        route.fulfill(status=reply.status_code, headers=dict(reply.headers), body=reply.data)

    def check(self, name: str, reply, status: int = 200) -> None:
        """Hold a page against axe-core's rules, and against a screen that need not be scrolled sideways."""
        assert reply.status_code == status, name
        self._reply = reply
        self._page.goto("http://survey.example/shown")
        for size in (PHONE, DESKTOP):
            self._page.set_viewport_size(size["viewport"])
            assert self._page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"), name
            found = playwright_axe.Axe().run(self._page).response["violations"]
            said = [f"{name}: {fault['id']}: {fault['nodes'][0]['html']}" for fault in found]
            assert said == []
        self.names.add(name)


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_page_has_a_fault_that_axe_core_knows(browser, everything, tmp_path, language) -> None:
    clock = Clock()
    store = Store(tmp_path / "answers.sqlite", everything.manifest.key_commitment, clock)
    app = create_app(everything, store, pilot=True)
    context = browser.new_context()
    page = context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    shown = Shown(page, Visitor(app, clock))
    someone = shown.visitor
    shown.check("consent", someone.get(f"/?language={language}"))
    assert f'lang="{language}"' in someone.get(f"/?language={language}").text
    someone.post("/consent", consent="agree", language=language, PROLIFIC_PID="p1")
    shown.check("about", someone.get("/about"))
    shown.check("about, incomplete", someone.post("/about"), 400)
    someone.post("/about", gender="Woman")
    shown.check("instructions", someone.get("/instructions"))
    someone.post("/instructions")
    shown.check("practice", someone.get("/video/1"))
    for place in range(1, 9):
        someone.watch(place)
        if place in (2, 5):
            shown.check("attention check" if place == 5 else "video", someone.get(f"/video/{place}"))
        if place == 2:
            shown.check("video, incomplete", someone.answer(place, ""), 400)
        someone.answer(place, "Circle" if place == 5 else LABELS[place % 6], confidence="3")
    shown.check("after", someone.get("/after"))
    shown.check("after, incomplete", someone.post("/after", age="7"), 400)
    someone.post("/after", age="30")
    shown.check("review", someone.get("/review"))
    someone.post("/submit")
    shown.check("thanks", someone.get("/thanks"))
    for path in ("resume", "withdraw", "new"):
        shown.check(path, someone.get(f"/{path}"))
    shown.check("unknown code", someone.post("/resume", code="bbbb"), 404)
    shown.check("not found", someone.get("/nothing"), 404)
    shown.check("status", someone.post("/status", code=codes.status_token(store.secret)))
    shown.check("withdrawn", someone.post("/withdraw", code=someone.cookie))
    stranger = Visitor(app, clock)
    shown.check("out of date", stranger.client.post("/consent", data={"form-token": "0"}), 403)
    shown.check("declined", stranger.post("/consent", consent="decline", language=language))
    app.extensions["survey"] = replaced(app.extensions["survey"])
    shown.check("unsuitable", stranger.post("/consent", consent="agree", device="phone", language=language))
    assert len(shown.names) == 22
    context.close()
    store.close()
    assert errors == []


def replaced(survey):
    """Return the survey of a study that is not for phones."""
    said = survey.kit.manifest.model_copy(update={"requirements": Requirements(devices=("desktop",))})
    return replace(survey, kit=replace(survey.kit, manifest=said))


# The label of a radio button shows its focus.
OUTLINED = """() => [document.activeElement, document.activeElement.closest("label")].some(
    (element) => element && getComputedStyle(element).outlineStyle !== "none")"""


def press_until(page, selector: str, key: str = "Tab") -> None:
    """Press a key until an element has the focus, and check that the focus is visible."""
    for _ in range(30):
        page.keyboard.press(key)
        if page.evaluate("wanted => document.activeElement.matches(wanted)", selector):
            assert page.evaluate(OUTLINED), f"{selector}: its focus cannot be seen"
            return
    raise AssertionError(f"{page.url}: {selector} cannot be reached with {key}")


def test_survey_can_be_completed_by_keyboard(browser, server) -> None:
    context = browser.new_context(**DESKTOP)
    page = context.new_page()
    page.goto(f"{server.address}/")
    press_until(page, "button[value=agree]")
    page.keyboard.press("Enter")
    page.wait_for_url("**/about")
    press_until(page, "input[type=radio]")
    page.keyboard.press("Space")
    press_until(page, "button[type=submit], form button:not([type=button])")
    page.keyboard.press("Enter")
    page.wait_for_url("**/instructions")
    press_until(page, "form button")
    page.keyboard.press("Enter")
    for place in range(1, 7):
        page.wait_for_url(f"**/video/{place}")
        press_until(page, "#play")
        page.keyboard.press("Space")
        page.locator("#gate:enabled").wait_for()
        press_until(page, "input[name=response]")
        page.keyboard.press("ArrowDown")
        press_until(page, "#submit")
        page.keyboard.press("Enter")
    page.wait_for_url("**/review")
    press_until(page, "form button")
    page.keyboard.press("Enter")
    page.wait_for_url("**/thanks")
    context.close()


def test_groups_and_controls_have_accessible_names(browser, server) -> None:
    context = browser.new_context(**DESKTOP)
    page = context.new_page()
    page.goto(f"{server.address}/")
    page.get_by_role("button", name="I agree").click()
    page.get_by_label("Woman").check()
    assert 'group "What is your gender?"' in page.locator("main").aria_snapshot()
    page.get_by_role("button", name="Continue").click()
    page.wait_for_url("**/instructions")
    page.get_by_role("button", name="Continue").click()
    page.wait_for_url("**/video/1")
    told = page.locator("main").aria_snapshot()
    assert 'heading "Video 1 of 6" [level=1]' in told
    assert 'button "Play the video"' in told
    assert 'group "Which emotion best described the movement of the robots in the video?"' in told
    assert len(re.findall(r'- radio "\w+" \[disabled\]', told)) == 6
    assert "status: Watch the video to its end" in told
    page.locator("#play").click()
    page.locator("#gate:enabled").wait_for()
    told = page.locator("main").aria_snapshot()
    assert 'button "Watch again"' in told
    assert "status: You can watch it again" in told
    context.close()
