"""Every figure matches its accepted image; `make golden` accepts the current figures."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Text
from PIL import Image

from emovid.figures.catalogue import CATALOGUE, Entry
from emovid.scene.load import load_scene, scene_text
from emovid.swarm.files import load_trajectory
from emovid.swarm.simulate import simulate
from emovid.swarm.start import start_poses
from tests.helpers.golden import (
    FOLDER,
    SMALLER,
    TOLERANCE,
    GoldenMaterial,
    difference_picture,
    differences,
    image_of,
    small,
    stored_run,
)

DRAWN = [name for name, entry in CATALOGUE.items() if entry.draw]
SCENES = sorted({name for entry in CATALOGUE.values() for name in entry.emotions})
ALIKE = 1e-3  # m: rounding grows to 1e-6 m in the first second of anger, the most chaotic scene


@pytest.fixture(scope="module")
def material() -> GoldenMaterial:
    return GoldenMaterial()


def check(name: str, drawn: np.ndarray, golden: np.ndarray, folder: Path) -> None:
    """Fail and write a picture of the differences unless a figure matches its golden image."""
    alike = drawn.shape == golden.shape and np.abs(differences(drawn, golden)).max() <= TOLERANCE
    if not alike:
        shown = folder / f"{name}-difference.png"
        difference_picture(drawn, golden).save(shown)
        pytest.fail(f"{name} looks otherwise: see {shown}; if it is right so, run make golden")


def golden_image(name: str) -> np.ndarray:
    return np.asarray(Image.open(image_of(name)).convert("RGB"))


@pytest.mark.parametrize("name", DRAWN)
def test_figure_matches_its_golden_image(name, material, tmp_path) -> None:
    check(name, small(CATALOGUE[name], material), golden_image(name), tmp_path)


def test_golden_folder_has_one_image_per_figure_and_one_run_per_coverage_scene(material) -> None:
    runs = {stored_run(name) for name in SCENES if material.is_stored(name)}
    assert set(FOLDER.iterdir()) == runs | {image_of(name) for name in DRAWN}
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < 1_000_000


def test_stored_runs_match_the_shipped_scenes(material) -> None:
    for name in filter(material.is_stored, SCENES):
        scene, stored, t = load_scene(name), load_trajectory(stored_run(name)), np.linspace(0, 1, 11)
        assert scene_text(stored.scene) == scene_text(scene), f"{name}: run make golden"
        now = simulate(
            scene.model_copy(update={"duration": 1.5})
        )  # the shorter last period limits the commands differently
        assert stored.at(t)[..., :2] == pytest.approx(now.at(t)[..., :2], abs=ALIKE), f"{name}: run make golden"


@pytest.mark.parametrize("name", ["sadness-frames", "robotarium-perspective", "densities", "descriptors"])
def test_golden_images_tolerate_rounding_differences(name, monkeypatch, tmp_path) -> None:
    def displaced(scene, rng):
        return start_poses(scene, rng) + np.random.default_rng(1).normal(0, 1e-12, (scene.robots, 3))

    monkeypatch.setattr("emovid.swarm.simulate.start_poses", displaced)
    monkeypatch.setattr("emovid.figures.control_laws.start_poses", displaced)
    check(name, small(CATALOGUE[name], GoldenMaterial()), golden_image(name), tmp_path)


def changed(name: str, change) -> Entry:
    """Return a figure that is modified after drawing."""
    entry = CATALOGUE[name]

    def draw(*parts, width):
        figure = entry.draw(*parts, width=width)
        change(figure)
        return figure

    return entry._replace(draw=draw)


def without_trails(figure) -> None:
    figure.axes[2].collections[0].set_visible(False)


def with_another_digit(figure) -> None:
    (text,) = [text for text in figure.findobj(Text) if text.get_text() == "26"]
    text.set_text("28")


@pytest.mark.parametrize(("name", "change"), [("sadness-frames", without_trails), ("circumplex", with_another_digit)])
def test_small_changes_are_detected_and_shown(name, change, material, tmp_path) -> None:
    with pytest.raises(pytest.fail.Exception, match=f"{name} looks otherwise: see {tmp_path}"):
        check(name, small(changed(name, change), material), golden_image(name), tmp_path)
    shown = np.asarray(Image.open(tmp_path / f"{name}-difference.png"))
    height, width = golden_image(name).shape[:2]
    assert shown.shape == (3 * height, width, 3)
    assert (shown[2 * height :] < 128).any()
    assert (shown[2 * height :] == 255).mean() > 0.9


def test_comparison_tolerates_one_dot_but_not_another_size(material, tmp_path) -> None:
    (png,) = CATALOGUE["shapes"].files(material, ["png"])
    (tmp_path / "large.png").write_bytes(png)
    large = np.asarray(Image.open(tmp_path / "large.png").convert("RGB"))
    moved = np.asarray(Image.fromarray(np.roll(large, 1, axis=1)).reduce(SMALLER))
    check("shapes", moved, golden_image("shapes"), tmp_path)
    with pytest.raises(pytest.fail.Exception):
        check("shapes", moved[:-1], golden_image("shapes"), tmp_path)
