import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.scene.behaviour import Uniform
from emovid.scene.stage import Rectangle
from emovid.swarm import voronoi
from emovid.swarm.densities import density_of
from emovid.swarm.laws import corners_of, mass_and_centroid
from emovid.swarm.voronoi import clipped_cells, voronoi_cells
from tests.helpers.polygons import area, mirrored_voronoi, shoelace
from tests.helpers.stages import HEXAGON, THIN, TRIANGLE, convex_corners

STAGE = Rectangle(width=1.2, height=0.8)
CORNERS = corners_of(STAGE)
CONSTANT = density_of(Uniform(kind="uniform"), STAGE)
# A coarse grid makes coincident points, points on a line or a circle, and points on the edge likely.
POINT = st.tuples(st.integers(-12, 12), st.integers(-8, 8)).map(lambda p: (p[0] / 20, p[1] / 20))


def areas(cells: np.ndarray) -> np.ndarray:
    x, y = np.moveaxis(cells - cells[:, :1], -1, 0)
    return np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1) / 2


def uniform(robots: int, seed: int, corners: np.ndarray = CORNERS) -> np.ndarray:
    """Return random points in a convex polygon."""
    shares = np.random.default_rng(seed).dirichlet(np.ones(len(corners)), robots)
    return shares @ corners


def assert_cells_are_those_of_cutting(points: np.ndarray, corners: np.ndarray, about: float = 1e-12) -> None:
    """Compare areas, and centroids within `about`, with clipping; lengths are in units of the stage extent."""
    distinct, which = np.unique(points, axis=0, return_inverse=True)
    robots = distinct[:, 0] + 1j * distinct[:, 1]
    cut = [np.stack([ring.real, ring.imag], 1) for ring in clipped_cells(robots, corners[:, 0] + 1j * corners[:, 1])]
    extent = np.ptp(corners, axis=0).max()
    area, centroid = mass_and_centroid(points, corners, CONSTANT)
    polygons = voronoi_cells(points, corners) - points[:, None]
    for i, k in enumerate(which):
        expected_area, expected = shoelace(cut[k])
        assert area[i] == pytest.approx(expected_area, abs=1e-14 * extent**2)
        assert areas(polygons[i : i + 1]) == pytest.approx([expected_area], abs=1e-9 * extent**2)
        if expected_area > 1e-6 * extent**2:
            assert centroid[i] - points[i] == pytest.approx(expected, abs=about * extent)


@pytest.mark.parametrize("robots", [2, 3, 15, 200, 3000])
def test_cells_agree_with_qhull(robots: int) -> None:
    points = np.random.default_rng(robots).uniform([-0.6, -0.4], [0.6, 0.4], (robots, 2))
    expected = [area(corners) for corners in mirrored_voronoi(points, 1.2, 0.8)]
    assert areas(voronoi_cells(points, CORNERS)) == pytest.approx(expected, rel=1e-9, abs=1e-14)


def test_wrong_triangulations_of_qhull_are_detected() -> None:
    # Twelve robots within a tenth of a micrometer: Qhull returns an invalid triangulation without an error.
    rng = np.random.default_rng(35)
    apart = rng.uniform([-0.6, -0.4], [0.6, 0.4], (12, 2))
    points = np.concatenate([apart, rng.normal(0, 1e-7, (12, 2))])
    with np.errstate(all="ignore"):
        assert voronoi._delaunay_links(points[:, 0] + 1j * points[:, 1]) is None
    assert_cells_are_those_of_cutting(points, CORNERS, about=1e-9)


def test_cell_of_one_robot_is_the_stage() -> None:
    assert voronoi_cells(np.array([[0.3, 0.1]]), CORNERS)[0] == pytest.approx(CORNERS)


def test_two_robots_share_the_stage_at_their_bisector() -> None:
    left, right = voronoi_cells(np.array([[-0.3, 0.0], [0.1, 0.0]]), CORNERS)
    assert left == pytest.approx(np.array([[-0.6, -0.4], [-0.1, -0.4], [-0.1, 0.4], [-0.6, 0.4]]))
    assert right == pytest.approx(np.array([[-0.1, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.1, 0.4]]))


