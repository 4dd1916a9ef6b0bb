"""The table of events in docs/survey.md, row by row."""

import csv
import re

import pytest

from emovid.survey.app import create_app
from emovid.survey.codes import digest, readable
from emovid.survey.export import responses_csv
from emovid.survey.store import Store
from tests.helpers.small_survey import LABELS
from tests.helpers.visitor import Visitor

SIX = ["fear", "anger", "fear", "sadness", "disgust", "happiness"]


def rows(store, opened) -> list[dict[str, str]]:
    text = responses_csv(store, opened, pilot=False, release=7200)
    return list(csv.DictReader(text.splitlines()))


def responses(store, opened) -> list[str]:
    return [row["response"] for row in rows(store, opened)]


def test_complete_participation_exports_all_answers_and_events(visitor, store, opened) -> None:
    someone = visitor()
    assert "I agree and want to take part" in someone.get("/").text
    someone.go_through(SIX)
    page = someone.get("/thanks").text
    assert "C0MPLETE" in page
    assert 'href="https://example.org/back?study=1&amp;done=yes"' in page
    found = rows(store, opened)
    order, choices = opened.orders["P001"], opened.choices["P001"]
    assert [row["video"] for row in found] == list(order)
    assert [row["position"] for row in found] == list("123456")
    assert [row["response"] for row in found] == SIX == [row["first_response"] for row in found]
    for row in found:
        shared = {name: row[name] for name in ("participant", "order_row", "status", "mode", "gender", "country")}
        assert shared == {
            "participant": f"p-{store.site}-0001", "order_row": "P001", "status": "finished", "mode": "study",
            "gender": "Woman",
            "country": "",
        }  # fmt: skip
        assert row["choices"] == "|".join(choices)
        assert (row["plays"], row["watched_share"], row["changes"]) == ("1", "1.000", "0")
        assert (row["device"], row["width"], row["height"]) == ("phone", "343", "193")
        assert (row["frames"], row["dropped_frames"], row["consent_version"]) == ("10", "1", "1")
    assert [row["answer_seconds"] for row in found] == [f"{n}.000" for n in range(1, 7)]


def test_videos_and_choices_follow_the_assigned_row(visitor, opened) -> None:
    someone = visitor().begin()
    for place in range(1, 7):
        page = someone.get(f"/video/{place}").text
        assert f'<h1 id="heading">Video {place} of 6</h1>' in page
        assert re.findall(r"/media/(\w+)\.mp4", page) == [opened.orders["P001"][place - 1]]
        assert tuple(re.findall(r'name="response" value="(\w+)"', page)) == opened.choices["P001"]
        assert "playsinline" in page
        assert "autoplay" not in page
        if place < 6:
            assert someone.get(f"/video/{place + 1}").location == f"/video/{place}"
        assert someone.get("/review").location == f"/video/{place}"
        someone.watch(place)
        someone.answer(place, "fear")


def test_declining_stores_no_data(visitor, store) -> None:
    someone = visitor()
    reply = someone.post("/consent", consent="decline")
    assert "You are not taking part" in reply.text
    assert store.participants() == []
    assert someone.get("/about").location == "/resume"


def test_declining_after_consent_in_another_tab_offers_withdrawal(visitor, store) -> None:
    someone = visitor()
    declining_tab = someone.token
    someone.begin()
    reply = someone.client.post("/consent", data={"form-token": declining_tab, "consent": "decline"})
    assert reply.location == "/withdraw"
    assert readable(someone.cookie) in someone.get("/withdraw").text
    assert len(store.participants()) == 1  # until they confirm


def test_repeated_consent_enrolls_once(visitor, store, opened) -> None:
    someone = visitor()
    token = someone.token
    for _ in range(3):
        reply = someone.client.post("/consent", data={"form-token": token, "consent": "agree"})
        assert reply.location == "/about"
    assert len(store.participants()) == 1
    store.enroll(digest(someone.cookie), opened.orders, opened.choices, "1", 60.0)  # like two simultaneous requests
    assert len(store.participants()) == 1


def test_rows_are_assigned_in_turn(visitor, store, opened) -> None:
    for _ in range(14):
        visitor().post("/consent", consent="agree")
    assert [person.order_row for person, _ in store.participants()] == [*opened.orders, "P001", "P002"]


def test_missing_required_answer_is_requested_and_other_answers_are_kept(visitor) -> None:
    someone = visitor()
    someone.post("/consent", consent="agree")
    reply = someone.post("/about", country="Peru")
    assert reply.status_code == 400
    assert "Please answer this question." in reply.text
    assert 'value="Peru"' in reply.text
    assert someone.post("/about", gender="none of the choices").status_code == 400
    assert someone.post("/about", gender="Man", country="Peru").location == "/instructions"
    assert re.search(r'value="Man" checked', someone.get("/about").text)


