"""Options of studies (practice, attention checks, recruitment, languages, requirements) and of the server."""

import csv
import html
import io
import re
import sqlite3
from collections.abc import Callable
from dataclasses import replace
from urllib.parse import parse_qs, urlsplit

import pytest

from emovid.cli.main import main
from emovid.kit.folder import Kit, open_public
from emovid.kit.manifest import ServerKeys
from emovid.kit.study import Counting, Recruitment, Return
from emovid.kit.texts import TRANSLATED, Texts, words_of
from emovid.survey import codes
from emovid.survey.app import create_app
from emovid.survey.database import DatabaseBusyError
from emovid.survey.export import responses_csv
from emovid.survey.store import Store, Withdrawal
from tests.helpers.small_survey import PARTS, STUDY, small_kit
from tests.helpers.visitor import Clock, Visitor

EVERYTHING = (
    STUDY.replace('"https://example.org/back?study=1&done=yes"', '"https://example.org/back?pid={PROLIFIC_PID}"')
    + PARTS
    + """\
requirements: {text: Please use a computer., devices: [desktop], min_width: 600, browsers: [firefox, chrome]}
recruitment: {service: prolific, automatic: 5, declined: {code: N0PE}, failed: {code: FA1LED}}
counting: {failed_checks: false, max_stalled_ms: 500}
translations:
  ar:
    title: عنوان
    question: ما العاطفة؟
    labels: {happiness: سعادة, surprise: مفاجأة, anger: غضب, fear: خوف, disgust: اشمئزاز, sadness: حزن}
    consent: نص الموافقة
    instructions: تعليمات
    thanks: شكرا
    debriefing: كان عن الحركة
    requirements: استخدم حاسوبا
    questions:
      gender: {question: ما جنسك؟, choices: [امرأة, رجل, آخر]}
      country: {question: أين تعيش؟}
      comments: {question: تعليقات؟}
      age: {question: العمر؟}
      tools: {question: أدوات؟, choices: [أ, ب, ج]}
      shape: {question: أي شكل؟, choices: [دائرة, نجمة]}
"""
)
CHROME = "Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/140.0.0.0 Safari/537.36"
SAFARI = "Mozilla/5.0 (Macintosh) AppleWebKit/605.1.15 (KHTML, like Gecko) Version/18.0 Safari/605.1.15"
RECRUIT = {"PROLIFIC_PID": "p 1&x", "STUDY_ID": "s", "SESSION_ID": "t", "OTHER": "no"}


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    """Build a kit with all options."""
    return small_kit(tmp_path_factory.mktemp("options"), EVERYTHING)


@pytest.fixture
def full(everything) -> Kit:
    return open_public(everything)


@pytest.fixture
def answers(full, tmp_path, clock):
    made = Store(tmp_path / "options.sqlite", full.manifest.key_commitment, clock)
    yield made
    made.close()


@pytest.fixture
def come(full, answers, clock) -> Callable[..., Visitor]:
    """Open a separate browser."""
    return lambda **how: Visitor(create_app(full, answers, **how), clock)


def agree(someone: Visitor, **form):
    form = {"consent": "agree", "device": "desktop", "width": "1280"} | form
    return someone.client.post("/consent", data={"form-token": someone.token, **form}, headers={"User-Agent": CHROME})


def take_part(someone: Visitor, shape: str = "Circle", **form) -> Visitor:
    """Go from the consent to the submission."""
    assert agree(someone, **form).location == "/about"
    someone.post("/about", gender="Woman")
    assert someone.post("/instructions").location == "/video/1"
    for place in range(1, 9):
        assert someone.watch(place).json["open"]
        response = shape if 'value="Star"' in someone.get(f"/video/{place}").text else "fear"
        assert someone.answer(place, response, **{"response-ms": "900"}).status_code == 303
    assert someone.get("/").location == "/after"
    assert someone.post("/after", age="30", tools="A").location == "/review"
    assert someone.post("/submit").status_code == 303
    return someone


