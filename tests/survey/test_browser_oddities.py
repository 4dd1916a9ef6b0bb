"""Pages in odd situations: names of their own parts, blocked scripts, a locked database, hidden tabs, a kiosk."""

import sqlite3

import pytest

from tests.helpers.participant import Participant
from tests.helpers.served import serving
from tests.helpers.small_survey import STUDY, small_kit

NAMES = """\
  - {name: action, question: "Do you like action films?", choices: ["yes", "no"], required: false}
  - {name: state, question: "Which state do you live in?", required: false}
  - {name: player, question: "Do you play an instrument?", required: false}
consent:"""


@pytest.fixture(scope="module")
def kit(tmp_path_factory):
    return small_kit(tmp_path_factory.mktemp("odd"), STUDY.replace("consent:", NAMES, 1))


@pytest.fixture
def server(kit):
    with serving(kit) as running:
        yield running


@pytest.fixture
def person(browser, server):
    present = Participant(browser, server.address, 1)
    yield present
    present.leave()


def test_questions_named_like_page_elements_are_sent_and_connection_loss_is_shown(person, server) -> None:
    page = person.page
    page.get_by_role("button", name="I agree").click()
    page.wait_for_url("**/about")
    page.get_by_label("Woman").check()
    page.get_by_label("yes").check()
    page.get_by_label("Which state do you live in?").fill("Ohio")
    server.kill()
    page.get_by_role("button", name="Continue").click()
    page.get_by_text("No connection to the survey. Trying again.").wait_for()
    server.start()
    page.wait_for_url("**/instructions")
    page.get_by_role("link", name="Back").click()
    assert page.get_by_label("Which state do you live in?").input_value() == "Ohio"


def test_invalid_code_in_the_url_asks_for_the_code(person, server) -> None:
    person.page.goto(f"{server.address}/resume#100%")
    assert person.page.get_by_label("Your code").input_value() == "100%"
    assert person.page.url == f"{server.address}/resume"


def test_delayed_play_report_keeps_its_identity_after_the_next_play_begins(person) -> None:
    told = []

    def answer(route) -> None:
        told.append(route.request.post_data_json)
        if len(told) == 1:
            route.fulfill(json={"open": False, "wait": 0.5})
        else:
            route.continue_()

    person.page.route("**/watched", answer)
    person.begin()
    person.play()
    person.page.get_by_text("One moment.").wait_for()
    person.play()  # again, while the first is still being reported
    person.watched()
    assert told[1] == told[0]


def test_back_button_shows_the_answers_that_the_server_has(person) -> None:
    page = person.page
    person.begin()
    person.play()
    person.watched()
    person.choose()
    page.wait_for_url("**/video/2")
    page.go_back()
    page.wait_for_url("**/video/1")
    chosen = page.locator("input[name=response]:checked")
    assert chosen.get_attribute("value") == person.last[person.code]
    person.choose()  # a change, sent from there
    page.wait_for_url("**/video/2")
    assert page.go_back().status == 200
    assert chosen.get_attribute("value") == person.last[person.code]


@pytest.mark.parametrize("script", ["survey.js", "player.js"])
def test_without_one_of_its_scripts_a_page_with_a_video_says_that_it_needs_them(person, script) -> None:
    person.begin()
    person.page.route(f"**/static/{script}", lambda route: route.abort())
    person.page.reload()
    person.page.get_by_text("This page needs JavaScript to show the video.").locator("visible=true").wait_for()
    assert person.page.locator("#play").is_disabled()


def test_a_hidden_tab_pauses_the_video_and_its_share_is_reported(person) -> None:
    person.begin()
    person.page.locator("#play").click()
    hide = """() => { Object.defineProperty(document, "hidden", { get: () => true, configurable: true });
                      document.dispatchEvent(new Event("visibilitychange")); }"""
    with person.page.expect_request("**/watched") as reported:
        person.page.evaluate(hide)
    assert reported.value.post_data_json["share"] < 0.98
    assert person.page.evaluate("document.getElementById('gate').disabled")
    assert person.page.locator("#player video").evaluate("video => video.paused")
    person.page.evaluate("() => { delete document.hidden; }")
    person.play()
    person.watched()


def test_a_locked_database_is_waited_for(person, kit) -> None:
    page = person.page
    page.get_by_role("button", name="I agree").click()
    page.get_by_label("Woman").check()
    other = sqlite3.connect(kit / "answers" / "answers.sqlite", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    page.get_by_role("button", name="Continue").click()
    page.get_by_text("The survey is busy. Trying again.").wait_for()
    other.execute("ROLLBACK")
    other.close()
    page.wait_for_url("**/instructions")


def test_answers_that_are_too_long_stay_on_the_page(person) -> None:
    page = person.page
    page.get_by_role("button", name="I agree").click()
    page.get_by_label("Woman").check()
    field = page.locator("#about-country")
    field.evaluate("field => { field.removeAttribute('maxlength'); field.value = 'x'.repeat(200000); }")
    page.get_by_role("button", name="Continue").click()
    page.get_by_text("Your answers are too long to be sent.").wait_for()
    assert len(field.input_value()) == 200_000
    field.fill("Ohio")
    page.get_by_role("button", name="Continue").click()
    page.wait_for_url("**/instructions")


def test_a_kiosk_forgets_whoever_leaves_in_the_middle(browser, kit) -> None:
    with serving(kit, "--kiosk") as server:
        person = Participant(browser, server.address, 1)
        page = person.page
        page.clock.install()
        page.get_by_role("button", name="I agree").click()
        page.wait_for_url("**/about")
        page.locator("#about-country").fill("Ohio")
        page.clock.fast_forward(290_000)
        page.locator("#about-country").press("a")  # still there
        page.clock.fast_forward(290_000)
        assert page.locator("#about-country").input_value() == "Ohioa"
        page.clock.fast_forward(20_000)
        page.get_by_role("button", name="I agree").wait_for()
        assert page.url == f"{server.address}/"
        person.leave()


def test_each_step_loads_the_next_page_once(person) -> None:
    loaded = []
    person.page.on("request", lambda request: loaded.append((request.method, request.url)))
    person.begin()
    names = [url.rpartition("/")[2] for method, url in loaded if method == "GET" and url.startswith("http")]
    assert [name for name in names if "." not in name] == ["about", "instructions", "1"]  # no scripts and videos
