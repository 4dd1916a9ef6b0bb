"""The two ways to draw what a frame consists of: from straight above, and in perspective."""

from collections.abc import Sequence

import numpy as np
from matplotlib.colors import to_rgb

from emovid.scene.model import Scene
from emovid.scene.video import Colours, Video, ViewName
from emovid.swarm.arrays import Array
from emovid.swarm.coverage import corners_of
from emovid.video.camera import Camera
from emovid.video.canvas import Canvas, Layer, Pixels, rgba
from emovid.video.pinhole import Pinhole
from emovid.video.ribbons import ribbon
from emovid.video.robot_outlines import robot_parts, robot_rim
from emovid.video.solids import Colouring, seen_robots

_EDGE = 0.1  # width of the line around the stage, over a robot's
_HALO = 0.04  # width of the light rim that lifts a robot off the trails, over the robot's
_SKY = 0.45  # share of the stage's colour far away, where the floor ends; the rest is that of the surround
_HAZE = 6.0  # how far away the floor has mostly the colour of that, in distances of the stage's far edge


class Overhead:
    """Draws flat outlines.

    Attributes:
        camera: that sees them.
    """

    def __init__(self, scene: Scene, video: Video, colouring: Colouring) -> None:
        self.camera = Camera.framing(scene.stage, video.width, video.height)
        self._scene, self._colours, body = scene, video.palette, scene.robot.body
        self._halo = _HALO * body.width
        faces = {"wheels": colouring.wheels[None], "body": colouring.bodies, "front": colouring.front[None]}
        rim = Layer(robot_rim(body, self._halo), rgba([self._colours.stage]))
        self._robot = [rim, *(Layer(path, faces[name]) for name, path in robot_parts(body).items())]

    def draw_stage(self, canvas: Canvas) -> None:
        """Draw the stage with its edge."""
        corners = self.camera.pixels(corners_of(self._scene.stage))
        edge = _EDGE * self._scene.robot.body.width * self.camera.scale
        canvas.polygon(corners, self._colours.stage, self._colours.boundary, edge)

    def draw_lines(
        self,
        canvas: Canvas,
        lines: Sequence[Array],
        colours: Array,
        width: float,
        before: Sequence[Array | None],  # noqa: ARG002 - here, all have round ends
    ) -> None:
        """Draw lines (P, 2) [m] of a width [m], each in its colour (L, 4), one over the other."""
        canvas.lines([self.camera.pixels(line) for line in lines], colours, width * self.camera.scale)

    def draw_robots(self, canvas: Canvas, poses: Array) -> None:
        """Draw the robots at poses (N, 3)."""
        turns = _turns(poses[:, 2]) * np.array([[self.camera.scale], [self.camera.scale], [1]])
        reach = (self._scene.robot.body.radius + self._halo) * self.camera.scale
        canvas.stamp(self._robot, turns, self.camera.pixels(poses[:, :2]), reach)


class Perspective:
    """Draws what a pinhole on the side of the stage sees: a floor up to the horizon, and robots that stand on it.

    Attributes:
        camera: the pinhole.
    """

    def __init__(self, scene: Scene, video: Video, colouring: Colouring) -> None:
        self.camera = Pinhole.framing(scene.stage, video, scene.robot.body.height)
        self._scene, self._colours, self._colouring = scene, video.palette, colouring

    def draw_stage(self, canvas: Canvas) -> None:
        """Draw the floor, and on it the stage with its edge."""
        canvas.replace(_floor(self.camera, self._scene, self._colours))
        corners = corners_of(self._scene.stage)
        edge = 2 * _EDGE * self._scene.robot.body.width
        ring = np.concatenate([corners, corners[:1]])
        self.draw_lines(canvas, [ring], rgba([self._colours.boundary]), edge, [corners[-1]])
        canvas.polygon(self.camera.pixels(corners), self._colours.stage, self._colours.stage, 0.0)

    def draw_lines(
        self,
        canvas: Canvas,
        lines: Sequence[Array],
        colours: Array,
        width: float,
        before: Sequence[Array | None],
    ) -> None:
        """Draw lines (P, 2) [m] of a width [m], each in its colour (L, 4), one over the other.

        Each continues a line from the point (2,) in `before`, or starts where it does. See `ribbon`.
        """
        ribbons = [ribbon(self.camera, line, width, point) for line, point in zip(lines, before, strict=True)]
        low, high = (np.concatenate(corners) for corners in zip(*((r.low, r.high) for r in ribbons), strict=True))
        canvas.fill([ribbon.path for ribbon in ribbons], colours, low, high)

    def draw_robots(self, canvas: Canvas, poses: Array) -> None:
        """Draw the robots at poses (N, 3), far to near."""
        seen = seen_robots(self.camera, self._scene.robot.body, poses, self._colouring)
        canvas.fill(seen.paths, seen.colours, seen.low, seen.high)


View = Overhead | Perspective
VIEWS: dict[ViewName, type[Overhead] | type[Perspective]] = {"overhead": Overhead, "perspective": Perspective}


def _floor(camera: Pinhole, scene: Scene, colours: Colours) -> Pixels:
    """Return the empty room (height, width, 4): a floor that pales with its distance, and what is above its end."""
    surround, stage = (255 * np.array(to_rgb(colour)) for colour in (colours.surround, colours.stage))
    sky = surround + _SKY * (stage - surround)
    rows = camera.height - np.arange(camera.height) - 0.5  # of the pixels' middles, from below
    below = np.minimum(rows, camera.horizon - 1e-3)
    middles = np.stack([np.full(camera.height, camera.width / 2), below], axis=-1)
    away = camera.metres(middles)[:, 1] - camera.aim.y
    start = scene.stage.box[3] - camera.aim.y
    share = 1 - np.exp(-np.maximum(away / start - 1, 0) / _HAZE)
    share[rows >= camera.horizon] = 1
    room = np.full((camera.height, camera.width, 4), 255, np.uint8)
    room[..., :3] = np.round(surround + share[:, None] * (sky - surround))[:, None]
    return room


def _turns(headings: Array) -> Array:
    """Return rotations (N, 3, 3) by the headings (N,) [rad]."""
    turns = np.zeros((len(headings), 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(headings)
    turns[:, 1, 0] = np.sin(headings)
    turns[:, 0, 1] = -turns[:, 1, 0]
    turns[:, 2, 2] = 1
    return turns