def test_answers_can_be_changed_until_submission_and_the_first_is_kept(visitor, store, opened) -> None:
    someone = visitor().go_through(SIX, submit=False)
    assert someone.chosen(2) == "anger"
    assert someone.answer(2, "disgust").location == "/review"
    assert someone.chosen(2) == "disgust"
    someone.answer(2, "surprise")
    someone.post("/submit")
    row = rows(store, opened)[1]
    assert (row["response"], row["first_response"], row["changes"]) == ("surprise", "anger", "2")


def test_watching_again_is_counted_and_keeps_the_question_open(visitor, store, opened) -> None:
    someone = visitor().begin()
    someone.watch(1)
    someone.watch(1, seconds=0.2, share=0.2)
    assert someone.answer(1, "fear").location == "/video/2"
    assert rows(store, opened)[0]["plays"] == "2"
    assert rows(store, opened)[0]["watched_share"] == "1.000"


def test_a_double_submission_changes_nothing(visitor, store, opened) -> None:
    someone = visitor().go_through(SIX)
    before = rows(store, opened)
    someone.clock.now += 10
    assert someone.post("/submit").location == "/"
    assert someone.answer(1, "surprise").location == "/thanks"
    assert someone.post("/about", gender="Man").location == "/thanks"
    assert rows(store, opened) == before


def test_repeated_answer_is_stored_once(visitor, store, opened) -> None:
    someone = visitor().begin()
    someone.watch(1)
    for _ in range(3):
        assert someone.answer(1, "fear").location == "/video/2"
    assert [(row["response"], row["changes"]) for row in rows(store, opened)] == [("fear", "0")]


def test_submission_requires_all_answers(visitor, store, opened) -> None:
    someone = visitor().go_through(SIX[:5], submit=False)
    someone.post("/submit")
    assert someone.get("/").location == "/video/6"
    assert {row["status"] for row in rows(store, opened)} == {"in progress"}


def test_two_tabs_share_a_participant_and_the_later_answer_counts(visitor, store, opened) -> None:
    someone = visitor().begin()
    first_tab = someone.get("/video/1").text
    someone.watch(1)
    someone.answer(1, "fear")
    token = re.search(r'value="([0-9a-f]{64})"', first_tab)[1]
    assert someone.client.post("/video/1", data={"form-token": token, "response": "anger"}).location == "/video/2"
    assert responses(store, opened) == ["anger"]


def test_tab_open_after_submission_is_redirected_to_the_last_page(visitor) -> None:
    someone = visitor().go_through(SIX)
    assert someone.get("/video/3").location == "/thanks"
    assert someone.get("/review").location == "/thanks"
    reply = someone.report("/video/3/play", play="0" * 16)
    assert reply.status_code == 409


def test_back_button_shows_the_stored_state(visitor) -> None:
    someone = visitor().go_through(SIX[:3], submit=False)
    for page in ("/about", "/instructions", "/video/1", "/video/2"):
        reply = someone.get(page)
        assert reply.status_code == 200
        assert reply.headers["Cache-Control"] == "no-store"
    assert someone.chosen(2) == SIX[1]


def test_browser_crash_loses_no_acknowledged_answer(visitor) -> None:
    someone = visitor().go_through(SIX[:3], submit=False)
    again = visitor()
    again.client.set_cookie("emovid", someone.cookie)
    assert again.get("/").location == "/video/4"
    assert [again.chosen(place) for place in (1, 2, 3)] == SIX[:3]


def test_server_restart_does_not_interrupt_participants(visitor, store, opened, tmp_path, clock) -> None:
    someone = visitor().go_through(SIX[:3], submit=False)
    token, cookie = someone.token, someone.cookie
    store.close()
    again = Store(tmp_path / "answers.sqlite", opened.manifest.key_commitment, clock)
    later = Visitor(create_app(opened, again), clock)
    later.client.set_cookie("emovid", cookie)
    assert later.token == token  # a form from before the restart is still valid
    assert later.get("/").location == "/video/4"
    for place, response in enumerate(SIX[3:], start=4):
        later.watch(place)
        later.answer(place, response)
    later.post("/submit")
    assert responses(again, opened) == SIX
    again.close()


def test_expired_cookie_requires_the_code_to_resume(visitor, store, opened) -> None:
    someone = visitor().go_through(SIX[:2], submit=False)
    code = re.search(r'id="own-code"[^>]*>([a-z0-9-]+)<', someone.get("/video/3").text)[1]
    elsewhere = visitor()
    assert elsewhere.get("/video/3").location == "/resume"
    assert elsewhere.post("/video/3", response="fear").status_code == 403
    assert elsewhere.post("/resume", code=f"  {code.upper()} ").location == "/"
    assert elsewhere.get("/").location == "/video/3"
    assert elsewhere.chosen(2) == SIX[1]
    assert len(store.participants()) == 1


