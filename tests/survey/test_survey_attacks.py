"""Attempts that the survey must refuse."""

import re
import sys

import pytest

from emovid.kit.folder import open_public
from emovid.survey import codes
from emovid.survey.app import create_app
from emovid.survey.export import responses_csv
from emovid.survey.forms import body_limit
from emovid.survey.store import open_survey
from tests.helpers.small_survey import STUDY
from tests.helpers.visitor import Visitor

POSTS = ("/consent", "/about", "/instructions", "/video/1", "/video/1/play", "/video/1/watched", "/submit", "/resume",
         "/withdraw", "/new")  # fmt: skip
PAGES = ("/", "/about", "/instructions", "/video/1", "/review", "/thanks", "/resume", "/withdraw", "/new", "/nothing")
INJECTIONS = [
    "'; DROP TABLE answers; --",
    "' OR '1'='1",
    '"><script>alert(1)</script>',
    "{{ 7*7 }}{% debug %}",
    "\r\nSet-Cookie: emovid=evil",
    "../../private/key.csv",
    "\x00\x1b[31m",
    "=HYPERLINK(\"http://x\")",
    "fear\x00",
    "𝕱" * 1000,
]  # fmt: skip


def everything(store, opened) -> str:
    return responses_csv(store, opened, pilot=False, release=7200)


@pytest.fixture
def someone(visitor) -> Visitor:
    """Enroll a participant who may answer the first video."""
    found = visitor().begin()
    assert found.watch(1).json["open"]
    return found


@pytest.mark.parametrize("path", POSTS)
@pytest.mark.parametrize("forged", ["", "0" * 64, "another's"])
def test_posts_without_the_form_token_are_refused(someone, visitor, store, opened, path, forged) -> None:
    someone.answer(1, "fear")
    before = everything(store, opened)
    token = visitor().token if forged == "another's" else forged
    form = {"response": "anger", "consent": "agree", "code": codes.readable(someone.cookie), "gender": "Man"}
    cookie = someone.cookie
    for reply in (
        someone.client.post(path, data=form | {"form-token": token}),
        someone.client.post(path, json={"play": "0" * 16}, headers={"X-Form-Token": token}),
        someone.client.post(path, data=form, headers={"Origin": "https://evil.example"}),
    ):
        assert reply.status_code == 403
        assert "not recorded" in reply.text
    assert everything(store, opened) == before
    assert someone.cookie == cookie


@pytest.mark.parametrize("method", ["put", "patch", "delete"])
def test_other_methods_change_nothing(someone, method) -> None:
    assert getattr(someone.client, method)("/video/1").status_code in (403, 405)


def test_participants_cannot_see_or_change_answers_of_others(visitor, store, opened) -> None:
    first, second = visitor().begin(), visitor().begin()
    for one, response in ((first, "fear"), (second, "anger")):
        one.watch(1)
        one.answer(1, response)
    assert (first.chosen(1), second.chosen(1)) == ("fear", "anger")
    attacker = visitor()
    attacker.client.set_cookie("emovid", second.cookie[:-1] + ("b" if second.cookie[-1] != "b" else "c"))
    assert attacker.get("/video/1").location == "/resume"
    for number in ("1", "2", "p-0001", "P001"):
        assert attacker.post("/resume", code=number).status_code == 404
        assert attacker.post("/withdraw", code=number).status_code == 404
        for place in (f"/video/1?participant={number}", f"/review?id={number}"):
            assert attacker.get(place).location == "/resume"
    attacker.post("/video/1", response="anger", participant="1")
    assert (first.chosen(1), second.chosen(1)) == ("fear", "anger")


def test_the_form_of_one_participant_cannot_be_sent_as_another(visitor) -> None:
    first, second = visitor().begin(), visitor().begin()
    second.watch(1)
    stolen = second.client.post("/video/1", data={"form-token": first.token, "response": "fear"})
    assert stolen.status_code == 403
    assert second.chosen(1) == ""


def test_unwatched_video_cannot_be_answered_by_a_direct_post(visitor, store, opened) -> None:
    hasty = visitor().begin()
    assert hasty.answer(1, "fear").status_code == 409
    hasty.get("/video/1")
    assert hasty.answer(1, "fear").status_code == 409
    assert hasty.report("/video/1/watched", play="0" * 16, share=1).status_code == 409  # never begun
    assert hasty.answer(1, "fear").status_code == 409
    hasty.report("/video/1/play", play="0" * 16)
    assert hasty.report("/video/1/watched", play="0" * 16, share=1).json == {"open": False, "wait": pytest.approx(0.98)}
    for claim in (1e9, float("inf"), float("nan"), "1", None, True, [1], {}):
        assert not hasty.report("/video/1/watched", play="0" * 16, share=claim).json["open"]
    hasty.clock.now += 0.97
    assert hasty.report("/video/1/watched", play="0" * 16, share=1).json["open"] is False
    assert hasty.answer(1, "fear").status_code == 409
    hasty.clock.now += 100  # elapsed time alone is not enough
    assert hasty.answer(1, "fear").status_code == 409
    assert hasty.report("/video/1/watched", play="0" * 16, share=0.97).json == {"open": False, "wait": 0}
    assert "fear" not in everything(store, opened).replace("fear|", "").replace("|fear", "")  # no answer
    assert hasty.report("/video/1/watched", play="0" * 16, share=1).json["open"]
    assert hasty.answer(1, "fear").location == "/video/2"


