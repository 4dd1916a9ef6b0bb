"""Voronoi cells within a convex stage as fans of triangles about the robots, in time N log N; and pairs of neighbors.

Positions and vectors are complex numbers: conj(a) b is the dot product of a and b, plus i times their cross product.

Two cells meet along the bisector of two robots that are linked in the Delaunay triangulation. From a robot at p to one
at p + d, the bisector is p + d/2 + s i d; the border of the two cells ends where s is half the cotangent of the angle
that faces the link, in the triangle on either side. The border is clipped to the stage, and the parts of the stage's
edges that the borders leave open close the cells. No circumcenter is computed, so flat triangles with distant
circumcenters do no harm.

In a small swarm, all pairs of robots are compared with all others: this takes three fifths of Qhull's time for 15
robots, and as much for 25. scipy is imported for large swarms only: its import takes as long as drawing eight seconds
of video.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from emovid.swarm.arrays import Array, Complex, Indices, Mask

_FEW_POINTS = 40  # for which comparing all pairs is faster than building a tree
_FEW = 20  # robots for which pairs are faster than Qhull
_TOLERANCE = 1e-9  # far above rounding (1e-12), far below the effect of a wrong triangulation (1e-3)


def pairs_within(points: Array, distance: float) -> tuple[Indices, Indices]:
    """Return the pairs i < j, (P,) each and in order, of points (N, 2) at most `distance` apart."""
    if len(points) <= _FEW_POINTS:
        i, j = all_pairs(len(points))
        x, y = (points[j] - points[i]).T
        near = np.flatnonzero(x * x + y * y <= distance * distance)
        return i[near], j[near]
    from scipy.spatial import cKDTree  # noqa: PLC0415 - see above

    near = cKDTree(points).query_pairs(distance, output_type="ndarray")
    i, j = near[np.lexsort(near.T[::-1])].T
    return i, j


@cache
def all_pairs(points: int) -> tuple[Indices, Indices]:
    """Return all pairs i < j, (P,) each and in order."""
    i, j = np.triu_indices(points, 1)
    return i, j


def clipped_cells(robots: Complex, outline: Complex) -> list[Complex]:
    """Return the corners of each robot's cell [m] from the robot, counter-clockwise: slow, and simple.

    A cell is the stage, clipped at the bisectors to the other robots.

    Args:
        robots: (N,) [m], no two coincident.
        outline: corners of the convex stage (C,) [m], counter-clockwise.
    """
    return [_clipped_cell(robots - robot, outline - robot) for robot in robots]


def _clipped_cell(others: Complex, cell: Complex) -> Complex:
    """Clip at the bisectors to the others, nearest first, until they are twice as far as the farthest corner."""
    nearest_first = np.argsort(np.abs(others), kind="stable")[1:]  # the first is the robot itself
    for other in others[nearest_first]:
        if np.abs(other) >= 2 * np.max(np.abs(cell), initial=0.0):
            break
        cell = _clip(cell, other)
    return cell


def _clip(cell: Complex, other: complex) -> Complex:
    """Return the part of a convex polygon that is no nearer to `other` than to the origin."""
    beyond = (np.conj(other) * cell).real - abs(other) ** 2 / 2
    out = beyond > 0
    crossed = out != np.roll(out, -1)
    share = beyond / np.where(crossed, beyond - np.roll(beyond, -1), 1.0)
    crossing = cell + share * (np.roll(cell, -1) - cell)
    return np.stack([cell, crossing], axis=1)[np.stack([~out, crossed], axis=1)]


class Fans(NamedTuple):
    """Triangles, each with one corner at a robot, that tile the robots' cells and so the stage.

    Attributes:
        cell_of: the cell of each robot (N,); coincident robots share it.
        robot: the position of each cell's robots (cells,) [m].
        cell: the cell of each triangle (K,).
        a, b: its other corners (K,) [m] as seen from the robot, counter-clockwise.
        borders: number B of borders between two cells. Each is a side of two triangles: of the first B, and of the next
            B in the same order.
    """

    cell_of: Indices
    robot: Complex
    cell: Indices
    a: Complex
    b: Complex
    borders: int


class _Links(NamedTuple):
    """Pairs of neighbors i, j (L,), and the ends of their borders on the bisectors (L,): s, infinite for no end.

    `left` and `right` are seen from i toward j.
    """

    i: Indices
    j: Indices
    right: Array
    left: Array


def voronoi_fans(points: Array, corners: Array) -> Fans:
    """Return the Voronoi cells of `points` within a convex polygon as fans of triangles.

    Args:
        points: on the stage (N, 2) [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
    """
    robots, outline = _complex(points), _complex(corners)
    cell_of = np.arange(len(robots))
    with np.errstate(divide="ignore", invalid="ignore"):
        links = _links(robots)
        if links is None:  # robots that coincide, are on a line, or are too near to each other
            robots, cell_of = np.unique(robots, return_inverse=True)
            links = _links(robots) or _links_on_a_line(robots)
        cell, a, b, borders = _fans(robots, links, outline)
    stage = ((outline[1:-1] - outline[0]).conj() * (outline[2:] - outline[0])).imag.sum()
    if not abs((a.conj() * b).imag.sum() - stage) <= _TOLERANCE * stage:
        # Robots less than some 1e-7 of the swarm's extent apart: the rounding errors of Qhull are as large.
        cells = clipped_cells(robots, outline)
        cell = np.repeat(np.arange(len(cells)), [len(ring) for ring in cells])
        a, b = np.concatenate(cells), np.concatenate([np.roll(ring, -1) for ring in cells])
        borders = 0
    return Fans(cell_of, robots, cell, a, b, borders)


def voronoi_cells(points: Array, corners: Array) -> Array:
    """Return the Voronoi cells (N, M, 2) [m] of `points` (N, 2) within a convex polygon.

    Each row lists a cell's corners counter-clockwise; shorter rows repeat their last corner.

    Args:
        points: on the stage [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
    """
    cell_of, robot, cell, a, *_ = voronoi_fans(points, corners)
    size = np.bincount(cell, minlength=len(robot))
    total = np.bincount(cell, a.real, len(robot)) + 1j * np.bincount(cell, a.imag, len(robot))
    inside = total / np.maximum(size, 1)  # a robot on the stage's edge is not
    ring = a[np.lexsort((np.angle(a - inside[cell]), cell))]
    first = np.cumsum(size) - size
    column = np.minimum(np.arange(size.max()), size[:, None] - 1)
    rows = robot[:, None] + np.where(size[:, None] > 0, ring[first[:, None] + column], 0.0)
    return np.stack([rows.real, rows.imag], axis=-1)[cell_of]


def _complex(points: Array) -> Complex:
    return np.ascontiguousarray(points, dtype=float).view(complex)[:, 0]


def _links(robots: Complex) -> _Links | None:
    """Return the links, or None if robots coincide, are on a line or are too near to each other."""
    return _links_of_pairs(robots) if len(robots) <= _FEW else _delaunay_links(robots)


def _links_of_pairs(robots: Complex) -> _Links | None:
    """Return the links among all pairs, their borders clipped by every third robot; None for coincident robots."""
    i, j = all_pairs(len(robots))
    link = robots[j] - robots[i]
    if not link.all():
        return None
    to_i, to_j = robots[i] - robots[:, None], robots[j] - robots[:, None]  # from each third robot (N, pairs)
    # Twice the triangle's area, above 0 on the left of the link, is most exact where the shorter sides meet. It must
    # not be -0.0: on the link's line, a robot between the two takes all of their border, and one beside them nothing.
    leftwards = (np.where(np.abs(to_i) < np.abs(to_j), to_i, to_j).conj() * link).imag + 0.0
    end = (to_i.conj() * to_j).real / leftwards / 2
    on_left = leftwards >= 0
    left = np.fmin.reduce(np.where(on_left, end, np.inf))
    right = np.fmax.reduce(np.where(on_left, -np.inf, end))
    linked = np.flatnonzero(right < left)
    return _Links(i[linked], j[linked], right[linked], left[linked])


def _delaunay_links(robots: Complex) -> _Links | None:
    """Return the links of the Delaunay triangulation, or None if Qhull finds none, or leaves out robots."""
    from scipy.spatial import Delaunay, QhullError  # noqa: PLC0415 - see above

    try:
        triangulation = Delaunay((robots - robots[0]).view(float).reshape(-1, 2))
    except QhullError:
        return None
    if len(triangulation.coplanar):
        return None
    # Both (T, 3): the robot at a corner, and the triangle across the side that faces it.
    robot, across = triangulation.simplices.astype(np.intp), triangulation.neighbors.astype(np.intp)
    corner = robots[robot]
    angle = (corner[:, [1, 2, 0]] - corner).conj() * (corner[:, [2, 0, 1]] - corner)
    # All three imaginary parts are twice the triangle's area, the one where the shorter sides meet most exactly.
    each = np.arange(len(robot))
    doubled_area = np.abs(angle.imag[each, np.abs(angle.real).argmin(axis=1)])
    end = angle.real / doubled_area[:, None] / 2
    # Each link once, from the later of its two triangles.
    triangle, facing = np.nonzero(across < each[:, None])
    other = across[triangle, facing]
    facing_there = (across[other] == triangle[:, None]).argmax(axis=1)
    left, right = end[triangle, facing], -end[other, facing_there]
    right[other < 0] = -np.inf
    if (right - left > _TOLERANCE * (1 + left**2 + right**2)).any():  # a border with its ends swapped
        return None
    return _Links(robot[triangle, facing - 2], robot[triangle, facing - 1], right, left)


def _links_on_a_line(robots: Complex) -> _Links:
    """Return the links of robots on a line, or of one robot alone."""
    along = robots - robots[0]
    order = np.argsort((along * along[np.abs(along).argmax()].conj()).real)
    endless = np.full(len(order) - 1, np.inf)
    return _Links(order[:-1], order[1:], -endless, endless)


def _fans(robots: Complex, links: _Links, outline: Complex) -> tuple[Indices, Complex, Complex, int]:
    """Return the cell and the corners a and b of each triangle, and the number of borders, as in `Fans`."""
    i, j, right, left = links
    d, middle = robots[j] - robots[i], (robots[i] + robots[j]) / 2
    side = np.concatenate([outline[1:], outline[:1]]) - outline
    near: Indices | slice = slice(None)
    rim = np.full(len(robots), True)
    if len(robots) > _FEW:
        # Only a cell with a corner farther away than the nearest edge can reach the rim of the stage.
        room = ((robots[:, None] - outline) * (side / np.abs(side)).conj()).imag.min(axis=1)
        far = (d.real**2 + d.imag**2) * (0.25 + np.maximum(left**2, right**2)) >= room[i] ** 2
        rim[:] = False
        rim[i[far]] = rim[j[far]] = True
        near = np.flatnonzero(rim[i] | rim[j])
    # A bisector meets the line of an edge at middle + s i d = corner + t side.
    link, to_corner = d[near, None], outline - middle[near, None]
    slope = (link * side.conj()).real + 0.0  # not -0.0: all of such an edge is nearer to i, or all to j
    s = (to_corner * side.conj()).imag / slope
    t = (to_corner * link.conj()).real / -slope
    falling = slope < 0
    first = np.maximum.reduce(np.where(falling, -np.inf, s), axis=1)
    last = np.minimum.reduce(np.where(falling, s, np.inf), axis=1)
    left[near] = np.minimum(np.maximum(left[near], first), last)
    right[near] = np.minimum(np.maximum(right[near], first), last)
    stretch, begin, end = _along_edges(rim, i[near], j[near], t, falling)
    on_rim, edge = np.divmod(stretch, len(side))
    kept = np.flatnonzero(left != right)
    half, way = d[kept] / 2, 1j * d[kept]
    right_end, left_end = right[kept] * way, left[kept] * way
    start, stop = (outline[edge] + t * side[edge] - robots[on_rim] for t in (begin, end))
    a = np.concatenate([half + right_end, left_end - half, start])
    b = np.concatenate([half + left_end, right_end - half, stop])
    return np.concatenate([i[kept], j[kept], on_rim]), a, b, len(kept)


def _along_edges(rim: Mask, i: Indices, j: Indices, t: Array, falling: Mask) -> tuple[Indices, Array, Array]:
    """Return the stretches of the stage's C edges in the cells on its rim: C cell + edge, beginning and end (S,).

    Args:
        rim: which cells are on it (cells,).
        i: of the links of those cells (L,).
        j: the other robots of the links (L,).
        t: where their bisectors meet the edges (L, C), 0 at an edge's beginning and 1 at its end.
        falling: whether an edge leaves j's side of the bisector for i's as t rises (L, C).
    """
    edges = np.arange(t.shape[1])
    begin, end = np.zeros(len(rim) * len(edges)), np.repeat(rim.astype(float), len(edges))
    enters = np.where(falling, i[:, None], j[:, None])
    leaves = i[:, None] + j[:, None] - enters
    np.maximum.at(begin, (enters * len(edges) + edges).ravel(), t.ravel())
    np.minimum.at(end, (leaves * len(edges) + edges).ravel(), t.ravel())
    stretch = np.flatnonzero(begin < end)
    return stretch, begin[stretch], end[stretch]
