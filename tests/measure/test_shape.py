from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.measure.arrangement import hull_of, shape
from emovid.measure.window import Window
from tests.helpers.driven import driven, ring, standing


def of(run) -> dict[str, float]:
    return shape(Window(run, 0.0, float(run.t[-1])))


@pytest.fixture(scope="module")
def still(make_scene):
    return lambda points: of(standing(make_scene("fear", {"robots": len(points)}), points))


@pytest.mark.parametrize("robots", [3, 4, 15])
def test_a_ring_is_a_regular_polygon(still, robots) -> None:
    found = still(ring(robots, 0.2) + np.array([0.1, -0.05]))
    area = robots / 2 * 0.2**2 * np.sin(2 * np.pi / robots)
    assert found["radius_of_gyration_mean"] == pytest.approx(0.2)
    assert found["radius_of_gyration_diagonals"] == pytest.approx(0.2 / np.hypot(1.2, 0.8))
    assert found["hull_area_share_mean"] == pytest.approx(area / 0.96)
    assert found["hull_circularity"] == pytest.approx(np.pi / robots / np.tan(np.pi / robots))
    assert found["radius_spread"] == pytest.approx(0, abs=1e-12)
    assert found["radius_of_gyration_growth"] == pytest.approx(0, abs=1e-12)


def test_swarm_over_the_whole_stage_has_its_area(still) -> None:
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 61), np.linspace(-0.4, 0.4, 41))
    found = still(np.column_stack([x.ravel(), y.ravel()]))
    assert found["hull_area_share_mean"] == pytest.approx(1)
    assert found["hull_circularity"] == pytest.approx(4 * np.pi * 0.96 / 4**2)
    assert found["radius_of_gyration_mean"] == pytest.approx(np.sqrt((1.2**2 + 0.8**2) / 12), rel=0.05)


def test_growing_ring_has_growth_rate_of_speed_over_mean_radius(make_scene) -> None:
    outwards = 2 * np.pi * np.arange(15) / 15
    start = np.column_stack([ring(15, 0.1), outwards])
    found = of(driven(make_scene("fear"), start, np.tile([0.05, 0.0], (16, 15, 1)), 0.25))
    assert found["radius_of_gyration_start"] == pytest.approx(0.1)
    assert found["radius_of_gyration_end"] == pytest.approx(0.3)
    assert found["radius_of_gyration_growth"] == pytest.approx(0.05 / 0.2)
    assert found["hull_area_share_growth"] > 1.5 * found["radius_of_gyration_growth"]


@pytest.mark.parametrize("points", [[[0.1, 0.2]], [[0.1, 0.2]] * 3])
def test_coincident_robots_have_no_circularity_or_spread(still, points) -> None:
    found = still(np.array(points))
    assert found["radius_of_gyration_mean"] == pytest.approx(0, abs=1e-12)
    assert found["hull_area_share_mean"] == 0
    assert isnan(found["hull_circularity"])
    assert isnan(found["radius_spread"])


@pytest.mark.parametrize("points", [[[0, 0], [0.3, 0.1]], [[0, 0], [0.3, 0.1], [-0.3, -0.1], [0.15, 0.05]]])
def test_a_line_has_no_area(still, points) -> None:
    found = still(np.array(points))
    assert found["hull_area_share_mean"] == found["hull_circularity"] == pytest.approx(0, abs=1e-9)
    assert hull_of(np.array(points))[1] == pytest.approx(2 * np.hypot(*np.ptp(points, axis=0)))


@given(robots=st.integers(2, 20), seed=st.integers(0, 10_000), angle=st.floats(0, 2 * np.pi), mirror=st.booleans())
def test_size_and_roundness_do_not_depend_on_position_and_robot_order(make_scene, robots, seed, angle, mirror) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.3, 0.3, (robots, 2))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    other = rng.permutation(points * [1, -1 if mirror else 1] @ turn.T + rng.uniform(-1, 1, 2))
    scene = make_scene("fear", {"robots": robots})
    assert of(standing(scene, other)) == pytest.approx(of(standing(scene, points)), abs=1e-9, nan_ok=True)
