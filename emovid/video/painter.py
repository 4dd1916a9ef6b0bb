"""Frames: a trajectory at one instant, as a picture, from above or in perspective.

Everything that never changes is drawn once and kept as the background.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.path import Path

from emovid.scene.behaviour import Coverage
from emovid.scene.model import Scene
from emovid.scene.video import Colours, Video, ViewName
from emovid.signals import held_signals
from emovid.swarm.arrays import Array
from emovid.swarm.densities import density_of
from emovid.swarm.laws import corners_of
from emovid.swarm.trajectory import Trajectory
from emovid.video import overlays
from emovid.video.cameras import Camera, OverheadCamera, PinholeCamera
from emovid.video.canvas import Canvas, Change, Layer, Pixels, rgba
from emovid.video.robots import RobotColours, robot_parts, robot_rim, robot_solids
from emovid.video.trails import PIECE, Piece, Span, Trails, faded, oldest, ribbon, spans, trail_colours, trailed_robots

_FLATNESS = 0.1  # largest deviation of a drawn trail from its arcs [pixels]
_PREPARED = 64  # pieces of time whose paths are remembered: more than a frame shows
_EDGE = 0.1  # width of the line around the stage, over a robot's width
_HALO = 0.04  # width of the light rim that separates a robot from trails below it, over the robot's width
_SKY = 0.45  # share of the stage's color at the horizon; the rest is the color of the surround
_HAZE = 6.0  # distance at which the floor has mostly the color of the horizon, over that of the stage's far edge


class Painter:
    """Draws any frame of one trajectory.

    Complete pieces of trails stay in the background: the cost of a frame does not grow with the run, and a frame does
    not depend on the frames drawn before it.

    Args:
        trajectory: the run to draw.
        video: the look; by default that of the scene.
    """

    @held_signals()  # see `frame`
    def __init__(self, trajectory: Trajectory, video: Video | None = None) -> None:
        scene = trajectory.scene
        self.trajectory, self.video = trajectory, video or scene.video
        self._scene, self._colours = scene, self.video.palette
        self._canvas = Canvas(self.video.width, self.video.height, self._colours.surround)
        trailed = trailed_robots(trajectory.poses[0], self.video.trails.robots)
        self._trail_colours = trail_colours(self._colours, len(trailed))
        self._first_of_colour = np.sort(np.unique(self._trail_colours, axis=0, return_index=True)[1])
        bodies = np.tile(to_rgba(self._colours.body), (scene.robots, 1))
        bodies[trailed] = self._trail_colours
        robot_colours = RobotColours(bodies, *rgba([self._colours.wheels, self._colours.front]))
        self._view = VIEWS[self.video.view](scene, self.video, robot_colours)
        self._trails = Trails(trajectory, trailed, _FLATNESS / self.camera.max_scale)
        self._paths = lru_cache(_PREPARED)(self._prepared)  # most pieces of a trail are those of the frame before
        self._draw_stage()
        self._empty, self._kept = self._canvas.pixels.copy(), 0  # pieces of trails that the background holds

    @property
    def camera(self) -> Camera:
        """The camera of the view."""
        return self._view.camera

    @held_signals()  # Agg calls Python, and would turn the exception of a signal into an error of its own
    def frame(self, t: float) -> Pixels:
        """Return the frame (height, width, 4) at time `t` [s]: RGBA, row 0 on top, overwritten by the next call."""
        poses = self._trails.poses(t)
        self._start(t)
        self._draw_trails(spans(self.video.trails, t, self._kept * PIECE), oldest(self.video.trails, t))
        if self.video.overlays.cells:
            cells = overlays.cells_of(self._scene.stage, poses[:, :2])
            overlays.draw_cells(self._canvas, self.camera, cells, self._colours.overlay)
        if self.video.overlays.targets:  # they lie on the floor, under the robots
            targets = overlays.targets_of(self._scene, poses[:, :2], t)
            overlays.draw_targets(self._canvas, self.camera, poses[:, :2], targets, self._colours)
        self._view.draw_robots(self._canvas, poses)
        if self.video.overlays.clock:
            overlays.draw_clock(self._canvas, self.camera, t, self._colours.overlay)
        return self._canvas.pixels

    def changed(self) -> Change:
        """Return the differences between this frame and the frame at the last call."""
        return self._canvas.changed()

    def _start(self, t: float) -> None:
        """Start the frame with all complete pieces of permanent trails."""
        complete = 0 if self.video.trails.seconds else int(t // PIECE)
        if complete < self._kept:
            self._canvas.replace(self._empty)
            self._kept = 0
        self._canvas.restore()
        if complete > self._kept:
            self._draw_trails([Span(i * PIECE, (i + 1) * PIECE) for i in range(self._kept, complete)], 0.0)
            self._kept = complete
            self._canvas.keep()

    def _draw_trails(self, parts: list[Span], oldest: float) -> None:
        paths = [path for part in parts for path in self._paths(part.start, part.end, oldest)]
        if paths:
            colours = faded(
                self._trail_colours[self._first_of_colour], self._colours.stage, [part.share for part in parts]
            )
            self._view.draw_lines(self._canvas, paths, colours, self.video.trails.width)

    def _prepared(self, start: float, end: float, oldest: float) -> list[Path]:
        """Return one path for each color of trails: far fewer to draw than one for each robot."""
        paths = self._view.line_paths(self._trails.pieces(Span(start, end), oldest), self.video.trails.width)
        alike = [(self._trail_colours == self._trail_colours[first]).all(axis=1) for first in self._first_of_colour]
        return [Path.make_compound_path(*(paths[i] for i in np.flatnonzero(same))) for same in alike]

    def _draw_stage(self) -> None:
        scene, colours = self._scene, self._colours
        self._view.draw_stage(self._canvas)
        if self.video.overlays.density and isinstance(scene.behaviour, Coverage):
            density = density_of(scene.behaviour.density, scene.stage)
            overlays.paint_density(self._canvas.pixels, self.camera, scene.stage, density, colours.density)
        self._canvas.keep()


class OverheadView:
    """Draws flat outlines from above.

    Attributes:
        camera: above the stage.
    """

    def __init__(self, scene: Scene, video: Video, robot_colours: RobotColours) -> None:
        self.camera = OverheadCamera.framing(scene.stage, video.width, video.height)
        self._scene, self._colours, body = scene, video.palette, scene.robot.body
        self._halo = _HALO * body.width
        faces = {"wheels": robot_colours.wheels[None], "body": robot_colours.bodies, "front": robot_colours.front[None]}
        rim = Layer(robot_rim(body, self._halo), rgba([self._colours.stage]))
        self._robot = [rim, *(Layer(path, faces[name]) for name, path in robot_parts(body).items())]

    def draw_stage(self, canvas: Canvas) -> None:
        """Draw the stage with its edge."""
        corners = self.camera.pixels(corners_of(self._scene.stage))
        edge = _EDGE * self._scene.robot.body.width * self.camera.scale
        canvas.polygon(corners, self._colours.stage, self._colours.boundary, edge)

    def line_paths(self, pieces: Sequence[Piece], width: float) -> list[Path]:  # noqa: ARG002 - the other view needs it
        """Return the paths that `draw_lines` takes for lines of a width [m]."""
        return [Path(self.camera.pixels(piece.line)) for piece in pieces]

    def draw_lines(self, canvas: Canvas, paths: Sequence[Path], colours: Array, width: float) -> None:
        """Draw lines of a width [m], each in its color (L, 4), one over the other."""
        canvas.strokes(paths, colours, width * self.camera.scale)

    def draw_robots(self, canvas: Canvas, poses: Array) -> None:
        """Draw the robots at poses (N, 3)."""
        turns = _rotations(poses[:, 2]) * np.array([[self.camera.scale], [self.camera.scale], [1]])
        canvas.stamp(self._robot, turns, self.camera.pixels(poses[:, :2]))


class PerspectiveView:
    """Draws the view of a camera at the side of the stage: a floor up to the horizon, and robots that stand on it.

    Attributes:
        camera: a pinhole.
    """

    def __init__(self, scene: Scene, video: Video, robot_colours: RobotColours) -> None:
        self.camera = PinholeCamera.framing(scene.stage, video, scene.robot.body.height)
        self._scene, self._colours, self._robot_colours = scene, video.palette, robot_colours

    def draw_stage(self, canvas: Canvas) -> None:
        """Draw the floor, and on it the stage with its edge."""
        canvas.replace(_floor(self.camera, self._scene, self._colours))
        corners = corners_of(self._scene.stage)
        edge = 2 * _EDGE * self._scene.robot.body.width
        ring = Piece(np.concatenate([corners, corners[:1]]), corners[-1])
        self.draw_lines(canvas, self.line_paths([ring], edge), rgba([self._colours.boundary]), edge)
        canvas.polygon(self.camera.pixels(corners), self._colours.stage, self._colours.stage, 0.0)

    def line_paths(self, pieces: Sequence[Piece], width: float) -> list[Path]:
        """Return the paths that `draw_lines` takes for lines of a width [m]."""
        return [ribbon(self.camera, piece.line, width, piece.before) for piece in pieces]

    def draw_lines(self, canvas: Canvas, paths: Sequence[Path], colours: Array, width: float) -> None:  # noqa: ARG002
        """Draw lines of a width [m], each in its color (L, 4), one over the other."""
        canvas.fill(paths, colours)

    def draw_robots(self, canvas: Canvas, poses: Array) -> None:
        """Draw the robots at poses (N, 3), far to near."""
        solids = robot_solids(self.camera, self._scene.robot.body, poses, self._robot_colours)
        canvas.fill(solids.paths, solids.colours)


VIEWS: dict[ViewName, type[OverheadView] | type[PerspectiveView]] = {
    "overhead": OverheadView,
    "perspective": PerspectiveView,
}


def _floor(camera: PinholeCamera, scene: Scene, colours: Colours) -> Pixels:
    """Return the empty scene (height, width, 4): a floor that pales with distance, up to the horizon and above it."""
    surround, stage = (255 * np.array(to_rgb(colour)) for colour in (colours.surround, colours.stage))
    sky = surround + _SKY * (stage - surround)
    rows = camera.height - np.arange(camera.height) - 0.5  # centers of the pixels, from below
    below = np.minimum(rows, camera.horizon - 1e-3)
    middles = np.stack([np.full(camera.height, camera.width / 2), below], axis=-1)
    away = camera.metres(middles)[:, 1] - camera.aim.y
    start = scene.stage.box[3] - camera.aim.y
    share = 1 - np.exp(-np.maximum(away / start - 1, 0) / _HAZE)
    share[rows >= camera.horizon] = 1
    room = np.full((camera.height, camera.width, 4), 255, np.uint8)
    room[..., :3] = np.round(surround + share[:, None] * (sky - surround))[:, None]
    return room


def _rotations(headings: Array) -> Array:
    """Return rotations (N, 3, 3) by the headings (N,) [rad]."""
    turns = np.zeros((len(headings), 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(headings)
    turns[:, 1, 0] = np.sin(headings)
    turns[:, 0, 1] = -turns[:, 1, 0]
    turns[:, 2, 2] = 1
    return turns
