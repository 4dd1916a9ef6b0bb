"""Frames: a trajectory at one instant, as a picture.

What never changes is drawn once and kept as the background.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np
from matplotlib.colors import to_rgba

from emovid.scene.behaviour import Coverage
from emovid.scene.video import Video
from emovid.signals import held_signals
from emovid.swarm.arrays import Array
from emovid.swarm.densities import density_of
from emovid.swarm.trajectory import Trajectory
from emovid.video import overlays
from emovid.video.camera import AnyCamera
from emovid.video.canvas import Box, Canvas, Pixels, rgba
from emovid.video.robot_outlines import trailed_robots
from emovid.video.solids import Colouring
from emovid.video.view import VIEWS

_FLATNESS = 0.1  # pixels by which a trail may stray from its arcs
_SLICE = 1.0  # seconds of a trail drawn in one go
_SHADES = 16  # steps in which a trail fades
_INSTANT = 1e-9  # seconds: times of samples are that near to those they stand for


class Painter:
    """Draws any frame of one trajectory.

    Trails are drawn in slices of time, the oldest first, so that each robot has its own trail behind it where several
    have passed. Slices that are complete stay in the background: a frame's cost does not grow with the run, and a frame
    does not depend on which ones were drawn before it.

    Args:
        trajectory: what to draw.
        video: the look; the scene's own if left out.
    """

    @held_signals()  # see `frame`
    def __init__(self, trajectory: Trajectory, video: Video | None = None) -> None:
        scene = trajectory.scene
        self.video = video or scene.video
        self._trajectory = trajectory
        # The robots of a frame stand at the ends of its trails, which start where others did.
        self._poses = lru_cache(maxsize=2 * _SHADES)(lambda t: trajectory.at(np.array([t]))[0])
        self._colours = self.video.palette
        self._canvas = Canvas(self.video.width, self.video.height, self._colours.surround)
        self._trailed = trailed_robots(scene.robots, self.video.trails.robots)
        self._trail_colours = self._shades()
        self._view = VIEWS[self.video.view](scene, self.video, self._colouring())
        tolerance = _FLATNESS / self.camera.finest
        self._trails = [trajectory.trace(robot, tolerance) for robot in self._trailed]
        self._draw_stage()
        self._empty, self._slices = self._canvas.pixels.copy(), 0

    @property
    def camera(self) -> AnyCamera:
        """What sees the stage."""
        return self._view.camera

    @held_signals()  # Agg asks Python for things, and makes what a signal raises meanwhile an error of its own
    def frame(self, t: float) -> Pixels:
        """Return the frame (height, width, 4) at time `t` [s]: RGBA, row 0 on top, overwritten by the next call."""
        poses = self._poses(t)
        self._start(t)
        self._draw_trails(t)
        if self.video.overlays.cells:
            cells = overlays.cells_of(self._trajectory.scene.stage, poses[:, :2])
            overlays.draw_cells(self._canvas, self.camera, cells, self._colours.overlay)
        self._view.draw_robots(self._canvas, poses)
        if self.video.overlays.targets:
            targets = overlays.targets_of(self._trajectory.scene, poses[:, :2], t)
            overlays.draw_targets(self._canvas, self.camera, poses[:, :2], targets, self._colours)
        if self.video.overlays.clock:
            overlays.draw_clock(self._canvas, self.camera, t, self._colours.overlay)
        return self._canvas.pixels

    def changed(self) -> list[Box]:
        """Return boxes that hold all that differs between this frame and the one at the last call."""
        return self._canvas.changed()

    def _start(self, t: float) -> None:
        """Start the frame with all slices of trails that are complete by `t`, if trails stay for ever."""
        complete = 0 if self.video.trails.seconds else int(t // _SLICE)
        if complete < self._slices:
            self._canvas.replace(self._empty)
            self._slices = 0
        self._canvas.restore()
        if complete > self._slices:
            for i in range(self._slices, complete):
                self._draw_slice(i * _SLICE, (i + 1) * _SLICE, 0.0)
            self._slices = complete
            self._canvas.keep()

    def _draw_trails(self, t: float) -> None:
        """Draw what the background does not hold."""
        seconds = self.video.trails.seconds
        oldest = 0.0 if seconds is None else max(t - seconds, 0.0)
        if seconds and self.video.trails.fade:
            cuts = t - seconds * np.linspace(1, 0, _SHADES + 1)
            for shade, (start, end) in enumerate(pairwise(cuts)):
                self._draw_slice(max(start, 0.0), end, oldest, shade)
            return
        since = max(self._slices * _SLICE, oldest)
        for i in range(int(since // _SLICE), int(t // _SLICE) + 1):
            self._draw_slice(max(i * _SLICE, since), min((i + 1) * _SLICE, t), oldest)

    def _draw_slice(self, start: float, end: float, oldest: float, shade: int = -1) -> None:
        """Draw each trail, of which there is nothing before the time `oldest` [s], from time `start` to time `end`."""
        if end <= start or not len(self._trailed):
            return
        first_ends, last_ends = (self._poses(t)[self._trailed, None, :2] for t in (start, end))
        lines, before = [], []
        for (times, points), first_end, last_end in zip(self._trails, first_ends, last_ends, strict=True):
            first, last = times.searchsorted([start + _INSTANT, end - _INSTANT])
            lines.append(np.concatenate([first_end, points[first:last], last_end]))
            earlier = times.searchsorted(start - _INSTANT) - 1
            before.append(points[earlier] if start > oldest and earlier >= 0 else None)
        self._view.draw_lines(self._canvas, lines, self._trail_colours[shade], self.video.trails.width, before)

    def _shades(self) -> Array:
        """Return the colours of the trails (_SHADES, trails, 4) by age, from nearly the stage's to their own."""
        colours = self._colours.trails
        full = np.array([to_rgba(colours[i % len(colours)]) for i in range(len(self._trailed))]).reshape(-1, 4)
        share = np.linspace(0, 1, _SHADES + 1)[1:, None, None]
        # Mixed, not translucent: where two pieces of a trail overlap, nothing shows.
        return full * share + np.array(to_rgba(self._colours.stage)) * (1 - share)

    def _colouring(self) -> Colouring:
        colours, robots = self._colours, self._trajectory.scene.robots
        bodies = np.tile(to_rgba(colours.body), (robots, 1))
        bodies[self._trailed] = self._trail_colours[-1]
        return Colouring(bodies, *rgba([colours.wheels, colours.front]))

    def _draw_stage(self) -> None:
        scene, colours = self._trajectory.scene, self._colours
        self._view.draw_stage(self._canvas)
        if self.video.overlays.density and isinstance(scene.behaviour, Coverage):
            density = density_of(scene.behaviour.density, scene.stage)
            overlays.paint_density(self._canvas.pixels, self.camera, scene.stage, density, colours.density)
        self._canvas.keep()
