"""Integrals over rectangular cells, as products or sums of integrals along one axis."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import roots_jacobi

from emovid.scene.behaviour import Boundary, Gaussian, Sum, Uniform
from emovid.scene.stage import Rectangle
from emovid.swarm import quadrature
from emovid.swarm.densities import Density, density_of
from emovid.swarm.laws import corners_of, locational_cost, mass_and_centroid
from tests.helpers.stages import HEXAGON, TRIANGLE, polygon

STAGE = Rectangle(width=1.2, height=0.8)
CORNERS = corners_of(STAGE)
LATTICE = st.tuples(st.integers(1, 12), st.integers(1, 8))
NODE, WEIGHT = np.polynomial.legendre.leggauss(40)


@lru_cache(maxsize=64)  # the lattices of the tests share few intervals
def along(begin: float, end: float, centre: float, sigma: float) -> tuple[float, float, float]:
    """Return log of the largest value, mass over it, and mean of a Gaussian on an interval, from 40 x 200 nodes."""
    cuts = np.linspace(begin, end, 201)
    x = (cuts[:-1, None] + cuts[1:, None]) / 2 + np.diff(cuts)[:, None] / 2 * NODE
    exponent = -((x - centre) ** 2) / (2 * sigma**2)
    value = np.exp(exponent - exponent.max()) * WEIGHT * (end - begin) / 400
    return float(exponent.max()), float(value.sum()), float((value * x).sum() / value.sum())


ACCURACY = 1e-5  # of centroids, over a density's width: a micrometer, where a control step is millimeters


def lattice(columns: int, rows: int) -> tuple[np.ndarray, list[tuple[float, float, float, float]]]:
    """Return the centers of equal rectangles that tile the stage, and their bounds: left, right, bottom, top."""
    x, y = np.linspace(-0.6, 0.6, columns + 1), np.linspace(-0.4, 0.4, rows + 1)
    bounds = [(x[i], x[i + 1], y[j], y[j + 1]) for i in range(columns) for j in range(rows)]
    return np.array([[(a + b) / 2, (c + d) / 2] for a, b, c, d in bounds]), bounds


@given(LATTICE, st.floats(0.008, 2), st.floats(-0.6, 0.6), st.floats(-0.4, 0.4))
def test_gaussian_centroids_are_exact_far_from_the_peak(
    size: tuple[int, int], sigma: float, x: float, y: float
) -> None:
    points, bounds = lattice(*size)
    density = density_of(Gaussian(kind="gaussian", sigma=sigma, centre={"x": x, "y": y}), STAGE)
    mass, centroid = mass_and_centroid(points, CORNERS, density)
    for i, (left, right, bottom, top) in enumerate(bounds):
        x_log, x_mass, x_mean = along(left, right, x, sigma)
        y_log, y_mass, y_mean = along(bottom, top, y, sigma)
        if x_log + y_log > -600:  # smaller densities are zero in floating point
            assert mass[i] == pytest.approx(np.exp(x_log + y_log) * x_mass * y_mass, rel=1e-6)
            assert np.hypot(*(centroid[i] - (x_mean, y_mean))) < ACCURACY * sigma


def across(begin: float, end: float, crest: float, width: float) -> tuple[float, float, float]:
    """Return the same for the union g + h - g h of two ridges g and h at +-crest, from 40 x 200 nodes."""
    cuts = np.linspace(begin, end, 201)
    x = (cuts[:-1, None] + cuts[1:, None]) / 2 + np.diff(cuts)[:, None] / 2 * NODE
    one, other = (-((x - sign * crest) ** 2) / (2 * width**2) for sign in (1, -1))
    highest = max(one.max(), other.max())
    value = np.exp(one - highest) + np.exp(other - highest) * -np.expm1(one)
    value = value * WEIGHT * (end - begin) / 400
    return float(highest), float(value.sum()), float((value * x).sum() / value.sum())


@given(LATTICE, st.floats(0.012, 0.5), st.floats(0, 0.1))
def test_boundary_centroids_are_exact_far_from_the_edges(size: tuple[int, int], width: float, inset: float) -> None:
    # On a rectangle 1 - prod (1 - g) is a + b - a b, with a of x alone and b of y alone.
    points, bounds = lattice(*size)
    density = density_of(Boundary(kind="boundary", width=width, inset=inset), STAGE)
    mass, centroid = mass_and_centroid(points, CORNERS, density)
    for i, (left, right, bottom, top) in enumerate(bounds):
        x_log, x_mass, x_mean = across(left, right, 0.6 - inset, width)
        y_log, y_mass, y_mean = across(bottom, top, 0.4 - inset, width)
        highest = max(x_log, y_log)
        if highest < -600:
            continue
        parts = [
            (np.exp(x_log - highest) * x_mass * (top - bottom), (x_mean, (bottom + top) / 2)),
            (np.exp(y_log - highest) * y_mass * (right - left), ((left + right) / 2, y_mean)),
            (-np.exp(x_log + y_log - highest) * x_mass * y_mass, (x_mean, y_mean)),
        ]
        total = sum(part for part, _ in parts)
        expected = sum(part * np.array(mean) for part, mean in parts) / total
        assert mass[i] == pytest.approx(np.exp(highest) * total, rel=1e-6)
        assert np.hypot(*(centroid[i] - expected)) < 1e-6 * width


@pytest.mark.parametrize("corners", [TRIANGLE, HEXAGON])
def test_cost_of_one_robot_on_a_polygon_is_the_polar_moment(corners: list[tuple[float, float]]) -> None:
    # Of a polygon about the origin, in its textbook form: sum of (a x b) (a.a + a.b + b.b) / 12 over its edges.
    stage = polygon(corners)
    a = corners_of(stage) - [0.05, 0.1]
    b = np.roll(a, -1, axis=0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    expected = np.sum(cross * ((a * a).sum(1) + (a * b).sum(1) + (b * b).sum(1))) / 12
    density = density_of(Uniform(kind="uniform"), stage)
    assert locational_cost(np.array([[0.05, 0.1]]), corners_of(stage), density) == pytest.approx(expected, rel=1e-12)


def test_coincident_robots_cost_as_much_as_one() -> None:
    density = density_of(Gaussian(kind="gaussian", sigma=0.1), STAGE)
    points = np.array([[0.1, 0.2], [-0.2, 0.0]])
    once, twice = (locational_cost(p, CORNERS, density) for p in (points, np.repeat(points, 2, axis=0)))
    assert twice == pytest.approx(once, rel=1e-12)


def test_triangles_too_large_for_any_order_are_split() -> None:
    # The stage is 120 standard deviations wide; its one cell has mass 2 pi sigma^2 and mean square distance 2 sigma^2.
    density = density_of(Gaussian(kind="gaussian", sigma=0.01), STAGE)
    centre = np.zeros((1, 2))
    assert mass_and_centroid(centre, CORNERS, density)[0] == pytest.approx([2 * np.pi * 0.01**2], rel=1e-9)
    assert locational_cost(centre, CORNERS, density) == pytest.approx(2 * np.pi * 0.01**2 * 2 * 0.01**2, rel=1e-9)


@pytest.mark.parametrize("block", [400, 5000])
def test_integrals_do_not_depend_on_the_block_size(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(0).uniform([-0.6, -0.4], [0.6, 0.4], (300, 2))
    density = density_of(Gaussian(kind="gaussian", sigma=0.1), STAGE)._replace(gaussians=None)
    _, expected = mass_and_centroid(points, CORNERS, density)
    monkeypatch.setattr(quadrature, "_BLOCK", block)
    assert mass_and_centroid(points, CORNERS, density)[1] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("nodes", [1, 2, 5, 20])
def test_radial_rule_agrees_with_scipy(nodes: int) -> None:
    for found, expected in zip(quadrature._jacobi(nodes), roots_jacobi(nodes, 0, 1), strict=True):
        assert found == pytest.approx(expected, rel=1e-12)


KINDS = [
    (Gaussian(kind="gaussian", sigma=0.1, centre={"x": 0.1, "y": -0.05}), STAGE),
    (Boundary(kind="boundary", width=0.06, inset=0.06), STAGE),
    (Boundary(kind="boundary", width=0.15, inset=0.0), polygon(TRIANGLE)),
    (Boundary(kind="boundary", width=0.08, inset=0.05), polygon(HEXAGON)),
    (Sum(kind="sum", parts=[
        {"weight": 0.2, "density": {"kind": "uniform"}},
        {"weight": 3.0, "density": {"kind": "gaussian", "sigma": 0.05}},
        {"density": {"kind": "boundary", "width": 0.1}},
    ]), STAGE),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "stage"), KINDS)
@given(seed=st.integers(0, 2**32 - 1), robots=st.integers(1, 40), crowd=st.floats(0.02, 1))
def test_line_integrals_agree_with_quadrature_over_triangles(kind, stage, seed, robots, crowd) -> None:
    corners, density = corners_of(stage), density_of(kind, stage)
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(len(corners)), robots)
    points = crowd * (weights @ corners) + (1 - crowd) * corners.mean(axis=0)
    mass, centroid = mass_and_centroid(points, corners, density)
    assert density.gaussians is not None
    expected_mass, expected = mass_and_centroid(points, corners, density._replace(gaussians=None))
    assert mass == pytest.approx(expected_mass, rel=3e-6)
    assert np.abs(centroid - expected).max() < ACCURACY * density.scale


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.2, 0.1), (0.6, 0.4), (0.6, 0.0), (0.1, 0.4)])
def test_gaussian_peaks_on_cell_borders_and_stage_edges_are_integrated_correctly(place: tuple[float, float]) -> None:
    x, y = place
    density = density_of(Gaussian(kind="gaussian", sigma=0.05, centre={"x": x, "y": y}), STAGE)
    points = np.array([[-0.2, -0.1], [0.2, 0.1]])  # the border of their cells passes through the origin
    mass, centroid = mass_and_centroid(points, CORNERS, density)
    expected_mass, expected = mass_and_centroid(points, CORNERS, density._replace(gaussians=None))
    assert mass == pytest.approx(expected_mass, rel=1e-6)
    assert centroid == pytest.approx(expected, abs=1e-7)
    sides = sum(abs(of) == at for of, at in ((x, 0.6), (y, 0.4)))
    assert mass.sum() == pytest.approx(2 * np.pi * 0.05**2 / 2**sides, rel=1e-6)


@given(st.floats(-3, 3), st.floats(-3, 3), st.integers(0, 1000))
def test_exponential_density_matches_its_closed_form(p: float, q: float, seed: int) -> None:
    # exp(p x + q y) over triangles with corners z: the mass is the divided difference of exp at the corners' exponents.
    corners = np.random.default_rng(seed).uniform(-1, 1, (3, 2))
    u, v = corners[1] - corners[0], corners[2] - corners[0]
    doubled_area = u[0] * v[1] - u[1] * v[0]
    if doubled_area < 0:
        corners, doubled_area = corners[::-1], -doubled_area
    e = np.sort(corners @ [p, q])
    if min(np.diff(e)) < 0.05 or doubled_area < 0.01:
        return
    divided = np.exp(e[0]) / ((e[0] - e[1]) * (e[0] - e[2])) + np.exp(e[1]) / ((e[1] - e[0]) * (e[1] - e[2]))
    divided += np.exp(e[2]) / ((e[2] - e[0]) * (e[2] - e[1]))
    density = Density(lambda x, y: np.exp(p * x + q * y), 1.0)
    mass, _ = mass_and_centroid(corners.mean(axis=0)[None], corners, density)
    assert mass == pytest.approx([doubled_area * divided], rel=1e-7)