def rows(answers: Store, kit: Kit) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(responses_csv(answers, kit, pilot=False, release=7200))))


def test_practice_is_first_check_follows_three_videos_and_both_are_excluded(come, answers, full) -> None:
    someone = come()
    agree(someone)
    someone.post("/about", gender="Man")
    someone.post("/instructions")
    assert "Practice video" in someone.get("/video/1").text
    assert "not counted" in someone.get("/video/1").text
    seen = []
    for place in range(1, 9):
        page = someone.get(f"/video/{place}").text
        seen.append(re.search(r'<h1 id="heading">([^<]*)<', page)[1])
        someone.watch(place)
        if place == 5:  # the practice video and three others come before it
            assert "Which shape?" in page
            assert re.findall(r'name="response" value="(\w+)"', page) == ["Circle", "Star"]
            assert someone.answer(place, "fear").status_code == 400
        someone.answer(place, "Circle" if place == 5 else "fear")
    assert seen == ["Practice video", *(f"Video {n} of 7" for n in range(1, 8))]
    found = rows(answers, full)
    assert [row["position"] for row in found] == list("123456")
    assert [row["video"] for row in found] == list(full.orders["P001"])
    assert {row["checks"] for row in found} == {"1 of 1"}


def test_answers_of_other_kinds_are_checked_and_exported(come, answers, full) -> None:
    someone = take_part(come())
    assert someone.get("/after").location == "/thanks"
    other = come()
    agree(other)
    other.post("/about", gender="Woman")
    other.post("/instructions")
    for place in range(1, 9):
        other.watch(place)
        other.answer(place, "Circle" if place == 5 else "fear")
    for age in ("", "17", "100", "1e2", "18.5", "old", "٣٠"):
        reply = other.post("/after", age=age, comments="first\r\nsecond\x00")
        assert reply.status_code == 400
        assert "from 18 to 99" in reply.text
        assert not age or f'value="{age}"' in reply.text  # to be corrected
        assert ">first\nsecond</textarea>" in reply.text
    reply = other.client.post(
        "/after", data={"form-token": other.token, "age": " 42", "comments": "a\r\n b", "tools": ["C", "A", "x"]}
    )
    assert reply.location == "/review"
    other.post("/submit")
    last = rows(answers, full)[-1]
    assert (last["age"], last["comments"], last["tools"]) == ("42", "a\n b", "A|C")


def test_submission_requires_the_questions_after_the_videos(come) -> None:
    someone = come()
    agree(someone)
    someone.post("/about", gender="Woman")
    someone.post("/instructions")
    for place in range(1, 9):
        someone.watch(place)
        someone.answer(place, "Circle" if place == 5 else "fear")
    someone.post("/submit")
    assert someone.get("/").location == "/after"


def test_recruitment_ids_are_stored_separately_and_returned(come, answers, everything, capsys) -> None:
    someone = come()
    page = someone.get("/", query_string=RECRUIT).text
    assert 'name="PROLIFIC_PID" value="p 1&amp;x"' in page
    assert "OTHER" not in page
    take_part(someone, **RECRUIT)
    thanks = someone.get("/thanks").text
    assert 'href="https://example.org/back?pid=p%201%26x"' in thanks
    assert 'data-seconds="5"' in thanks
    assert "C0MPLETE" in thanks
    assert 'id="another"' not in thanks  # they are at a computer of their own
    assert "This was about motion." in thanks
    assert answers.recruits() == [({name: RECRUIT[name] for name in list(RECRUIT)[:3]}, "finished")]
    with answers._data.reading() as sql:
        participants = str(sql.execute("SELECT * FROM participants").fetchall())
        (digest,) = sql.execute("SELECT digest FROM recruits").fetchone()
    assert "p 1&x" not in participants
    assert digest not in participants
    assert codes.digest(someone.cookie) in participants
    someone.post("/withdraw", code=someone.cookie)
    assert answers.recruits() == []


