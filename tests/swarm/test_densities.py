from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.special import ndtr

from emovid.scene.load import Setting, load_scene
from emovid.swarm.densities import density_of

HALF = np.array([0.6, 0.4])  # of the shipped stages [m]


def phi(tmp_path: Path, density: dict, points: np.ndarray) -> np.ndarray:
    """Return a density on the stage of fear, 1.2 m x 0.8 m, at points (..., 2) [m]."""
    scene = load_scene("fear", [Setting("behaviour.density", located(tmp_path, density), "test")])
    return density_of(scene.behaviour.density, scene.stage).phi(points[..., 0], points[..., 1])


def located(tmp_path: Path, density: dict) -> dict:
    """Return the keys with pictures found in `tmp_path`."""
    keys = dict(density)
    if "file" in keys:
        keys["file"] = str(tmp_path / keys["file"])
    if "parts" in keys:
        keys["parts"] = [part | {"density": located(tmp_path, part["density"])} for part in keys["parts"]]
    return keys


def picture(folder: Path, dark: np.ndarray) -> dict:
    """Write a picture (rows, columns) of darkness from 0 to 1, and return its density keys."""
    Image.fromarray(np.round(255 * (1 - dark)).astype(np.uint8)).save(folder / "map.png")
    return {"kind": "image", "file": "map.png", "smoothing": 0.05}


def grid(count: int = 23) -> np.ndarray:
    x, y = (np.linspace(-half, half, count) for half in HALF)
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)


def test_black_picture_gives_density_one_up_to_the_corners(tmp_path) -> None:
    assert phi(tmp_path, picture(tmp_path, np.ones((3, 5))), grid()) == pytest.approx(1, abs=1e-6)


def test_an_edge_in_a_picture_is_smoothed_by_a_gaussian(tmp_path) -> None:
    # Black to the left of x = 0, where two of the 24 cells meet: peaks that are 0.05 m apart against the integral.
    dark = np.repeat([[1.0] * 60 + [0.0] * 60], 80, axis=0)
    points = grid()
    assert phi(tmp_path, picture(tmp_path, dark), points) == pytest.approx(ndtr(-points[..., 0] / 0.05), abs=0.025)


def test_picture_is_oriented_like_the_stage(tmp_path) -> None:
    dark = np.zeros((80, 120))
    dark[:20, 90:] = 1.0
    corners = np.array([[-0.55, -0.35], [0.55, -0.35], [0.55, 0.35], [-0.55, 0.35]])
    found = phi(tmp_path, picture(tmp_path, dark), corners)
    assert found[2] > 0.98
    assert found[[0, 1, 3]].max() < 1e-6


def test_density_is_independent_of_picture_resolution(tmp_path) -> None:
    x, y = np.meshgrid(np.linspace(-0.595, 0.595, 120), np.linspace(0.395, -0.395, 80))
    dark = 0.5 + 0.4 * np.sin(3 * x) * np.cos(4 * y)
    points = grid() * 0.6  # the formula does not hold outside the picture
    small = phi(tmp_path, picture(tmp_path, dark), points)
    large = phi(tmp_path, picture(tmp_path, np.kron(dark, np.ones((7, 7)))), points)
    assert large == pytest.approx(small, abs=0.004)
    smooth = 0.5 + 0.4 * np.exp(-0.5 * (9 + 16) * 0.05**2) * np.sin(3 * points[..., 0]) * np.cos(4 * points[..., 1])
    assert small == pytest.approx(smooth, abs=0.006)


def test_a_sum_is_the_weighted_sum_of_its_parts(tmp_path) -> None:
    peak = {"kind": "gaussian", "sigma": 0.1, "centre": {"x": 0.2, "y": -0.1}}
    ridge = {"kind": "boundary", "width": 0.08}
    spot = picture(tmp_path, np.eye(8))
    parts = [{"weight": 2.5, "density": peak}, {"density": ridge}, {"weight": 0.5, "density": spot}]
    expected = sum(w * phi(tmp_path, part, grid()) for w, part in ((2.5, peak), (1.0, ridge), (0.5, spot)))
    assert phi(tmp_path, {"kind": "sum", "parts": parts}, grid()) == pytest.approx(expected, rel=1e-12)


def test_length_scale_of_a_sum_is_that_of_its_finest_part(tmp_path) -> None:
    parts = [{"density": {"kind": "uniform"}}, {"density": {"kind": "gaussian", "sigma": 0.1}},
             {"density": {"kind": "boundary", "width": 0.03}}]  # fmt: skip
    scene = load_scene("fear", [Setting("behaviour.density", {"kind": "sum", "parts": parts}, "test")])
    assert density_of(scene.behaviour.density, scene.stage).scale == 0.03
