from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.measure.arrangement import crowding, order
from emovid.measure.window import Window
from tests.helpers.driven import driven, ring, standing

TRIANGLE = [{"x": 0.0, "y": 0.0}, {"x": 0.9, "y": 0.0}, {"x": 0.0, "y": 1.2}]  # sides 0.9, 1.2 and 1.5


def of(run) -> dict[str, float]:
    return crowding(Window(run, 0.0, float(run.t[-1])))


def test_distances_between_robots_on_a_rectangle(make_scene) -> None:
    points = [[0.5, 0.0], [0.3, 0.0], [-0.3, 0.0], [-0.3, 0.3]]
    found = of(standing(make_scene("fear", {"robots": 4}), points))
    assert found["nearest_neighbour_mean"] == pytest.approx((0.2 + 0.2 + 0.3 + 0.3) / 4)
    assert found["distance_to_centre_mean"] == pytest.approx((0.5 + 0.3 + 0.3 + np.hypot(0.3, 0.3)) / 4)
    assert found["distance_to_boundary_mean"] == pytest.approx((0.1 + 0.3 + 0.3 + 0.1) / 4)


def test_distances_between_robots_on_a_triangle(make_scene) -> None:
    keys = {
        "stage": {"corners": TRIANGLE},
        "robots": 1,
        "start": {"place": "stage"},
        "behaviour.density": {"kind": "uniform"},
    }
    scene = make_scene("fear", keys)
    incentre_run = standing(scene, [[0.3, 0.3]])
    area, diagonal, centre = Window(incentre_run, 0.0, 0.1).stage
    assert (area, diagonal) == pytest.approx((0.54, 1.5))
    assert centre == pytest.approx([0.3, 0.4])
    incentre = of(incentre_run)
    assert incentre["distance_to_boundary_mean"] == pytest.approx(0.3)
    assert incentre["distance_to_centre_mean"] == pytest.approx(0.1)


@pytest.mark.parametrize("way", [1, -1])
def test_rotating_ring_has_rotation_but_no_polarization(make_scene, way) -> None:
    angle = 2 * np.pi * np.arange(15) / 15
    start = np.column_stack([ring(15, 0.2), angle + np.pi / 2])
    found = of(driven(make_scene("fear"), start, np.tile([way * 0.2, way], (20, 15, 1)), 0.1))
    assert found["rotation"] == pytest.approx(1)
    assert found["polarisation"] == pytest.approx(0, abs=1e-9)
    assert found["nearest_neighbour_mean"] == pytest.approx(0.4 * np.sin(np.pi / 15))
    assert found["nearest_neighbour_growth"] == pytest.approx(0, abs=1e-9)


def test_reversing_robots_count_with_their_direction_of_motion(make_scene) -> None:
    points = ring(6, 0.2)
    heading = np.array([0, np.pi] * 3)
    commands = np.stack([np.where(heading > 0, -0.1, 0.1), np.zeros(6)], axis=-1)
    run = driven(make_scene("fear", {"robots": 6}), np.column_stack([points, heading]), [commands] * 5, 0.2)
    assert of(run)["polarisation"] == pytest.approx(1)


def test_stationary_robots_have_no_direction(make_scene) -> None:
    commands = np.zeros((5, 4, 2))
    commands[:, 0, 0] = 0.1
    commands[:, 1] = [1e-6, 3]
    some = driven(make_scene("fear", {"robots": 4}), np.column_stack([ring(4, 0.2), np.zeros(4)]), commands, 0.2)
    assert of(some)["polarisation"] == pytest.approx(1)  # of the one moving robot
    none = of(standing(make_scene("fear", {"robots": 4}), ring(4, 0.2)))
    assert isnan(none["polarisation"])
    assert isnan(none["rotation"])


def test_single_robot_has_no_neighbor_distance_and_no_radius(make_scene) -> None:
    found = of(driven(make_scene("fear", {"robots": 1}), [[0, 0, 0]], [[[0.1, 0]]] * 5, 0.2))
    assert isnan(found["nearest_neighbour_mean"])
    assert isnan(found["rotation"])
    assert found["polarisation"] == pytest.approx(1)


@given(seed=st.integers(0, 10_000), angle=st.floats(0, 2 * np.pi), mirror=st.booleans())
def test_order_measures_do_not_depend_on_position_and_robot_order(seed, angle, mirror) -> None:
    rng = np.random.default_rng(seed)
    points, heading = rng.uniform(-1, 1, (3, 7, 2)), rng.uniform(-np.pi, np.pi, (3, 7))
    velocities = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag(
        [1, -1 if mirror else 1]
    )
    who = rng.permutation(7)
    moved = order((points @ turn.T + rng.uniform(-1, 1, 2))[:, who], (velocities @ turn.T)[:, who])
    for found, expected in zip(moved, order(points, velocities), strict=True):
        assert found == pytest.approx(expected)
        assert (found <= 1 + 1e-12).all()
