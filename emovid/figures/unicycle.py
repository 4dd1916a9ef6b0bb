"""The unicycle in drawings: the robot with its dimensions (Fig. 1), the effect of l (Fig. 9), the law (Fig. 17)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emovid.figures.schematic import (
    ANGULAR,
    LINEAR,
    PALE,
    THIN,
    draw_angle,
    draw_arrow,
    draw_dimension,
    draw_line,
    draw_turn,
    drawing,
    write_math,
)
from emovid.figures.stage_panels import LINE, PAPER, draw_lines, draw_robots, panels, write_below
from emovid.figures.style import INK, QUIET, SINGLE_COLUMN, in_style
from emovid.scene.load import load_robot
from emovid.scene.robots import Body
from emovid.swarm.arrays import Array
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import look_ahead, move, near_identity, wrapped

_ROBOT_HEIGHT, _LAW_HEIGHT = 2.2, 2.3  # largest heights of Figs. 1 and 17 [in]
# Angles at which no two parts of Fig. 17 overlap: of the heading from x, and of u from the heading.
_HEADING, _ASIDE = np.radians(30), np.radians(38)
# Path and numbers are our choice: the paper prints none. The path has corners, since a robot follows a smooth path
# closely with any l once it has caught up.
PATH = 0.001 * np.array(
    [[0, 0], [160, 0], [250, 100], [390, 100], [460, -30], [550, 60], [610, 60], [690, -50], [840, -50], [930, 30]]
)  # m
SMALL_L, LARGE_L = 0.005, 0.08  # m
_SPEED = 0.08  # of the followed particle [m/s]
_GAIN = 8.0  # K
_PERIOD = 0.033  # s
_STEPS = 8  # points of the trace per period
# Angular as in the scenes: commands held for long, their speed capped, so that K |u| T / l stays at 4.6. A robot then
# makes a quarter of its speed good, and the particle is as slow.
_ANGULARITY, _HELD, _SLOW = 4.6, 0.25, 0.23
ANGULAR_L = _SPEED * _HELD / _ANGULARITY  # m

_BLUE, _RED = "#5aa0dc", "#e08a5f"  # light enough to show the dashed path on top
_TRACE = 2.0  # width of a smooth trace [pt]


@in_style()
def robot_figure(body: Body, *, width: float = SINGLE_COLUMN) -> Figure:
    """Draw a robot with two wheels as it is simulated, facing right, with its dimensions and its axes (Fig. 1).

    Args:
        body: of the robot, with the lengths to print.
        width: of the figure [in].
    """
    assert body.wheels is not None
    half, base, wheel = body.width / 2, body.wheel_base / 2, body.wheels.radius
    side = base + body.wheels.width / 2
    gap = 0.2 * body.width
    bounds = np.array([[-2.6 * half, -half - 2.2 * gap], [2.6 * half, side + 1.8 * gap]])
    figure, axes = drawing(bounds, width, _ROBOT_HEIGHT)
    draw_robots(axes, body, np.zeros((1, 3)), [PALE.body], PALE)
    for name, tip, beside in (("x", (1.3, 0), (1.3, 0.25)), ("y", (0, 0.72), (-0.2, 0.62))):
        draw_arrow(axes, np.zeros(2), half * np.array(tip), width=THIN)
        write_math(axes, half * np.array(beside), f"${name}$")
    axes.plot(0, 0, "o", color=INK, markersize=3, zorder=6)
    write_math(axes, half * np.array([-0.2, -0.2]), "$p$")
    lengths = (
        ((-half, -half), (half, -half), (0, -1.2 * gap), body.width),
        ((half, -half), (half, half), (0.85 * half, 0), body.width),
        ((-wheel, -base), (-wheel, base), (-1.35 * half, 0), body.wheel_base),
        ((-wheel, side), (wheel, side), (0, gap), 2 * wheel),
    )
    for one, other, offset, length in lengths:
        draw_dimension(axes, np.array(one), np.array(other), np.array(offset), f"{1000 * length:g} mm")
    return figure


class PathRun(NamedTuple):
    """A run along a path.

    Attributes:
        l: look-ahead distance [m]; None for a single integrator.
        poses: (P, 3), dense enough for a smooth line.
        angularity: largest K |u| T / l, with commands held for T.
    """

    l: float | None
    poses: Array
    angularity: float


def follow(path: Array, l: float | None, *, angular: bool = False) -> PathRun:
    """Return the run of a robot that follows a particle along `path` (C, 2) [m] at constant speed.

    The law is that of a contour, u = particle - p, with p~ in place of p for a unicycle; p~ starts at the particle.

    Args:
        path: corners; the first edge is longer than `l`.
        l: look-ahead distance [m]; None for a robot that moves as a single integrator.
        angular: whether commands are held for long and their speed is capped, as in the angular scenes.
    """
    lengths = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    ahead, period, most = l or 0.0, _HELD if angular else _PERIOD, _SPEED / _GAIN if angular else np.inf
    step = _SPEED * period * (_SLOW if angular else 1.0)
    heading = np.arctan2(path[1, 1] - path[0, 1], path[1, 0] - path[0, 0])
    pose = np.array([[*path[0], heading]])
    poses, fastest = [pose], 0.0
    for run in ahead + step * np.arange(int((lengths[-1] - ahead) / step)):
        particle = np.stack([np.interp(run, lengths, along) for along in path.T])
        u = particle - look_ahead(pose, ahead)
        u *= min(most / max(np.hypot(*u[0]), 1e-12), 1.0)
        fastest = max(fastest, float(np.hypot(*u[0])))
        if l is None:
            speed = _GAIN * np.hypot(*u.T)
            pose = np.column_stack([pose[:, :2], np.where(speed > 0, np.arctan2(u[:, 1], u[:, 0]), pose[:, 2])])
            command = np.column_stack([speed, 0 * speed])
        else:
            command = near_identity(u, pose[:, 2], _GAIN, l)
        poses += [move(pose, command, period * (i + 1) / _STEPS) for i in range(_STEPS)]
        pose = poses[-1]
    return PathRun(l, np.concatenate(poses), _GAIN * fastest * period / l if l else 0.0)


@in_style()
def following_figure(runs: Sequence[PathRun], path: Array = PATH, *, width: float = SINGLE_COLUMN) -> Figure:
    """Draw runs along one dashed path, one above the other, each with robot and look-ahead point at its end (Fig. 9).

    Args:
        runs: from `follow`.
        path: corners (C, 2) [m].
        width: of the figure [in].
    """
    shown = np.concatenate([path, *(run.poses[:, :2] for run in runs)])
    room = 1.1 * load_robot("gritsbot").radius
    bounds = np.array([shown.min(axis=0) - room, shown.max(axis=0) + np.array([room + LARGE_L, room])])
    figure, axes = panels(bounds, len(runs), 1, width, below=LINE)
    for panel, run in zip(axes, runs, strict=True):
        colour = _RED if run.l is None else _BLUE
        panel.plot(*path.T, color=INK, linewidth=0.6, linestyle=(0, (4, 3)), zorder=2.5, label="path")
        draw_lines(panel, [run.poses[:, :2]], [colour], _TRACE if run.angularity < 1 else _TRACE / 2)
        body = load_robot("single_integrator" if run.l is None else "gritsbot")
        draw_robots(panel, body, run.poses[-1:], [colour], PAPER)
        if run.l is None:
            write_below(panel, "single integrator")
            continue
        ends = np.concatenate([run.poses[-1:, :2], look_ahead(run.poses[-1:], run.l)])
        panel.plot(*ends.T, color=INK, linewidth=0.6, zorder=4)
        panel.plot(*ends[1], "o", color=INK, markersize=2.2, zorder=5, label="look-ahead point")
        write_below(panel, f"unicycle, $l$ = {1000 * run.l:.2g} mm, $K|u|T/l$ up to {run.angularity:.2g}")
    return figure


def clearest_step(trajectory: Trajectory) -> tuple[Array, Array]:
    """Return the pose (3,) and the command (2,) of the step that shows the geometry best.

    Among all steps of all robots, its heading and direction of u are nearest to those of a legible drawing.

    Raises:
        ValueError: for robots without a look-ahead point, or if none moves.
    """
    l = trajectory.scene.robot.l
    if not trajectory.scene.robot.body.steers or l is None or not trajectory.commands.any():
        raise ValueError("no step of a unicycle that moves")
    poses, (v, omega) = trajectory.poses[:-1], np.moveaxis(trajectory.commands, -1, 0)
    off = np.abs(wrapped(poses[..., 2] - _HEADING)) + np.abs(wrapped(np.arctan2(l * omega, v) - _ASIDE))
    step = np.unravel_index(np.argmin(np.where(np.hypot(v, l * omega) > 0, off, np.inf)), off.shape)
    return poses[step], trajectory.commands[step]


@in_style()
def diffeomorphism_figure(
    pose: Array, command: Array, body: Body, K: float, l: float, *, width: float = SINGLE_COLUMN
) -> Figure:
    """Draw a robot at a pose, its look-ahead point p~, and the effect of a command on both (Fig. 17).

    The velocity K u of p~ has the parts v along the heading and l omega across it; these and u have one scale.

    Args:
        pose: (3,) x [m], y [m], heading [rad]; only the heading matters.
        command: (2,) v [m/s], omega [rad/s].
        body: of the robot.
        K: gain.
        l: distance of p~ [m].
        width: of the figure [in].
    """
    heading = float(pose[2])
    along, across = (np.array([np.cos(a), np.sin(a)]) for a in (heading, heading + np.pi / 2))
    ahead = l * along
    seconds = 1.1 * body.width / np.hypot(command[0], l * command[1])  # arrows about as long as the robot
    forward, sideways = seconds * command[0] * along, seconds * l * command[1] * across
    parts = np.array([ahead, ahead + forward, ahead + sideways, ahead + forward + sideways, [0, 0]])
    room = 0.3 * body.width
    low = np.minimum(parts.min(axis=0) - room, -body.radius - room)
    high = np.maximum(parts.max(axis=0) + room, body.radius)
    figure, axes = drawing(np.array([low, high]), width, _LAW_HEIGHT)
    draw_robots(axes, body, np.array([[0, 0, heading]]), [PALE.body], PALE)
    turned = np.sign(command[1]) or 1.0
    _draw_frame(axes, low, body, l, heading)
    _draw_length(axes, ahead, -turned * across, body)
    for part, colour in ((forward, LINEAR), (sideways, ANGULAR), (forward + sideways, INK)):
        draw_arrow(axes, ahead, ahead + part, colour)
    velocity = forward + sideways
    beside_it = ahead + turned * 0.14 * body.width * _unit(np.array([-velocity[1], velocity[0]]))
    beside_it += 0.2 * body.width * _unit(velocity)
    draw_arrow(axes, beside_it, beside_it + velocity / K)
    for part in (forward, sideways):
        draw_line(axes, [ahead + part, ahead + forward + sideways], QUIET, (3, 3))
    radius = 0.36 * body.width
    draw_turn(axes, np.zeros(2), radius, heading + turned * 1.9, heading + turned * 3.6, ANGULAR)
    for point in (np.zeros(2), ahead):
        axes.plot(*point, "o", color=INK, markersize=3, zorder=6)
    beside = 0.13 * body.width
    write_math(axes, 1.3 * radius * _direction(heading + turned * 2.75), r"$\omega$", ANGULAR)
    write_math(axes, -1.2 * beside * along - turned * beside * across, "$p$")
    write_math(axes, ahead + turned * 0.9 * beside * across - 0.9 * beside * along, r"$\tilde{p}$")
    write_math(axes, ahead + forward + 0.8 * beside * along, "$v$", LINEAR)
    write_math(axes, ahead + sideways + turned * 1.2 * beside * across, r"$l\,\omega$", ANGULAR)
    write_math(axes, ahead + velocity + 1.1 * beside * _unit(velocity), r"$K u$")
    write_math(axes, beside_it + velocity / K + 0.6 * beside * _unit(velocity), "$u$")
    return figure


def _draw_frame(axes: Axes, low: Array, body: Body, l: float, heading: float) -> None:
    """Draw the directions of x and y and, at p, the angle of the heading."""
    reach = 0.6 * body.width
    corner = low + 0.12 * body.width
    for name, tip in (("x", np.array([reach, 0])), ("y", np.array([0, reach]))):
        draw_arrow(axes, corner, corner + tip, QUIET, 0.6)
        write_math(axes, corner + 1.2 * tip, f"${name}$", QUIET)
    reach = 1.4 * max(body.radius, l)  # outside the dimension line
    draw_line(axes, [np.zeros(2), np.array([1.08 * reach, 0.0])], QUIET, (3, 3))
    draw_angle(axes, np.zeros(2), reach, *sorted((0.0, heading)))
    middle = (reach + 0.14 * body.width) * _direction(heading / 2)
    write_math(axes, middle, r"$\theta$")


def _draw_length(axes: Axes, ahead: Array, side: Array, body: Body) -> None:
    """Draw the axis from p to p~ and, on the free side of the body, its length."""
    draw_line(axes, [np.zeros(2), ahead], INK, (3, 2), zorder=4)
    offset = 0.95 * body.width * side
    draw_dimension(axes, np.zeros(2), ahead, offset, "$l$")


def _direction(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)
