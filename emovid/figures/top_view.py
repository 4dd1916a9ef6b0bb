"""The stage from above, in print: panels of one scale, and in them the stage, trails and robots as vector paths."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.path import Path

from emovid.figures.schematic import scale_of
from emovid.figures.style import POINTS, SINGLE_COLUMN, TEXT
from emovid.scene.model import Scene
from emovid.scene.robots import Body
from emovid.scene.stage import Stage
from emovid.scene.video import THEMES, Colours
from emovid.swarm.arrays import Array
from emovid.swarm.laws import corners_of
from emovid.swarm.trajectory import Trajectory
from emovid.video.robots import robot_parts, robot_rim
from emovid.video.trails import trailed_robots

LINE = 1.4 * TEXT  # room for a line of text beside a panel [pt]

_MARGIN, _GAP = 1.0, 8.0  # around the panels and between them [pt]
_EDGE = 0.6  # width of the line around the stage [pt]
_THINNEST = 0.4  # width of a trail where a panel is small [pt]
_HALO = 0.4  # width of the light rim that lifts a robot off the trails [pt]
_FLATNESS = 0.03  # by which a trail may stray from its arcs [pt]
_SLICE = 1.0  # seconds of a trail drawn in one go, as in the videos
_INSIDE = np.array([1e-9, -1e-9])  # s; a slice has its ends, and not once more the points that are there
PAPER = THEMES["light"].model_copy(update={"stage": "#ffffff", "surround": "#ffffff"})
# Any: the stubs lack parse_math.
_AT: Any = {"xycoords": "axes fraction", "textcoords": "offset points", "annotation_clip": False, "parse_math": True}


def panels(
    bounds: Array, count: int, columns: int, width: float, *, above: float = 0.0, below: float = 0.0, gap: float = _GAP
) -> tuple[Figure, list[Axes]]:
    """Return a figure with equal panels, row by row, that show the same part of the plane at the same scale.

    Args:
        bounds: its lower left and upper right corner (2, 2) [m].
        count: of panels.
        columns: in a full row.
        width: of the figure [in].
        above: room over each panel [pt].
        below: room under each panel [pt].
        gap: between panels side by side [pt].
    """
    columns = min(columns, count)
    rows = -(-count // columns)
    page = width * POINTS
    wide = (page - 2 * _MARGIN - (columns - 1) * gap) / columns
    (left, bottom), (right, top) = bounds
    high = wide * (top - bottom) / (right - left)
    height = 2 * _MARGIN + rows * (above + high + below) + (rows - 1) * _GAP
    figure = Figure(figsize=(width, height / POINTS))
    made = []
    for i in range(count):
        row, column = divmod(i, columns)
        x = _MARGIN + column * (wide + gap)
        y = height - _MARGIN - row * (above + high + below + _GAP) - above - high
        box = (x / page, y / height, wide / page, high / height)
        made.append(figure.add_axes(box, xlim=(left, right), ylim=(bottom, top)))
        made[-1].set_axis_off()
    return figure, made


def stage_panels(
    stage: Stage,
    count: int,
    columns: int,
    width: float,
    colours: Colours = PAPER,
    *,
    above: float = 0.0,
    below: float = 0.0,
    gap: float = _GAP,
) -> tuple[Figure, list[Axes]]:
    """Return panels that each show the whole stage in the colours of the boundary and the stage. See `panels`."""
    corners = corners_of(stage)
    point = np.ptp(corners[:, 0]) * min(columns, count) / (width * POINTS)  # m, about
    bounds = np.array([corners.min(axis=0) - 0.75 * _EDGE * point, corners.max(axis=0) + 0.75 * _EDGE * point])
    figure, made = panels(bounds, count, columns, width, above=above, below=below, gap=gap)
    for axes in made:
        draw_stage(axes, stage, colours)
    return figure, made


def columns_of(count: int, width: float) -> int:
    """Return how many panels stand side by side: three over two columns of text; in one column, as few as fit."""
    if width > SINGLE_COLUMN:
        return 3
    return 1 if count <= 3 else 2


def write_below(axes: Axes, text: str) -> None:
    """Write a line of text under a panel."""
    axes.annotate(text, (0.5, 0), xytext=(0, 2 - LINE), ha="center", va="bottom", **_AT)


def write_above(axes: Axes, text: str) -> None:
    """Write a line of text over a panel."""
    axes.annotate(text, (0.5, 1), xytext=(0, LINE - 2), ha="center", va="top", **_AT)


def draw_stage(axes: Axes, stage: Stage, colours: Colours = PAPER) -> None:
    """Draw the outline of the stage, and fill it, unless it is as white as the paper."""
    outline = Polygon(corners_of(stage), edgecolor=colours.boundary, linewidth=_EDGE, joinstyle="round", zorder=1)
    outline.set(fill=colours.stage != PAPER.stage, facecolor=colours.stage)
    axes.add_patch(outline)


def draw_trails(axes: Axes, trajectory: Trajectory, until: float) -> None:
    """Draw the trails of the robots that leave one, as they are at the time `until` [s].

    In slices of time, the oldest first: each robot has its own trail behind it where several have passed.
    """
    trails, colours = trajectory.scene.video.trails, print_colours(trajectory.scene).trails
    since = 0.0 if trails.seconds is None else max(until - trails.seconds, 0.0)
    robots = trailed_robots(trajectory.scene.robots, trails.robots)
    lines = slices(trajectory, robots.tolist(), since, until, _FLATNESS / scale_of(axes))
    kinds = [colours[i % len(colours)] for i in range(len(robots))]
    width = max(trails.width * scale_of(axes), _THINNEST)
    draw_lines(axes, lines, kinds * (len(lines) // max(len(kinds), 1)), width)


def draw_lines(axes: Axes, lines: Sequence[Array], colours: Sequence[str], width: float) -> None:
    """Draw lines (P, 2) [m] one over the other, round at their ends."""
    if lines:
        drawn = LineCollection(lines, colors=colours, linewidths=width, capstyle="round", joinstyle="round", zorder=2)
        drawn.set(label="trails", snap=False)
        axes.add_collection(drawn, autolim=False)


def slices(trajectory: Trajectory, robots: Sequence[int], since: float, until: float, tolerance: float) -> list[Array]:
    """Return the paths (P, 2) [m] of robots within a time [s], cut at whole seconds: slice by slice, robot by robot."""
    if until <= since:
        return []
    inner = _SLICE * np.arange(np.floor(since / _SLICE) + 1, np.ceil(until / _SLICE))
    cuts = np.concatenate([[since], inner, [until]])
    ends = trajectory.at(cuts)[..., :2]
    traces = [trajectory.trace(robot, tolerance) for robot in robots]
    made = []
    for k in range(len(cuts) - 1):
        for robot, (times, points) in zip(robots, traces, strict=True):
            first, last = np.searchsorted(times, cuts[k : k + 2] + _INSIDE)
            made.append(np.concatenate([ends[k : k + 1, robot], points[first:last], ends[k + 1 : k + 2, robot]]))
    return made


def draw_robots(axes: Axes, body: Body, poses: Array, bodies: Sequence[str], colours: Colours) -> None:
    """Draw robots at poses (N, 3), bodies in colours of their own, as vector outlines."""
    kinds = {"rim": [colours.stage], "wheels": [colours.wheels], "body": list(bodies), "front": [colours.front]}
    parts = {"rim": robot_rim(body, _HALO / scale_of(axes)), **robot_parts(body)}
    for name, part in parts.items():
        drawn = PathCollection(_placed(part, poses), facecolors=kinds[name], edgecolors="none", linewidths=0)
        drawn.set(label=name, snap=False, zorder=3)
        axes.add_collection(drawn, autolim=False)


def draw_swarm(axes: Axes, trajectory: Trajectory, t: float) -> None:
    """Draw all robots where they are at the time `t` [s], in the colours of their trails."""
    scene = trajectory.scene
    draw_robots(axes, scene.robot.body, trajectory.at(np.array([t]))[0], body_colours(scene), print_colours(scene))


def print_colours(scene: Scene) -> Colours:
    """Return the colours of the scene's videos; a light stage that has no colour of its own is as white as paper."""
    return scene.video.colours.over(PAPER if scene.video.theme == "light" else THEMES[scene.video.theme])


def body_colours(scene: Scene) -> list[str]:
    """Return the colour of each robot's body: that of its trail, if it leaves one."""
    colours = print_colours(scene)
    bodies = [colours.body] * scene.robots
    for i, robot in enumerate(trailed_robots(scene.robots, scene.video.trails.robots)):
        bodies[robot] = colours.trails[i % len(colours.trails)]
    return bodies


def _placed(part: Path, poses: Array) -> list[Path]:
    """Return a robot's part at each pose."""
    turned = []
    for x, y, heading in poses.tolist():
        cos, sin = np.cos(heading), np.sin(heading)
        points = np.asarray(part.vertices) @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
        turned.append(Path(points, part.codes))
    return turned