def test_code_is_never_sent_in_a_url(visitor) -> None:
    someone = visitor().begin()
    code = readable(someone.cookie)
    for page in ("/instructions", "/video/1"):
        assert re.findall(rf'href="([^"]*){code}"', someone.get(page).text) == ["/resume#"]


@pytest.mark.parametrize("code", ["", "nonsense", "b" * 24, "' OR 1=1 --", "b" * 5000])
def test_an_unknown_code_is_reported_and_deletes_nothing(visitor, code) -> None:
    someone = visitor().begin()
    cookie = someone.cookie
    reply = someone.post("/resume", code=code)
    assert reply.status_code == 404
    assert "This code is not known" in reply.text
    assert someone.cookie == cookie
    assert someone.get("/").location == "/video/1"


def test_unknown_cookie_is_treated_as_a_new_visitor(visitor) -> None:
    someone = visitor()
    someone.client.set_cookie("emovid", "bcdf" * 6)
    assert "I agree" in someone.get("/").text
    assert someone.get("/video/1").location == "/resume"


def test_withdrawal_deletes_data_and_later_requests_report_it(visitor, store, opened) -> None:
    someone, other = visitor().go_through(SIX), visitor().go_through(SIX)
    code, cookie = readable(someone.cookie), someone.cookie
    assert f'value="{code}"' in someone.get("/withdraw").text
    assert "Your answers were deleted" in someone.post("/withdraw", code=code).text
    assert {row["participant"] for row in rows(store, opened)} == {f"p-{store.site}-0002"}
    assert "I agree" in someone.get("/").text
    assert "Your answers were deleted" in someone.post("/withdraw", code=code).text
    assert someone.post("/resume", code=code).status_code == 410
    assert someone.post("/withdraw", code="b" * 24).status_code == 404
    tab = visitor()
    tab.client.set_cookie("emovid", cookie)
    assert tab.post("/video/1", response="fear").status_code == 403
    assert tab.post("/consent", consent="agree").status_code == 403
    assert "I agree" in tab.get("/").text
    assert tab.post("/consent", consent="agree").location == "/about"
    assert other.get("/").location == "/thanks"


def test_withdrawal_with_another_code_keeps_own_answers(visitor, store) -> None:
    earlier, someone = visitor().go_through(SIX), visitor().go_through(SIX[:2], submit=False)
    assert "Your answers were deleted" in someone.post("/withdraw", code=earlier.cookie).text
    assert someone.get("/").location == "/video/3"
    assert [person.order_row for person, _ in store.participants()] == ["P002"]


def test_next_person_at_the_same_computer_is_a_new_participant(visitor, store) -> None:
    computer = visitor().go_through(SIX)
    assert "Start for another person" in computer.get("/new").text
    assert computer.post("/new").location == "/"
    computer.go_through(SIX)
    assert [person.order_row for person, _ in store.participants()] == ["P001", "P002"]


def test_abandoned_row_is_reassigned_and_a_returning_participant_keeps_answers(visitor, store, opened, clock) -> None:
    gone = visitor().go_through(SIX[:2], submit=False)
    clock.now += 7201
    assert {row["status"] for row in rows(store, opened)} == {"abandoned"}
    visitor().post("/consent", consent="agree")
    assert [person.order_row for person, _ in store.participants()] == ["P001", "P001"]
    assert gone.get("/").location == "/video/3"
    assert gone.chosen(1) == SIX[0]


def test_pages_without_javascript_explain_the_requirement(visitor) -> None:
    assert "<noscript><p" in visitor().begin().get("/video/1").text


def test_every_label_is_accepted_as_an_answer(visitor, store, opened) -> None:
    visitor().go_through(list(LABELS))
    assert responses(store, opened) == list(LABELS)
    assert store.find(digest("b" * 24)) is None


def test_blocked_cookies_are_named(app) -> None:
    client = app.test_client(use_cookies=False)
    token = re.search(r'name="form-token" value="([0-9a-f]+)"', client.get("/").text)[1]
    reply = client.post("/consent", data={"consent": "agree", "form-token": token})
    assert reply.status_code == 403
    assert "This survey needs cookies" in reply.text


def test_a_page_ahead_leads_to_the_current_one(visitor) -> None:
    someone = visitor().begin()
    for path in ("/video/2", "/video/6", "/review", "/thanks"):
        assert someone.get(path).location == "/video/1"
    assert someone.get("/video/7").location == "/video/1"
    assert someone.get("/after").location == "/video/1"


def test_the_next_page_is_named_to_the_script(visitor) -> None:
    someone = visitor()
    form = {"form-token": someone.token, "consent": "agree"}
    reply = someone.client.post("/consent", data=form, headers={"X-Survey-Script": "form"})
    assert (reply.status_code, reply.headers["X-Next"], reply.text) == (200, "/about", "")
    assert "Location" not in reply.headers
