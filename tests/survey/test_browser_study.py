"""A whole study, rehearsed: twelve participants in a real browser, and what they clicked against what is analyzed."""

import json

import numpy as np
import pandas as pd
import pytest

from emovid.cli.main import main
from tests.helpers.participant import Participant
from tests.helpers.served import Server, serving
from tests.helpers.small_survey import LABELS, STUDY, small_kit

PEOPLE = 12


@pytest.fixture(scope="module")
def kit(tmp_path_factory):
    text = STUDY.replace("duration: 1}", "duration: 2}")
    return small_kit(tmp_path_factory.mktemp("rehearsal"), text, PEOPLE)


@pytest.fixture(scope="module")
def people(browser, kit):
    """Run all participants in parallel: some go back, replay, reload or lose their tab; the server is killed."""
    with serving(kit) as server:
        present = [Participant(browser, server.address, number) for number in range(PEOPLE)]
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
        assert server.stop() in (0, 143)
    return present


def see(place: int, present: list[Participant], server: Server) -> None:
    """Let all participants watch and answer one video; some also go back or reload."""
    reload, crash, again, back = ({2: 0, 3: 1, 5: 2, 4: 3}.get(place) == k for k in range(4))
    for person in present:
        person.play()
    for person in present[0::4] if reload else ():
        person.reload()
    for person in present[1::4] if crash else ():
        person.crash()
    if place == 4:
        server.kill()
        server.start()
    for person in present:
        person.watched()
    for person in present[2::4] if again else ():
        person.watch_again()
    for person in present:
        person.choose()
    for person in present[3::4] if back else ():
        person.go_back_to(place, "Back")
        person.choose()


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
    arguments = [
        str(folder / "responses.csv"),
        "--key",
        str(kit / "private" / "key.csv"),
        "-o",
        str(folder / "results"),
    ]
    assert main(["study", "analyze", *arguments, "--quiet"]) == 0
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
    assert (table["plays"] >= 1).all()
    assert (
        table.groupby("participant")["plays"].sum() > 6
    ).sum() >= 9  # those who reloaded, lost the tab or watched again
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
