"""What videos and figures draw alike: the outline of a robot, and which robots leave a trail."""

import numpy as np
from matplotlib.path import Path

from emovid.scene.robots import Body, CircularShape, PolygonalShape, RectangularShape, Shape, Wheels
from emovid.swarm.arrays import Array, Indices


def trailed_robots(robots: int, trails: int | None) -> Indices:
    """Return which robots leave a trail: `trails` of them, evenly spread through the swarm; all for None or too few."""
    count = robots if trails is None else min(robots, trails)
    return np.arange(count) * robots // max(count, 1)


def robot_parts(body: Body) -> dict[str, Path]:
    """Return the outlines [m] of a robot seen from above, in its own frame, in drawing order."""
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
    """Return the outline [m] of a robot and all that is within `rim` [m] of it."""
    shapes = _grown(body.shape, rim)
    if wheels := body.wheels:
        tyre = 2 * wheels.radius + 2 * rim, wheels.width + 2 * rim, rim
        shapes += [_rounded(*tyre, y=side * wheels.base / 2, edges=4) for side in (1, -1)]
    return Path.make_compound_path(*shapes)


def _grown(shape: Shape, rim: float) -> list[Path]:
    """Return outlines that together hold a shape and all that is within `rim` of it."""
    match shape:
        case CircularShape():
            side = 2 * shape.radius + 2 * rim
            return [_rounded(side, side, shape.radius + rim, x=shape.ahead)]
        case RectangularShape():
            sides = shape.length + 2 * rim, shape.width + 2 * rim
            return [_rounded(*sides, shape.corner + rim, x=shape.ahead)]
        case PolygonalShape():  # pragma: no branch - there is no other
            corners = np.array(shape.corners)
            following = np.roll(corners, -1, axis=0)
            if np.sum(corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]) < 0:
                corners = corners[::-1]  # all outlines run one way round: where they overlap, they fill
            return [Path(np.concatenate([corners, corners[:1]]), closed=True), *(_edges(corners, rim) if rim else ())]


def _edges(corners: Array, rim: float) -> list[Path]:
    """Return what is within `rim` of each edge of a polygon."""
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
    """A rectangle with round corners, each a polygon of `edges`: by default finer than pixels at any size we draw."""
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
