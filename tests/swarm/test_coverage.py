import numpy as np
import pytest
from scipy.special import erf

from emovid.scene.behaviour import Boundary, Coverage, Gaussian, Uniform
from emovid.scene.load import load_scene
from emovid.scene.stage import Rectangle
from emovid.swarm.densities import density_of
from emovid.swarm.laws import corners_of, coverage_velocity, mass_and_centroid
from emovid.swarm.voronoi import voronoi_cells
from tests.helpers.polygons import centroid_by_dblquad, shoelace
from tests.helpers.stages import HEXAGON, polygon

STAGE = Rectangle(width=1.2, height=0.8)
TOLERANCE = 1e-6 * np.hypot(1.2, 0.8)
GAUSSIAN = Gaussian(kind="gaussian", sigma=0.11)
BOUNDARY = Boundary(kind="boundary", width=0.06, inset=0.06)
UNIFORM = Uniform(kind="uniform")


def random_points(robots: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform([-0.6, -0.4], [0.6, 0.4], (robots, 2))


@pytest.mark.parametrize("robots", [1, 2, 4, 15])
@pytest.mark.parametrize("emotion", ["disgust", "anger"])
def test_centroids_of_the_shipped_densities_agree_with_dblquad(emotion: str, robots: int) -> None:
    law = load_scene(emotion).behaviour
    assert isinstance(law, Coverage)
    density = density_of(law.density, STAGE)
    points = random_points(robots, robots)
    cells = voronoi_cells(points, corners_of(STAGE))
    mass, centroid = mass_and_centroid(points, corners_of(STAGE), density)
    for i in range(min(robots, 4)):
        expected_mass, expected = centroid_by_dblquad(cells[i], density.phi)
        assert mass[i] == pytest.approx(expected_mass, rel=1e-5)
        assert np.hypot(*(centroid[i] - expected)) < TOLERANCE


@pytest.mark.parametrize("robots", [1, 2, 15, 500])
def test_uniform_centroids_are_exact(robots: int) -> None:
    points = random_points(robots, 7)
    cells = voronoi_cells(points, corners_of(STAGE))
    mass, centroid = mass_and_centroid(points, corners_of(STAGE), density_of(UNIFORM, STAGE))
    for i, cell in enumerate(cells):
        expected_area, expected = shoelace(cell)
        assert mass[i] == pytest.approx(expected_area, rel=1e-12)
        assert centroid[i] == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("sigma", [0.01, 0.03, 0.12, 0.5, 5.0])
def test_gaussian_over_the_stage_matches_its_closed_form(sigma: float) -> None:
    # Split at x = 0: each half's mass and mean are one-dimensional integrals of a Gaussian.
    density = density_of(Gaussian(kind="gaussian", sigma=sigma), STAGE)
    mass, centroid = mass_and_centroid(np.array([[0.3, 0.0], [-0.3, 0.0]]), corners_of(STAGE), density)
    root = sigma * np.sqrt(2)
    along_x = sigma * np.sqrt(np.pi / 2) * erf(0.6 / root)
    along_y = 2 * sigma * np.sqrt(np.pi / 2) * erf(0.4 / root)
    mean = sigma**2 * -np.expm1(-(0.6**2) / (2 * sigma**2)) / along_x
    assert mass == pytest.approx([along_x * along_y] * 2, rel=1e-6)
    assert centroid == pytest.approx(np.array([[mean, 0], [-mean, 0]]), abs=TOLERANCE)


def test_cell_far_in_the_tail_has_an_exact_centroid() -> None:
    # Beyond x = 0.55, 11 standard deviations out: mass 1e-27, mean just inside the cell's edge.
    density = density_of(Gaussian(kind="gaussian", sigma=0.05), STAGE)
    points = np.array([[0.58, 0.0], [0.52, 0.0]])
    cells = voronoi_cells(points, corners_of(STAGE))
    _, expected = centroid_by_dblquad(cells[0], lambda x, y: 1e24 * density.phi(x, y))
    assert mass_and_centroid(points, corners_of(STAGE), density)[1][0] == pytest.approx(expected, abs=TOLERANCE)


def test_densities_by_hand() -> None:
    x, y = np.array([0.0, 0.11, 0.54]), np.array([0.0, 0.0, 0.0])
    assert density_of(GAUSSIAN, STAGE).phi(x, y) == pytest.approx([1, np.exp(-0.5), np.exp(-0.5 * (0.54 / 0.11) ** 2)])
    ridge = density_of(BOUNDARY, STAGE).phi(x, y)
    assert ridge[2] == pytest.approx(1, abs=1e-6)  # on the crest: 60 mm inside the edge
    assert ridge[0] < 1e-6  # the center is far from every edge
    assert np.all(density_of(UNIFORM, STAGE).phi(x, y) == 1)


def test_a_corner_is_as_dense_as_an_edge() -> None:
    corner, edge = density_of(BOUNDARY, STAGE).phi(np.array([0.54, 0.54]), np.array([0.34, 0.0]))
    assert (corner, edge) == pytest.approx((1, 1), abs=1e-6)


def test_ridges_of_a_hexagon_by_hand() -> None:
    # Of a regular hexagon about the origin: at its center all six edges are an apothem away, at the middle of an edge
    # they are 0, 1/2, 1/2, 3/2, 3/2 and 2 apothems away.
    apothem = 0.6 * np.sqrt(3) / 2
    phi = density_of(Boundary(kind="boundary", width=0.2, inset=0.1), polygon(HEXAGON)).phi

    def ridge(distance: float) -> float:
        return float(np.exp(-((distance - 0.1) ** 2) / (2 * 0.2**2)))

    found = phi(np.array([0.0, 0.0]), np.array([0.0, apothem]))
    at_edge = np.prod([1 - ridge(k * apothem) for k in (0, 0.5, 0.5, 1.5, 1.5, 2)])
    assert found == pytest.approx([1 - (1 - ridge(apothem)) ** 6, 1 - at_edge], rel=1e-12)


def law(**keys: object) -> Coverage:
    return Coverage(law="coverage", **{"kappa": 2.0, "density": UNIFORM, **keys})  # type: ignore[arg-type]


def test_robots_move_toward_their_centroids() -> None:
    u = coverage_velocity(law(), STAGE, np.array([[0.0, 0.0], [0.4, 0.0]]))
    # The border is x = 0.2: cells centered on -0.2 and 0.4.
    assert u == pytest.approx(np.array([[-0.4, 0.0], [0.0, 0.0]]), abs=1e-12)


def test_speed_limit_keeps_the_direction() -> None:
    points = random_points(15, 3)
    free, capped = coverage_velocity(law(), STAGE, points), coverage_velocity(law(u_max=0.05), STAGE, points)
    speed = np.hypot(*free.T)
    assert np.hypot(*capped.T) == pytest.approx(np.minimum(speed, 0.05))
    assert free[:, 0] * capped[:, 1] == pytest.approx(free[:, 1] * capped[:, 0], abs=1e-15)


def test_robot_with_a_massless_cell_stays() -> None:
    points = np.array([[0.59, 0.39], [0.0, 0.0]])
    u = coverage_velocity(law(density=Gaussian(kind="gaussian", sigma=0.008)), STAGE, points)
    assert np.array_equal(u[0], [0.0, 0.0])
    assert np.isfinite(u).all()


def test_centroidal_configurations_are_stationary() -> None:
    # A 3 x 2 lattice of equal cells is a centroidal Voronoi configuration of the uniform density.
    lattice = np.array([[x, y] for x in (-0.4, 0.0, 0.4) for y in (-0.2, 0.2)])
    assert coverage_velocity(law(), STAGE, lattice) == pytest.approx(np.zeros((6, 2)), abs=1e-12)
