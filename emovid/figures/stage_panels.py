"""Panels that show the stage in print, from above or in perspective: stage, trails and robots as vector paths."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.path import Path
from matplotlib.typing import ColorType

from emovid.figures.schematic import scale_of
from emovid.figures.style import POINTS, SINGLE_COLUMN, TEXT
from emovid.scene.model import Scene
from emovid.scene.robots import Body
from emovid.scene.stage import Stage
from emovid.scene.video import THEMES, Colours
from emovid.swarm.arrays import Array
from emovid.swarm.laws import corners_of
from emovid.swarm.trajectory import Trajectory
from emovid.video.cameras import PinholeCamera
from emovid.video.robots import RobotColours, robot_parts, robot_rim, robot_solids
from emovid.video.trails import Trails, faded, oldest, ribbon, spans, trail_colours, trailed_robots

LINE = 1.4 * TEXT  # height of a line of text beside a panel [pt]
PAPER = THEMES["light"].model_copy(update={"stage": "#ffffff", "surround": "#ffffff"})

_MARGIN, _GAP = 1.0, 8.0  # around the panels and between them [pt]
_EDGE = 0.6  # width of the line around the stage [pt]
_THINNEST = 0.75  # smallest width of a trail, in the middle of the stage [pt]
_HALO = 0.4  # width of the light rim that separates a robot from trails below it [pt]
_FLATNESS = 0.03  # largest deviation of a drawn trail from its arcs [pt]
_SIDE_MARGIN = 0.01  # around a stage in perspective, over its width in the picture
# Any: the stubs lack parse_math.
_AT: Any = {"xycoords": "axes fraction", "textcoords": "offset points", "annotation_clip": False, "parse_math": True}


def panels(
    bounds: Array, count: int, columns: int, width: float, *, above: float = 0.0, below: float = 0.0, gap: float = _GAP
) -> tuple[Figure, list[Axes]]:
    """Return a figure with equal panels, row by row, that show the same part of the plane at the same scale.

    Args:
        bounds: lower left and upper right corner (2, 2) [m] of that part.
        count: number of panels.
        columns: panels in a full row.
        width: of the figure [in].
        above: height for text over each panel [pt].
        below: height for text under each panel [pt].
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
    """Return panels that each show the whole stage from above, filled unless it is white as paper. See `panels`."""
    corners = corners_of(stage)
    point = np.ptp(corners[:, 0]) * min(columns, count) / (width * POINTS)  # m, about
    bounds = np.array([corners.min(axis=0) - 0.75 * _EDGE * point, corners.max(axis=0) + 0.75 * _EDGE * point])
    figure, made = panels(bounds, count, columns, width, above=above, below=below, gap=gap)
    for axes in made:
        outline = Polygon(corners, edgecolor=colours.boundary, linewidth=_EDGE, joinstyle="round", zorder=1)
        outline.set(fill=colours.stage != PAPER.stage, facecolor=colours.stage)
        axes.add_patch(outline)
    return figure, made


def perspective_panels(
    scene: Scene, count: int, columns: int, width: float, *, above: float = 0.0, below: float = 0.0
) -> tuple[Figure, list[Axes], PinholeCamera]:
    """Return panels that each show the stage from the scene's camera, in its pixels, and the camera. See `panels`."""
    camera = PinholeCamera.framing(scene.stage, scene.video, scene.robot.body.height)
    corners, colours = corners_of(scene.stage), print_colours(scene)
    tops = np.column_stack([corners, np.full(len(corners), scene.robot.body.height)])
    seen = np.concatenate([camera.pixels(corners), camera.project(tops)])
    margin = _SIDE_MARGIN * np.ptp(seen[:, 0])
    bounds = np.array([seen.min(axis=0) - margin, seen.max(axis=0) + margin])
    figure, made = panels(bounds, count, columns, width, above=above, below=below)
    for axes in made:
        outline = Polygon(camera.pixels(corners), facecolor=colours.stage, edgecolor=colours.boundary)
        outline.set(linewidth=_EDGE, joinstyle="round", zorder=1)
        axes.add_patch(outline)
    return figure, made, camera


def columns_of(count: int, width: float) -> int:
    """Return the number of panels side by side: three in two columns of text; in one column, as few as fit."""
    if width > SINGLE_COLUMN:
        return 3
    return 1 if count <= 3 else 2


def write_below(axes: Axes, text: str) -> None:
    """Write a line of text, or several, under a panel."""
    lines = text.count("\n") + 1
    axes.annotate(text, (0.5, 0), xytext=(0, 2 - lines * LINE), ha="center", va="bottom", **_AT)


def write_above(axes: Axes, text: str) -> None:
    """Write a line of text over a panel."""
    axes.annotate(text, (0.5, 1), xytext=(0, LINE - 2), ha="center", va="top", **_AT)