@pytest.mark.parametrize("write", ["add_recruit", "end_recruit"])
def test_a_recruit_is_recorded_by_the_next_request_where_the_database_was_locked(come, answers, write) -> None:
    someone = come()
    path = "/consent" if write == "add_recruit" else "/submit"
    if path == "/submit":
        take_part(someone, **RECRUIT)
        answers.end_recruit(codes.recruit_digest(someone.cookie), "started")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(answers, write, busy)
        reply = agree(someone, **RECRUIT) if path == "/consent" else someone.post(path)
        assert (reply.status_code, reply.headers["X-Survey"]) == (503, "busy")
    reply = agree(someone, **RECRUIT) if path == "/consent" else someone.post(path)
    assert reply.status_code == 303
    assert [outcome for _, outcome in answers.recruits()] == ["started" if path == "/consent" else "finished"]
    assert len(answers.participants()) == 1


def busy(*_: object) -> None:
    raise DatabaseBusyError("locked")


def test_a_second_member_of_a_panel_at_the_same_computer_is_another_participant(come, answers) -> None:
    computer = come()
    take_part(computer, **RECRUIT)
    first = computer.cookie
    assert computer.get("/", query_string=RECRUIT | {"SESSION_ID": "another"}).location == "/thanks"  # the same person
    page = computer.get("/", query_string=RECRUIT | {"PROLIFIC_PID": "q2"}).text
    assert "I agree" in page
    assert computer.cookie != first
    take_part(computer, **RECRUIT | {"PROLIFIC_PID": "q2"})
    assert sorted(parameters["PROLIFIC_PID"] for parameters, _ in answers.recruits()) == ["p 1&x", "q2"]
    assert computer.post("/resume", code=first).location == "/"


ODD = [
    "a/b?c=d&e",
    "100 %",
    '"><b>',
    "{STUDY_ID}",
    "=HYPERLINK(1)",
    "é\u200d漢🤖",
    "' OR 1=1 --",
    "x" * 1500,
    "..%2f",
    "a\nb",
]


@pytest.mark.parametrize("name", ODD, ids=range(len(ODD)))
def test_odd_names_of_a_panel_are_kept_and_come_back_as_they_were(come, answers, name) -> None:
    someone, given = come(), RECRUIT | {"PROLIFIC_PID": name}
    page = someone.get("/", query_string=given).text
    assert html.unescape(re.search(r'name="PROLIFIC_PID" value="([^"]*)"', page)[1]) == name
    take_part(someone, **given)
    ((parameters, _),) = answers.recruits()
    assert parameters["PROLIFIC_PID"] == name
    link = html.unescape(re.search(r'href="(https://example[^"]*)"', someone.get("/thanks").text)[1])
    assert parse_qs(urlsplit(link).query) == {"pid": [name]}


def test_workers_of_mturk_return_with_their_assignment(opened, store, clock) -> None:
    link = "https://www.mturk.com/mturk/externalSubmit?assignmentId={assignmentId}&done=yes"
    said = opened.manifest.model_copy(update={"recruitment": Recruitment(service="mturk")})
    kit = replace(opened, manifest=said, server=ServerKeys(complete=Return(link=link)))
    someone = Visitor(create_app(kit, store), clock)
    given = {"workerId": "A1", "assignmentId": "3 X&Y", "hitId": "H", "turkSubmitTo": "https://evil.example"}
    someone.post("/consent", consent="agree", **given)
    someone.go_through(["fear"] * 6)
    shown = html.unescape(someone.get("/thanks").text)
    assert "externalSubmit?assignmentId=3%20X%26Y&done=yes" in shown
    assert "evil" not in shown
    assert store.recruits() == [({name: given[name] for name in ("workerId", "assignmentId", "hitId")}, "finished")]


