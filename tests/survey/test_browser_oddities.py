"""Unusual situations: questions named like page elements, invalid URLs, an early second play."""

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
