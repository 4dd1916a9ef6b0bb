"""The stage in perspective, in print: as the videos show it from their camera, cut to the stage, as vector paths."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.path import Path

from emovid.figures.schematic import scale_of
from emovid.figures.top_view import body_colours, panels, print_colours, slices
from emovid.scene.model import Scene
from emovid.swarm.arrays import Array
from emovid.swarm.laws import corners_of
from emovid.swarm.trajectory import Trajectory
from emovid.video.cameras import PinholeCamera
from emovid.video.robots import RobotColours, robot_solids
from emovid.video.trails import ribbon, trailed_robots

_EDGE = 0.6  # width of the line around the stage [pt]
_THINNEST = 0.4  # width of a trail in the middle of the stage where a panel is small [pt]
_FLATNESS = 0.03  # by which a trail may stray from its arcs [pt]
_MARGIN = 0.01  # around the stage, over its width in the picture


def seen_panels(
    scene: Scene, count: int, columns: int, width: float, *, above: float = 0.0, below: float = 0.0
) -> tuple[Figure, list[Axes], PinholeCamera]:
    """Return panels that each show the stage from the scene's camera, the camera's pixels their units. See `panels`."""
    camera = PinholeCamera.framing(scene.stage, scene.video, scene.robot.body.height)
    corners = corners_of(scene.stage)
    tops = np.column_stack([corners, np.full(len(corners), scene.robot.body.height)])
    seen = np.concatenate([camera.pixels(corners), camera.project(tops)])
    margin = _MARGIN * np.ptp(seen[:, 0])
    bounds = np.array([seen.min(axis=0) - margin, seen.max(axis=0) + margin])
    figure, made = panels(bounds, count, columns, width, above=above, below=below)
    colours = print_colours(scene)
    for axes in made:
        outline = Polygon(camera.pixels(corners), facecolor=colours.stage, edgecolor=colours.boundary)
        outline.set(linewidth=_EDGE, joinstyle="round", zorder=1)
        axes.add_patch(outline)
    return figure, made, camera


def draw_seen_trails(axes: Axes, trajectory: Trajectory, until: float, camera: PinholeCamera) -> None:
    """Draw the trails on the floor as they are at the time `until` [s]."""
    trails, colours = trajectory.scene.video.trails, print_colours(trajectory.scene).trails
    since = 0.0 if trails.seconds is None else max(until - trails.seconds, 0.0)
    robots = trailed_robots(trajectory.scene.robots, trails.robots)
    point = scale_of(axes)  # of the page, per pixel
    lines = slices(trajectory, robots.tolist(), since, until, _FLATNESS / point / camera.max_scale)
    width = max(trails.width, _THINNEST / point / camera.scale)
    kinds = [to_rgba(colours[i % len(robots) % len(colours)]) for i in range(len(lines))]
    # Each but those of the first slice continues the same robot's of the slice before.
    before = [None] * len(robots) + [line[-2] for line in lines[: -len(robots) or None]]
    if lines:
        ribbons = [ribbon(camera, line, width, point) for line, point in zip(lines, before, strict=True)]
        _fill(axes, [made.path for made in ribbons], np.array(kinds), 2)


def draw_seen_swarm(axes: Axes, trajectory: Trajectory, t: float, camera: PinholeCamera) -> None:
    """Draw all robots where they are at the time `t` [s], in the colours of their trails."""
    scene, colours = trajectory.scene, print_colours(trajectory.scene)
    bodies = np.array([to_rgba(colour) for colour in body_colours(scene)])
    colouring = RobotColours(bodies, *(np.array(to_rgba(colour)) for colour in (colours.wheels, colours.front)))
    seen = robot_solids(camera, scene.robot.body, trajectory.at(np.array([t]))[0], colouring)
    _fill(axes, seen.paths, seen.colours, 3)


def _fill(axes: Axes, outlines: Sequence[Path], colours: Array, zorder: float) -> None:
    drawn = PathCollection(list(outlines), facecolors=list(map(tuple, colours)), edgecolors="none", linewidths=0)
    drawn.set(snap=False, zorder=zorder)
    axes.add_collection(drawn, autolim=False)