def test_failed_check_and_declined_consent_have_separate_codes(come, answers, full) -> None:
    someone = take_part(come(), shape="Star", **RECRUIT)
    thanks = someone.get("/thanks").text
    assert "FA1LED" in thanks
    assert "C0MPLETE" not in thanks
    assert [outcome for _, outcome in answers.recruits()] == ["failed"]
    assert {row["status"] for row in rows(answers, full)} == {"failed check"}
    declined = come().post("/consent", consent="decline", **RECRUIT).text
    assert "N0PE" in declined
    assert "C0MPLETE" not in declined


def test_requirements_are_shown_and_checked_first(come, answers) -> None:
    assert "Please use a computer." in come().get("/").text
    assert "cannot be shown on this device" in agree(come(), device="phone").text
    assert "cannot be shown on this device" in agree(come(), width="599").text
    someone = come()
    reply = someone.client.post(
        "/consent", data={"form-token": someone.token, "consent": "agree"}, headers={"User-Agent": SAFARI}
    )
    assert "Please use a computer." in reply.text
    assert answers.participants() == []


def test_a_language_is_chosen_at_the_start_and_kept(come, answers, full) -> None:
    someone = come()
    assert 'href="/?language=ar"' in someone.get("/").text
    page = someone.get("/?language=ar").text
    assert '<html lang="ar" dir="rtl">' in page
    assert "نص الموافقة" in page
    assert words_of("ar")["agree"] in page
    agree(someone, language="ar")
    about = someone.get("/about").text
    assert 'value="Woman" required>امرأة' in about  # the data keep the labels of the study
    someone.post("/about", gender="Woman")
    someone.post("/instructions")
    assert "ما العاطفة؟" in someone.get("/video/1").text
    assert '<html lang="en" dir="ltr">' in come().get("/?language=xx").text
    assert {row["language"] for row in rows(answers, full)} == {"ar"}


def test_stalled_videos_are_marked_by_the_preset_rule(come, answers, full) -> None:
    someone = come()
    agree(someone)
    someone.post("/about", gender="Woman")
    someone.post("/instructions")
    someone.watch(1)
    someone.answer(1, "fear")
    for place, stalled in ((2, 500), (3, 501)):
        someone.get(f"/video/{place}")
        someone.report(f"/video/{place}/play", play=f"{place}" * 16)
        someone.clock.now += 2
        facts = {"share": 1, "frames": 30, "stalls": 2, "stalled-ms": stalled, "play-ms": 1400}
        someone.report(f"/video/{place}/watched", play=f"{place}" * 16, **facts)
        someone.post(f"/video/{place}", response="anger", **{"response-ms": "800"})
    found = rows(answers, full)
    assert [row["playback"] for row in found] == ["smooth", "stalled"]
    assert (found[1]["stalls"], found[1]["stalled_ms"], found[1]["play_ms"]) == ("2", "501", "1400")


@pytest.mark.parametrize(
    ("rules", "status"),
    [
        ({}, "finished"),
        ({"straightliners": False}, "straightliner"),
        ({"min_response_ms": 900}, "finished"),
        ({"min_response_ms": 901}, "speeder"),
    ],
)
def test_careless_participants_are_marked_by_the_rules_of_the_study(come, answers, full, rules, status) -> None:
    take_part(come(), shape="Star")  # and "fear" for all videos
    kit = replace(full, manifest=full.manifest.model_copy(update={"counting": Counting(**rules)}))
    assert {row["status"] for row in rows(answers, kit)} == {status}


def test_kiosk_last_page_has_a_next_person_link_and_no_code(come, answers) -> None:
    computer = come(kiosk=True)
    code = codes.readable(take_part(computer).cookie)
    page = computer.get("/thanks").text
    assert code not in page
    assert re.search(r'<a href="/" id="another" data-seconds="20"', page)
    assert "I agree" in computer.get("/").text
    assert code not in computer.get("/withdraw").text
    take_part(computer)
    assert len(answers.participants()) == 2


def test_without_a_kiosk_the_last_page_has_a_link_to_the_next_person(visitor) -> None:
    someone = visitor().go_through(["fear"] * 6)
    assert 'href="/new"' in someone.get("/thanks").text


