"""Control barrier certificates: the commands closest to the nominal ones with which bodies and walls stay apart.

A. D. Ames, X. Xu, J. W. Grizzle and P. Tabuada, "Control barrier function based quadratic programs for safety critical
systems", IEEE TAC 62(8), 2017; for swarms L. Wang, A. D. Ames and M. Egerstedt, "Safety barrier certificates for
collisions-free multirobot systems", IEEE T-RO 33(3), 2017. Three choices differ from theirs:

Guarded point. A body lies in a disk about a point q, a distance a ahead of the axle (`Body.guarded`). The point's
velocity is linear in the command, u = [e, a e'] (v, omega), e the heading and e' its left: the barrier keeps the bodies
themselves apart, and loses no spacing to a look-ahead point. The unknowns are the speeds z = (v, c omega), c half the
wheel base: |z|^2 is half the sum of squares of the wheels' speeds, and the motors' limits are half-planes, so that no
scaling is needed afterward.

Rate. With h = |q_i - q_j| - D and n the direction from i to j, the certificate is n . (u_i - u_j) <= gamma h:
linear in h [m]. The Robotarium's has the cube of a difference of squares there, which slows robots many spacings apart.

Between samples. Under a held command u turns at omega, so q strays from its tangent by at most |u| |omega| t^2 / 2.
With U the largest |u| that the motors allow and T the period,

    n . (u_i - u_j) + U T/2 (|omega_i| + |omega_j|) <= gamma h,    gamma T <= 1,

therefore keeps |q_i - q_j| >= D at all times, not only at samples; a wall likewise, with D/2 and one robot. Standing
still fulfills every row, so the program has a solution unless a robot is too near. Robots that start nearer than D have
to part; where the motors or other robots prevent that, they part as fast as they can and come no nearer, and the
trajectory records it: bodies that start apart never touch.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from emovid.scene.robots import Barrier, Limits, Robot, spacing_of
from emovid.scene.stage import Stage
from emovid.swarm.arrays import Array, Indices, Mask
from emovid.swarm.projection import nearest_within
from emovid.swarm.unicycle import look_ahead

_PENALTY = 100.0  # for violating rows without a solution completely, compared with speeds of the order of 1
_DIRECTIONS = 16  # corners of the polygon within the speeds of an omnidirectional robot


class Certified(NamedTuple):
    """Commands of the barrier.

    Attributes:
        headings: (N,) [rad], those of omnidirectional robots changed with their velocities.
        commands: (N, 2).
        bend: distance from the nominal commands (N,) [m/s], in the speeds z.
        relaxed: (N,), robots too close to another or a wall that could not separate as required.
    """

    headings: Array
    commands: Array
    bend: Array
    relaxed: Mask


class _Rows(NamedTuple):
    """Conditions g_i . z_i + g_j . z_j <= most, each for a pair or a wall.

    Attributes:
        i, j: the robots (R,); j is i for a wall, with g_j = 0.
        g_i, g_j: (R, 2).
        most: (R,) [m/s].
    """

    i: Indices
    j: Indices
    g_i: Array
    g_j: Array
    most: Array


def certified(poses: Array, commands: Array, seconds: float, robot: Robot, stage: Stage, safety: Barrier) -> Certified:
    """Return the commands closest to the nominal ones that fulfill the certificate.

    Args:
        poses: (N, 3) at the start of the period.
        commands: (N, 2), nominal, within the robot's limits.
        seconds: for which they are held.
        robot: with limits of all its motions, as in every valid scene with a barrier.
        stage: to stay on.
        safety: spacing and gamma.
    """
    motors = _Motors(robot, seconds)
    nominal = motors.speeds(poses[:, 2], commands)
    rows = _rows(poses, motors, stage, spacing_of(safety, robot), safety.gamma)
    z, relaxed = _solve(nominal, rows, motors)
    headings, commands = motors.commands(poses[:, 2], z, commands)
    return Certified(headings, commands, np.hypot(*(z - nominal).T), relaxed)


class _Motors:
    """Motion of the center of a body by the speeds z, and the limits of its motors.

    Attributes:
        ahead: distance of the body's middle ahead of the pose [m].
        top: the largest speed of that point [m/s], U.
        stray: factor of |z_2| in the allowance for curved paths, U T/2 / c; 0 for straight lines.
        normals, most: normals and offsets of the half-planes of its limits, (L, 2) and (L,).
    """

    def __init__(self, robot: Robot, seconds: float) -> None:
        assert robot.limits is not None  # a valid scene with a barrier has them
        self.steers, self.ahead = robot.body.steers, robot.body.guarded[0]
        self.c = robot.body.wheel_base / 2 or robot.body.radius
        self.normals, self.most = self._half_planes(robot.limits)
        self.stray, turn_max = 0.0, 0.0
        self.top = robot.limits.v_max or 0.0
        if self.steers:
            lever = abs(self.ahead) / self.c
            v_max, turn_max = _largest(self.normals, self.most)
            both = (robot.limits.wheel_max or np.inf) * max(1.0, lever)  # one wheel's speed is |z_1| + |z_2|
            self.top = min(float(np.hypot(v_max, lever * turn_max)), both)
            self.stray = self.top * seconds / 2 / self.c
        self.reach = self.top + self.stray * turn_max

    def _half_planes(self, limits: Limits) -> tuple[Array, Array]:
        if not self.steers:
            assert limits.v_max is not None
            angle = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
            inscribed = limits.v_max * np.cos(np.pi / _DIRECTIONS)
            return np.column_stack([np.cos(angle), np.sin(angle)]), np.full(_DIRECTIONS, inscribed)
        planes = []
        if limits.wheel_max is not None:
            planes += [(x, y, limits.wheel_max) for x in (1.0, -1.0) for y in (1.0, -1.0)]
        if limits.v_max is not None:
            planes += [(x, 0.0, limits.v_max) for x in (1.0, -1.0)]
        if limits.omega_max is not None:
            planes += [(0.0, y, self.c * limits.omega_max) for y in (1.0, -1.0)]
        table = np.array(planes)
        return table[:, :2], table[:, 2]

    def speeds(self, heading: Array, commands: Array) -> Array:
        """Return the speeds z (N, 2) [m/s] of commands; for an omnidirectional robot its velocity."""
        v, omega = commands.T
        if self.steers:
            return np.column_stack([v, self.c * omega])
        return np.column_stack([v * np.cos(heading), v * np.sin(heading)])

    def commands(self, heading: Array, z: Array, nominal: Array) -> tuple[Array, Array]:
        """Return headings (N,) and commands (N, 2) of the speeds `z`; the nominal ones where nothing changed."""
        changed = (z != self.speeds(heading, nominal)).any(axis=1)
        if self.steers:
            return heading, np.where(changed[:, None], np.column_stack([z[:, 0], z[:, 1] / self.c]), nominal)
        speed = np.hypot(z[:, 0], z[:, 1])
        new_heading = np.where(changed & (speed > 0), np.arctan2(z[:, 1], z[:, 0]), heading)
        return new_heading, np.column_stack([np.where(changed, speed, nominal[:, 0]), nominal[:, 1]])

    def along(self, heading: Array, n: Array) -> Array:
        """Return g (R, 2) such that the body's middle moves at g . z along the directions n (R, 2)."""
        if not self.steers:
            return n
        cos, sin = np.cos(heading), np.sin(heading)
        lever = self.ahead / self.c
        return np.column_stack([cos * n[:, 0] + sin * n[:, 1], lever * (cos * n[:, 1] - sin * n[:, 0])])


