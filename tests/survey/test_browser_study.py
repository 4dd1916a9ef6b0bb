"""A whole study, rehearsed: participants in Chromium and Firefox, and what they clicked against what is analyzed."""

import json
import os
from collections.abc import Iterator

import numpy as np
import pandas as pd
import pytest

from emovid.cli.main import main
from tests.helpers.firefox import firefox, path_of_firefox
from tests.helpers.participant import FirefoxParticipant, Participant
from tests.helpers.served import Server, serving
from tests.helpers.small_survey import LABELS, STUDY, small_kit

# Participants in Chromium and in Firefox; `make rehearsal` has six in each. Orders of six are balanced.
CHROMIUM, FIREFOX = map(int, os.environ.get("EMOVID_REHEARSAL", "5 1").split())
if path_of_firefox() is None:
    CHROMIUM, FIREFOX = CHROMIUM + FIREFOX, 0
PEOPLE = CHROMIUM + FIREFOX
ARABIC = """\
translations:
  ar:
    title: روبوتات صغيرة
    question: ما العاطفة التي وصفت حركة الروبوتات؟
    labels: {happiness: سعادة, surprise: مفاجأة, anger: غضب, fear: خوف, disgust: اشمئزاز, sadness: حزن}
    consent: يمكنك التوقف في أي وقت.
    instructions: شاهد كل فيديو حتى نهايته.
    thanks: شكرا.
    questions:
      gender: {question: ما جنسك؟, choices: [امرأة, رجل, جنس آخر]}
      country: {question: أين تعيش؟}
consent:"""
AGAIN = {2: 0, 3: 1, 5: 2}  # at these videos, each fourth participant reloads, loses the tab, watches again


@pytest.fixture(scope="module")
def kit(tmp_path_factory):
    text = STUDY.replace("duration: 1}", "duration: 2}").replace("consent:", ARABIC, 1)
    return small_kit(tmp_path_factory.mktemp("rehearsal"), text, PEOPLE)


@pytest.fixture(scope="module")
def people(browser, kit):
    """Let those in Chromium take part at once, and those in Firefox one after the other at a shared computer."""
    with serving(kit) as server:
        present = [Participant(browser, server.address, number) for number in range(CHROMIUM)]
        for person in present:
            person.begin()
        for place in range(1, 7):
            see(place, present, server)
        for person in present[::3]:
            person.go_back_to(2, "Change Video 2 of 6")
            person.choose()
            person.page.wait_for_url("**/review")
        for person in present:
            person.submit()
            person.leave()
        others = list(in_firefox(server.address))
        assert server.stop() in (0, 143)
    return present + others


def see(place: int, present: list[Participant], server: Server) -> None:
    """Let all watch and answer one video; some do more."""
    more = AGAIN.get(place)
    for person in present:
        person.play()
    for person in present[more::4] if more in (0, 1) else ():
        (person.crash if more else person.reload)()
    if place == 4:
        server.kill()
        server.start()
    for person in present:
        person.watched()
    for person in present[more::4] if more == 2 else ():
        person.watch_again()
    for person in present:
        person.choose()
    for person in present[3::4] if place == 4 else ():
        person.go_back_to(place, "Back")
        person.choose()


def in_firefox(address: str) -> Iterator[FirefoxParticipant]:
    """Yield participants who have taken part: the first in Arabic, in a window of a phone's width."""
    if not FIREFOX:
        return
    with firefox() as window:
        for number in range(FIREFOX):
            window.resize(1200 if number else 420, 900)
            person = FirefoxParticipant(window, number)
            person.take_part(address, "en" if number else "ar", country="می\u200cخواهم")
            yield person


@pytest.fixture(scope="module")
def table(people, kit) -> pd.DataFrame:
    target = kit.parent / "responses.csv"
    assert main(["study", "responses", str(kit), "-o", str(target)]) == 0
    return pd.read_csv(target)


def test_export_contains_exactly_the_clicks(people, table) -> None:
    recorded = {
        tuple(sorted(zip(rows["video"], rows["response"], rows["first_response"], rows["gender"], strict=True)))
        for _, rows in table.groupby("participant")
    }
    clicked = {
        tuple(sorted((code, answer, person.first[code], person.gender) for code, answer in person.last.items()))
        for person in people
    }
    assert recorded == clicked
    assert len(table) == 6 * PEOPLE
    assert set(table["status"]) == {"finished"}


def test_analysis_counts_the_clicked_answers(people, table, kit) -> None:
    folder = kit.parent
    key = pd.read_csv(kit / "private" / "key.csv").set_index("video_code")["true_emotion"]
    answers, secret = str(folder / "responses.csv"), str(kit / "private" / "key.csv")
    assert main(["study", "analyze", answers, "--key", secret, "-o", str(folder / "results"), "--quiet"]) == 0
    results = json.loads((folder / "results" / "results.json").read_text())
    assert results["n_participants"] == PEOPLE
    order = results["emotions"]
    expected = np.zeros((6, 6), dtype=int)
    for person in people:
        for code, answer in person.last.items():
            expected[order.index(answer), order.index(key[code])] += 1
    assert results["counts"] == expected.tolist()


def test_events_match_the_actions_of_participants(people, table) -> None:
    assert (table["watched_share"] >= 0.98).all()
    assert (table["play_ms"] >= 1900).all()
    assert (table["plays"] >= 1).all()
    more = sum(number % 4 < 3 for number in range(CHROMIUM))  # who reloaded, lost the tab or watched again
    assert (table.groupby("participant")["plays"].sum() > 6).sum() >= more
    assert table["changes"].sum() == sum(
        person.first[code] != last for person in people for code, last in person.last.items()
    )
    assert set(table["device"]) == {"phone", "desktop"}
    assert set(table["width"] > 200) == {True}
    assert set(table["response"]) <= set(LABELS)


def test_each_order_of_the_kit_is_used_once(people, table, kit) -> None:
    orders = pd.read_csv(kit / "orders.csv")
    planned = {tuple(rows.sort_values("position")["video_code"]) for _, rows in orders.groupby("participant")}
    shown = [tuple(rows.sort_values("position")["video"]) for _, rows in table.groupby("participant")]
    assert len(shown) == PEOPLE
    assert set(shown) <= planned
    assert set(table["order_row"]) == set(orders["participant"])


@pytest.mark.skipif(not FIREFOX, reason="no Firefox: its pages were NOT TRIED in it")
def test_languages_and_their_letters_are_in_the_export(people, table) -> None:
    arabic = table[table["language"] == "ar"]
    assert len(arabic) == 6
    assert set(arabic["country"]) == {"می\u200cخواهم"}
    assert set(table["language"]) == {"ar", "en"}
