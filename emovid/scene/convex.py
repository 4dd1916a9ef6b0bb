"""Convex polygons: whether corners make one, the lines of its edges, and its largest circle.

Corners are pairs (x, y) [m]. An outline is all of them, counter-clockwise. In plain numbers, since a scene is read
without arrays.
"""

from collections.abc import Iterator, Sequence
from math import atan2, hypot, pi
from typing import NamedTuple

Corner = tuple[float, float]
Outline = tuple[Corner, ...]

_SAME = 1e-6  # m; a corner that is no farther from its neighbour, or from the line past it, is none


class Edge(NamedTuple):
    """The line of an edge: a point (p, q) on it or on the inner side has x p + y q <= offset.

    Attributes:
        x, y: its unit normal, outwards.
        offset: its distance from the origin [m], negative if the origin is outside.
    """

    x: float
    y: float
    offset: float


def first_fault(corners: Sequence[Corner]) -> tuple[int, str] | None:
    """Return the first corner that a convex polygon could not have, and what is wrong with it.

    Args:
        corners: three or more, in order around the polygon, either way.
    """
    sides = [_from_to(a, b) for a, b in _pairs(corners)]
    doubled_area = sum(_cross(a, b) for a, b in _pairs(corners))
    for i, side in enumerate(sides):
        if hypot(*side) <= _SAME:
            return max(i, (i + 1) % len(sides)), "the same place as the corner beside it: expected each corner once"
    whole_turn = 0.0
    for i, after in enumerate(sides):
        before = sides[i - 1]
        turn = _cross(before, after)
        if abs(turn) <= _SAME * hypot(before[0] + after[0], before[1] + after[1]):
            return i, "on the line between the corners beside it: expected corners only"
        whole_turn += atan2(turn, _dot(before, after))
        if turn * doubled_area <= 0 or abs(whole_turn) > 3 * pi:
            return i, "not convex here: expected the corners of a convex stage, in order around it"
    return None


def outline_of(corners: Sequence[Corner]) -> Outline:
    """Return the corners of a convex polygon, given either way, counter-clockwise from the leftmost, lowest one."""
    clockwise = sum(_cross(a, b) for a, b in _pairs(corners)) < 0
    ring = tuple(reversed(corners)) if clockwise else tuple(corners)
    first = ring.index(min(ring))
    return ring[first:] + ring[:first]


def edges_of(outline: Outline) -> tuple[Edge, ...]:
    """Return the lines of the edges; of an upright rectangle right, left, top, bottom.

    Their order is that of their directions, so that a sum over them has the same last digit however corners are listed.
    """
    edges = []
    for a, b in _pairs(outline):
        along = _from_to(a, b)
        length = hypot(*along)
        x, y = along[1] / length, -along[0] / length
        edges.append(Edge(x, y, x * a[0] + y * a[1]))
    return tuple(sorted(edges, key=lambda edge: (-abs(edge.x), -edge.x, -edge.y)))


def inradius_of(outline: Outline) -> float:
    """Return the radius [m] of the largest circle inside.

    All edges move inwards at one speed. An edge of length L between corners that turn by a and b has shrunk to a point
    after L / (tan(a/2) + tan(b/2)), and its neighbours meet. If they are parallel, or part, nothing is left inside.
    """
    sides = [_from_to(a, b) for a, b in _pairs(outline)]
    lengths = [hypot(*side) for side in sides]
    ways = [(x / length, y / length) for (x, y), length in zip(sides, lengths, strict=True)]
    radius = 0.0
    while True:
        ends = [_half_tangent(a, b) for a, b in _pairs(ways)]
        losses = [ends[i - 1] + end for i, end in enumerate(ends)]
        lives = [length / loss for length, loss in zip(lengths, losses, strict=True)]
        shortest = min(lives)
        gone = lives.index(shortest)
        radius += shortest
        if _cross(ways[gone - 1], ways[(gone + 1) % len(ways)]) <= 0:
            return radius
        lengths = [length - shortest * loss for length, loss in zip(lengths, losses, strict=True)]
        del lengths[gone], ways[gone]


def _half_tangent(a: Corner, b: Corner) -> float:
    """Return tan(angle / 2) of the angle from one unit vector to another, in the form that stays exact up to pi."""
    return _cross(a, b) / (1 + _dot(a, b)) if _dot(a, b) >= 0 else (1 - _dot(a, b)) / _cross(a, b)


def _pairs(ring: Sequence[Corner]) -> Iterator[tuple[Corner, Corner]]:
    """Yield each with the next, and the last with the first."""
    return zip(ring, [*ring[1:], ring[0]], strict=True)


def _from_to(a: Corner, b: Corner) -> Corner:
    return b[0] - a[0], b[1] - a[1]


def _dot(a: Corner, b: Corner) -> float:
    return a[0] * b[0] + a[1] * b[1]


def _cross(a: Corner, b: Corner) -> float:
    return a[0] * b[1] - a[1] * b[0]