@pytest.mark.parametrize("removed_by_the_proxy", [False, True])
def test_url_prefix_applies_to_every_address(opened, store, clock, removed_by_the_proxy) -> None:
    client = create_app(opened, store, prefix="/study1", https=True).test_client()
    start = "" if removed_by_the_proxy else "/study1"
    reply = client.get(f"{start}/", base_url="https://localhost")
    assert set(re.findall(r'(?:href|src|action)="(/[^"]*)"', reply.text)) == {
        "/study1/static/icon.svg", "/study1/static/survey.css", "/study1/static/survey.js", "/study1/consent",
        "/study1/resume",
    }  # fmt: skip
    assert re.fullmatch(
        r"__Secure-emovid=[a-z0-9]{24}; .*Secure; HttpOnly; Path=/study1; .*", reply.headers["Set-Cookie"]
    )
    assert client.get(f"{start}/video/1", base_url="https://localhost").location == "/study1/resume"
    assert client.get("/study10/", base_url="https://localhost").status_code == 404


def test_pilot_is_announced_on_every_page(opened, store) -> None:
    client = create_app(opened, store, pilot=True).test_client()
    for path in ("/", "/resume", "/nothing"):
        assert "This is a test run." in client.get(path).text
    assert "This is a test run." not in create_app(opened, store).test_client().get("/").text


def test_status_page_requires_its_token_and_shows_only_counts(visitor, store) -> None:
    visitor().go_through(["fear"] * 6)
    researcher = visitor()
    token = codes.status_token(store.secret)
    assert "finished" not in researcher.get("/status").text
    assert researcher.post("/status", code="b" * 24).status_code == 403
    page = researcher.post("/status", code=token).text
    assert re.search(r"finished</th><td>1<", page)
    assert "fear" not in page


@pytest.mark.parametrize("language", TRANSLATED)
def test_every_language_has_all_texts(language) -> None:
    words = words_of(language)
    english = {name: field.default for name, field in Texts.model_fields.items()}
    assert set(words) == {*english, "agree", "decline", "declined"}
    for name, text in words.items():
        assert text.strip()
        assert re.findall(r"{\w+}", text) == re.findall(r"{\w+}", english.get(name, "")) or name == "place"
        assert set(re.findall(r"{\w+}", text)) == set(re.findall(r"{\w+}", english.get(name, "")))


def test_recruits_are_listed_as_csv(everything, capsys, tmp_path, monkeypatch) -> None:
    kit = open_public(everything)
    store = Store(kit.folder.answers / "answers.sqlite", kit.manifest.key_commitment)
    store.add_recruit("digest", {"PROLIFIC_PID": "=1", "STUDY_ID": "s"})
    store.close()
    assert main(["study", "recruits", str(everything)]) == 0
    assert capsys.readouterr().out == "PROLIFIC_PID,STUDY_ID,SESSION_ID,outcome\n'=1,s,,started\n"


@pytest.mark.parametrize("depth", [10, 100_000])
def test_nested_json_is_refused(visitor, depth) -> None:
    someone = visitor().begin()
    body = "[" * depth + "]" * depth
    for path in ("/video/1/play", "/video/1/watched"):
        headers = {"X-Form-Token": someone.token, "Content-Type": "application/json"}
        assert someone.client.post(path, data=body[:60_000], headers=headers).status_code == 400


def test_clock_set_back_between_runs_gives_no_negative_time(opened, tmp_path, monkeypatch) -> None:
    path = tmp_path / "clock.sqlite"
    first = Store(path, opened.manifest.key_commitment)
    first.enroll("digest", opened.orders, opened.choices, "1", 60.0)
    before = first.clock()
    first.close()
    monkeypatch.setattr("emovid.survey.store.time.time", lambda: before - 3600)
    again = Store(path, opened.manifest.key_commitment)
    assert again.clock() >= before - 1
    again.close()


