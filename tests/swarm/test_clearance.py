import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emovid.scene.model import Stage
from emovid.swarm.clearance import farthest_advance, share_apart, share_on_stage
from emovid.swarm.unicycle import move

STAGE = Stage(width=1.2, height=0.8)
RADIUS = 0.02
SECONDS = 0.25
SEED = st.integers(0, 2**32 - 1)


def swarm(seed: int, robots: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Return random poses on the stage, many at its edge, and wild commands."""
    rng = np.random.default_rng(seed)
    half = np.array([0.6, 0.4]) - RADIUS
    points = np.clip(rng.uniform(-1.3, 1.3, (robots, 2)) * half, -half, half)
    commands = np.stack([rng.uniform(-3, 3, robots), rng.choice([0, 1e-9, 1, 20, -5, -300], robots)], axis=-1)
    return np.column_stack([points, rng.uniform(-np.pi, np.pi, robots)]), commands


def path(poses: np.ndarray, commands: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the centres (instants, N, 2) along the arcs of the cut commands."""
    cut = commands * np.stack([share, np.ones_like(share)], axis=-1)
    return np.stack([move(poses, cut, t)[:, :2] for t in np.linspace(0, SECONDS, 501)])


@given(st.floats(-10, 10), st.floats(-100, 100))
@settings(max_examples=200)
def test_farthest_advance_is_the_peak_of_the_arc(angle: float, omega: float) -> None:
    t = np.linspace(0, SECONDS, 20001)
    advance = t * np.sinc(omega * t / (2 * np.pi)) * np.cos(angle + omega * t / 2)
    found = farthest_advance(np.array([angle]), np.array([omega]), SECONDS)[0]
    assert found == pytest.approx(max(advance.max(), 0), abs=1e-6)
    assert found >= advance.max() - 1e-12


@given(SEED)
def test_bodies_stay_on_the_stage_throughout(seed: int) -> None:
    poses, commands = swarm(seed)
    share = share_on_stage(poses, commands, SECONDS, STAGE, RADIUS)
    centres = path(poses, commands, share)
    assert (np.abs(centres) <= np.array([0.6, 0.4]) - RADIUS + 1e-9).all()


@given(SEED)
def test_no_more_is_cut_than_must_be(seed: int) -> None:
    poses, commands = swarm(seed)
    share = share_on_stage(poses, commands, SECONDS, STAGE, RADIUS)
    centres = path(poses, commands, share)
    room = (np.array([0.6, 0.4]) - RADIUS - np.abs(centres)).min(axis=(0, 2))
    # A command that was cut takes its body to the edge, to within the sampling of the arc.
    assert (room[share < 1] < 4e-3).all()
    free = (np.abs(path(poses, commands, np.ones(len(poses)))) < np.array([0.6, 0.4]) - RADIUS).all(axis=(0, 2))
    assert (share[free] == 1).all()


def test_a_robot_at_the_edge_may_drive_away_and_backwards() -> None:
    poses = np.array([[0.58, 0, 0], [0.58, 0, 0], [0.58, 0, np.pi], [0.58, 0, np.pi / 2]])
    commands = np.array([[0.1, 0], [-0.1, 0], [0.1, 0], [0.1, 0]])
    assert share_on_stage(poses, commands, SECONDS, STAGE, RADIUS) == pytest.approx([0, 1, 1, 1])


def test_half_of_a_command_fits_by_hand() -> None:
    # 25 mm at 0.1 m/s in 0.25 s, and 12.5 mm of room.
    pose, command = np.array([[0.58 - 0.0125, 0.0, 0.0]]), np.array([[0.1, 0.0]])
    assert share_on_stage(pose, command, SECONDS, STAGE, RADIUS) == pytest.approx([0.5])


@given(SEED, st.floats(0, 0.01))
def test_bodies_stay_apart_throughout(seed: int, clearance: float) -> None:
    rng = np.random.default_rng(seed)
    lattice = np.array([[x, y] for x in np.arange(5) for y in np.arange(4)]) * (2 * RADIUS + clearance)
    poses = np.column_stack([lattice, rng.uniform(-np.pi, np.pi, 20)])
    commands = swarm(seed)[1]
    share = share_apart(poses, commands, SECONDS, RADIUS, clearance)
    centres = path(poses, commands, share)
    apart = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=-1) + np.eye(20)
    assert apart.min() >= 2 * RADIUS + clearance - 1e-9


def test_two_robots_that_drive_at_each_other_share_the_room() -> None:
    poses = np.array([[-0.05, 0, 0], [0.05, 0, np.pi]])
    commands = np.array([[0.2, 0.0], [0.2, 0.0]])  # 50 mm each; to the border, less body and half the clearance, 28 mm
    assert share_apart(poses, commands, SECONDS, RADIUS, 0.004) == pytest.approx([0.56, 0.56])


def test_robots_out_of_reach_are_not_cut() -> None:
    poses = np.array([[-0.5, 0, 0], [0.5, 0, np.pi]])
    assert share_apart(poses, np.array([[0.2, 0.0], [0.2, 0.0]]), SECONDS, RADIUS, 0.004) == pytest.approx([1, 1])
    assert share_apart(poses[:1], np.array([[0.2, 0.0]]), SECONDS, RADIUS, 0.004) == pytest.approx([1])
