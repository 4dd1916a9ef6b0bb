"""Robots that stand up from the floor: bodies as upright prisms, wheels as discs, seen by a pinhole.

Parts are painted from far to near. That is exact for bodies whose discs stay apart (`Body.radius`): of two equal discs
that do not meet, no straight line from a point enters the farther one first.
"""

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from matplotlib.path import Path

from emovid.scene.robots import Body, Wheels
from emovid.swarm.arrays import Array, Indices
from emovid.video.pinhole import Pinhole
from emovid.video.robot_outlines import robot_parts, robot_rim

_LIGHT = np.array([-0.6, -0.8])  # where light comes from, along the floor: from the left, behind the camera
_SIDE, _CONTRAST = 0.68, 0.14  # share of its colour that a side across the light has, and what light adds or takes
_SHADES = 12  # steps of a side's colour between both ends
_BELOW = 0.2  # of the way to its middle that a side reaches below the top
_INSET = 0.75  # by which a shade keeps off the outline [pixels]
_CLEARANCE = 0.5  # of the body's underside above the floor, over the wheels' radius
_HUB, _HUB_SIZE = 0.3, 0.65  # of a wheel: share of the body's colour, radius over the wheel's
_SPOKES = 24  # corners of a wheel's outline
_SHADOW_RIM = 0.06  # by which the shadow is wider than the robot, over the body's width
_SHADOW = np.array([0.0, 0.0, 0.0, 0.16])
# What is left of a top's RGBA on a side, by its shade: from the last, the negative ones.
_STEPS = np.roll(np.arange(-_SHADES // 2, _SHADES // 2 + 1), -(_SHADES // 2))
_SHARES = np.stack([*3 * [_SIDE + _CONTRAST * 2 * _STEPS / _SHADES], np.ones(_SHADES + 1)], axis=-1)


class Colouring(NamedTuple):
    """The colours of a swarm, RGBA from 0 to 1.

    Attributes:
        bodies: (N, 4).
        wheels: (4,).
        front: of the mark (4,).
    """

    bodies: Array
    wheels: Array
    front: Array


class Seen(NamedTuple):
    """A swarm as it is seen.

    Attributes:
        paths: what to fill, in the order of painting [pixels].
        colours: of each (F, 4), RGBA from 0 to 1.
        low, high: corners of boxes (N, 2) that together hold it [pixels].
    """

    paths: list[Path]
    colours: Array
    low: Array
    high: Array


def seen_robots(camera: Pinhole, body: Body, poses: Array, colouring: Colouring) -> Seen:
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
        parts += walls.seen(i, colour)
        if wheels:
            parts += wheels.before(i, colouring.wheels, hub)
        parts.append((Path(walls.high[i]), colour))
        if mark is not None and marks is not None:
            parts.append((Path(marks[i], mark.codes), colouring.front))
    paths, colours = zip(*parts, strict=True)
    everything = [shadows, walls.low, walls.high, *([wheels.hulls.reshape(len(poses), -1, 2)] if wheels else [])]
    low, high = (np.array([ends(ring, axis=1) for ring in everything]) for ends in (np.min, np.max))
    return Seen(list(paths), np.array(colours), low.min(axis=0), high.max(axis=0))


class _Walls:
    """The sides of upright prisms.

    Args:
        camera: that sees them.
        outline: of the prism (M, 2) [m], counter-clockwise.
        poses: (N, 3).
        bottom, top: above the floor [m].

    Attributes:
        low, high: the outline's corners at the bottom and at the top (N, M, 2) [pixels].
    """

    def __init__(self, camera: Pinhole, outline: Array, poses: Array, bottom: float, top: float) -> None:
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

    def seen(self, i: int, colour: Array) -> list[tuple[Path, Array]]:
        """Return the sides of robot `i` that are seen: all in the shade of the longest, and on it the others.

        All reach below the top and the others keep off the outline. So nothing behind shines through where parts meet,
        and the outline is drawn once: what is drawn twice is bolder, and more so between pixels than on them.
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
        """Return the corners of the sides of robot `i` that are seen, side by side; of the farthest run first."""
        faces, count = self._faces[i], self._faces.shape[1]
        runs = []
        for start in np.flatnonzero(self._starts[i]).tolist():
            length = next(k for k in range(1, count) if not faces[(start + k) % count])
            runs.append(np.arange(start, start + length + 1) % count)
        return sorted(runs, key=lambda run: -self._distance[i, run].mean()) if len(runs) > 1 else runs


class _Wheels:
    """Wheels as upright discs: of each robot (N) the left and the right one.

    Args:
        camera: that sees them.
        wheels: of a robot.
        poses: (N, 3).

    Attributes:
        hulls: outlines (N, 2, K, 2) [pixels].
    """

    def __init__(self, camera: Pinhole, wheels: Wheels, poses: Array) -> None:
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
        """Return the wheel of robot `i` that may hide its body, if the camera is on that side."""
        seen = [side for side in (0, 1) if self._outside[i, side]]
        return [part for k in seen for part in ((Path(self.hulls[i, k]), tyre), (Path(self._hubs[i, k]), hub))]


@lru_cache(maxsize=8)
def _outlines(body: Body) -> tuple[Array, Path, Path | None]:
    """Return a robot's body (M, 2) with each corner once, its shadow and the marks on its top, in its own frame [m]."""
    parts = robot_parts(body)
    ring = np.asarray(parts["body"].vertices)
    corners = ring[:-1][np.hypot(*np.diff(ring, axis=0).T) > 1e-9]  # a square corner is a round one of radius 0
    return corners, robot_rim(body, _SHADOW_RIM * body.width), parts.get("front")


def _strips(shades: Indices, along: Array) -> Iterator[tuple[int, int]]:
    """Yield the first and the last corner of strips of one shade; what is narrower than a pixel joins the next one."""
    first = 0
    for cut in [*(np.flatnonzero(np.diff(shades)) + 1).tolist(), len(shades)]:
        if along[cut] - along[first] >= 1:
            yield first, cut
            first = cut


def _placed(points: Array, poses: Array) -> Array:
    """Return points (P, 2) of a robot's frame at poses (N, 3): (N, P, 2) [m]."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turns = np.stack([np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)], axis=-2)
    return points @ turns + poses[:, None, :2]


def _at_height(camera: Pinhole, points: Array, up: float) -> Array:
    return camera.project(np.concatenate([points, np.full_like(points[..., :1], up)], axis=-1))
