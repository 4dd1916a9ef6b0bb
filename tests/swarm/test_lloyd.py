import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad

from emovid.scene.behaviour import Boundary, Gaussian, Uniform
from emovid.scene.stage import Rectangle
from emovid.swarm.densities import density_of
from emovid.swarm.laws import corners_of, locational_cost, mass_and_centroid

STAGE = Rectangle(width=1.2, height=0.8)
CORNERS = corners_of(STAGE)
DENSITIES = {
    "uniform": density_of(Uniform(kind="uniform"), STAGE),
    "gaussian": density_of(Gaussian(kind="gaussian", sigma=0.1), STAGE),
    "boundary": density_of(Boundary(kind="boundary", width=0.06, inset=0.06), STAGE),
}


def random_points(robots: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform([-0.6, -0.4], [0.6, 0.4], (robots, 2))


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.2, -0.1), (0.6, 0.4)])
def test_cost_of_one_robot_is_the_polar_moment_of_the_stage(place: tuple[float, float]) -> None:
    # Of a rectangle about its center, A (w^2 + h^2) / 12; about another point, plus A d^2 (parallel axis theorem).
    x, y = place
    expected = 0.96 * ((1.2**2 + 0.8**2) / 12 + x**2 + y**2)
    assert locational_cost(np.array([place]), CORNERS, DENSITIES["uniform"]) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("kind", ["gaussian", "boundary"])
def test_cost_agrees_with_dblquad(kind: str) -> None:
    # Two robots share the stage at x = 0.
    phi = DENSITIES[kind].phi

    def integrand(y: float, x: float) -> float:
        return ((abs(x) - 0.3) ** 2 + y**2) * float(phi(np.array(x), np.array(y)))

    halves = [dblquad(integrand, *ends, -0.4, 0.4, epsabs=1e-11)[0] for ends in ((-0.6, 0.0), (0.0, 0.6))]
    points = np.array([[-0.3, 0.0], [0.3, 0.0]])
    assert locational_cost(points, CORNERS, DENSITIES[kind]) == pytest.approx(sum(halves), rel=1e-6)


@pytest.mark.parametrize("kind", DENSITIES)
@given(seed=st.integers(0, 10_000), robots=st.integers(1, 20), step=st.floats(0.01, 1.0))
def test_a_step_toward_the_centroids_never_raises_the_cost(kind: str, seed: int, robots: int, step: float) -> None:
    points = random_points(robots, seed)
    before = locational_cost(points, CORNERS, DENSITIES[kind])
    for _ in range(3):
        points = points + step * (mass_and_centroid(points, CORNERS, DENSITIES[kind])[1] - points)
        after = locational_cost(points, CORNERS, DENSITIES[kind])
        assert after <= before * (1 + 1e-9)
        before = after


def test_step_away_from_the_centroids_raises_the_cost() -> None:
    points = random_points(6, 1)
    away = points - 0.2 * (mass_and_centroid(points, CORNERS, DENSITIES["uniform"])[1] - points)
    assert locational_cost(away, CORNERS, DENSITIES["uniform"]) > locational_cost(points, CORNERS, DENSITIES["uniform"])


@pytest.mark.parametrize("kind", DENSITIES)
@pytest.mark.parametrize("robots", [1, 2, 10_000])
def test_cell_masses_add_up_to_the_mass_of_the_stage(kind: str, robots: int) -> None:
    whole = mass_and_centroid(np.zeros((1, 2)), CORNERS, DENSITIES[kind])[0][0]
    mass, _ = mass_and_centroid(random_points(robots, 3), CORNERS, DENSITIES[kind])
    assert mass.sum() == pytest.approx(whole, rel=1e-12 if kind == "uniform" else 1e-6)


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (2, 1), (3, 2), (5, 3), (100, 100)])
def test_a_lattice_of_equal_rectangles_is_centroidal(columns: int, rows: int) -> None:
    x = (np.arange(columns) + 0.5) * 1.2 / columns - 0.6
    y = (np.arange(rows) + 0.5) * 0.8 / rows - 0.4
    lattice = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    mass, centroid = mass_and_centroid(lattice, CORNERS, DENSITIES["uniform"])
    assert centroid == pytest.approx(lattice, abs=1e-12)
    assert mass == pytest.approx(np.full(len(lattice), 0.96 / len(lattice)), rel=1e-9)
    # Of a rectangle about its center: area (a^2 + b^2) / 12.
    a, b = 1.2 / columns, 0.8 / rows
    assert locational_cost(lattice, CORNERS, DENSITIES["uniform"]) == pytest.approx(0.96 * (a**2 + b**2) / 12, rel=1e-9)
