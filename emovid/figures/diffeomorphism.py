"""The near-identity diffeomorphism (Appendix B) in one drawing, as Fig. 17: what a robot's commands do to p~."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emovid.figures.schematic import (
    ANGULAR,
    LINEAR,
    PALE,
    draw_angle,
    draw_arrow,
    draw_dimension,
    draw_line,
    draw_turn,
    drawing,
    write_math,
)
from emovid.figures.style import INK, QUIET, SINGLE_COLUMN, in_style
from emovid.figures.top_view import draw_robots
from emovid.scene.robots import Body
from emovid.swarm.arrays import Array
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import wrapped

_HIGHEST = 2.3  # of the page [in]
# The angles that show all parts apart: of the heading from x, and of u from the heading.
_HEADING, _ASIDE = np.radians(30), np.radians(38)


def clearest_step(trajectory: Trajectory) -> tuple[Array, Array]:
    """Return the pose (3,) and the command (2,) of the step that shows the geometry best.

    Of all steps of all robots, the one whose heading and direction of u come nearest to those of a legible drawing.

    Raises:
        ValueError: for robots without a look-ahead point, or none of which moves.
    """
    l = trajectory.scene.robot.l
    if not trajectory.scene.robot.body.steers or l is None or not trajectory.commands.any():
        raise ValueError("no step of a unicycle that moves")
    poses, (v, omega) = trajectory.poses[:-1], np.moveaxis(trajectory.commands, -1, 0)
    off = np.abs(wrapped(poses[..., 2] - _HEADING)) + np.abs(wrapped(np.arctan2(l * omega, v) - _ASIDE))
    step = np.unravel_index(np.argmin(np.where(np.hypot(v, l * omega) > 0, off, np.inf)), off.shape)
    return poses[step], trajectory.commands[step]


@in_style()
def diffeomorphism_figure(pose: Array, command: Array, body: Body, l: float, *, width: float = SINGLE_COLUMN) -> Figure:
    """Draw a robot at a pose, its look-ahead point p~, and what a command does to both.

    The velocity K u of p~ has the parts v along the heading and l omega across it; all three are drawn to one scale, as
    is the robot.

    Args:
        pose: (3,) x [m], y [m], heading [rad]; only the heading is seen.
        command: (2,) v [m/s], omega [rad/s].
        body: of the robot.
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
    figure, axes = drawing(np.array([low, high]), width, _HIGHEST)
    draw_robots(axes, body, np.array([[0, 0, heading]]), [PALE.body], PALE)
    turned = np.sign(command[1]) or 1.0
    _draw_frame(axes, low, body, l, heading)
    _draw_length(axes, ahead, -turned * across, body)
    for part, colour in ((forward, LINEAR), (sideways, ANGULAR), (forward + sideways, INK)):
        draw_arrow(axes, ahead, ahead + part, colour)
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
    write_math(axes, ahead + forward + sideways + 1.1 * beside * _unit(forward + sideways), r"$K u$")
    return figure


def _draw_frame(axes: Axes, low: Array, body: Body, l: float, heading: float) -> None:
    """Draw the directions of x and y and, at p, the angle of the heading."""
    reach = 0.6 * body.width
    corner = low + 0.12 * body.width
    for name, tip in (("x", np.array([reach, 0])), ("y", np.array([0, reach]))):
        draw_arrow(axes, corner, corner + tip, QUIET, 0.6)
        write_math(axes, corner + 1.2 * tip, f"${name}$", QUIET)
    reach = 1.4 * max(body.radius, l)  # beyond the dimension line's way to p~
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
