"""The gallery: one page with figures, videos and scenes, checked as text and in a browser."""

import re
from base64 import b64decode
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.figures.catalogue import CATALOGUE, MEASURES, STUDY
from emovid.figures.gallery import Picture, SceneVideo, gallery_page
from emovid.figures.run_cache import Material
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, shipped_scene
from emovid.workflows.figures import measures_of, study_results
from emovid.workflows.gallery import gallery, steps

ENTRIES = [CATALOGUE[name] for name in ("gritsbot", "happiness-frames", "shapes", "confusion-matrix")]
SHORT = [Setting("duration", 4, "test"), Setting("video.fps", 10, "test")]
VOID = {"meta", "img", "br"}
PIXEL = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAGCpXPQAAAABJRU5ErkJggg=="


class Outline(HTMLParser):
    """The tags of a page in order with their attributes, and errors of closing tags."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.text: list[str] = []
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs) -> None:
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names))
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data) -> None:
        self.text.append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def make(done=lambda _: None) -> bytes:
    material = Material(SHORT, {STUDY: lambda _: study_results(None), MEASURES: measures_of})
    return gallery(material, ENTRIES, done)


@pytest.fixture(scope="module")
def told() -> list[str]:
    return []


@pytest.fixture(scope="module")
def file(tmp_path_factory, told) -> Path:
    """Make a gallery of short videos and some figures."""
    target = tmp_path_factory.mktemp("gallery") / "gallery.html"
    target.write_bytes(make(told.append))
    return target


@pytest.fixture(scope="module")
def outline(file) -> Outline:
    return Outline(file.read_text(encoding="utf-8"))


def test_page_is_well_formed_with_accessible_names(outline) -> None:
    assert outline.all("html") == [{"lang": "en"}]
    levels = [int(tag[1]) for tag, _ in outline.tags if re.fullmatch("h[1-6]", tag)]
    assert levels.count(1) == 1
    assert all(later <= earlier + 1 for earlier, later in pairwise(levels))
    ids = [attributes["id"] for _, attributes in outline.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    meant = [
        word for _, found in outline.tags for key in ("aria-labelledby", "aria-describedby") if (word := found.get(key))
    ]
    meant += [link["href"][1:] for link in outline.all("a") if link["href"].startswith("#")]
    assert set(meant) <= set(ids)
    assert set(EMOTIONS) <= set(meant)
    assert [image["alt"] for image in outline.all("img")] == [
        CATALOGUE[name].caption for name in ("happiness-frames", "gritsbot", "shapes", "confusion-matrix")
    ]
    assert all(video["aria-label"] for video in outline.all("video"))


def test_page_loads_nothing_from_other_hosts(outline, file) -> None:
    for tag, attributes in outline.tags:
        for key in ("src", "srcset", "poster", "href"):
            address = attributes.get(key) or "data:"
            assert address.startswith("data:") or (tag == "a" and address.startswith(("#", "https://")))
    assert not re.search(r"@import|url\(|fetch\(|<link|<iframe", file.read_text(encoding="utf-8"))


def test_page_has_each_scene_text_with_its_video(outline) -> None:
    videos = outline.all("video")
    assert len(videos) == 6
    for video in videos:
        assert {"loop", "muted", "playsinline", "controls"} <= set(video)
        assert "autoplay" not in video
        assert b64decode(video["src"].removeprefix("data:video/mp4;base64,"))[4:8] == b"ftyp"
        assert b64decode(video["poster"].removeprefix("data:image/png;base64,")).startswith(b"\x89PNG")
    page = gallery_page([film(Material().text("fear"))], [], "0")
    assert shipped_scene("fear").read_text() in "".join(Outline(page).text)
    assert "\nseed: 5\n" in Material([Setting("seed", 5, "test")]).text("fear")


def film(text: str, name: str = "fear") -> SceneVideo:
    return SceneVideo(name, "said", "https://example.org/", text, b"", b"", (600, 400))


def test_texts_of_scenes_and_captions_are_shown_unchanged() -> None:
    bad = "</pre><script>alert('x')</script> & \"quoted\" é 漢"
    page = gallery_page([film(bad)], [Picture("a", "", bad, "png", b64decode(PIXEL), (3.5, 2))], bad)
    outline = Outline(page)
    assert len(outline.all("script")) == 1
    assert outline.all("img")[0]["alt"] == bad
    assert "".join(outline.text).count(bad) == 3


def test_the_same_input_gives_the_same_bytes(file) -> None:
    assert make() == file.read_bytes()


def test_progress_names_all_videos_and_figures(told, file) -> None:
    assert told == [*(f"video of {emotion}" for emotion in EMOTIONS), *(entry.name for entry in ENTRIES)]
    assert steps(ENTRIES) == len(told)


def test_gallery_command_includes_all_figures_of_the_study(capsys, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    shown = []

    def fake(_, entries, done):
        shown.extend(entry.name for entry in entries)
        for _ in range(steps(entries)):
            done("part")
        return b"page"

    monkeypatch.setattr("emovid.workflows.figures.gallery", fake)
    few = {name: CATALOGUE[name] for name in ("gritsbot", "accuracy-gender", "confusion-matrix")}
    monkeypatch.setattr("emovid.workflows.figures.CATALOGUE", few)
    assert main(["figures", "gallery", "gritsbot", "--format", "svg"]) == 0
    assert shown == list(few)
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "[1/10] figures/gritsbot: svg"
    assert said[-1] == "[10/10] figures/gallery: part"
    assert {path.name for path in Path("figures").iterdir()} == {"gritsbot.svg", "gallery.html"}
    counts = Path(__file__).parents[2] / "studies/santos-egerstedt/counts.csv"
    main(["study", "analyze", "--counts", str(counts), "-o", "r", "--quiet"])
    shown.clear()
    assert main(["figures", "gallery", "--study", "r", "-o", "other"]) == 0
    assert shown == ["gritsbot", "confusion-matrix"]
    assert capsys.readouterr().err.splitlines()[-1].startswith("accuracy-gender: left out: ")


WIDTHS = {"phone": (390, 844), "desktop": (1280, 900)}
LUMINANCE = """() => {
  const parse = colour => colour.match(/[\\d.]+/g).map(Number);
  const linear = c => c <= .04045 ? c / 12.92 : ((c + .055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => [r, g, b].map(c => linear(c / 255))
    .reduce((sum, c, i) => sum + c * [.2126, .7152, .0722][i], 0);
  const ground = element => {
    for (; element; element = element.parentElement) {
      const [r, g, b, a = 1] = parse(getComputedStyle(element).backgroundColor);
      if (a === 1) return [r, g, b];
    }
    return [255, 255, 255];
  };
  return [...document.body.querySelectorAll("*:not(script)")]
    .filter(e => [...e.childNodes].some(node => node.nodeType === 3 && node.data.trim()))
    .map(e => [light(parse(getComputedStyle(e).color)), light(ground(e))].sort((a, b) => b - a))
    .map(([more, less]) => (more + .05) / (less + .05));
}"""
STATES = "[...document.querySelectorAll('video')].map(video => video.paused)"


def until(page, expression: str) -> None:
    """Wait until a condition holds; the content security policy of the page blocks the wait of playwright."""
    for _ in range(200):
        if page.evaluate(expression):
            return
        page.wait_for_timeout(50)
    pytest.fail(f"never: {expression}")


@pytest.fixture(params=WIDTHS)
def page(request, browser, file):
    """Open the page on a screen."""
    width, height = WIDTHS[request.param]
    opened = browser.new_page(viewport={"width": width, "height": height})
    asked, said = [], []
    opened.on("request", lambda one: asked.append(one.url.partition(":")[0]))
    opened.on("console", lambda message: said.append(message.text))
    opened.on("pageerror", lambda error: said.append(str(error)))
    opened.goto(file.as_uri())
    yield opened
    assert (asked.count("file"), set(asked) - {"file", "data"}, said) == (1, set(), [])
    opened.close()


def test_page_fits_every_screen_width(page) -> None:
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("[...document.images].every(image => image.complete && image.naturalWidth > 0)")
    video, text = (page.locator(f"section:first-of-type {kind}").bounding_box() for kind in ("video", "pre"))
    if page.viewport_size["width"] > 1000:
        assert text["x"] >= video["x"] + video["width"]
        assert abs(text["y"] - video["y"]) < 2
    else:
        assert text["y"] >= video["y"] + video["height"]
    contrasts = page.evaluate(LUMINANCE)
    assert len(contrasts) > 30
    assert min(contrasts) >= 4.5  # WCAG 2.2, 1.4.3


def test_visible_videos_play_and_a_paused_video_stays_paused(page) -> None:
    first, away = "document.querySelector('video')", "document.querySelector('#figures').scrollIntoView()"
    until(page, f"{first}.currentTime > 0 && !{first}.paused")
    page.evaluate(away)
    until(page, f"{first}.paused")
    page.evaluate("scrollTo(0, 0)")
    until(page, f"!{first}.paused")
    page.evaluate(f"{first}.pause()")
    page.wait_for_timeout(200)  # until the page has received the event
    page.evaluate("document.querySelector('#fear').scrollIntoView()")
    until(page, "!document.querySelectorAll('video')[3].paused")
    page.evaluate("scrollTo(0, 0)")
    until(page, "document.querySelectorAll('video')[3].paused")
    assert page.evaluate(STATES)[0]


def test_reduced_motion_preference_stops_autoplay(browser, file) -> None:
    calm = browser.new_page(reduced_motion="reduce")
    calm.goto(file.as_uri())
    calm.wait_for_timeout(500)
    assert calm.evaluate(STATES) == [True] * 6
    calm.evaluate("document.querySelector('video').play()")
    until(calm, "document.querySelector('video').currentTime > 0")
    calm.close()