def test_plays_of_other_videos_or_participants_do_not_open_a_question(visitor) -> None:
    first, second = visitor().begin(), visitor().begin()
    first.report("/video/1/play", play="a" * 16)
    first.clock.now += 5
    assert second.report("/video/1/watched", play="a" * 16, share=1).status_code == 409
    assert first.report("/video/2/play", play="b" * 16).status_code == 409  # not yet its turn
    assert first.report("/video/7/play", play="b" * 16).status_code == 409
    assert first.report("/video/1/watched", play="a" * 16, share=1).json["open"]
    assert first.answer(2, "fear").location == "/video/1"
    assert second.answer(1, "fear").status_code == 409


@pytest.mark.parametrize("report", [{}, {"play": 7}, {"play": "x" * 16}, {"play": "0" * 17}, [], "text", 7])
def test_invalid_player_reports_are_refused(someone, report) -> None:
    for path in ("/video/1/play", "/video/1/watched"):
        reply = someone.client.post(path, json=report, headers={"X-Form-Token": someone.token})
        assert reply.status_code == 400


def test_impossible_sizes_and_frame_counts_are_ignored(someone, store) -> None:
    odd = {"device": "<b>", "width": 1e300, "height": -4, "frames": "many", "dropped": float("nan")}
    assert someone.report("/video/1/play", play="f" * 16, **odd).status_code == 200
    assert someone.report("/video/1/watched", play="f" * 16, share=0, **odd).status_code == 200
    huge = {"share": 10**400, "frames": 10**400}  # larger than any float
    assert someone.report("/video/1/watched", play="f" * 16, **huge, dropped=-(10**400)).status_code == 200
    with store._data.reading() as sql:
        kept = sql.execute("SELECT device, width, height, frames, dropped FROM plays WHERE play = ?", ("f" * 16,))
        assert kept.fetchone() == ("", 100_000, 0, 100_000, 0)


@pytest.mark.parametrize("text", INJECTIONS)
def test_texts_are_not_interpreted_as_sql_html_header_or_path(someone, store, opened, text) -> None:
    assert someone.answer(1, text).status_code == 400
    assert someone.answer(1, "fear").location == "/video/2"
    said = someone.post("/about", gender="Man", country=text)
    assert said.location == "/instructions"
    assert said.headers.getlist("Set-Cookie") == []
    page = someone.get("/about").text
    assert "<script>alert" not in page
    assert "49" not in re.findall(r'id="about-country"[^>]*', page)[0].replace("49;", "")
    for path in ("/resume", "/withdraw"):
        reply = someone.post(path, code=text)
        assert reply.status_code == 404
        assert "<script>alert" not in reply.text
        assert "emovid=evil" not in str(reply.headers)
    someone.client.set_cookie("other", "x")
    assert someone.get("/video/1").status_code == 200
    lines = everything(store, opened).splitlines()
    assert len(lines) == 2
    assert not re.search(r"(^|,)[=@]", lines[1])


def test_text_is_shown_as_it_was_written(someone) -> None:
    someone.post("/about", gender="Man", country="<b>\"&'")
    assert 'value="&lt;b&gt;&#34;&amp;&#39;"' in someone.get("/about").text


def test_study_texts_are_escaped_in_html(kit, tmp_path, clock) -> None:
    manifest = kit / "public" / "manifest.json"
    manifest.write_text(manifest.read_text().replace("Watch each video to its end.", "<script>alert(1)</script>"))
    opened, store = open_survey(kit, pilot=False, create=True)
    visitor = Visitor(create_app(opened, store), clock)
    visitor.post("/consent", consent="agree")
    visitor.post("/about", gender="Man")
    assert "&lt;script&gt;" in visitor.get("/instructions").text
    store.close()