def _largest(normals: Array, most: Array) -> tuple[float, float]:
    """Return upper bounds [m/s] of z_1 and z_2 from the half-planes."""
    return tuple(float(np.min(most[axis > 0] / axis[axis > 0])) for axis in normals.T)  # type: ignore[return-value]


def _rows(poses: Array, motors: _Motors, stage: Stage, spacing: float, gamma: float) -> _Rows:
    """Return the rows of the certificate that a command within the limits can break, still without |omega|."""
    middles = look_ahead(poses, motors.ahead)
    near = cKDTree(middles).query_pairs(spacing + 2 * motors.reach / gamma, output_type="ndarray")
    i, j = near[np.lexsort(near.T[::-1])].T  # in the same order on every machine
    apart = middles[j] - middles[i]
    distance = np.hypot(apart[:, 0], apart[:, 1])
    n = apart / np.where(distance > 0, distance, 1.0)[:, None]
    edges = np.array(stage.edges)
    room = edges[:, 2] - np.einsum("ni,ci->nc", middles, edges[:, :2]) - spacing / 2  # (N, C)
    robot, edge = np.nonzero(gamma * room < motors.reach)
    walls = motors.along(poses[robot, 2], edges[edge, :2])
    return _Rows(
        np.concatenate([i, robot]),
        np.concatenate([j, robot]),
        np.concatenate([motors.along(poses[i, 2], n), walls]),
        np.concatenate([motors.along(poses[j, 2], -n), np.zeros_like(walls)]),
        gamma * np.concatenate([distance - spacing, room[robot, edge]]),
    )


