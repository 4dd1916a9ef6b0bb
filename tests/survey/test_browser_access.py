"""Accessibility of the survey: axe-core on every page, keyboard operation, names for screen readers."""

import re

import pytest

from tests.helpers.participant import DESKTOP, PHONE
from tests.helpers.served import serving

playwright_axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe-core: NOT TRIED")


@pytest.fixture
def server(kit):
    with serving(kit) as running:
        yield running


@pytest.fixture(params=[PHONE, DESKTOP], ids=["phone", "desktop"])
def page(request, browser):
    context = browser.new_context(**request.param)
    opened = context.new_page()
    errors = []
    opened.on("pageerror", lambda error: errors.append(str(error)))
    yield opened
    context.close()
    assert errors == []


def check(page) -> None:
    """Check a page with axe-core, and that it does not scroll horizontally."""
    found = playwright_axe.Axe().run(page).response["violations"]
    said = [f"{page.url}: {fault['id']}: {fault['help']} {fault['nodes'][0]['html']}" for fault in found]
    assert said == []
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"), page.url


def test_pages_have_no_axe_core_violations(page, server) -> None:
    page.goto(f"{server.address}/")
    check(page)
    page.get_by_role("button", name="I agree").click()
    page.wait_for_url("**/about")
    check(page)
    page.get_by_role("button", name="Continue").click()  # without an answer
    page.get_by_label("Woman").check()
    page.get_by_role("button", name="Continue").click()
    page.wait_for_url("**/instructions")
    check(page)
    page.get_by_role("button", name="Continue").click()
    for place in range(1, 7):
        page.wait_for_url(f"**/video/{place}")
        if place == 1:
            check(page)
        page.locator("#play").click()
        page.locator("#gate:enabled").wait_for()
        if place == 1:
            check(page)
        page.get_by_role("radio").first.check()
        page.locator("#submit").click()
    page.wait_for_url("**/review")
    check(page)
    page.get_by_role("button", name="Submit all answers").click()
    page.wait_for_url("**/thanks")
    check(page)
    for path in ("resume", "withdraw", "new", "nothing"):
        page.goto(f"{server.address}/{path}")
        check(page)


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
