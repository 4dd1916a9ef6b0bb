"""From interactions, information and control law to the behavior of a swarm (Fig. 2), for both kinds of law.

Each row shows one run: the interactions, the information of one robot, its control law, and the swarm's behavior.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from emovid.figures.control_laws import AGENT, ARROW, TARGET, centroids, contour_of, draw_contour, draw_discs
from emovid.figures.schematic import ANGULAR, LINEAR, PALE, THIN, draw_arrow, draw_line, draw_turn
from emovid.figures.stage_panels import (
    LINE,
    draw_robots,
    draw_swarm,
    draw_trails,
    print_colours,
    stage_panels,
    write_above,
    write_below,
)
from emovid.figures.style import DOUBLE_COLUMN, FAINT, INK, POINTS, QUIET, in_style
from emovid.scene.behaviour import Coverage
from emovid.swarm.arrays import Array, Indices
from emovid.swarm.laws import corners_of, followed_points, start_angles
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import wrapped
from emovid.swarm.voronoi import voronoi_cells

_COLUMNS = ("Interactions", "Information", "Control law", "Swarm behavior")
_CONTOUR = ("none", "own point on the contour", r"$u_i = x(\theta_i(t), t) - \tilde{p}_i$")
_COVERAGE = ("Voronoi neighbors", "positions of neighbors", r"$u_i = \kappa\,(c_i - p_i)$")
_GAP = 20.0  # between panels, for the arrows that lead from one to the next [pt]
_CELL = "#dce8f4"
# Angles at which v, omega and u do not overlap: of the heading from x, and of u from the heading.
_HEADING, _ASIDE = np.radians(10), np.radians(40)
_ROUNDING = 1e-7  # m
_ENDS = np.array([-1, 1])


@in_style()
def interaction_figure(
    runs: Sequence[Trajectory], times: Sequence[float], behaviours: Sequence[str], *, width: float = DOUBLE_COLUMN
) -> Figure:
    """Draw a row of four panels for each run: interactions, information, control law, swarm behavior (Fig. 2).

    Args:
        runs: of unicycles, on stages of one size.
        times: of the first three panels of each [s]; the last panel shows the end.
        behaviours: of the swarms, in words.
        width: of the figure [in].
    """
    across, stage = 4 if width >= DOUBLE_COLUMN else 2, runs[0].scene.stage
    figure, axes = stage_panels(stage, 4 * len(runs), across, width, above=LINE, below=LINE, gap=_GAP)
    for row, (run, t, behaviour) in enumerate(zip(runs, times, behaviours, strict=True)):
        period = int(np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, len(run.commands) - 1))
        robot = clearest_robot(run, period)
        group = axes[4 * row : 4 * row + 4]
        covers = isinstance(run.scene.behaviour, Coverage)
        _draw_interactions(group[0], run, period)
        (_draw_cell if covers else _draw_target)(group[1], run, period, robot)
        _draw_command(group[2], run, period, robot)
        draw_trails(group[3], run, float(run.t[-1]))
        draw_swarm(group[3], run, float(run.t[-1]))
        texts = _COVERAGE if covers else _CONTOUR
        for panel, heading, text in zip(group, _COLUMNS, (*texts, behaviour), strict=True):
            if row == 0 or across < 4:
                write_above(panel, heading)
            write_below(panel, text)
        for panel in group[:-1] if across == 4 else group[::2]:
            _draw_step(panel)
    return figure


def clearest_robot(run: Trajectory, period: int) -> int:
    """Return the robot whose command in a control period is the most legible in a wide panel."""
    assert run.scene.robot.l is not None
    v, lateral = run.commands[period, :, 0], run.scene.robot.l * run.commands[period, :, 1]
    off = np.abs(np.abs(np.arctan2(lateral, v)) - _ASIDE) + np.abs(wrapped(run.poses[period, :, 2] - _HEADING))
    return int(np.argmin(np.where(np.hypot(v, lateral) > 0, off, np.inf)))


def neighbours(points: Array, cells: Array) -> Indices:
    """Return the pairs (C, 2) of robots (N, 2) [m] whose Voronoi cells (N, M, 2) share an edge, each pair once.

    The middle of a shared edge has the same distance from both robots.
    """
    found = set()
    for i, cell in enumerate(cells):
        after = np.roll(cell, -1, axis=0)
        proper = np.linalg.norm(after - cell, axis=1) > _ROUNDING
        away = np.linalg.norm((cell + after)[proper, None] / 2 - points, axis=-1)
        shared = (np.abs(away - away[:, i, None]) < _ROUNDING).any(axis=0)
        found |= {(min(i, j), max(i, j)) for j in np.nonzero(shared)[0].tolist() if j != i}
    return np.array(sorted(found), dtype=np.intp).reshape(-1, 2)


def _draw_interactions(axes: Axes, run: Trajectory, period: int) -> None:
    """Draw the swarm, and a line between every two robots that interact."""
    points = run.poses[period, :, :2]
    if isinstance(run.scene.behaviour, Coverage):
        for pair in neighbours(points, voronoi_cells(points, corners_of(run.scene.stage))):
            axes.plot(*points[pair].T, color=ARROW, linewidth=0.6, zorder=2, label="interaction")
    colours = print_colours(run.scene)
    draw_robots(axes, run.scene.robot.body, run.poses[period], [colours.body] * run.scene.robots, colours)


def _draw_target(axes: Axes, run: Trajectory, period: int, robot: int) -> None:
    """Draw the contour and the point that a robot follows."""
    contour, t = contour_of(run.scene), float(run.t[period])
    place = run.poses[period, robot, :2]
    target = followed_points(contour, start_angles(run.scene.robots), t)[robot]
    draw_contour(axes, contour, t)
    draw_discs(axes, place[None], 5, AGENT, "agent")
    draw_discs(axes, target[None], 4, TARGET, "target")
    _frame(axes, np.array([place, target]), 0.15 * np.ptp(axes.get_ylim()))
    outwards = -_away_from(target - np.array([contour.centre.x, contour.centre.y]))
    _name(axes, place, -outwards, "$p_i$")
    _name(axes, target, outwards, r"$x(\theta_i)$", 13)


def _draw_cell(axes: Axes, run: Trajectory, period: int, robot: int) -> None:
    """Draw a robot, its neighbors, and its Voronoi cell with the centroid."""
    points = run.poses[period, :, :2]
    cells = voronoi_cells(points, corners_of(run.scene.stage))
    pairs = neighbours(points, cells)
    known = pairs[(pairs == robot).any(axis=1)].sum(axis=1) - robot
    place, target = points[robot], centroids(run.scene, points)[robot]
    axes.add_patch(Polygon(cells[robot], facecolor=_CELL, edgecolor=QUIET, linewidth=THIN, zorder=0.5))
    for other in points[known]:
        draw_arrow(axes, other, other + 0.86 * (place - other), FAINT, THIN)
    draw_discs(axes, points[known], 5, INK, "neighbours")
    draw_discs(axes, place[None], 5, AGENT, "agent")
    axes.plot(*target, "+", color=INK, markersize=5, markeredgewidth=1.2, zorder=6)
    _frame(axes, np.concatenate([points[known], cells[robot]]), 0.02)
    _name(axes, place, _away_from(points[known] - place, target - place), "$p_i$")
    _name(axes, target, _away_from(place - target), "$c_i$")


def _draw_command(axes: Axes, run: Trajectory, period: int, robot: int) -> None:
    """Draw a robot with u at its look-ahead point, and the resulting v and omega."""
    body, l = run.scene.robot.body, run.scene.robot.l or 0.0
    (x, y, heading), (v, omega) = run.poses[period, robot], run.commands[period, robot]
    along, across = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    seconds = 0.75 * body.width / max(np.hypot(v, l * omega), _ROUNDING)
    place = np.array([x, y])
    wanted = seconds * (v * along + l * omega * across)
    shown = np.array([place - body.radius, place + body.radius, place + l * along + wanted])
    _frame(axes, shown, 0.22 * body.width)
    draw_robots(axes, body, np.array([[x, y, heading]]), [PALE.body], PALE)
    tip, ahead = place + seconds * v * along, place + l * along
    draw_arrow(axes, place, tip, LINEAR)
    draw_arrow(axes, ahead, ahead + wanted)
    turned = np.sign(omega) or 1.0
    draw_turn(axes, place, 0.36 * body.width, heading + turned * 1.9, heading + turned * 3.6, ANGULAR)
    draw_line(axes, [place, ahead], INK, (3, 2), zorder=4)
    for point in (place, ahead):
        axes.plot(*point, "o", color=INK, markersize=2.5, zorder=6)
    _name(axes, ahead + wanted, turned * across, "$u_i$", 5)
    _name(axes, tip, -turned * across, "$v_i$", 5)
    back = heading + turned * 2.75
    _name(axes, place + 0.36 * body.width * np.array([np.cos(back), np.sin(back)]), -along, r"$\omega_i$", 6)


def _frame(axes: Axes, points: Array, room: float) -> None:
    """Show the part of the plane with points (P, 2) and `room` around them [m], in the panel's proportions."""
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    size = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())])
    half = ((high - low) / size).max() * size / 2
    middle = (low + high) / 2
    axes.set(xlim=middle[0] + half[0] * _ENDS, ylim=middle[1] + half[1] * _ENDS)


def _name(axes: Axes, place: Array, direction: Array, name: str, away: float = 8.0) -> None:
    """Write a name `away` [pt] from a place."""
    how: Any = {"textcoords": "offset points", "ha": "center", "va": "center", "parse_math": True, "zorder": 6}
    axes.annotate(name, tuple(place), xytext=tuple(away * direction), **how)


def _away_from(*directions: Array) -> Array:
    """Return the direction (2,) in the middle of the widest gap between directions (..., 2)."""
    angles = np.sort([np.arctan2(y, x) for x, y in np.concatenate([np.atleast_2d(each) for each in directions])])
    gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
    middle = angles[np.argmax(gaps)] + gaps.max() / 2
    return np.array([np.cos(middle), np.sin(middle)])


def _draw_step(axes: Axes) -> None:
    """Draw an arrow from a panel to the next one."""
    how = {"arrowstyle": "-|>", "color": QUIET, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9}
    at = axes.transAxes
    width = axes.bbox.width / axes.figure.dpi * POINTS
    start, end = 1 + 4 / width, 1 + (_GAP - 4) / width
    axes.annotate("", (end, 0.5), xytext=(start, 0.5), xycoords=at, textcoords=at, arrowprops=how)
