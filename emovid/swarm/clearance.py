"""Clearance: the share of a command's v with which bodies stay on the stage and apart. Poses are never moved.

Under a held command the displacement is v times a curve that depends on heading and omega alone. So its reach toward a
line has a closed form, which gives the largest v that keeps the center behind every line; omega stays as it is.
Lines beyond the reach of a robot in a control period are ignored.
"""

from functools import lru_cache

import numpy as np

from emovid.scene.stage import Edge, Stage
from emovid.swarm.arrays import Array, Indices
from emovid.swarm.voronoi import pairs_within

_ROUNDING = 1e-12  # m


def share_on_stage(poses: Array, commands: Array, seconds: float, stage: Stage, radius: float) -> Array:
    """Return the share (N,) in [0, 1] of each v that keeps the body, a disk of `radius` [m], on the stage throughout.

    Args:
        poses: (N, 3) at the start of the period, bodies on the stage.
        commands: (N, 2).
        seconds: for which they are held.
        stage: to stay on.
        radius: of a body [m].
    """
    normal_x, normal_y, offset, direction = _lines(stage.edges)
    slack = offset - radius - (normal_x * poses[:, 0] + normal_y * poses[:, 1])
    edge, robot = np.nonzero(slack < np.abs(commands[:, 0]) * seconds)
    return _smallest_share(poses, commands, seconds, robot, direction[edge], slack[edge, robot])


@lru_cache(maxsize=8)  # needed in every period
def _lines(edges: tuple[Edge, ...]) -> tuple[Array, Array, Array, Array]:
    """Return the edges' normals' x and y and their offsets [m], (C, 1) each, and their directions (C,) [rad]."""
    x, y, offset = np.array(edges).T
    # From 0 to 2 pi: another turn of the circle would change the last digit.
    return x[:, None], y[:, None], offset[:, None], np.mod(np.arctan2(y, x), 2 * np.pi)


def room_on_stage(points: Array, stage: Stage) -> Array:
    """Return the radius (...) [m] of the largest disk about each point (..., 2) that is on the stage; < 0 off it."""
    return np.min(stage.distances(points[..., 0], points[..., 1]), axis=0)


def share_apart(poses: Array, commands: Array, seconds: float, radius: float, clearance: float) -> Array:
    """Return the share (N,) in [0, 1] of each v that keeps the body inside its robot's own Voronoi cell.

    Cells are disjoint, so bodies that start in theirs with half the clearance to spare stay that far apart whatever
    the others do: buffered Voronoi cells, D. Zhou, Z. Wang, S. Bandyopadhyay and M. Schwager, "Fast, on-line collision
    avoidance for dynamic vehicles using buffered Voronoi cells", IEEE RA-L 2(2), 2017.

    Args:
        poses: (N, 3) at the start of the period.
        commands: (N, 2).
        seconds: for which they are held.
        radius: of a body [m].
        clearance: to keep between bodies [m].
    """
    reach = np.abs(commands[:, 0]) * seconds
    i, j = pairs_within(poses[:, :2], 2 * (radius + reach.max()) + clearance)
    robot, other = np.concatenate([i, j]), np.concatenate([j, i])
    towards = poses[other, :2] - poses[robot, :2]
    slack = np.hypot(towards[:, 0], towards[:, 1]) / 2 - radius - clearance / 2
    near = np.flatnonzero(slack < reach[robot])
    facing = np.arctan2(towards[near, 1], towards[near, 0])
    return _smallest_share(poses, commands, seconds, robot[near], facing, slack[near])


def _smallest_share(
    poses: Array, commands: Array, seconds: float, robot: Indices, facing: Array, slack: Array
) -> Array:
    """Return for each robot (N,) the smallest of its shares at the lines (C,) it can reach; 1 if there is none."""
    share = np.ones(len(poses))
    if len(robot):
        np.minimum.at(share, robot, _fitting_share(poses[robot], commands[robot], seconds, facing, slack))
    return share


def _fitting_share(poses: Array, commands: Array, seconds: float, facing: Array, slack: Array) -> Array:
    """Return the share (C,) of each v with which a center advances by at most `slack` [m] in the direction `facing`.

    A slack below zero, from rounding, counts as zero. So does an advance of the size of a rounding error: otherwise a
    robot that touches a wall could not drive along it.
    """
    v, omega = commands[:, 0], commands[:, 1]
    heading = poses[:, 2] + np.where(v < 0, np.pi, 0.0)  # driving backward is driving forward, turned around
    advance = np.abs(v) * farthest_advance(heading - facing, omega, seconds)
    room = np.maximum(slack, 0.0)
    too_far = advance > room + _ROUNDING
    return np.where(too_far, room / np.where(too_far, advance, 1.0), 1.0)


def farthest_advance(angle: Array, omega: Array, seconds: float) -> Array:
    """Return the largest advance (C,) [m] along a direction, within `seconds`, of unit-speed motion on an arc.

    The advance after t is (sin(angle + omega t) - sin(angle)) / omega: it peaks where the heading is perpendicular
    to the direction, if the arc gets there, or at one of its ends.

    Args:
        angle: heading at the start, from the direction (C,) [rad].
        omega: turning rate (C,) [rad/s].
        seconds: available time.
    """
    turn = omega * seconds
    # A right turn is a left turn in the mirror.
    start = np.where(omega < 0, -angle, angle)
    to_peak = np.mod(np.pi / 2 - start, 2 * np.pi)
    swept = np.abs(turn)
    chord = seconds * np.sinc(turn / (2 * np.pi)) * np.cos(angle + turn / 2)
    straight = swept < 1e-9
    radius = 1 / np.where(straight, 1.0, np.abs(omega))
    peak = np.where((to_peak < swept) & ~straight, (1 - np.sin(start)) * radius, 0.0)
    return np.maximum(np.maximum(peak, chord), 0.0)