@pytest.mark.parametrize(
    "path",
    ["/media/../manifest.json", "/media/..%2fmanifest.json", "/media/%2e%2e%2f%2e%2e%2fprivate%2fkey.csv.mp4",
     "/media/..%5c..%5cprivate%5ckey.mp4", "/media//etc/passwd.mp4", "/media/key.mp4", "/media/.mp4",
     "/static/../app.py", "/static/%2e%2e/app.py", "/static/..%2f..%2fsurvey%2fstore.py", "/private/key.csv",
     "/orders.csv", "/manifest.json", "/answers/answers.sqlite", "/video/0", "/video/-1", "/video/1.5",
     "/video/99999999999999999999", "/console", "/static/"],
)  # fmt: skip
def test_paths_cannot_leave_the_page_folder(someone, path) -> None:
    reply = someone.get(path)
    assert reply.status_code == (303 if path.startswith(("/video/0", "/video/9")) else 404)
    assert b"true_emotion" not in reply.data
    assert b"def " not in reply.data
    assert "/private" not in reply.text.replace(path, "")


def test_videos_are_served_only_to_their_participants(visitor, someone, opened) -> None:
    code = opened.orders["P001"][0]
    assert someone.get(f"/media/{code}.mp4").status_code == 200
    assert visitor().get(f"/media/{code}.mp4").status_code == 404
    assert someone.get("/media/bbbbbb.mp4").status_code == 404


def test_range_requests_return_the_requested_bytes(someone, opened) -> None:
    code = opened.orders["P001"][0]
    whole = opened.folder.video(code).read_bytes()
    path = f"/media/{code}.mp4"
    assert someone.get(path).data == whole
    assert someone.get(path).headers["Accept-Ranges"] == "bytes"
    for asked, expected in {"0-99": whole[:100], "100-": whole[100:], "-7": whole[-7:]}.items():
        reply = someone.get(path, headers={"Range": f"bytes={asked}"})
        assert (reply.status_code, reply.data) == (206, expected)
        assert reply.headers["Content-Range"].endswith(f"/{len(whole)}")
    assert someone.get(path, headers={"Range": f"bytes={len(whole)}-"}).status_code == 416
    tag = someone.get(path).headers["ETag"]
    assert someone.get(path, headers={"If-None-Match": tag}).status_code == 304


def test_request_bodies_and_fields_are_limited(someone, store, opened) -> None:
    before, limit = everything(store, opened), body_limit(opened.manifest.demographics)
    token = someone.token
    for reply in (
        someone.post("/about", gender="Man", country="x" * (limit + 1)),
        someone.client.post("/about", data=b"x" * (limit + 1), headers={"X-Form-Token": token}),
        someone.report("/video/1/play", play="0" * 16, padding="x" * limit),
    ):
        assert reply.status_code == 413
        assert "Your answers are too long to be sent" in reply.text
    assert everything(store, opened) == before
    someone.post("/about", gender="Man", country="x" * 5000)
    assert max(map(len, re.findall("x+", someone.get("/about").text))) == 500


NESTED = b"[" * 20_000 + b"]" * 20_000
BODIES = [  # type, content
    ("application/json", b""),
    ("application/json", b"null"),
    ("application/json", b"\xff\xfe"),
    ("application/json", b"9" * 5000),
    ("application/json", b'{"play": "' + b"0" * 16 + b'", "share": ' + b"9" * 4000 + b"}"),
    ("application/json", b'{"play": "' + b"0" * 16 + b'", "share": 1e999, "frames": -1e999, "stalls": true}'),
    ("application/json", b'{"play": "\\ud800"}'),
    ("application/json", NESTED),
    ("application/json", b'{"play": ' + NESTED + b"}"),
    ("application/x-www-form-urlencoded", b"response=%ED%A0%80&gender=%FF&code=%00"),
    ("application/x-www-form-urlencoded", b"a=1&" * 10_000),
    ("application/x-www-form-urlencoded", b"%" * 60_000),
    ("multipart/form-data", b"--x"),
    ("multipart/form-data; boundary=x", b"--x\r\n\r\n"),
    ("multipart/form-data; boundary=x", b"--x\r\nContent-Disposition: form-data; name=a; filename=b\r\n\r\nc\r\n--x--"),
    ("multipart/form-data; boundary=" + "y" * 300, b"--" + b"y" * 300 + b"\r\n" * 30_000),
    ("text/plain; charset=nonsense", b"\x00" * 60_000),
]


@pytest.mark.parametrize("body", BODIES, ids=range(len(BODIES)))
def test_no_body_makes_the_survey_fail(someone, body) -> None:
    kind, content = body
    headers = {"X-Form-Token": someone.token, "Content-Type": kind}
    for path in POSTS:
        reply = someone.client.post(path, data=content, headers=headers)
        assert reply.status_code < 500, path
        assert "Traceback" not in reply.text


@pytest.mark.parametrize("over", [-1, 0, 1])
def test_bodies_at_their_limit_are_taken_and_one_byte_more_is_refused(someone, opened, over) -> None:
    limit, start = body_limit(opened.manifest.demographics), b"gender=Man&country="
    body = start + b"x" * (limit - len(start) + over)
    headers = {"X-Form-Token": someone.token, "Content-Type": "application/x-www-form-urlencoded"}
    assert someone.client.post("/about", data=body, headers=headers).status_code == (413 if over > 0 else 303)