@given(st.lists(POINT, min_size=1, max_size=40), st.sampled_from([1, 100]))
def test_cells_agree_with_pairwise_clipping_and_qhull(points: list[tuple[float, float]], few: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(voronoi, "_FEW", few)
        assert_cells_are_those_of_cutting(np.array(points), CORNERS)


@given(st.integers(1, 20), st.integers(-17, -3), st.integers(0, 1000))
def test_small_swarms_allow_arbitrarily_close_robots(robots: int, digits: int, seed: int) -> None:
    points = uniform(robots, seed)
    twins = points + np.random.default_rng(seed).normal(size=points.shape) * 10.0**digits
    swarm = np.concatenate([points, np.clip(twins, CORNERS[0], CORNERS[2])])[: voronoi._FEW]
    assert_cells_are_those_of_cutting(swarm, CORNERS, about=1e-11)


def test_interior_robot_has_a_cell_inside_the_stage() -> None:
    angle = np.arange(6) * np.pi / 3
    points = np.concatenate([[[0.1, 0.0]], 0.2 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [0.1, 0.0]])
    # A regular hexagon with an inradius of 0.1.
    assert areas(voronoi_cells(points, CORNERS))[0] == pytest.approx(2 * np.sqrt(3) * 0.1**2, rel=1e-12)
    assert_cells_are_those_of_cutting(points, CORNERS)


@given(st.lists(POINT, min_size=1, max_size=40, unique=True))
def test_cells_partition_the_stage(points: list[tuple[float, float]]) -> None:
    cells = voronoi_cells(np.array(points), CORNERS)
    assert areas(cells).sum() == pytest.approx(0.96, abs=1e-12)


@given(st.lists(POINT, min_size=2, max_size=30), st.tuples(st.floats(-0.6, 0.6), st.floats(-0.4, 0.4)))
def test_points_lie_in_the_cell_of_their_nearest_robot(
    points: list[tuple[float, float]], place: tuple[float, float]
) -> None:
    robots = np.array(points)
    nearest = int(np.argmin(np.hypot(*(robots - place).T)))
    cell = voronoi_cells(robots, CORNERS)[nearest]
    edges = np.roll(cell, -1, axis=0) - cell
    beside = edges[:, 0] * (place[1] - cell[:, 1]) - edges[:, 1] * (place[0] - cell[:, 0])
    assert (beside >= -1e-12).all()


@given(convex_corners(), st.integers(1, 30), st.integers(0, 1000), st.booleans())
def test_cells_tile_any_convex_stage(
    corners: list[tuple[float, float]], robots: int, seed: int, cornered: bool
) -> None:
    stage = np.array(corners)
    points = uniform(robots, seed, stage)
    if cornered:
        points = np.concatenate([points, stage, (stage + np.roll(stage, 1, axis=0)) / 2])
    assert areas(voronoi_cells(points, stage)).sum() == pytest.approx(shoelace(stage)[0], rel=1e-12)
    assert_cells_are_those_of_cutting(points, stage, about=1e-11)


@pytest.mark.parametrize("corners", [TRIANGLE, HEXAGON, THIN])
def test_cell_of_one_robot_is_the_polygon(corners: list[tuple[float, float]]) -> None:
    stage = np.array(corners)
    (cell,) = voronoi_cells(stage.mean(axis=0)[None], stage)
    found_area, centroid = shoelace(cell)
    expected_area, expected = shoelace(stage)
    assert found_area == pytest.approx(expected_area, rel=1e-12)
    assert centroid == pytest.approx(expected, abs=1e-12)


def test_coincident_robots_share_a_cell() -> None:
    points = np.array([[0.1, 0.1], [-0.3, 0.0], [0.1, 0.1]])
    cells = voronoi_cells(points, CORNERS)
    assert np.array_equal(cells[0], cells[2])
    assert areas(cells)[1:].sum() == pytest.approx(0.96)


def test_robots_at_one_position_share_the_whole_stage() -> None:
    assert areas(voronoi_cells(np.full((20, 2), 0.1), CORNERS)) == pytest.approx(np.full(20, 0.96))


@pytest.mark.parametrize("robots", [2, 3, 15, 41])
@pytest.mark.parametrize("end", [(0.6, 0.0), (0.0, 0.4), (0.6, 0.4)])
def test_robots_on_a_line_cut_the_stage_into_strips(end: tuple[float, float], robots: int) -> None:
    points = np.linspace(-1, 1, robots)[:, None] * end
    assert_cells_are_those_of_cutting(points, CORNERS)


@pytest.mark.parametrize("robots", [3, 4, 15, 20, 60])
def test_robots_on_a_circle_have_its_sectors(robots: int) -> None:
    angle = np.arange(robots) * 2 * np.pi / robots
    points = 0.3 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert_cells_are_those_of_cutting(points, CORNERS)


@pytest.fixture
def cuttings(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Record each use of the clipping fallback: the numbers of robots."""
    calls: list[int] = []

    def counted(robots: np.ndarray, outline: np.ndarray) -> list[np.ndarray]:
        calls.append(len(robots))
        return clipped_cells(robots, outline)

    monkeypatch.setattr(voronoi, "clipped_cells", counted)
    return calls


@pytest.mark.parametrize("share", [1.0, 0.25, 1e-3, 1e-6])
def test_ten_thousand_close_robots_need_no_fallback(share: float, cuttings: list[int]) -> None:
    points = share * uniform(10_000, 2) + [0.1, 0.2] * np.array(1 - share)
    cells = voronoi_cells(points, CORNERS)
    assert areas(cells).sum() == pytest.approx(0.96, abs=1e-12)
    assert not cuttings


def test_lattice_with_robots_on_the_edge_needs_no_fallback(cuttings: list[int]) -> None:
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 101), np.linspace(-0.4, 0.4, 81))
    found = areas(voronoi_cells(np.stack([x.ravel(), y.ravel()], axis=1), CORNERS)).reshape(x.shape)
    assert found[1:-1, 1:-1] == pytest.approx(np.full((79, 99), 0.012 * 0.01), rel=1e-9)
    assert found[0, 0] == pytest.approx(0.006 * 0.005, rel=1e-9)
    assert not cuttings


@pytest.mark.parametrize("apart", [1e-4, 1e-7, 1e-9, 1e-12, 1e-15])
def test_adjacent_robots_halve_their_common_cell(apart: float) -> None:
    points = np.concatenate([uniform(30, 4), [[0.1, 0.05], [0.1 + apart, 0.05]]])
    assert_cells_are_those_of_cutting(points, CORNERS)


@pytest.mark.parametrize("size", [1e-3, 1e-5, 1e-7, 1e-9])
def test_crowd_below_the_resolution_of_qhull_uses_the_fallback(size: float, cuttings: list[int]) -> None:
    crowd = np.random.default_rng(3).normal([0.3, 0.1], size, (25, 2))
    points = np.concatenate([crowd, [[-0.5, -0.3], [-0.2, 0.35]]])
    assert_cells_are_those_of_cutting(points, CORNERS)
    assert bool(cuttings) == (size < 1e-6)


def test_robot_rounded_beyond_the_edge_may_have_no_cell() -> None:
    points = np.array([[0.6, 0.0], [np.nextafter(0.6, 1), 0.0], [0.0, 0.0]])
    cells = voronoi_cells(points, CORNERS)
    assert areas(cells) == pytest.approx([0.3 * 0.8, 0.0, 0.9 * 0.8])
    assert cells[1] == pytest.approx(np.tile(points[1], (cells.shape[1], 1)))


def test_equal_points_give_bitwise_equal_cells() -> None:
    points = uniform(2000, 5)
    assert np.array_equal(voronoi_cells(points, CORNERS), voronoi_cells(points.copy(), CORNERS))
