"""The near-identity diffeomorphism of Appendix B under held commands: inverse, limits and thresholds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.scene.load import Setting, load_scene
from emovid.swarm.laws import followed_points, start_angles
from emovid.swarm.simulate import simulate
from emovid.swarm.unicycle import look_ahead, move, near_identity

ANGLE, SPEED = st.floats(-np.pi, np.pi), st.floats(-2, 2)


@given(ANGLE, SPEED, SPEED, st.floats(0.1, 20), st.floats(1e-3, 0.5))
def test_inverse_map_recovers_u(heading: float, ux: float, uy: float, K: float, l: float) -> None:
    # The look-ahead point moves at R(theta) diag(1, l) (v, omega), the derivative of p~ in the paper.
    ((v, omega),) = near_identity(np.array([[ux, uy]]), np.array([heading]), K, l)
    rotation = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    assert rotation @ [v, l * omega] / K == pytest.approx([ux, uy], abs=1e-12)


@pytest.mark.parametrize("scene", ["happiness", "surprise", "sadness"])
def test_look_ahead_points_start_each_period_with_velocity_K_u(scene: str) -> None:
    trajectory = simulate(load_scene(scene, [Setting("duration", 2, "test")]))
    robot, behaviour = trajectory.scene.robot, trajectory.scene.behaviour
    uncut = ~(trajectory.stage_cut | trajectory.separation_cut)
    assert uncut.all()
    for k in range(0, len(trajectory.commands), 7):
        poses = trajectory.poses[k]
        ahead = look_ahead(poses, robot.l)
        u = followed_points(behaviour, start_angles(15), trajectory.t[k]) - ahead
        step = 1e-7
        velocity = (look_ahead(move(poses, trajectory.commands[k], step), robot.l) - ahead) / step
        assert velocity == pytest.approx(robot.K * u, abs=1e-5)


def settled(g: float, error: float, periods: int = 4000) -> float:
    """Return the heading error [rad] after many periods under constant u, from the map and motion of the robot."""
    l, seconds, K = 0.01, 0.1, 1.0
    u, pose = np.array([[g * l / (K * seconds), 0.0]]), np.array([[0.0, 0.0, error]])
    for _ in range(periods):
        pose = move(pose, near_identity(u, pose[:, 2], K, l), seconds)
    return float(pose[0, 2])


@pytest.mark.parametrize("g", [0.3, 0.9, 1.1, 1.9])
def test_heading_converges_to_u_below_a_gain_of_2(g: float) -> None:
    assert settled(g, 0.5) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("g", [2.1, 2.5])
def test_heading_oscillates_above_a_gain_of_2(g: float) -> None:
    # The period-2 orbit of e - g sin e: e = -e', so 2 e = g sin e.
    error = abs(settled(g, 0.5))
    assert error > 0.1
    assert 2 * error == pytest.approx(g * np.sin(error), abs=1e-6)


@pytest.mark.parametrize(("g", "crosses"), [(0.5, False), (0.99, False), (1.01, True), (1.8, True)])
def test_heading_overshoots_above_a_gain_of_1(g: float, crosses: bool) -> None:
    assert (settled(g, 0.001, periods=1) < 0) == crosses


def test_robot_with_vanishing_l_only_spins() -> None:
    # The turning rate grows without bound and v does not: over a period the chord v T sinc(omega T / 2) goes to 0.
    u, pose = np.array([[0.05, 0.02]]), np.array([[0.0, 0.0, 2.0]])
    chords = []
    for l in (1e-1, 1e-3, 1e-5, 1e-6):
        command = near_identity(u, pose[:, 2], 4.0, l)
        chords.append(float(np.hypot(*(move(pose, command, 0.1)[0, :2]))))
        assert command[0, 0] == pytest.approx(4.0 * (0.05 * np.cos(2.0) + 0.02 * np.sin(2.0)))
    assert chords[0] > 1e-3
    assert chords[-1] < 1e-6


def test_robot_with_large_l_drives_straight() -> None:
    u, pose = np.array([[0.05, 0.02]]), np.array([[0.0, 0.0, 0.3]])
    end = move(pose, near_identity(u, pose[:, 2], 4.0, 1e6), 0.1)[0]
    forward = 4.0 * (0.05 * np.cos(0.3) + 0.02 * np.sin(0.3)) * 0.1
    assert end == pytest.approx([forward * np.cos(0.3), forward * np.sin(0.3), 0.3], abs=1e-7)