def draw_trails(
    axes: Axes, trajectory: Trajectory, until: float, camera: PinholeCamera | None = None, thinnest: float = _THINNEST
) -> None:
    """Draw the trails as they are at the time `until` [s], at least `thinnest` [pt] wide.

    From above, or as a camera sees them.
    """
    look, colours, point = trajectory.scene.video.trails, print_colours(trajectory.scene), scale_of(axes)
    robots = trailed_robots(trajectory.poses[0], look.robots)
    trails = Trails(trajectory, robots, _FLATNESS / point / (camera.max_scale if camera else 1))
    shown = spans(look, until)
    pieces = [piece for span in shown for piece in trails.pieces(span, oldest(look, until))]
    mixed = faded(trail_colours(colours, len(robots)), colours.stage, [span.share for span in shown])
    rgba = [tuple(colour) for colour in mixed.tolist()]
    if camera is None:
        draw_lines(axes, [piece.line for piece in pieces], rgba, max(look.width * point, thinnest))
    elif pieces:
        width = max(look.width, thinnest / point / camera.scale)
        ribbons = [ribbon(camera, piece.line, width, piece.before) for piece in pieces]
        _fill(axes, ribbons, rgba, 2)


def draw_lines(axes: Axes, lines: Sequence[Array], colours: Sequence[ColorType], width: float) -> None:
    """Draw lines (P, 2) [m] of a width [pt] one over the other, with round ends."""
    if lines:
        drawn = LineCollection(lines, colors=colours, linewidths=width, capstyle="round", joinstyle="round", zorder=2)
        drawn.set(label="trails", snap=False)
        axes.add_collection(drawn, autolim=False)


def draw_robots(axes: Axes, body: Body, poses: Array, bodies: Sequence[str], colours: Colours) -> None:
    """Draw robots at poses (N, 3) from above, each body in its own color."""
    kinds = {"rim": [colours.stage], "wheels": [colours.wheels], "body": list(bodies), "front": [colours.front]}
    parts = {"rim": robot_rim(body, _HALO / scale_of(axes)), **robot_parts(body)}
    for name, part in parts.items():
        drawn = PathCollection(_placed(part, poses), facecolors=kinds[name], edgecolors="none", linewidths=0)
        drawn.set(label=name, snap=False, zorder=3)
        axes.add_collection(drawn, autolim=False)


def draw_swarm(axes: Axes, trajectory: Trajectory, t: float, camera: PinholeCamera | None = None) -> None:
    """Draw all robots at the time `t` [s] in the colors of their trails, from above or as a camera sees them."""
    scene, poses = trajectory.scene, trajectory.at(np.array([t]))[0]
    colours, bodies = print_colours(scene), body_colours(trajectory)
    if camera is None:
        draw_robots(axes, scene.robot.body, poses, bodies, colours)
    else:
        rgba = [np.array(to_rgba(colour)) for colour in (*bodies, colours.wheels, colours.front)]
        solids = robot_solids(camera, scene.robot.body, poses, RobotColours(np.array(rgba[:-2]), *rgba[-2:]))
        # Shadows are mixed with the stage, not translucent, which EPS is not.
        stage, alpha = np.array(to_rgba(colours.stage)), solids.colours[:, 3:]
        mixed = alpha * np.insert(solids.colours[:, :3], 3, 1, axis=1) + (1 - alpha) * stage
        _fill(axes, solids.paths, list(map(tuple, mixed)), 3)


def print_colours(scene: Scene) -> Colours:
    """Return the colors of the scene's videos; a light stage without a color of its own is white as paper."""
    return scene.video.colours.over(PAPER if scene.video.theme == "light" else THEMES[scene.video.theme])


def body_colours(trajectory: Trajectory) -> list[str]:
    """Return the color of each robot's body: that of its trail, if it leaves one."""
    scene, colours = trajectory.scene, print_colours(trajectory.scene)
    bodies = [colours.body] * scene.robots
    for i, robot in enumerate(trailed_robots(trajectory.poses[0], scene.video.trails.robots)):
        bodies[robot] = colours.trails[i % len(colours.trails)]
    return bodies


def _placed(part: Path, poses: Array) -> list[Path]:
    """Return a part of a robot at each pose."""
    turned = []
    for x, y, heading in poses.tolist():
        cos, sin = np.cos(heading), np.sin(heading)
        points = np.asarray(part.vertices) @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
        turned.append(Path(points, part.codes))
    return turned


def _fill(axes: Axes, outlines: Sequence[Path], colours: Sequence[ColorType], zorder: float) -> None:
    drawn = PathCollection(list(outlines), facecolors=colours, edgecolors="none", linewidths=0)
    drawn.set(snap=False, zorder=zorder)
    axes.add_collection(drawn, autolim=False)
