"""The page for jsPsych, run in a real browser from consent to download. Needs npm, its registry, and Chromium."""

import csv
import json
import shutil
import subprocess
import tarfile
import threading
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.kit.audit import audit
from emovid.kit.export import export
from emovid.kit.exports.jspsych import RELEASE
from emovid.kit.folder import Kit, open_kit
from tests.helpers.tiny import LABELS, STUDY, make_kit, make_kit_of_placeholders

CONFIDENCE = "ratings: {confidence: {question: How sure are you, low: not at all, high: completely, steps: 7}}\n"


@pytest.fixture(scope="module")
def jspsych_files(request, tmp_path_factory) -> Path:
    """Download the release named by the page, once for all test runs."""
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("no npm: jsPsych cannot be got, and its page was NOT TRIED")
    kept = request.config.cache.mkdir("jspsych") / "-".join(name.rpartition("@")[2] for name in RELEASE)
    if kept.is_dir():
        return kept
    folder = tmp_path_factory.mktemp("npm")
    done = subprocess.run([npm, "pack", "--silent", *RELEASE], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"npm cannot get jsPsych, and its page was NOT TRIED: {done.stderr[-200:]}")
    made = folder / "files"
    made.mkdir()
    for package, files in RELEASE.items():
        name, _, version = package.rpartition("@")
        with tarfile.open(folder / f"{name.removeprefix('@').replace('/', '-')}-{version}.tgz") as archive:
            for source, target in files.items():
                member = archive.extractfile(f"package/{source}")
                assert member is not None
                (made / target).write_bytes(member.read())
    shutil.copytree(made, kept)
    return kept


@pytest.fixture(scope="module")
def exported(tmp_path_factory) -> Kit:
    """Export a kit with a separate order of answers for each participant and a slider."""
    folder = tmp_path_factory.mktemp("jspsych")
    text = STUDY.replace("duration: 1}", "duration: 0.6}") + "choices: random\n" + CONFIDENCE
    make_kit(folder, text)
    kit = open_kit(folder / "kit")
    export(kit, "jspsych")
    return kit


@contextmanager
def served(folder: Path):
    """Serve a folder, and yield the address of its page."""

    class Handler(SimpleHTTPRequestHandler):
        def __init__(self, *arguments, **options) -> None:
            super().__init__(*arguments, directory=str(folder), **options)

        def log_message(self, *arguments) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/index.html"
        server.shutdown()


@pytest.fixture(scope="module")
def address(exported, jspsych_files):
    """Serve the export together with jsPsych."""
    folder = exported.folder.exports / "jspsych"
    shutil.copytree(jspsych_files, folder / "jspsych")
    with served(folder) as place:
        yield place


@pytest.fixture
def page(browser):
    """Open a page, and fail on errors of its scripts."""
    opened = browser.new_page(viewport={"width": 390, "height": 844})
    errors = []
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    yield opened
    opened.close()
    assert errors == []


def begin(page, address: str, participant: str) -> None:
    page.goto(f"{address}?participant={participant}")
    page.get_by_role("button", name="I agree and want to take part").click()
    page.get_by_label("Another gender").check()
    page.get_by_role("button", name="Continue").click()
    page.get_by_role("button", name="Continue").click()


def test_the_procedure_from_consent_to_analysis(exported, address, page, tmp_path, monkeypatch, capsys) -> None:
    order, key = exported.orders["P003"], exported.key
    given = {code: key[code] for code in order} | {order[0]: "fear", order[3]: "anger"}
    begin(page, address, "P003")
    for place, code in enumerate(order, start=1):
        shown = page.locator("input[name=response]").evaluate_all("inputs => inputs.map(input => input.value)")
        assert tuple(shown) == exported.choices["P003"]
        assert page.locator("input[name=response]").first.is_disabled()
        page.get_by_role("button", name="Play the video").click()
        page.get_by_role("button", name="Watch again").wait_for()
        if place == 2:
            page.get_by_role("button", name="Watch again").click()
            page.get_by_role("button", name="Watch again").wait_for()
        submit = page.get_by_role("button", name="Submit answer")
        page.get_by_label(given[code].title(), exact=True).check()
        assert submit.is_disabled()  # the slider is at its default position
        page.get_by_label("How sure are you").press("ArrowRight")
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        if place < 6:
            submit.click()
    with page.expect_download() as download:
        submit.click()
    assert download.value.suggested_filename == "P003.csv"
    download.value.save_as(tmp_path / "P003.csv")
    page.get_by_text("Thank you.").wait_for()

    with (tmp_path / "P003.csv").open() as file:
        trials = [row for row in csv.DictReader(file) if row["video_code"]]
    assert [(row["video_code"], row["position"], row["response"], row["plays"]) for row in trials] == [
        (code, str(place), given[code], "2" if place == 2 else "1") for place, code in enumerate(order, start=1)
    ]
    assert {row["confidence"] for row in trials} == {"5"}
    assert {row["choices"] for row in trials} == {"|".join(exported.choices["P003"])}

    monkeypatch.chdir(tmp_path)
    kit = exported.folder
    read = ["study", "analyze", "P003.csv", "--key", str(kit.key), "--map", str(kit.map), "--quiet"]
    assert main(read) == 0, capsys.readouterr().err
    results = json.loads((tmp_path / "results" / "results.json").read_text())
    assert results["counts"] == [
        [sum(given[code] == label and key[code] == emotion for code in order) for emotion in LABELS] for label in LABELS
    ]
    assert set(results["groups"]) == {"gender"}
    with (tmp_path / "results" / "responses_tidy.csv").open() as file:
        tidy = {row["video"]: (row["position"], row["perceived"]) for row in csv.DictReader(file)}
    assert tidy == {code: (str(place), given[code]) for place, code in enumerate(order, start=1)}


