from math import isnan

import numpy as np
import pytest

from emovid.measure.convergence import convergence, mean_cost
from emovid.measure.window import Window
from emovid.swarm.densities import density_of
from emovid.swarm.laws import corners_of, lloyd
from emovid.swarm.simulate import simulate
from tests.helpers.driven import driven, standing


def of(run) -> dict[str, float]:
    return convergence(Window(run, 0.0, float(run.t[-1])))


def of_stage(scene):
    return corners_of(scene.stage), density_of(scene.behaviour.density, scene.stage)


def summed_cost(points: np.ndarray, phi) -> float:
    """Return the mean cost on the shipped stage as a sum over small squares."""
    x, y = np.meshgrid((np.arange(600) + 0.5) / 500 - 0.6, (np.arange(400) + 0.5) / 500 - 0.4)
    weight = phi(x, y)
    square = np.min([(x - p) ** 2 + (y - q) ** 2 for p, q in points], axis=0)
    return float((weight * square).sum() / weight.sum())


@pytest.mark.parametrize("emotion", ["fear", "disgust", "anger"])
@pytest.mark.parametrize("robots", [1, 2, 15])
def test_mean_cost_is_the_mean_square_distance_to_the_density(make_scene, emotion, robots) -> None:
    corners, density = of_stage(make_scene(emotion))
    points = np.random.default_rng(robots).uniform([-0.6, -0.4], [0.6, 0.4], (robots, 2))
    assert mean_cost(points, corners, density) == pytest.approx(summed_cost(points, density.phi), rel=1e-3)


def test_cost_of_one_central_robot_is_that_of_the_stage(make_scene) -> None:
    found = of(standing(make_scene("fear", {"robots": 1}), [[0, 0]]))
    assert found["cost_end"] == pytest.approx((1.2**2 + 0.8**2) / 12)
    assert found["cost_ratio"] == pytest.approx(1)
    assert isnan(found["cost_progress"])  # no iteration was necessary
    assert found["overshoot_share"] == 0


def test_two_robots_converge_to_the_centers_of_the_halves(make_scene) -> None:
    scene = make_scene("fear", {"robots": 2})
    found = of(standing(scene, [[0.1, 0.05], [0.2, -0.1]]))
    assert found["cost_converged"] == pytest.approx((0.6**2 + 0.8**2) / 12, rel=1e-4)
    assert found["cost_progress"] == 0
    settled = lloyd(np.array([[0.1, 0.05], [0.2, -0.1]]), *of_stage(scene), gain=1e-12)
    assert np.abs(settled) == pytest.approx(np.array([[0.3, 0], [0.3, 0]]), abs=1e-4)


def test_lloyd_iteration_stops_without_progress(make_scene) -> None:
    stage = of_stage(make_scene("fear"))
    start = np.array([[0.1, 0.05], [0.2, -0.1]])
    assert lloyd(start, *stage, gain=0.0) == pytest.approx(lloyd(start, *stage, gain=1e-15), abs=1e-6)


def test_coincident_robots_have_the_mean_cost_of_one(make_scene) -> None:
    points = np.array([[0.1, 0.05], [0.2, -0.1]])
    corners, density = of_stage(make_scene("fear"))
    assert mean_cost(points[[0, 1, 1]], corners, density) == pytest.approx(mean_cost(points, corners, density))


@pytest.mark.parametrize("emotion", ["fear", "disgust", "anger"])
def test_lloyd_iteration_decreases_the_cost_and_ends_at_the_centroids(make_scene, emotion) -> None:
    run = simulate(make_scene(emotion, {"duration": 4}))
    found = of(run)
    assert found["cost_start"] > found["cost_end"] > found["cost_converged"] > 0
    assert found["cost_ratio"] == pytest.approx(found["cost_end"] / found["cost_converged"])
    corners, density = of_stage(run.scene)
    settled = lloyd(run.poses[-1, :, :2], corners, density, gain=1e-6 * found["cost_end"])
    again = lloyd(settled, corners, density, gain=1e-9 * found["cost_end"])
    assert mean_cost(again, corners, density) == pytest.approx(found["cost_converged"], rel=1e-3)
    assert np.hypot(*(again - settled).T).max() < 0.02


def test_overshoot_is_the_part_of_a_step_beyond_the_centroid(make_scene) -> None:
    # One robot with its centroid in the middle: 50 mm past it, back to it, away from it, 3 mm past it (too little).
    scene = make_scene("fear", {"robots": 1})
    commands = [[[0.15, 0]], [[-0.05, 0]], [[0.02, 0]], [[-0.023, 0]]]
    found = of(driven(scene, [[-0.1, 0, 0]], commands, 1.0))
    assert found["overshoot_share"] == pytest.approx(1 / 4)
    assert found["overshoot_mean"] == pytest.approx(0.05)


def test_overshoot_of_a_passing_robot_is_measured_along_the_line_to_the_centroid(make_scene) -> None:
    found = of(driven(make_scene("fear", {"robots": 1}), [[-0.1, 0, np.pi / 4]], [[[0.2, 0]]], 1.0))
    assert found["overshoot_mean"] == pytest.approx(0.2 * np.cos(np.pi / 4) - 0.1)


def test_anger_overshoots_and_fear_does_not(make_scene) -> None:
    anger, fear = (of(simulate(make_scene(emotion, {"duration": 6}))) for emotion in ("anger", "fear"))
    assert anger["overshoot_share"] > 0.2
    assert anger["overshoot_mean"] > 0.01
    assert fear["overshoot_share"] < 0.01


def test_overshoot_counts_only_complete_periods_in_the_window(make_scene) -> None:
    run = driven(make_scene("fear", {"robots": 1}), [[-0.1, 0, 0]], [[[0.15, 0]], [[-0.05, 0]], [[0.0, 0]]], 1.0)
    assert convergence(Window(run, 0.0, 1.0))["overshoot_share"] == 1
    assert convergence(Window(run, 0.5, 3.0))["overshoot_share"] == 0
    assert isnan(convergence(Window(run, 0.5, 1.2))["overshoot_share"])


def test_convergence_is_undefined_for_contours(make_scene) -> None:
    assert all(isnan(value) for value in of(simulate(make_scene("sadness", {"duration": 1}))).values())