def _solve(nominal: Array, rows: _Rows, motors: _Motors) -> tuple[Array, Mask]:
    """Return the speeds (N, 2) closest to the nominal ones that fulfill rows and limits, and `Certified.relaxed`."""
    nobody = np.zeros(len(nominal), dtype=bool)
    pair = rows.i != rows.j
    curved = np.abs(nominal[rows.i, 1]) + np.where(pair, np.abs(nominal[rows.j, 1]), 0.0)
    advance = np.sum(rows.g_i * nominal[rows.i] + rows.g_j * nominal[rows.j], axis=1) + motors.stray * curved
    if (advance <= rows.most).all():
        return nominal, nobody
    robots, place = np.unique(np.concatenate([rows.i, rows.j]), return_inverse=True)
    i, j = place[: len(pair)], place[len(pair) :]
    each = np.arange(len(pair))
    parts, most = [], []
    # |omega| is two rows, one for each sign: a pair's row becomes four, a wall's two.
    for sign_i, sign_j in product((1.0, -1.0), repeat=2) if motors.stray else [(1.0, 1.0)]:
        part = np.zeros((len(pair), len(robots), 2))
        part[each, i] = rows.g_i + np.array([0.0, sign_i * motors.stray])
        part[each[pair], j[pair]] = rows.g_j[pair] + np.array([0.0, sign_j * motors.stray])
        chosen = pair | (sign_j > 0)
        parts.append(part[chosen])
        most.append(rows.most[chosen])
    limits = np.einsum("ab,kc->akbc", np.eye(len(robots)), motors.normals).reshape(-1, len(robots), 2)
    A = np.concatenate([*parts, limits]).reshape(-1, 2 * len(robots))
    b = np.concatenate([*most, np.tile(motors.most, len(robots))])
    unit = motors.top
    wanted = nominal[robots].ravel() / unit
    found = nearest_within(wanted, A, b / unit)
    relaxed = nobody.copy()
    if found is None:
        too_near = rows.most < 0
        relaxed[rows.i[too_near]] = relaxed[rows.j[too_near]] = True
        found = _nearly_within(wanted, A, b / unit)
    z = nominal.copy()
    z[robots] = unit * found.reshape(-1, 2)
    return z, relaxed


def _nearly_within(wanted: Array, A: Array, b: Array) -> Array:
    """Return the closest point (n,) that fulfills the rows with b < 0 as far as possible.

    The share of their demand that is missed is one more unknown, with a penalty; at 1, standing still is a solution.
    """
    missed = np.minimum(b, 0.0) / _PENALTY
    more = np.column_stack([A, missed])
    bounds = np.zeros((2, more.shape[1]))
    bounds[:, -1] = 1.0, -1.0
    found = nearest_within(np.append(wanted, 0.0), np.vstack([more, bounds]), np.concatenate([b, [_PENALTY, 0.0]]))
    return np.zeros_like(wanted) if found is None else found[:-1]
