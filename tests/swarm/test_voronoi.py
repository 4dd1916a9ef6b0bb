import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from polygons import area, mirrored_voronoi, shoelace

from emovid.scene.stage import Rectangle
from emovid.swarm.coverage import corners_of
from emovid.swarm.voronoi import voronoi_cells

STAGE = Rectangle(width=1.2, height=0.8)
CORNERS = corners_of(STAGE)
# A coarse grid makes coincident points, points on a line, and points on the edge likely.
POINT = st.tuples(st.integers(-12, 12), st.integers(-8, 8)).map(lambda p: (p[0] / 20, p[1] / 20))


def areas(cells: np.ndarray) -> np.ndarray:
    return np.array([shoelace(cell)[0] for cell in cells])


@pytest.mark.parametrize("robots", [2, 3, 15, 200, 3000])
def test_cells_are_those_of_qhull(robots: int) -> None:
    points = np.random.default_rng(robots).uniform([-0.6, -0.4], [0.6, 0.4], (robots, 2))
    expected = [area(corners) for corners in mirrored_voronoi(points, 1.2, 0.8)]
    assert areas(voronoi_cells(points, CORNERS)) == pytest.approx(expected, rel=1e-9, abs=1e-14)


def test_one_robot_has_the_whole_stage() -> None:
    assert voronoi_cells(np.array([[0.3, 0.1]]), CORNERS)[0] == pytest.approx(CORNERS)


def test_a_clustered_swarm_needs_more_than_the_nearest_neighbours() -> None:
    # The point on the left is hemmed in by none of its nearest 32: its cell ends at the far ones.
    rng = np.random.default_rng(1)
    crowd = rng.normal([0.4, 0.0], 0.001, (100, 2))
    points = np.concatenate([[[0.0, 0.0]], crowd, [[-0.2, 0.0]]])
    expected = [area(corners) for corners in mirrored_voronoi(points, 1.2, 0.8)]
    assert areas(voronoi_cells(points, CORNERS)) == pytest.approx(expected, rel=1e-7, abs=1e-13)


@given(st.lists(POINT, min_size=1, max_size=40, unique=True))
def test_cells_partition_the_stage(points: list[tuple[float, float]]) -> None:
    cells = voronoi_cells(np.array(points), CORNERS)
    assert areas(cells).sum() == pytest.approx(0.96, abs=1e-12)


@given(st.lists(POINT, min_size=2, max_size=30), st.tuples(st.floats(-0.6, 0.6), st.floats(-0.4, 0.4)))
def test_a_place_lies_in_the_cell_of_its_nearest_robot(
    points: list[tuple[float, float]], place: tuple[float, float]
) -> None:
    robots = np.array(points)
    nearest = int(np.argmin(np.hypot(*(robots - place).T)))
    cell = voronoi_cells(robots, CORNERS)[nearest]
    edges = np.roll(cell, -1, axis=0) - cell
    beside = edges[:, 0] * (place[1] - cell[:, 1]) - edges[:, 1] * (place[0] - cell[:, 0])
    assert (beside >= -1e-12).all()


def test_coincident_robots_share_a_cell() -> None:
    points = np.array([[0.1, 0.1], [0.1, 0.1], [-0.3, 0.0]])
    cells = voronoi_cells(points, CORNERS)
    assert areas(cells[:1]) == pytest.approx(areas(cells[1:2]))
    assert areas(cells)[1:].sum() == pytest.approx(0.96)


def test_any_convex_stage_will_do() -> None:
    hexagon = np.stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)], axis=1)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (20, 2))
    assert areas(voronoi_cells(points, hexagon)).sum() == pytest.approx(shoelace(hexagon)[0], abs=1e-12)
