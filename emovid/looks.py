"""What videos and figures draw alike: the outline of a robot, and which robots leave a trail."""

import numpy as np
from matplotlib.path import Path

from emovid.scene.robots import Body
from emovid.swarm.arrays import Indices


def trailed_robots(robots: int, trails: int | None) -> Indices:
    """Return which robots leave a trail: `trails` of them, evenly spread through the swarm; all for None or too few."""
    count = robots if trails is None else min(robots, trails)
    return np.arange(count) * robots // max(count, 1)


def robot_parts(body: Body) -> dict[str, Path]:
    """Return the outlines [m] of a robot seen from above, in its own frame, in drawing order."""
    parts = {}
    if body.wheel_base:
        left = _rectangle(2 * body.wheel_radius, body.wheel_width, y=body.wheel_base / 2)
        right = _rectangle(2 * body.wheel_radius, body.wheel_width, y=-body.wheel_base / 2)
        axle = _rectangle(0.6 * body.wheel_radius, body.wheel_base, y=0.0)
        parts["wheels"] = Path.make_compound_path(left, right, axle)
    parts["body"] = _rounded(body.width, body.width, body.corner)
    if body.steers:
        parts["front"] = _front_mark(body.width)
    return parts


def robot_rim(body: Body, rim: float) -> Path:
    """Return the outline [m] of a robot and all that is within `rim` [m] of it."""
    shapes = [_rounded(body.width + 2 * rim, body.width + 2 * rim, body.corner + rim)]
    if body.wheel_base:
        tyre = 2 * body.wheel_radius + 2 * rim, body.wheel_width + 2 * rim, rim
        shapes += [_rounded(*tyre, y=side * body.wheel_base / 2, edges=4) for side in (1, -1)]
    return Path.make_compound_path(*shapes)


def _rectangle(length: float, width: float, y: float = 0.0) -> Path:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2
    return Path(corners * [length, width] + [0, y], closed=True)


def _rounded(length: float, width: float, corner: float, y: float = 0.0, edges: int = 16) -> Path:
    """A rectangle with round corners, each a polygon of `edges`: by default finer than pixels at any size we draw."""
    angle = np.linspace(0, np.pi / 2, edges + 1) + np.arange(4)[:, None] * np.pi / 2
    sides = np.array([length / 2 - corner, width / 2 - corner])
    centres = sides * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    points = centres[:, None] + corner * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    points = points.reshape(-1, 2) + np.array([0, y])
    return Path(np.concatenate([points, points[:1]]), closed=True)


def _front_mark(width: float) -> Path:
    """A triangle that points forward, in the front half of the body."""
    return Path(width * np.array([[0.36, 0.0], [0.04, 0.27], [0.04, -0.27], [0.36, 0.0]]), closed=True)
