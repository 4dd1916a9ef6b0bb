import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from emovid.errors import SourceError
from emovid.scene.model import Scene
from emovid.swarm import start
from emovid.swarm.clearance import room_on_stage
from emovid.swarm.laws import followed_points, start_angles
from emovid.swarm.simulate import simulate
from emovid.swarm.start import _most, start_poses
from emovid.swarm.unicycle import look_ahead
from tests.helpers.stages import HEXAGON, THIN, TRIANGLE, keys_of


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("emotion", ["happiness", "surprise", "sadness"])
def test_look_ahead_points_start_on_the_contour(make_scene, emotion) -> None:
    scene = make_scene(emotion, {"start": {"place": "contour"}})
    poses = start_poses(scene, rng())
    expected = followed_points(scene.behaviour, start_angles(15), 0.0)
    assert look_ahead(poses, scene.robot.l) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("emotion", ["happiness", "sadness"])
def test_settled_look_ahead_points_start_with_their_steady_lag(make_scene, emotion) -> None:
    scene = make_scene(emotion, {"start": {"place": "contour", "settled": True}})
    contour, K, theta_0 = scene.behaviour, scene.robot.K, start_angles(15)
    age = (np.arange(10_000) + 0.5) * (30 / K / 10_000)  # p(0) = int_0^inf K exp(-K s) x(-s) ds, by midpoints
    past = np.array([followed_points(contour, theta_0, -s) for s in age])
    expected = np.tensordot(K * np.exp(-K * age), past, axes=1) * (30 / K / 10_000)
    poses = start_poses(scene, rng())
    assert look_ahead(poses, scene.robot.l) == pytest.approx(expected, abs=1e-6)  # the midpoint rule's error is 1.3e-7
    ahead = followed_points(contour, theta_0, 0.0) - expected
    assert np.cos(poses[:, 2] - np.arctan2(ahead[:, 1], ahead[:, 0])) == pytest.approx(np.ones(15), abs=1e-9)


def test_a_single_integrator_starts_on_the_contour_itself(make_scene) -> None:
    scene = make_scene("sadness", {"robot.model": "single_integrator"})
    poses = start_poses(scene, rng())
    assert np.hypot(*poses[:, :2].T) == pytest.approx(np.full(15, scene.behaviour.R))


@pytest.mark.parametrize("seed", range(5))
def test_random_starts_keep_their_spacing_and_region(make_scene, seed) -> None:
    scene = make_scene("fear")
    poses = start_poses(scene, rng(seed))
    assert pdist(poses[:, :2]).min() >= 0.06
    assert (np.abs(poses[:, :2]) <= [0.45, 0.3]).all()


def test_random_starts_fill_the_stage_and_all_headings(make_scene) -> None:
    scene = make_scene("anger", {"robots": 100, "start.min_spacing": None})
    poses = np.concatenate([start_poses(scene, rng(seed)) for seed in range(20)])
    radius = scene.robot.body.radius
    # Uniform over the stage minus the body: means 0, variances (2 half)^2 / 12; spacing only makes it more even.
    half = np.array([0.6 - radius, 0.4 - radius])
    assert np.abs(poses[:, :2].mean(axis=0)) == pytest.approx([0, 0], abs=0.02)
    assert poses[:, :2].std(axis=0) == pytest.approx(half / np.sqrt(3), rel=0.06)
    assert np.hypot(np.cos(poses[:, 2]).mean(), np.sin(poses[:, 2]).mean()) < 0.06


def test_starts_depend_on_the_seed(make_scene) -> None:
    scene = make_scene("anger")
    assert np.array_equal(start_poses(scene, rng(1)), start_poses(scene, rng(1)))
    assert not np.array_equal(start_poses(scene, rng(1)), start_poses(scene, rng(2)))


def test_listed_poses_are_used_unchanged(make_scene) -> None:
    poses = [{"x": 0.1, "y": -0.2, "heading": 1.0}, {"x": 0.3, "y": 0.0}]
    scene = make_scene("fear", {"robots": 2, "start": {"place": "poses", "poses": poses}})
    assert start_poses(scene, rng()) == pytest.approx(np.array([[0.1, -0.2, 1.0], [0.3, 0.0, 0.0]]))


def test_headings_are_within_half_a_turn_from_the_first_sample(make_scene) -> None:
    poses = [{"x": 0.0, "y": 0.0, "heading": 1000.0}, {"x": 0.2, "y": 0.0, "heading": -np.pi}]
    listed = make_scene("fear", {"start": {"place": "poses", "poses": poses}, "robots": 2, "duration": 0.1})
    on_contour = make_scene("happiness", {"duration": 0.1, "robots": 5})
    for scene in (listed, on_contour):
        headings = simulate(scene).poses[..., 2]
        assert ((headings > -np.pi) & (headings <= np.pi)).all()
    assert np.cos(start_poses(listed, rng())[:, 2] - [1000.0, np.pi]) == pytest.approx([1, 1], abs=1e-12)


def test_listed_bodies_may_not_overlap(make_scene) -> None:
    poses = [{"x": 0.0, "y": 0.0}, {"x": 0.03, "y": 0.0}]
    scene = make_scene("fear", {"robots": 2, "start": {"place": "poses", "poses": poses}})
    with pytest.raises(SourceError, match=r"robots 1 and 2 would start 30 mm apart, and need 43.3 mm"):
        start_poses(scene, rng())


