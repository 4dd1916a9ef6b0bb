"""Properties of every figure: all formats, reproducible bytes, and one style."""

import importlib
import os
import re
import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import matplotlib
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.font_manager import findfont
from matplotlib.text import Text

from emovid.errors import InputError
from emovid.figures.catalogue import CATALOGUE, MEASURES, STUDY, TEXTS, WIDTHS
from emovid.figures.paper_tables import table_latex
from emovid.figures.run_cache import Material
from emovid.figures.style import DOUBLE_COLUMN, FORMATS, SINGLE_COLUMN, in_style
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting
from emovid.swarm.simulate import simulate
from emovid.workflows.figures import measures_of, study_results
from emovid.workflows.gallery import GALLERY
from emovid.workflows.snapshots import CONTACT, FRAMES
from tests.helpers.pdf import all_fonts_are_embedded_truetype, font_sizes, objects, page_box

ROOT = Path(__file__).parents[2]
NAMES = list(CATALOGUE)
DRAWN = [name for name, entry in CATALOGUE.items() if entry.draw]
OF_PIXELS = {"densities"}
TEXT_SIZES = {8.0, 5.6}  # text, and the indices in it


@pytest.fixture(scope="module")
def material() -> Material:
    return Material(tables={STUDY: lambda _: study_results(None), MEASURES: measures_of})


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Make all figures in all formats in a separate process, with user settings that would be visible."""
    place = tmp_path_factory.mktemp("figures")
    (place / "matplotlibrc").write_text("font.size: 17\naxes.linewidth: 5\npath.snap: False\n")
    environment = os.environ | {"PYTHONHASHSEED": "1", "SOURCE_DATE_EPOCH": "1"}
    formats = [word for format in (*FORMATS, *TEXTS) for word in ("--format", format)]
    command = [sys.executable, "-W", "error", "-m", "emovid", "figures", "all", "-o", "made", *formats]
    done = subprocess.run(command, check=True, cwd=place, env=environment, capture_output=True, text=True)
    assert [line.split()[1] for line in done.stderr.splitlines()] == [f"made/{name}:" for name in CATALOGUE]
    return place / "made"


def test_one_command_makes_every_figure_in_every_format(folder) -> None:
    assert {path.name for path in folder.iterdir()} == {
        f"{entry.name}.{suffix}" for entry in CATALOGUE.values() for suffix in entry.formats
    }


@pytest.mark.parametrize("name", NAMES)
def test_the_same_input_gives_the_same_bytes(name, material, folder) -> None:
    entry = CATALOGUE[name]
    for suffix, data in zip(entry.formats, entry.files(material, entry.formats), strict=True):
        assert data == (folder / f"{name}.{suffix}").read_bytes(), suffix


@pytest.mark.parametrize("name", DRAWN)
def test_a_pdf_has_the_width_of_its_style_and_embeds_truetype_of_8_points(name, folder) -> None:
    pdf = (folder / f"{name}.pdf").read_bytes()
    left, bottom, width, height = page_box(pdf)
    assert (left, bottom, width) == (0, 0, pytest.approx(CATALOGUE[name].width * 72, abs=0.01))
    rows = int.from_bytes((folder / f"{name}.png").read_bytes()[20:24], "big")
    assert height == pytest.approx(rows / 300 * 72, abs=0.5)
    assert 72 < height < 9 * 72
    assert all_fonts_are_embedded_truetype(pdf)
    assert 8.0 in font_sizes(pdf) <= TEXT_SIZES
    assert b"CreationDate" not in objects(pdf)


@pytest.mark.parametrize("name", DRAWN)
def test_only_density_figures_contain_raster_images(name, folder) -> None:
    pdf = (folder / f"{name}.pdf").read_bytes()
    assert (b"/Subtype /Image" in pdf) == (name in OF_PIXELS)
    svg = (folder / f"{name}.svg").read_text()
    assert ("<image" in svg) == (name in OF_PIXELS)
    assert "<dc:date>" not in svg


@pytest.mark.parametrize("name", DRAWN)
def test_a_png_has_300_dots_per_inch(name, folder) -> None:
    png = (folder / f"{name}.png").read_bytes()
    assert int.from_bytes(png[16:20], "big") == round(CATALOGUE[name].width * 300)
    assert re.search(rb"pHYs(.{4})", png, re.DOTALL)[1] == round(300 / 0.0254).to_bytes(4, "big")


@pytest.mark.parametrize("name", DRAWN)
def test_an_eps_has_the_size_of_its_figure_embeds_truetype_and_no_date(name, folder) -> None:
    eps = (folder / f"{name}.eps").read_bytes()
    assert eps.startswith(b"%!PS-Adobe-3.0 EPSF-3.0\n")
    left, bottom, right, _ = map(float, re.search(rb"^%%HiResBoundingBox: (.*)$", eps, re.MULTILINE)[1].split())
    assert (left, bottom, right) == (0, 0, pytest.approx(CATALOGUE[name].width * 72, abs=0.01))
    assert b"/FontType 42" in eps
    assert b"%%CreationDate" not in eps


@pytest.mark.parametrize("style", WIDTHS)
@pytest.mark.parametrize("name", DRAWN)
def test_text_is_readable_in_both_widths(name, style, material) -> None:
    figure = CATALOGUE[name].figure(material, WIDTHS[style])
    assert figure.get_figwidth() == WIDTHS[style]
    with in_style():
        renderer = FigureCanvasAgg(figure).get_renderer()
        figure.draw(renderer)
        written = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text()]
        boxes = [Text.get_window_extent(text, renderer) for text in written]
    for text, box in zip(written, boxes, strict=True):
        assert text.get_fontsize() == 8.0
        assert Path(findfont(text.get_fontproperties())).is_relative_to(matplotlib.get_data_path())
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1, text.get_text()
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1, text.get_text()
    upright = [(text, box) for text, box in zip(written, boxes, strict=True) if text.get_rotation() % 90 == 0]
    for (one, box), (other, its) in combinations(upright, 2):
        assert not box.shrunk(0.9, 0.9).overlaps(its.shrunk(0.9, 0.9)), (one.get_text(), other.get_text())


def test_text_tables_are_not_drawn(material) -> None:
    with pytest.raises(ValueError, match="attributes is a table of text"):
        CATALOGUE["attributes"].figure(material)
    assert CATALOGUE["attributes"].formats == ("tex", "md", "html")


def test_names_numbers_and_captions_match_the_paper() -> None:
    numbers = [entry.paper for entry in CATALOGUE.values()]
    assert [number for number in numbers if number.startswith("Fig")] == [f"Fig. {n}" for n in range(1, 18)]
    assert [number for number in numbers if number.startswith("Table")] == ["Table I", "Table II", "Table III"]
    for entry in CATALOGUE.values():
        assert re.fullmatch(r"[A-Z][^\n]{20,100}[^.\n]", entry.caption)
        assert entry.width in (SINGLE_COLUMN, DOUBLE_COLUMN)
    for emotion, number in zip(EMOTIONS, range(3, 9), strict=True):
        assert CATALOGUE[f"{emotion}-frames"].paper == f"Fig. {number}"


def test_figures_page_lists_command_and_function_of_each_figure() -> None:
    page = (ROOT / "docs" / "figures.md").read_text()
    rows = re.findall(
        r"^\| [^|]+ \| ([^|]+) \| `emovid figures ([^`]+)` \| `([^`]+)`: `([^`]+)` \|$", page, re.MULTILINE
    )
    assert [name for _, name, _, _ in rows] == NAMES
    for paper, name, path, function in rows:
        entry = CATALOGUE[name]
        assert paper == (entry.paper or "none")
        module = importlib.import_module(path.removesuffix(".py").replace("/", "."))
        assert getattr(module, function) is (entry.draw or table_latex)
    others = re.findall(
        r"^\| [^|`]+ \| `emovid figures ([a-z-]+)[^`]*` \| `([^`]+)`: `([^`]+)` \|$", page, re.MULTILINE
    )
    assert [name for name, _, _ in others] == [FRAMES, CONTACT, GALLERY]
    for _, path, function in others:
        assert callable(getattr(importlib.import_module(path.removesuffix(".py").replace("/", ".")), function))


def test_inputs_of_figures_are_computed_once(monkeypatch) -> None:
    made = []
    monkeypatch.setattr("emovid.figures.run_cache.simulate", lambda scene: made.append(scene) or simulate(scene))
    material = Material(
        [Setting("duration", 1, "test"), Setting("seed", 7, "test")], {"x": lambda _: made.append("x") or 5}
    )
    assert material.run("fear") is material.run("fear")
    assert (material.scene("fear").duration, material.scene("fear").seed) == (1, 7)
    assert (material.table("x"), material.table("x")) == (5, 5)
    assert made == [material.scene("fear"), "x"]


def test_missing_group_or_other_labels_are_reported(material) -> None:
    results = replace(material.table(STUDY), groups={}, emotions=("awe",))
    other = Material(tables={STUDY: lambda _: results})
    with pytest.raises(InputError, match="the study has no group gender; its groups: none"):
        CATALOGUE["accuracy-gender"].figure(other)
    with pytest.raises(InputError, match="no place on the circumplex for awe"):
        CATALOGUE["circumplex"].figure(other)
