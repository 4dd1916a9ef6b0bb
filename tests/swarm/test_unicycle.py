import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from emovid.scene.robots import Limits
from emovid.swarm.unicycle import look_ahead, move, near_identity, within_limits, wrapped

ANGLE = st.floats(-10, 10)
SPEED = st.floats(-2, 2)
TURN = st.floats(-200, 200)
SECONDS = st.floats(0, 0.5)


def unicycle(_: float, pose: np.ndarray, v: float, omega: float) -> list[float]:
    return [v * np.cos(pose[2]), v * np.sin(pose[2]), omega]


@pytest.mark.parametrize(("v", "omega"), [(0.3, 2.0), (-0.2, 7.0), (0.5, 0.0), (0.4, 1e-9), (1.0, -150.0)])
def test_move_is_the_solution_of_the_unicycle_equations(v: float, omega: float) -> None:
    start = np.array([0.1, -0.2, 2.5])
    fine = solve_ivp(unicycle, (0, 0.25), start, args=(v, omega), rtol=1e-12, atol=1e-13, method="DOP853").y[:, -1]
    pose = move(start, np.array([v, omega]), 0.25)
    assert pose[:2] == pytest.approx(fine[:2], abs=1e-10)
    assert np.cos(pose[2] - fine[2]) == pytest.approx(1, abs=1e-12)


@given(ANGLE, SPEED, TURN, SECONDS, SECONDS)
def test_two_moves_with_one_command_equal_one_long_move(
    heading: float, v: float, omega: float, a: float, b: float
) -> None:
    start, command = np.array([0.0, 0.0, heading]), np.array([v, omega])
    once, twice = move(start, command, a + b), move(move(start, command, a), command, b)
    assert once[:2] == pytest.approx(twice[:2], abs=1e-10)


@given(ANGLE, SPEED, TURN, SECONDS)
def test_reversed_move_undoes_a_move(heading: float, v: float, omega: float, seconds: float) -> None:
    start, command = np.array([0.3, -0.1, heading]), np.array([v, omega])
    assert move(move(start, command, seconds), -command, seconds)[:2] == pytest.approx(start[:2], abs=1e-10)


@given(st.floats(-1e4, 1e4))
def test_wrapped_headings_keep_direction_and_range(angle: float) -> None:
    inside = float(wrapped(np.array(angle)))
    assert -np.pi < inside <= np.pi
    assert np.hypot(np.cos(inside) - np.cos(angle), np.sin(inside) - np.sin(angle)) < 1e-9


def test_wrapped_keeps_pi_and_turns_minus_pi() -> None:
    assert wrapped(np.array([np.pi, -np.pi, 0.0])) == pytest.approx([np.pi, np.pi, 0.0])


@given(ANGLE, SPEED, SPEED, st.floats(0.1, 20), st.floats(1e-3, 0.1))
def test_look_ahead_point_starts_with_velocity_K_u(heading: float, ux: float, uy: float, K: float, l: float) -> None:
    pose, u = np.array([[0.2, 0.1, heading]]), np.array([[ux, uy]])
    command = near_identity(u, pose[:, 2], K, l)
    step = 1e-7 * l / (1 + K * np.hypot(ux, uy))
    velocity = (look_ahead(move(pose, command, step), l) - look_ahead(pose, l)) / step
    assert velocity == pytest.approx(K * u, rel=1e-4, abs=1e-5 * K)


def test_near_identity_by_hand() -> None:
    # Heading +y with desired velocity (1, 0) m/s: no forward speed, and a right turn of K / l.
    commands = near_identity(np.array([[1.0, 0.0], [0.0, 1.0]]), np.full(2, np.pi / 2), K=3, l=0.5)
    assert commands == pytest.approx(np.array([[0.0, -6.0], [3.0, 0.0]]), abs=1e-12)


@pytest.mark.parametrize("g", [0.5, 1.5, 2.5, 4.5])
def test_heading_error_follows_e_minus_g_sin_e(g: float) -> None:
    # Under constant u, a period of length T turns the heading by -g sin(e) with g = K |u| T / l.
    K, l, seconds, u = 4.0, 0.01, 0.1, np.array([[g * 0.01 / 0.4, 0.0]])
    e, pose = 1.1, np.array([[0.0, 0.0, 1.1]])
    for _ in range(5):
        pose = move(pose, near_identity(u, pose[:, 2], K, l), seconds)
        e = e - g * np.sin(e)
        assert np.cos(pose[0, 2] - e) == pytest.approx(1, abs=1e-12)


@given(SPEED, TURN)
def test_limits_scale_a_command_as_a_whole(v: float, omega: float) -> None:
    limits = Limits(v_max=0.3, omega_max=9.0, wheel_max=0.25)
    command = np.array([[v, omega]])
    scaled = within_limits(command, limits, wheel_base=0.035)[0]
    assert abs(scaled[0]) <= 0.3 * (1 + 1e-12)
    assert abs(scaled[1]) <= 9.0 * (1 + 1e-12)
    assert abs(scaled[0]) + 0.0175 * abs(scaled[1]) <= 0.25 * (1 + 1e-12)
    assert scaled[0] * omega == pytest.approx(scaled[1] * v, abs=1e-9)  # the curvature is kept
    free = abs(v) <= 0.3 and abs(omega) <= 9 and abs(v) + 0.0175 * abs(omega) <= 0.25
    if free:
        assert np.array_equal(scaled, command[0])
    else:  # and speed is reduced no more than necessary: one limit is reached
        reached = max(abs(scaled[0]) / 0.3, abs(scaled[1]) / 9.0, (abs(scaled[0]) + 0.0175 * abs(scaled[1])) / 0.25)
        assert reached == pytest.approx(1)


@given(st.floats(-2, 2), st.floats(-40, 40))
def test_clipping_limits_each_wheel_separately(v: float, omega: float) -> None:
    base, most = 0.105, 0.2
    command = np.array([[v, omega]])
    clipped = within_limits(command, Limits(wheel_max=most), base, clip=True)[0]
    left, right = clipped[0] - base / 2 * clipped[1], clipped[0] + base / 2 * clipped[1]
    assert left == pytest.approx(min(max(v - base / 2 * omega, -most), most), abs=1e-12)
    assert right == pytest.approx(min(max(v + base / 2 * omega, -most), most), abs=1e-12)


def test_clipping_bends_the_path_that_scaling_keeps() -> None:
    # v = 0.2 m/s and 2 rad/s: wheels of 0.095 and 0.305 m/s.
    command, limits = np.array([[0.2, 2.0]]), Limits(wheel_max=0.2)
    scaled, clipped = (within_limits(command, limits, 0.105, clip)[0] for clip in (False, True))
    assert scaled == pytest.approx(np.array([0.2, 2.0]) * 0.2 / 0.305)
    assert clipped == pytest.approx([(0.095 + 0.2) / 2, (0.2 - 0.095) / 0.105])