def test_too_small_distance_is_reported_with_enough_digits(make_scene) -> None:
    keys = {"robots": 14, "behaviour.R": 0.08815, "robot.l": 0.005}
    scene = make_scene("sadness", keys)
    behind = keys["robot.l"] - scene.robot.body.disc[0]
    apart = 2 * np.hypot(keys["behaviour.R"], behind) * np.sin(np.pi / 14)  # a chord of the circle of body centers
    with pytest.raises(SourceError) as caught:
        start_poses(scene, rng())
    found, needed = map(float, re.search(r"start (\S+) mm apart, and need (\S+) mm$", str(caught.value)).groups())
    assert found < needed
    assert found == pytest.approx(1000 * apart, abs=5e-4)


def test_look_ahead_that_moves_robots_too_close_is_named(make_scene) -> None:
    keys = {"robots": 18, "behaviour.R": 0.12, "behaviour.A": 0.06, "start.settled": False}
    message = r"robots 2 and 3 would start 37\.2 mm apart, and need 39\.3 mm; all would fit with a robot\.l near 0$"
    with pytest.raises(SourceError, match=message):
        start_poses(make_scene("happiness", keys | {"robot.l": 0.02}), rng())
    start_poses(make_scene("happiness", keys | {"robot.l": 0.0001}), rng())


def test_random_placement_ends_after_a_number_of_rounds(make_scene, monkeypatch) -> None:
    scene = make_scene("anger", {"robots": 60})
    assert len(start_poses(scene, rng())) == 60
    monkeypatch.setattr(start, "_ROUNDS", 1)
    with pytest.raises(SourceError, match=r"60 robots do not fit into .* at random .*: room was found for [2-5][0-9]$"):
        start_poses(scene, rng())


def test_thousand_robots_fit_on_a_large_stage(make_scene) -> None:
    scene = make_scene("anger", {"robots": 1000, "stage.width": 5.0, "stage.height": 4.0})
    assert pdist(start_poses(scene, rng())[:, :2]).min() >= 0.06


# --- stages of any shape ---------------------------------------------------------------------------------------------


def on_stage(make_scene, corners: list[tuple[float, float]], **keys: object) -> Scene:
    return make_scene("anger", {"stage": keys_of(corners), "behaviour.density": {"kind": "uniform"}} | keys)


@pytest.mark.parametrize("corners", [HEXAGON, TRIANGLE, THIN])
def test_random_starts_are_on_a_stage_of_any_shape(make_scene, corners) -> None:
    scene = on_stage(make_scene, corners, robots=8)
    points = np.concatenate([start_poses(scene, rng(seed))[:, :2] for seed in range(20)])
    room = room_on_stage(points, scene.stage)
    assert room.min() >= scene.robot.body.radius - 1e-9
    assert room.min() < scene.robot.body.radius + 0.01  # up to the edge


def test_random_starts_are_uniform_on_a_triangle(make_scene) -> None:
    corners = np.array([[1.0, -1.0], [4.0, -1.0], [1.0, 3.0]])  # 3-4-5: its circle is about (2, 0), of radius 1
    scene = on_stage(make_scene, corners.tolist(), robots=100, **{"start.min_spacing": None})
    poses = np.concatenate([start_poses(scene, rng(seed))[:, :2] for seed in range(20)])
    # The area for body centers is a smaller, similar triangle with the same incenter.
    inside = [2, 0] + (1 - scene.robot.body.radius) * (corners - [2, 0])
    middle = inside.mean(axis=0)
    # A triangle's covariance is that of its corners, over 4: the minimal spacing only makes the starts more even.
    covariance = (inside - middle).T @ (inside - middle) / 12
    assert poses.mean(axis=0) == pytest.approx(middle, abs=0.05)
    assert np.cov(poses.T) == pytest.approx(covariance, rel=0.06)


def test_slanted_thin_stage_is_filled(make_scene) -> None:
    # 20 m long and 0.1 m wide: one random point in 160 of its bounding box is free.
    along, across = np.array([np.sqrt(0.5), np.sqrt(0.5)]), np.array([-np.sqrt(0.5), np.sqrt(0.5)])
    corners = [(i * along + j * across).tolist() for i, j in ((-10, -0.05), (10, -0.05), (10, 0.05), (-10, 0.05))]
    poses = start_poses(on_stage(make_scene, corners, robots=220), rng())
    assert pdist(poses[:, :2]).min() >= 0.06
    assert np.abs(poses[:, :2] @ along).max() > 9


def test_rectangle_given_by_corners_has_identical_starts(make_scene) -> None:
    corners = [(-0.6, 0.4), (0.6, 0.4), (0.6, -0.4), (-0.6, -0.4)]
    by_corners = make_scene("anger", {"stage": keys_of(corners)})
    assert np.array_equal(start_poses(by_corners, rng()), start_poses(make_scene("anger"), rng()))


@given(st.floats(0.01, 0.2), st.floats(0.0, 2.0), st.floats(0.0, 2.0))
def test_the_densest_lattice_has_no_more_points_than_the_bound(spacing, width, height) -> None:
    rows = int(height / (np.sqrt(3) / 2 * spacing)) + 1
    even, odd = int(width / spacing) + 1, int(np.floor(width / spacing - 0.5)) + 1
    assert (rows + 1) // 2 * even + rows // 2 * odd <= _most(np.array([width, height]), spacing)
