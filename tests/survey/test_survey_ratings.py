"""Sliders next to the choice, and pages overtaken by another tab."""

import csv

import pytest

from emovid.kit.folder import open_public
from emovid.survey.app import create_app
from emovid.survey.export import responses_csv
from emovid.survey.store import Store
from tests.helpers.participant import Participant
from tests.helpers.served import serving
from tests.helpers.small_survey import STUDY, small_kit
from tests.helpers.visitor import Clock, Visitor

RATINGS = """\
ratings:
  confidence: {question: "How sure are you?", low: not at all, high: completely, steps: 7}
  arousal: {question: "How excited is it?", low: calm, high: excited}
consent:"""


@pytest.fixture(scope="module")
def rated(tmp_path_factory):
    """Build a kit with two sliders."""
    return small_kit(tmp_path_factory.mktemp("rated"), STUDY.replace("consent:", RATINGS, 1))


@pytest.fixture
def recorded(rated, tmp_path):
    """Open its survey; return a participant who has watched the first video, a reader of the answers, and the store."""
    kit, clock = open_public(rated), Clock()
    store = Store(tmp_path / "rated.sqlite", kit.manifest.key_commitment, clock)
    someone = Visitor(create_app(kit, store), clock).begin()
    someone.watch(1)

    def rows() -> list[dict[str, str]]:
        text = responses_csv(store, kit, pilot=False, release=7200)
        return [row for row in csv.DictReader(text.splitlines()) if row["video"]]  # answers

    yield someone, rows, store
    store.close()


@pytest.mark.parametrize("value", ["", "0", "8", "-1", "4.5", "four", "0007", "٣"])
def test_unmoved_or_invalid_slider_is_requested_again(recorded, value) -> None:
    someone, rows, _ = recorded
    reply = someone.answer(1, "fear", confidence=value, arousal="101")
    assert reply.status_code == 400
    assert reply.text.count("Please answer this question.</p>") == 2  # at the slider, and the hidden one of the script
    assert 'id="confidence-error"' in reply.text
    assert 'name="arousal" value="101"' in reply.text  # given answers are kept
    assert rows() == []


def test_slider_values_are_recorded_and_movement_counts_as_change(recorded) -> None:
    someone, rows, _ = recorded
    assert someone.answer(1, "fear", confidence="7", arousal="1").location == "/video/2"
    assert 'name="confidence" value="7"' in someone.get("/video/1").text
    someone.answer(1, "fear", confidence="3", arousal="1")
    (row,) = rows()
    assert (row["confidence"], row["arousal"], row["valence"], row["changes"]) == ("3", "1", "", "1")


@pytest.mark.parametrize("what", ["submitted", "withdrawn"])
def test_answer_overtaken_by_another_tab_is_not_recorded(recorded, monkeypatch, what) -> None:
    someone, rows, store = recorded
    counts = store.answer

    def overtaken(person: int, *answer: object) -> bool:
        with store._data.writing() as sql:
            if what == "submitted":
                sql.execute("UPDATE participants SET submitted = 1 WHERE id = ?", (person,))
            else:
                sql.execute("DELETE FROM participants WHERE id = ?", (person,))
        return counts(person, *answer)

    monkeypatch.setattr(store, "answer", overtaken)
    assert someone.answer(1, "fear", confidence="7", arousal="1").location == "/"
    assert rows() == []


def test_withdrawn_participants_cannot_submit_or_report(recorded) -> None:
    someone, rows, store = recorded
    token, cookie = someone.token, someone.cookie
    someone.post("/withdraw", code=cookie)
    someone.client.set_cookie("emovid", cookie)
    for path in ("/submit", "/video/1/play", "/video/1/watched"):
        reply = someone.client.post(path, json={"play": "0" * 16}, headers={"X-Form-Token": token})
        assert reply.status_code == 403
        assert "not recorded" in reply.text
    assert rows() == store.participants() == []


def test_browser_requires_moving_every_slider(browser, rated) -> None:
    with serving(rated) as server:
        person = Participant(browser, server.address, 1)
        person.begin()
        person.play()
        person.watched()
        page = person.page
        page.get_by_role("radio").first.check()
        page.get_by_label("How sure are you?").fill("2")
        page.locator("#submit").click()
        assert page.locator("#missing").is_visible()
        assert page.evaluate("document.activeElement.id") == "arousal"  # the remaining one
        page.keyboard.press("Home")
        assert page.locator("#missing").is_hidden()
        page.locator("#submit").click()
        page.wait_for_url("**/video/2")
        person.go_back_to(1, "Back")
        values = [page.get_by_label(text).input_value() for text in ("How sure are you?", "How excited is it?")]
        assert values == ["2", "1"]
        person.leave()
