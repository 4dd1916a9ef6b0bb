"""Frames: a trajectory at one instant, drawn by matplotlib's Agg straight into one buffer.

What never changes is drawn once and copied. Everything else goes through `draw_path_collection`: unlike markers it does
not snap to whole pixels, which would make slow robots jerk, and unlike lines it neither simplifies paths nor reads the
user's matplotlibrc.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_rgba
from matplotlib.path import Path
from matplotlib.transforms import IdentityTransform
from numpy.typing import NDArray

from emovid.scene.model import Stage
from emovid.scene.robots import Body
from emovid.scene.video import Video
from emovid.swarm.arrays import Array, Indices
from emovid.swarm.trajectory import Trajectory
from emovid.video.camera import Camera

Pixels = NDArray[np.uint8]

_FLATNESS = 0.1  # pixels by which a trail may stray from its arcs
_SLICE = 1.0  # seconds of a trail drawn in one go
_EDGE = 0.003  # width of the line around the stage [m]
_HALO = 0.0012  # width of the light rim that lifts a robot off the trails [m]


class Painter:
    """Draws any frame of one trajectory.

    Trails are drawn in slices of time, the oldest first, so that each robot has its own trail behind it where several
    have passed. Slices that are complete stay in the background: a frame's cost does not grow with the run, and a frame
    does not depend on which ones were drawn before it.

    Args:
        trajectory: what to draw.
        video: the look; the scene's own if left out.
    """

    def __init__(self, trajectory: Trajectory, video: Video | None = None) -> None:
        scene = trajectory.scene
        self.video = video or scene.video
        self.camera = Camera.framing(scene.stage, self.video.width, self.video.height)
        self._trajectory = trajectory
        # At 72 dots per inch a point is a pixel. Any: matplotlib's stubs know less than its Agg renderer takes.
        agg: Any = RendererAgg
        self._renderer = agg(self.video.width, self.video.height, 72)
        self._pixels: Pixels = np.asarray(self._renderer.buffer_rgba())
        self._parts = robot_parts(scene.robot.body)
        self._outline = Path.make_compound_path(
            *(self._parts[name] for name in ("wheels", "body") if name in self._parts)
        )
        self._trailed = trailed_robots(scene.robots, self.video.trails.robots)
        self._trails = [self._trail(robot) for robot in self._trailed]
        self._colours = self._part_colours(scene.robots)
        self._draw_stage(scene.stage)
        self._empty = self._pixels.copy()
        self._background, self._slices = self._empty.copy(), 0

    def frame(self, t: float) -> Pixels:
        """Return the frame (height, width, 4) at time `t` [s]: RGBA, row 0 on top, overwritten by the next call."""
        poses = self._trajectory.at(np.array([t]))[0]
        self._copy_background(t)
        self._draw_trails(t)
        self._draw_robots(poses)
        return self._pixels

    def _copy_background(self, t: float) -> None:
        """Start the frame with all slices of trails that are complete by `t`, if trails stay for ever."""
        complete = 0 if self.video.trails.seconds else int(t // _SLICE)
        if complete < self._slices:
            self._background, self._slices = self._empty.copy(), 0
        np.copyto(self._pixels, self._background)
        if complete > self._slices:
            for i in range(self._slices, complete):
                self._draw_slice(i * _SLICE, (i + 1) * _SLICE)
            self._slices = complete
            np.copyto(self._background, self._pixels)

    def _draw_trails(self, t: float) -> None:
        """Draw what the background does not hold."""
        seconds = self.video.trails.seconds
        since = self._slices * _SLICE if seconds is None else max(t - seconds, 0.0)
        for i in range(int(since // _SLICE), int(t // _SLICE) + 1):
            self._draw_slice(max(i * _SLICE, since), min((i + 1) * _SLICE, t))

    def _draw_slice(self, start: float, end: float) -> None:
        """Draw each trail from time `start` to time `end` [s]."""
        trails, colours = self.video.trails, self.video.colours.trails
        if end <= start or not len(self._trailed):
            return
        ends = self.camera.pixels(self._trajectory.at(np.array([start, end]))[:, self._trailed, :2])
        lines = []
        for i, (times, points) in enumerate(self._trails):
            first, last = np.searchsorted(times, [start, end], side="right")
            lines.append(Path(np.concatenate([ends[:1, i], points[first:last], ends[1:, i]])))
        edge = _rgba([colours[i % len(colours)] for i in range(len(lines))])
        self._collection(lines, edge=edge, width=trails.width * self.camera.scale)

    def _trail(self, robot: int) -> tuple[Array, Array]:
        times, points = self._trajectory.trace(robot, _FLATNESS / self.camera.scale)
        return times, self.camera.pixels(points)

    def _part_colours(self, robots: int) -> dict[str, Array]:
        colours = self.video.colours
        bodies = np.tile(to_rgba(colours.body), (robots, 1))
        for i, robot in enumerate(self._trailed):
            bodies[robot] = to_rgba(colours.trails[i % len(colours.trails)])
        return {"wheels": _rgba([colours.wheels]), "body": bodies, "front": _rgba([colours.front])}

    def _draw_stage(self, stage: Stage) -> None:
        colours = self.video.colours
        rectangle = Path(self.camera.pixels(np.asarray(_rectangle(stage.width, stage.height).vertices)), closed=True)
        self._pixels[:] = np.round(255 * np.array(to_rgba(colours.surround)))
        width = _EDGE * self.camera.scale
        # The line lies outside the stage: half of it is drawn over by the floor.
        self._collection([rectangle], edge=_rgba([colours.boundary]), width=2 * width)
        self._collection([rectangle], face=_rgba([colours.stage]))

    def _draw_robots(self, poses: Array) -> None:
        turns = _turns(poses[:, 2]) * np.array([[self.camera.scale], [self.camera.scale], [1]])
        offsets = self.camera.pixels(poses[:, :2])
        halo = _rgba([self.video.colours.stage])
        rim = 2 * _HALO * self.camera.scale
        self._collection([self._outline], turns, offsets, edge=halo, width=rim)
        for name, path in self._parts.items():
            self._collection([path], turns, offsets, face=self._colours[name])

    def _collection(
        self,
        paths: Sequence[Path],
        turns: Array | None = None,
        offsets: Array | None = None,
        *,
        face: Array | None = None,
        edge: Array | None = None,
        width: float = 0.0,
    ) -> None:
        """Draw paths, anti-aliased at sub-pixel positions, with round joins and caps."""
        gc = self._renderer.new_gc()
        gc.set_snap(False)
        gc.set_antialiased(True)
        gc.set_capstyle("round")
        gc.set_joinstyle("round")
        none = np.empty((0, 4))
        self._renderer.draw_path_collection(
            gc,
            IdentityTransform(),
            paths,
            np.empty((0, 3, 3)) if turns is None else turns,
            np.empty((0, 2)) if offsets is None else offsets,
            IdentityTransform(),
            none if face is None else face,
            none if edge is None else edge,
            np.array([width]),
            [(0, None)],
            np.array([True]),
            None,
            "screen",
        )


def trailed_robots(robots: int, trails: int) -> Indices:
    """Return which robots leave a trail: `trails` of them, or all, evenly spread through the swarm."""
    count = min(robots, trails)
    return np.arange(count) * robots // max(count, 1)


def robot_parts(body: Body) -> dict[str, Path]:
    """Return the outlines [m] of a robot seen from above, in its own frame, in drawing order."""
    parts = {}
    if body.wheel_base:
        left = _rectangle(2 * body.wheel_radius, body.wheel_width, y=body.wheel_base / 2)
        right = _rectangle(2 * body.wheel_radius, body.wheel_width, y=-body.wheel_base / 2)
        axle = _rectangle(0.6 * body.wheel_radius, body.wheel_base, y=0.0)
        parts["wheels"] = Path.make_compound_path(left, right, axle)
    parts["body"] = _rounded_square(body.width, body.corner)
    if body.steers:
        parts["front"] = _front_mark(body.width)
    return parts


def _rectangle(length: float, width: float, y: float = 0.0) -> Path:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2
    return Path(corners * [length, width] + [0, y], closed=True)


def _rounded_square(width: float, corner: float) -> Path:
    """A square about the origin with round corners: a polygon, finer than pixels at any size we draw."""
    angle = np.linspace(0, np.pi / 2, 17) + np.arange(4)[:, None] * np.pi / 2
    centres = (width / 2 - corner) * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    points = centres[:, None] + corner * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    points = points.reshape(-1, 2)
    return Path(np.concatenate([points, points[:1]]), closed=True)


def _front_mark(width: float) -> Path:
    """A triangle that points forward, in the front half of the body."""
    return Path(width * np.array([[0.36, 0.0], [0.04, 0.27], [0.04, -0.27], [0.36, 0.0]]), closed=True)


def _turns(headings: Array) -> Array:
    """Return rotations (N, 3, 3) by the headings (N,) [rad]."""
    turns = np.zeros((len(headings), 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(headings)
    turns[:, 1, 0] = np.sin(headings)
    turns[:, 0, 1] = -turns[:, 1, 0]
    turns[:, 2, 2] = 1
    return turns


def _rgba(colours: Sequence[str]) -> Array:
    return np.array([to_rgba(colour) for colour in colours])