def test_injected_clock_is_used(opened, tmp_path) -> None:
    store = Store(tmp_path / "own.sqlite", opened.manifest.key_commitment, Clock(5.0))
    assert store.clock() == 5.0
    store.close()


def test_only_texts_of_a_finished_kit_can_be_corrected_as_a_new_version(tmp_path, capsys) -> None:
    kit = small_kit(tmp_path)
    study = tmp_path / "study.yaml"
    before = {path: path.read_bytes() for path in kit.rglob("*") if path.suffix in (".mp4", ".csv", ".txt")}
    opened = open_public(kit)
    store = Store(opened.folder.answers / "answers.sqlite", opened.manifest.key_commitment)
    store.enroll("digest", opened.orders, opened.choices, "1", 60.0)
    text = STUDY.replace("to its end.", "to the end.").replace("Fear", "Afraid").replace("C0MPLETE", "D0NE")
    study.write_text(text)
    assert main(["study", "update", str(kit), str(study)]) == 0
    changed = "instructions, labels.fear, thanks.code"
    told = capsys.readouterr().err
    assert told.startswith(f"{kit}: version 2; changed: ")
    assert sorted(told.splitlines()[0].partition("changed: ")[2].split(", ")) == changed.split(", ")
    after = open_public(kit)
    assert (after.manifest.version, after.manifest.instructions) == (2, "Watch each video to the end.")
    assert after.server.complete.code == "D0NE"
    assert {path: path.read_bytes() for path in before} == before
    assert len(store.participants()) == 1
    store.close()
    assert main(["study", "update", str(kit), str(study)]) == 0
    assert "nothing to update; version 2" in capsys.readouterr().err
    assert main(["study", "audit", str(kit)]) == 0
    capsys.readouterr()
    for change, key in ((("robots: 6", "robots: 7"), "set.robots"), (("random", "fixed"), "choices")):
        study.write_text(text.replace(*change))
        assert main(["study", "update", str(kit), str(study)]) == 2
        assert f"{key}: changes more than a text" in capsys.readouterr().err
    assert open_public(kit).manifest == after.manifest


def test_withdrawal_is_complete_only_without_text_in_logs(fresh, tmp_path, clock) -> None:
    opened = open_public(fresh)
    path = tmp_path / "held.sqlite"
    store = Store(path, opened.manifest.key_commitment, clock, patience=0.2)
    person = store.enroll("digest", opened.orders, opened.choices, "1", 60.0)
    store.tell(person.id, {"country": "Liechtenstein"})
    reader = sqlite3.connect(path, isolation_level=None)
    reader.execute("BEGIN")
    reader.execute("SELECT * FROM participants").fetchall()
    assert store.withdraw("digest") is Withdrawal.PENDING
    assert store.has_withdrawn("digest")
    reader.execute("ROLLBACK")
    assert store.withdraw("digest") is Withdrawal.DELETED
    files = [file.read_bytes() for file in tmp_path.glob("held.sqlite*")]
    assert b"Liechtenstein" not in b"".join(files)
    reader.close()
    store.close()


def test_deleted_data_held_by_a_reader_are_erased_by_the_next_write(fresh, tmp_path, clock) -> None:
    opened = open_public(fresh)
    path = tmp_path / "held.sqlite"
    store = Store(path, opened.manifest.key_commitment, clock, patience=0.2)
    person = store.enroll("digest", opened.orders, opened.choices, "1", 60.0)
    store.tell(person.id, {"country": "Liechtenstein"})
    reader = sqlite3.connect(path, isolation_level=None)
    reader.execute("BEGIN")
    reader.execute("SELECT * FROM participants").fetchall()
    assert store.withdraw("digest") is Withdrawal.PENDING
    reader.close()
    store.enroll("another", opened.orders, opened.choices, "1", 60.0)
    assert b"Liechtenstein" not in b"".join(file.read_bytes() for file in tmp_path.glob("held.sqlite*"))
    store.close()