@pytest.mark.parametrize("path", PAGES)
def test_every_page_has_a_restrictive_security_policy(someone, path) -> None:
    headers = someone.get(path).headers
    policy = dict(part.strip().split(" ", 1) for part in headers["Content-Security-Policy"].split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["frame-ancestors"] == policy["base-uri"] == "'none'"
    assert all(policy[name] == "'self'" for name in ("script-src", "style-src", "connect-src", "form-action"))
    assert policy["media-src"] == "'self' blob:"  # videos are played from memory once they are loaded completely
    assert (headers["X-Content-Type-Options"], headers["X-Frame-Options"]) == ("nosniff", "DENY")
    assert (headers["Referrer-Policy"], headers["Cache-Control"]) == ("no-referrer", "no-store")


@pytest.mark.parametrize("path", PAGES)
def test_pages_use_no_external_resources_and_no_inline_scripts(someone, path) -> None:
    page = someone.get(path, follow_redirects=True).text
    assert not re.search(r'(src|href|action)="(?!/|#|https://example\.org/back)', page)
    assert not re.search(r"<script(?! src=)|<style|\sstyle=|\son\w+=", page)


def test_cookies_are_http_only_and_secure_with_tls(opened, store, clock) -> None:
    plain = create_app(opened, store).test_client().get("/").headers["Set-Cookie"]
    assert re.fullmatch(r"emovid=[a-z0-9]{24}; .*HttpOnly; Path=/; SameSite=Lax", plain)
    secure = create_app(opened, store, https=True).test_client().get("/").headers["Set-Cookie"]
    assert re.fullmatch(r"__Host-emovid=[a-z0-9]{24}; .*Secure; HttpOnly; Path=/; SameSite=Lax", secure)


def test_other_sites_cannot_set_a_code_before_consent(visitor) -> None:
    victim = visitor()
    victim.get("/")
    cookie = victim.cookie
    attacker = visitor().begin()
    reply = victim.client.post("/resume", data={"code": attacker.cookie, "form-token": attacker.token})
    assert reply.status_code == 403
    assert victim.cookie == cookie


def test_internal_errors_reveal_no_details(someone, store, monkeypatch, caplog) -> None:
    def broken(*_: object) -> None:
        raise OSError("/secret/path: disk full")

    monkeypatch.setattr(store, "answer", broken)
    reply = someone.answer(1, "fear")
    assert reply.status_code == 500
    assert "Something went wrong" in reply.text
    assert "secret" not in reply.text
    assert "Traceback" not in reply.text
    assert "disk full" in caplog.text


def test_redirects_ignore_the_host_header(someone) -> None:
    for host in ("evil.example", "evil.example/..", "localhost:99999"):
        reply = someone.client.post(
            "/video/1", data={"form-token": someone.token, "response": "fear"}, headers={"Host": host}
        )
        assert "evil" not in reply.text + reply.headers.get("Location", "")


def test_survey_never_opens_the_private_folder(kit, clock) -> None:
    touched = []

    def listen(event: str, arguments: tuple[object, ...]) -> None:
        if listening and event in ("open", "os.listdir", "os.scandir") and "private" in str(arguments[0]):
            touched.append(arguments[0])

    listening = True
    sys.addaudithook(listen)
    (kit / "private").chmod(0)
    opened, store = open_survey(kit, pilot=False, create=True)
    Visitor(create_app(opened, store), clock).begin()
    everything(store, opened)
    store.close()
    listening = False
    (kit / "private").chmod(0o700)
    assert touched == []
    assert open_public(kit).key == {}


def test_pages_and_files_do_not_reveal_labels_of_videos(visitor, fresh, opened, store) -> None:
    """Labels appear only as answers to choose from, never next to a code or in the order of the key."""
    someone = visitor()
    seen = [someone.get("/").text]
    someone.begin()
    for place in range(1, 7):
        seen.append(someone.get(f"/video/{place}").text)
        someone.watch(place)
        someone.answer(place, "fear")
    without = [re.sub(r'<label><input type="radio"[^>]*>\w+</label>', "", page) for page in seen]
    assert not any(
        label in page.lower() for page in without for label in ("happi", "anger", "sad", "disgust", "surpris")
    )
    assert STUDY.count("anger") == 2
    key = (fresh / "private" / "key.csv").read_text()
    assert all(line.split(",")[1] not in "".join(without).lower() for line in key.splitlines()[1:])
    choice_orders = {tuple(re.findall(r'name="response" value="(\w+)"', page)) for page in seen[1:]}
    assert choice_orders == {opened.choices["P001"]}
