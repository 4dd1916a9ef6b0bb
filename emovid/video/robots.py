"""Robots as they are drawn: flat outlines from above, and solids on the floor in perspective.

Solids are painted from far to near. That is exact for bodies whose disks stay apart (`Body.radius`): of two equal disks
that do not meet, no straight line from a point enters the farther one first.
"""

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from matplotlib.path import Path

from emovid.scene.robots import Body, CircularShape, PolygonalShape, RectangularShape, Shape, Wheels
from emovid.swarm.arrays import Array, Indices
from emovid.video.cameras import PinholeCamera

_LIGHT = np.array([-0.6, -0.8])  # direction to the light, along the floor: left, behind the camera
_SIDE, _CONTRAST = 0.68, 0.14  # brightness of a side parallel to the light, and the change by light
_SHADES = 12  # steps of brightness of the sides
_BELOW = 0.2  # of the way to its middle that a side reaches under the top
_INSET = 0.75  # distance of a shade from the outline [pixels]
_CLEARANCE = 0.5  # height of the body's underside above the floor, over the wheels' radius
_HUB, _HUB_SIZE = 0.3, 0.65  # of a wheel: share of the body's color, radius over the wheel's
_SPOKES = 24  # corners of a wheel's outline
_SHADOW_RIM = 0.06  # by which the shadow is wider than the robot, over the body's width
_SHADOW = np.array([0.0, 0.0, 0.0, 0.16])
# Share of the top's RGBA that is left on a side, by its shade; negative shades are counted from the end.
_STEPS = np.roll(np.arange(-_SHADES // 2, _SHADES // 2 + 1), -(_SHADES // 2))
_SHARES = np.stack([*3 * [_SIDE + _CONTRAST * 2 * _STEPS / _SHADES], np.ones(_SHADES + 1)], axis=-1)


def robot_parts(body: Body) -> dict[str, Path]:
    """Return the outlines [m] of a robot from above, in its own frame, in drawing order."""
    parts = {}
    if body.wheels:
        parts["wheels"] = _wheels(body.wheels)
    parts["body"] = Path.make_compound_path(*_grown(body.shape, 0.0))
    marks = [_front_mark(body.front, body.shape.ahead)] if body.front else []
    marks += [_rounded(2 * light.radius, 2 * light.radius, light.radius, light.x, light.y) for light in body.lights]
    if marks:
        parts["front"] = Path.make_compound_path(*marks)
    return parts


def robot_rim(body: Body, rim: float) -> Path:
    """Return the outline [m] of a robot, widened by `rim` [m] on all sides."""
    shapes = _grown(body.shape, rim)
    if wheels := body.wheels:
        tyre = 2 * wheels.radius + 2 * rim, wheels.width + 2 * rim, rim
        shapes += [_rounded(*tyre, y=side * wheels.base / 2, edges=4) for side in (1, -1)]
    return Path.make_compound_path(*shapes)


def _grown(shape: Shape, rim: float) -> list[Path]:
    """Return outlines that together cover a shape widened by `rim`."""
    match shape:
        case CircularShape():
            side = 2 * shape.radius + 2 * rim
            return [_rounded(side, side, shape.radius + rim, x=shape.ahead)]
        case RectangularShape():
            sides = shape.length + 2 * rim, shape.width + 2 * rim
            return [_rounded(*sides, shape.corner + rim, x=shape.ahead)]
        case PolygonalShape():  # pragma: no branch - there is no other shape
            corners = np.array(shape.corners)
            following = np.roll(corners, -1, axis=0)
            if np.sum(corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]) < 0:
                corners = corners[::-1]  # all outlines run counter-clockwise, so that overlaps stay filled
            return [Path(np.concatenate([corners, corners[:1]]), closed=True), *(_edges(corners, rim) if rim else ())]


def _edges(corners: Array, rim: float) -> list[Path]:
    """Return the strip within `rim` of each edge of a polygon."""
    edges = []
    for one, other in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length, angle = np.hypot(*(other - one)), np.arctan2(*(other - one)[::-1])
        points = np.asarray(_rounded(length + 2 * rim, 2 * rim, rim, edges=4).vertices)
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        edges.append(Path(points @ turn + (one + other) / 2, closed=True))
    return edges


def _wheels(wheels: Wheels) -> Path:
    left, right = (_rectangle(2 * wheels.radius, wheels.width, y=side * wheels.base / 2) for side in (1, -1))
    axle = _rectangle(0.6 * wheels.radius, wheels.base, y=0.0)
    return Path.make_compound_path(left, right, axle)


def _rectangle(length: float, width: float, y: float = 0.0) -> Path:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2
    return Path(corners * [length, width] + [0, y], closed=True)


def _rounded(length: float, width: float, corner: float, x: float = 0.0, y: float = 0.0, edges: int = 16) -> Path:
    """A rectangle with round corners, each a polygon of `edges`: by default finer than pixels at every size drawn."""
    angle = np.linspace(0, np.pi / 2, edges + 1) + np.arange(4)[:, None] * np.pi / 2
    sides = np.array([length / 2 - corner, width / 2 - corner])
    centres = sides * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    points = centres[:, None] + corner * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    points = points.reshape(-1, 2) + np.array([x, y])
    return Path(np.concatenate([points, points[:1]]), closed=True)


def _front_mark(size: float, ahead: float) -> Path:
    """A triangle that points forward, in the front half of a body of that size whose middle is `ahead` of the pose."""
    corners = size * np.array([[0.36, 0.0], [0.04, 0.27], [0.04, -0.27], [0.36, 0.0]])
    return Path(corners + np.array([ahead, 0.0]), closed=True)


class RobotColours(NamedTuple):
    """The colors of a swarm, RGBA from 0 to 1.

    Attributes:
        bodies: (N, 4).
        wheels: (4,).
        front: of the mark (4,).
    """

    bodies: Array
    wheels: Array
    front: Array


class Solids(NamedTuple):
    """A swarm as the camera sees it.

    Attributes:
        paths: outlines to fill, in the order of painting [pixels].
        colours: of each (F, 4), RGBA from 0 to 1.
    """

    paths: list[Path]
    colours: Array


def robot_solids(camera: PinholeCamera, body: Body, poses: Array, colouring: RobotColours) -> Solids:
    """Return robots at poses (N, 3) as a camera above them sees them."""
    outline, shadow, mark = _outlines(body)
    shadows = camera.pixels(_placed(np.asarray(shadow.vertices), poses))
    walls = _Walls(camera, outline, poses, _CLEARANCE * body.wheels.radius if body.wheels else 0.0, body.height)
    wheels = _Wheels(camera, body.wheels, poses) if body.wheels else None
    marks = _at_height(camera, _placed(np.asarray(mark.vertices), poses), body.height) if mark else None
    middles = _placed(np.array([[body.shape.ahead, 0.0]]), poses)[:, 0]

    parts = [(Path(ring, shadow.codes), _SHADOW) for ring in shadows]
    for i in np.hypot(*(middles - camera.eye[:2]).T).argsort(kind="stable")[::-1].tolist():
        colour = colouring.bodies[i]
        hub = _HUB * colour + (1 - _HUB) * colouring.wheels
        if wheels:
            parts += wheels.behind(i, colouring.wheels)
        parts += walls.visible(i, colour)
        if wheels:
            parts += wheels.before(i, colouring.wheels, hub)
        parts.append((Path(walls.high[i]), colour))
        if mark is not None and marks is not None:
            parts.append((Path(marks[i], mark.codes), colouring.front))
    paths, colours = zip(*parts, strict=True)
    return Solids(list(paths), np.array(colours))


class _Walls:
    """The sides of robots' bodies, which are upright prisms.

    Args:
        camera: of the view.
        outline: of the prism (M, 2) [m], counter-clockwise.
        poses: (N, 3).
        bottom, top: above the floor [m].

    Attributes:
        low, high: the outline's corners at the bottom and at the top (N, M, 2) [pixels].
    """

    def __init__(self, camera: PinholeCamera, outline: Array, poses: Array, bottom: float, top: float) -> None:
        corners = _placed(outline, poses)
        self.low, self.high = (_at_height(camera, corners, up) for up in (bottom, top))
        # Strips reach so far below the top.
        self._inner = self.high + _BELOW * (self.high.mean(axis=1, keepdims=True) - self.high)
        along = np.roll(corners, -1, axis=1) - corners
        outward = np.stack([along[..., 1], -along[..., 0]], axis=-1)
        away = corners - camera.eye[:2]
        self._faces = (outward * away).sum(axis=-1) < 0  # the camera
        self._starts = self._faces & ~np.roll(self._faces, 1, axis=1)
        lit = outward @ _LIGHT / np.hypot(outward[..., 0], outward[..., 1])
        self._shades = np.round(lit * _SHADES / 2).astype(int)
        self._distance = np.hypot(away[..., 0], away[..., 1])

    def visible(self, i: int, colour: Array) -> list[tuple[Path, Array]]:
        """Return the visible sides of robot `i`: all in the shade of the longest one, then the others on top of it.

        All reach under the top, and the others keep away from the outline. So the background does not shine through
        where parts meet, and the outline is drawn once: drawn twice, it would be bolder, most of all between pixels.
        """
        parts = []
        for corners in self._runs(i):
            low, high, inner = self.low[i, corners], self.high[i, corners], self._inner[i, corners]
            shades = self._shades[i, corners[:-1]]
            steps = low[1:] - low[:-1]
            along = np.concatenate([[0.0], np.hypot(steps[:, 0], steps[:, 1]).cumsum()])
            main = int(shades[np.diff(along).argmax()])
            parts.append((Path(np.concatenate([low, high[-1:], inner[::-1], high[:1]])), colour * _SHARES[main]))
            inset = np.clip(along, _INSET, max(along[-1] - _INSET, _INSET))
            low, inner = (np.stack([np.interp(inset, along, x) for x in edge.T], axis=-1) for edge in (low, inner))
            up = inner - low
            low = low + up * np.minimum(_INSET / np.hypot(up[:, 0], up[:, 1]), 1)[:, None]
            for first, last in _strips(shades, inset):
                shade = int(shades[(first + last) // 2])
                if shade != main:
                    ring = np.concatenate([low[first : last + 1], inner[first : last + 1][::-1]])
                    parts.append((Path(ring), colour * _SHARES[shade]))
        return parts

    def _runs(self, i: int) -> list[Indices]:
        """Return the corners of runs of neighboring visible sides of robot `i`, the farthest run first."""
        faces, count = self._faces[i], self._faces.shape[1]
        runs = []
        for start in np.flatnonzero(self._starts[i]).tolist():
            length = next(k for k in range(1, count) if not faces[(start + k) % count])
            runs.append(np.arange(start, start + length + 1) % count)
        return sorted(runs, key=lambda run: -self._distance[i, run].mean()) if len(runs) > 1 else runs


class _Wheels:
    """Wheels as upright disks: the left and the right one of each robot (N).

    Args:
        camera: of the view.
        wheels: of a robot.
        poses: (N, 3).

    Attributes:
        hulls: outlines (N, 2, K, 2) [pixels].
    """

    def __init__(self, camera: PinholeCamera, wheels: Wheels, poses: Array) -> None:
        angle = 2 * np.pi * np.arange(_SPOKES) / _SPOKES
        sides = np.array([1, -1])[:, None] * (wheels.base + np.array([-1, 1]) * wheels.width) / 2  # inner and outer
        flat = np.zeros((2, 2, _SPOKES, 2))
        flat[..., 0], flat[..., 1] = wheels.radius * np.cos(angle), sides[..., None]
        placed = _placed(flat.reshape(-1, 2), poses).reshape(len(poses), 2, 2, _SPOKES, 2)
        up = np.broadcast_to(wheels.radius * (1 + np.sin(angle))[:, None], (*placed.shape[:-1], 1))
        rings = camera.project(np.concatenate([placed, up], axis=-1))
        points = rings.reshape(len(poses), 2, 2 * _SPOKES, 2)
        farthest = (points @ np.array([np.cos(angle), np.sin(angle)])).argmax(axis=2)
        self.hulls = np.take_along_axis(points, farthest[..., None], axis=2)
        middle = rings[:, :, 1].mean(axis=2, keepdims=True)
        self._hubs = middle + _HUB_SIZE * (rings[:, :, 1] - middle)
        offset = camera.eye[:2] - poses[:, :2]
        left = offset[:, 1] * np.cos(poses[:, 2]) - offset[:, 0] * np.sin(poses[:, 2])  # of the robot is the camera
        self._outside = left[:, None] * np.array([1, -1]) > sides[0, 1]

    def behind(self, i: int, tyre: Array) -> list[tuple[Path, Array]]:
        """Return the wheels of robot `i` that its body may hide."""
        return [(Path(self.hulls[i, side]), tyre) for side in (0, 1) if not self._outside[i, side]]

    def before(self, i: int, tyre: Array, hub: Array) -> list[tuple[Path, Array]]:
        """Return the wheel of robot `i` that may hide its body, if there is one."""
        near = [side for side in (0, 1) if self._outside[i, side]]
        return [part for k in near for part in ((Path(self.hulls[i, k]), tyre), (Path(self._hubs[i, k]), hub))]


@lru_cache(maxsize=8)
def _outlines(body: Body) -> tuple[Array, Path, Path | None]:
    """Return a robot's body (M, 2), its shadow and the marks on its top, in its own frame [m]."""
    parts = robot_parts(body)
    ring = np.asarray(parts["body"].vertices)
    corners = ring[:-1][np.hypot(*np.diff(ring, axis=0).T) > 1e-9]  # a square corner is a round one of radius 0
    return corners, robot_rim(body, _SHADOW_RIM * body.width), parts.get("front")


def _strips(shades: Indices, along: Array) -> Iterator[tuple[int, int]]:
    """Yield the first and the last corner of strips of one shade; one narrower than a pixel joins the next."""
    first = 0
    for cut in [*(np.flatnonzero(np.diff(shades)) + 1).tolist(), len(shades)]:
        if along[cut] - along[first] >= 1:
            yield first, cut
            first = cut


def _placed(points: Array, poses: Array) -> Array:
    """Return points (P, 2) of a robot's frame for robots at poses (N, 3): (N, P, 2) [m]."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turns = np.stack([np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)], axis=-2)
    return points @ turns + poses[:, None, :2]


def _at_height(camera: PinholeCamera, points: Array, up: float) -> Array:
    return camera.project(np.concatenate([points, np.full_like(points[..., :1], up)], axis=-1))
