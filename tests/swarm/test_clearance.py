import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from emovid.scene.stage import Polygon, Rectangle
from emovid.swarm import clearance
from emovid.swarm.clearance import farthest_advance, room_on_stage, share_apart, share_on_stage
from emovid.swarm.unicycle import move
from tests.helpers.stages import HEXAGON, convex_corners, polygon

STAGE = Rectangle(width=1.2, height=0.8)
RADIUS = 0.02
SECONDS = 0.25
SEED = st.integers(0, 2**32 - 1)


def swarm(seed: int, robots: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Return random poses on the stage, many at its edge, and random commands."""
    rng = np.random.default_rng(seed)
    half = np.array([0.6, 0.4]) - RADIUS
    points = np.clip(rng.uniform(-1.3, 1.3, (robots, 2)) * half, -half, half)
    commands = np.stack([rng.uniform(-3, 3, robots), rng.choice([0, 1e-9, 1, 20, -5, -300], robots)], axis=-1)
    return np.column_stack([points, rng.uniform(-np.pi, np.pi, robots)]), commands


def path(poses: np.ndarray, commands: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the centers (times, N, 2) along the arcs of the shortened commands."""
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
def test_commands_are_shortened_no_more_than_necessary(seed: int) -> None:
    poses, commands = swarm(seed)
    share = share_on_stage(poses, commands, SECONDS, STAGE, RADIUS)
    centres = path(poses, commands, share)
    room = (np.array([0.6, 0.4]) - RADIUS - np.abs(centres)).min(axis=(0, 2))
    # A shortened command moves its body to the edge, within the sampling of the arc.
    assert (room[share < 1] < 4e-3).all()
    free = (np.abs(path(poses, commands, np.ones(len(poses)))) < np.array([0.6, 0.4]) - RADIUS).all(axis=(0, 2))
    assert (share[free] == 1).all()


def test_a_robot_at_the_edge_may_drive_away_and_backward() -> None:
    poses = np.array([[0.58, 0, 0], [0.58, 0, 0], [0.58, 0, np.pi], [0.58, 0, np.pi / 2]])
    commands = np.array([[0.1, 0], [-0.1, 0], [0.1, 0], [0.1, 0]])
    assert share_on_stage(poses, commands, SECONDS, STAGE, RADIUS) == pytest.approx([0, 1, 1, 1])


def test_shortened_command_by_hand() -> None:
    # 25 mm at 0.1 m/s in 0.25 s, and 12.5 mm are free.
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


def test_robots_driving_at_each_other_share_the_free_distance() -> None:
    poses = np.array([[-0.05, 0, 0], [0.05, 0, np.pi]])
    commands = np.array([[0.2, 0.0], [0.2, 0.0]])  # 50 mm each; to the border, less body and half the clearance, 28 mm
    assert share_apart(poses, commands, SECONDS, RADIUS, 0.004) == pytest.approx([0.56, 0.56])


def test_distant_robots_are_not_slowed_down() -> None:
    poses = np.array([[-0.5, 0, 0], [0.5, 0, np.pi]])
    assert share_apart(poses, np.array([[0.2, 0.0], [0.2, 0.0]]), SECONDS, RADIUS, 0.004) == pytest.approx([1, 1])
    assert share_apart(poses[:1], np.array([[0.2, 0.0]]), SECONDS, RADIUS, 0.004) == pytest.approx([1])


# --- stages of any shape ---------------------------------------------------------------------------------------------


def swarm_on(stage: Polygon, seed: int, robots: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Return random poses on the stage, many at its edge, and random commands."""
    commands = swarm(seed, robots)[1]
    rng = np.random.default_rng(seed)
    normals, offsets = np.split(np.array(stage.edges), [2], axis=1)
    # The largest circle by linear programming: a body fits there.
    best = linprog([0, 0, -1], np.column_stack([normals, np.ones(len(normals))]), offsets, bounds=(None, None))
    angle = rng.uniform(-np.pi, np.pi, robots)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    towards = ray @ normals.T
    room = (offsets[:, 0] - RADIUS) - normals @ best.x[:2]
    reach = np.min(np.where(towards > 0, room / np.where(towards > 0, towards, 1), np.inf), axis=1)
    points = best.x[:2] + (np.minimum(rng.uniform(0, 1.5, robots), 1) * reach)[:, None] * ray
    return np.column_stack([points, rng.uniform(-np.pi, np.pi, robots)]), commands


@given(convex_corners(), SEED)
def test_bodies_stay_on_a_stage_of_any_shape_throughout(corners: list[tuple[float, float]], seed: int) -> None:
    stage = polygon(corners)
    assume(stage.inradius > RADIUS + 1e-3)
    poses, commands = swarm_on(stage, seed)
    share = share_on_stage(poses, commands, SECONDS, stage, RADIUS)
    centres = path(poses, commands, share)
    # An independent measure: the distance of a center to the left of each edge.
    ring = np.array(corners)
    along = np.roll(ring, -1, axis=0) - ring
    to_centre = centres[..., None, :] - ring
    left = (along[:, 0] * to_centre[..., 1] - along[:, 1] * to_centre[..., 0]) / np.hypot(*along.T)
    room = left.min(axis=(0, 2)) - RADIUS
    assert (room >= -1e-9).all()
    assert (
        room[share < 1] < 4e-3
    ).all()  # and commands are shortened no more than necessary, within the sampling of the arc


@given(SEED)
def test_rectangle_given_by_corners_shortens_commands_identically(seed: int) -> None:
    poses, commands = swarm(seed)
    by_corners = polygon([(0.6, 0.4), (0.6, -0.4), (-0.6, -0.4), (-0.6, 0.4)])
    expected = share_on_stage(poses, commands, SECONDS, STAGE, RADIUS)
    assert np.array_equal(share_on_stage(poses, commands, SECONDS, by_corners, RADIUS), expected)


def test_clearance_on_a_hexagon_by_hand() -> None:
    apothem = 0.6 * np.sqrt(3) / 2
    room = room_on_stage(np.array([[0.0, 0.0], [0.0, -0.5], [0.6, 0.0], [0.0, 1.0]]), polygon(HEXAGON))
    assert room == pytest.approx([apothem, apothem - 0.5, 0, apothem - 1], abs=1e-12)


@given(convex_corners(), SEED)
def test_distant_edges_do_not_affect_the_result(corners: list[tuple[float, float]], seed: int) -> None:
    stage = polygon(corners)
    assume(stage.inradius > RADIUS + 1e-3)
    poses, commands = swarm_on(stage, seed)
    of_edges = [
        clearance._fitting_share(
            poses,
            commands,
            SECONDS,
            np.full(len(poses), np.arctan2(y, x)),
            offset - RADIUS - poses[:, :2] @ [x, y],
        )
        for x, y, offset in stage.edges
    ]
    expected = np.min(of_edges, axis=0)
    assert share_on_stage(poses, commands, SECONDS, stage, RADIUS) == pytest.approx(expected, abs=1e-9)
