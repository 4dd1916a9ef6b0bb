"""The player in Chromium and Firefox: complete plays, failed videos, lost connections, long answers."""

import csv
import io

import pytest

from emovid.survey.export import responses_csv
from emovid.survey.store import open_survey
from tests.helpers.participant import Participant
from tests.helpers.served import serving
from tests.helpers.small_survey import STUDY, small_kit

# A reading of the player clock that is late by 0.4 s once, as in Firefox on a busy machine.
LATE = """(() => {
  const of = Object.getOwnPropertyDescriptor(HTMLMediaElement.prototype, "currentTime");
  let late = false, seen = 0;
  Object.defineProperty(HTMLMediaElement.prototype, "currentTime", {configurable: true, set: of.set,
    get() { const now = of.get.call(this); return late ? Math.max(0, now - 0.4) : now; }});
  window.addEventListener("timeupdate", (event) => {
    if (event.target.seeking || event.target.ended) return;
    seen += 1;
    if (seen === 4) { late = true; setTimeout(() => { late = false; }); }
  }, true);
})()"""
FASTER = "video => setInterval(() => { video.playbackRate = 4; video.currentTime += 0.3; }, 50)"
ITEMS = "".join(f"  - {{name: q{i}, question: Q{i}, required: false}}\n" for i in range(15))


@pytest.fixture(scope="module")
def kit(tmp_path_factory):
    text = STUDY.replace("duration: 1}", "duration: 3}").replace("consent:", f"{ITEMS}language: ar\nconsent:", 1)
    return small_kit(tmp_path_factory.mktemp("player"), text)


@pytest.fixture(scope="module")
def server(kit):
    with serving(kit) as running:
        yield running


@pytest.fixture
def page(browser, server):
    context = browser.new_context()
    opened = context.new_page()
    yield opened
    context.close()


def begin(page, server) -> None:
    page.goto(f"{server.address}/")
    page.locator("button[value=agree]").click()
    page.wait_for_url("**/about")
    page.get_by_label("Woman", exact=True).check()
    page.locator("main button[type=submit]").click()
    page.wait_for_url("**/instructions")
    page.locator("main button[type=submit]").click()
    page.wait_for_url("**/video/1")


def test_delayed_clock_reading_does_not_reduce_the_watched_time(page, server) -> None:
    page.add_init_script(LATE)
    begin(page, server)
    page.locator("#play").click()
    page.locator("#gate:enabled").wait_for()


def test_jumps_and_faster_playback_do_not_open_the_question(page, server) -> None:
    begin(page, server)
    page.locator("#player video").evaluate(FASTER)
    with page.expect_response("**/watched") as reported:
        page.locator("#play").click()
    assert reported.value.json() == {"open": False, "wait": 0}
    assert page.evaluate("document.getElementById('gate').disabled")


def test_failed_video_is_reported_and_plays_after_reconnecting(page, server) -> None:
    begin(page, server)
    page.context.route("**/media/**", lambda route: route.abort())
    page.reload()
    page.get_by_text("تعذّر تحميل الفيديو").wait_for()
    page.locator("#play").click()
    page.context.unroute("**/media/**")
    page.locator("#play").click()
    page.locator("#gate:enabled").wait_for()


def test_long_japanese_answers_are_sent_and_unsent_text_gives_a_warning(page, server, kit) -> None:
    page.goto(f"{server.address}/")
    page.locator("button[value=agree]").click()
    page.wait_for_url("**/about")
    for i in range(15):
        page.locator(f"#about-q{i}").fill("漢" * 500)
    asked = []
    page.on("dialog", lambda dialog: (asked.append(dialog.type), dialog.dismiss()))
    page.close(run_before_unload=True)
    page.get_by_label("Woman", exact=True).check()
    assert asked == ["beforeunload"]
    page.locator("main button[type=submit]").click()
    page.wait_for_url("**/instructions")
    opened, store = open_survey(kit, pilot=False)
    rows = csv.DictReader(io.StringIO(responses_csv(store, opened, pilot=False, release=7200)))
    assert {row["q14"] for row in rows} == {"", "漢" * 500}
    store.close()


def test_consent_without_a_connection_is_reported_and_continues_after_reconnecting(browser, kit) -> None:
    with serving(kit) as own:
        person = Participant(browser, own.address, 1)
        own.kill()
        person.page.locator("button[value=agree]").click()
        person.page.get_by_text("لا يوجد اتصال بالاستبيان").wait_for()
        own.start()
        person.page.wait_for_url("**/about")
        person.leave()
