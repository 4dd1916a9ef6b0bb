import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog, minimize

from emovid.swarm.projection import nearest_within

SEED = st.integers(0, 2**32 - 1)


def polytope(seed: int, least: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a point, and half-spaces with offsets from `least`: the origin is within all of them from 0 on."""
    rng = np.random.default_rng(seed)
    n, m = rng.integers(1, 9), rng.integers(1, 25)
    return rng.normal(size=n), rng.normal(size=(m, n)) * rng.lognormal(size=(m, 1)), rng.uniform(least, 1, m)


@given(SEED)
@settings(max_examples=200)
def test_result_satisfies_the_optimality_conditions(seed: int) -> None:
    point, A, b = polytope(seed)
    x = nearest_within(point, A, b)
    scale = np.linalg.norm(A, axis=1)
    assert ((A @ x - b) / scale).max() <= 1e-12
    # The residual is in the cone of the active normals: no other point is as near (KKT).
    touched = (A @ x - b) / scale > -1e-9
    if not touched.any():
        assert np.array_equal(x, point)
        return
    normals = A[touched] / scale[touched, None]
    cone = linprog(np.zeros(len(normals)), A_eq=normals.T, b_eq=point - x, bounds=(0, None))
    assert cone.status == 0 or np.abs(point - x).max() < 1e-9


@given(SEED)
@settings(max_examples=25)
def test_agrees_with_an_independent_solver(seed: int) -> None:
    point, A, b = polytope(seed)
    x = nearest_within(point, A, b)
    held = {"type": "ineq", "fun": lambda z: b - A @ z, "jac": lambda _: -A}
    other = minimize(
        lambda z: np.sum((z - point) ** 2),
        np.zeros_like(point),
        jac=lambda z: 2 * (z - point),
        constraints=held,
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert other.fun >= np.sum((x - point) ** 2) - 1e-9
    if other.success:
        assert x == pytest.approx(other.x, abs=1e-5)


@given(SEED)
@settings(max_examples=100)
def test_result_is_none_only_for_an_empty_polytope(seed: int) -> None:
    point, A, b = polytope(seed, least=-1.0)
    room = linprog(np.append(np.zeros_like(point), 1.0), np.column_stack([A, -np.ones(len(A))]), b, bounds=(None, None))
    slack = (
        room.x[-1] if room.status == 0 else -1.0
    )  # relaxation that makes the constraints feasible; unbounded means feasible
    x = nearest_within(point, A, b)
    if slack > 1e-3:
        assert x is None
    if slack < -1e-3:
        assert x is not None


def test_known_answers():
    square = np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]])
    assert nearest_within(np.array([3.0, 0.5]), square, np.ones(4)) == pytest.approx([1, 0.5], abs=1e-12)
    assert nearest_within(np.array([3.0, -7.0]), square, np.ones(4)) == pytest.approx([1, -1], abs=1e-12)
    within = np.array([0.25, -0.5])
    assert nearest_within(within, square, np.ones(4)) is within
    assert nearest_within(within, square, np.array([-2.0, 1, 1, 1])) is None


def test_linearly_dependent_constraints_are_accepted():
    A = np.array([[1.0, 0], [1, 0], [2, 0], [0.5, 1e-12]])
    assert nearest_within(np.array([4.0, 1.0]), A, np.array([1.0, 1, 2, 0.5])) == pytest.approx([1, 1], abs=1e-9)