def test_a_video_cannot_be_skipped(address, page) -> None:
    begin(page, address, "P001")
    page.get_by_role("button", name="Play the video").click()
    page.evaluate("document.querySelector('video').currentTime = 0.59")
    page.evaluate("document.querySelector('video').playbackRate = 16")
    page.get_by_role("button", name="Watch again").wait_for()
    assert page.evaluate("document.querySelector('video').playbackRate") == 1


def test_only_the_videos_of_the_participant_are_loaded(jspsych_files, page, tmp_path) -> None:
    text = STUDY + "exemplars: 2\norders: {shown: one_of_each}\n"
    kit = make_kit_of_placeholders(tmp_path, text)
    folder = kit.folder.exports / "jspsych"
    export(kit, "jspsych")
    shutil.copytree(jspsych_files, folder / "jspsych")
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    with served(folder) as place:
        page.goto(f"{place}?participant=P002")
        page.get_by_role("button", name="I agree and want to take part").wait_for()
    loaded = {Path(address).stem for address in asked if address.endswith(".mp4")}
    assert loaded == set(kit.orders["P002"])
    assert len(kit.manifest.codes) == 12


def test_the_page_works_when_it_is_opened_as_a_file(exported, address, page) -> None:
    begin(page, (exported.folder.exports / "jspsych" / "index.html").as_uri(), "P004")
    page.get_by_role("button", name="Play the video").click()
    page.get_by_role("button", name="Watch again").wait_for()
    page.get_by_label("Fear").check()
    assert page.get_by_label("Fear").is_checked()


def test_practice_checks_and_questions_after_the_videos(jspsych_files, page, tmp_path) -> None:
    parts = """practice: {scene: fear}
checks: [{name: shape, scene: sadness, question: Which shape, choices: [Circle, Star], answer: Star, after: 1}]
questions_after:
  - {name: hobbies, question: Which hobbies, choices: [Chess, Go], several: true}
  - {name: years, question: How many years, number: {low: 0, high: 99}}
recruitment: {parameters: [panel]}
thanks: {text: Thank you., link: "https://example.org/?back={panel}"}
"""
    text = STUDY.replace("thanks: {text: Thank you.}\n", "").replace("duration: 1}", "duration: 0.4}")
    text = "".join(line for line in text.splitlines(keepends=True) if line.strip().removeprefix("- scene: ") not in
                   ("happiness", "surprise", "disgust", "sadness"))  # fmt: skip
    make_kit(tmp_path, text + parts)
    kit = open_kit(tmp_path / "kit")
    export(kit, "jspsych")
    folder = kit.folder.exports / "jspsych"
    shutil.copytree(jspsych_files, folder / "jspsych")
    with served(folder) as place:
        page.goto(f"{place}?participant=P001&panel=x1")
        page.get_by_role("button", name="I agree and want to take part").click()
        page.get_by_label("Another gender").check()
        for _ in range(2):
            page.get_by_role("button", name="Continue").click()
        page.get_by_role("heading", name="Practice video").wait_for()
        for answer in ("Disgust", "Fear", "Star", "Anger"):
            page.get_by_role("button", name="Play the video").click()
            page.get_by_role("button", name="Watch again").wait_for()
            page.get_by_label(answer, exact=True).check()
            page.get_by_role("button", name="Submit answer").click()
        page.get_by_label("Chess").check()
        page.get_by_label("Go", exact=True).check()
        page.get_by_label("How many years").fill("7")
        with page.expect_download() as download:
            page.get_by_role("button", name="Continue").click()
        assert page.get_by_role("link").get_attribute("href") == "https://example.org/?back=x1"
    download.value.save_as(tmp_path / "P001.csv")
    with (tmp_path / "P001.csv").open() as file:
        rows = list(csv.DictReader(file))
    given = [(row["video_code"], row["response"]) for row in rows if row["video_code"]]
    assert given == list(zip(kit.orders["P001"], ("Fear".lower(), "anger"), strict=True))
    assert [row["practice_response"] for row in rows if row["practice_response"]] == ["disgust"]
    assert [(row["check"], row["check_response"]) for row in rows if row["check"]] == [("shape", "Star")]
    assert {"hobbies_1": "Chess", "hobbies_2": "Go", "years": "7"} in [
        json.loads(row["response"]) for row in rows if row["response"].startswith("{")
    ]
    assert {row["panel"] for row in rows} == {"x1"}


def test_without_consent_no_video_is_shown_and_no_data_are_stored(address, page) -> None:
    downloads = []
    page.on("download", lambda download: downloads.append(download))  # noqa: PLW0108 - playwright cannot wrap append
    page.goto(address)
    page.get_by_role("button", name="I do not agree").click()
    page.get_by_text("Nothing was recorded").wait_for()
    assert page.locator("video").count() == 0
    assert downloads == []


def test_page_does_not_reveal_emotions(exported) -> None:
    assert audit(exported.folder.path).findings == ()
