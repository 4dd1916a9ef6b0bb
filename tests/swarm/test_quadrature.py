"""Integrals over rectangular cells, where they are products or sums of integrals along one axis."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import roots_jacobi

from emovid.scene.behaviour import Boundary, Gaussian, Uniform
from emovid.scene.stage import Rectangle
from emovid.swarm import quadrature
from emovid.swarm.densities import Density, density_of
from emovid.swarm.laws import corners_of, locational_cost, mass_and_centroid
from tests.helpers.stages import HEXAGON, TRIANGLE, polygon

STAGE = Rectangle(width=1.2, height=0.8)
CORNERS = corners_of(STAGE)
LATTICE = st.tuples(st.integers(1, 12), st.integers(1, 8))
NODE, WEIGHT = np.polynomial.legendre.leggauss(40)


@lru_cache(maxsize=64)  # a lattice has few intervals
def along(begin: float, end: float, centre: float, sigma: float) -> tuple[float, float, float]:
    """Return log of the largest value, mass over it, and mean of a Gaussian on an interval, from 40 x 200 nodes."""
    cuts = np.linspace(begin, end, 201)
    x = (cuts[:-1, None] + cuts[1:, None]) / 2 + np.diff(cuts)[:, None] / 2 * NODE
    exponent = -((x - centre) ** 2) / (2 * sigma**2)
    value = np.exp(exponent - exponent.max()) * WEIGHT * (end - begin) / 400
    return float(exponent.max()), float(value.sum()), float((value * x).sum() / value.sum())


def lattice(columns: int, rows: int) -> tuple[np.ndarray, list[tuple[float, float, float, float]]]:
    """Return the centres of equal rectangles that tile the stage, and their bounds: left, right, bottom, top."""
    x, y = np.linspace(-0.6, 0.6, columns + 1), np.linspace(-0.4, 0.4, rows + 1)
    bounds = [(x[i], x[i + 1], y[j], y[j + 1]) for i in range(columns) for j in range(rows)]
    return np.array([[(a + b) / 2, (c + d) / 2] for a, b, c, d in bounds]), bounds


@given(LATTICE, st.floats(0.008, 2), st.floats(-0.6, 0.6), st.floats(-0.4, 0.4))
def test_gaussian_centroids_are_exact_however_far_out(size: tuple[int, int], sigma: float, x: float, y: float) -> None:
    points, bounds = lattice(*size)
    density = density_of(Gaussian(kind="gaussian", sigma=sigma, centre={"x": x, "y": y}), STAGE)
    mass, centroid = mass_and_centroid(points, CORNERS, density)
    for i, (left, right, bottom, top) in enumerate(bounds):
        x_log, x_mass, x_mean = along(left, right, x, sigma)
        y_log, y_mass, y_mean = along(bottom, top, y, sigma)
        if x_log + y_log > -600:  # beyond, the density has no digits
            assert mass[i] == pytest.approx(np.exp(x_log + y_log) * x_mass * y_mass, rel=1e-6)
            assert np.hypot(*(centroid[i] - (x_mean, y_mean))) < 1e-6 * sigma


@given(LATTICE, st.floats(0.012, 0.5), st.floats(0, 0.1))
def test_boundary_centroids_are_exact_in_its_valleys_too(size: tuple[int, int], width: float, inset: float) -> None:
    points, bounds = lattice(*size)
    density = density_of(Boundary(kind="boundary", width=width, inset=inset), STAGE)
    mass, centroid = mass_and_centroid(points, CORNERS, density)
    for i, (left, right, bottom, top) in enumerate(bounds):
        x, y = (left + right) / 2, (bottom + top) / 2
        ridges = [(0, crest, *along(left, right, crest, width)) for crest in (0.6 - inset, inset - 0.6)]
        ridges += [(1, crest, *along(bottom, top, crest, width)) for crest in (0.4 - inset, inset - 0.4)]
        highest = max(log for _, _, log, _, _ in ridges)
        if highest < -600:
            continue
        total, moment = 0.0, np.zeros(2)
        for axis, _, log, line_mass, mean in ridges:
            part = np.exp(log - highest) * line_mass * ((top - bottom) if axis == 0 else (right - left))
            total += part
            moment += part * np.array([mean, y] if axis == 0 else [x, mean])
        assert mass[i] == pytest.approx(np.exp(highest) * total, rel=1e-6)
        assert np.hypot(*(centroid[i] - moment / total)) < 1e-6 * width


@pytest.mark.parametrize("corners", [TRIANGLE, HEXAGON])
def test_the_cost_of_a_lone_robot_on_a_polygon_is_its_polar_moment(corners: list[tuple[float, float]]) -> None:
    # Of a polygon about the origin, in the textbook's form: sum of (a x b) (a.a + a.b + b.b) / 12 over its edges.
    stage = polygon(corners)
    a = corners_of(stage) - [0.05, 0.1]
    b = np.roll(a, -1, axis=0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    expected = np.sum(cross * ((a * a).sum(1) + (a * b).sum(1) + (b * b).sum(1))) / 12
    density = density_of(Uniform(kind="uniform"), stage)
    assert locational_cost(np.array([[0.05, 0.1]]), corners_of(stage), density) == pytest.approx(expected, rel=1e-12)


def test_coincident_robots_cost_what_one_costs() -> None:
    density = density_of(Gaussian(kind="gaussian", sigma=0.1), STAGE)
    points = np.array([[0.1, 0.2], [-0.2, 0.0]])
    once, twice = (locational_cost(p, CORNERS, density) for p in (points, np.repeat(points, 2, axis=0)))
    assert twice == pytest.approx(once, rel=1e-12)


def test_triangles_larger_than_any_order_can_do_are_split() -> None:
    # The stage is 120 standard deviations wide; its one cell holds the whole peak: 2 pi sigma^2, and twice sigma^2.
    density = density_of(Gaussian(kind="gaussian", sigma=0.01), STAGE)
    centre = np.zeros((1, 2))
    assert mass_and_centroid(centre, CORNERS, density)[0] == pytest.approx([2 * np.pi * 0.01**2], rel=1e-9)
    assert locational_cost(centre, CORNERS, density) == pytest.approx(2 * np.pi * 0.01**2 * 2 * 0.01**2, rel=1e-9)


@pytest.mark.parametrize("block", [400, 5000])
def test_integrals_do_not_depend_on_how_many_nodes_are_taken_at_a_time(
    block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = np.random.default_rng(0).uniform([-0.6, -0.4], [0.6, 0.4], (300, 2))
    density = density_of(Gaussian(kind="gaussian", sigma=0.1), STAGE)
    _, expected = mass_and_centroid(points, CORNERS, density)
    monkeypatch.setattr(quadrature, "_BLOCK", block)
    assert mass_and_centroid(points, CORNERS, density)[1] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("nodes", [1, 2, 5, 20])
def test_the_rule_along_rays_is_that_of_scipy(nodes: int) -> None:
    for found, expected in zip(quadrature._jacobi(nodes), roots_jacobi(nodes, 0, 1), strict=True):
        assert found == pytest.approx(expected, rel=1e-12)


@given(st.integers(0, 2**32 - 1), st.integers(1, 15), st.floats(0.02, 0.5))
def test_one_peak_is_integrated_as_exactly_with_fewer_nodes(seed: int, robots: int, sigma: float) -> None:
    points = np.random.default_rng(seed).uniform([-0.6, -0.4], [0.6, 0.4], (robots, 2))
    density = density_of(Gaussian(kind="gaussian", sigma=sigma), STAGE)
    _, found = mass_and_centroid(points, CORNERS, density)
    finely = density._replace(one_peak=False, scale=sigma / 4)  # as if it changed faster than it does
    _, expected = mass_and_centroid(points, CORNERS, finely)
    assert np.abs(found - expected).max() < 1e-6 * sigma


@given(st.floats(-3, 3), st.floats(-3, 3), st.integers(0, 1000))
def test_a_density_that_rises_exponentially_has_its_closed_form(p: float, q: float, seed: int) -> None:
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
