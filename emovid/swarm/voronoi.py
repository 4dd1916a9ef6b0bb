"""Voronoi cells within a convex stage, as fans of triangles about the robots, in time N log N.

Places and vectors are complex numbers here: conj(a) b is the dot product of a and b, plus i times their cross product.

Two cells meet along the bisector of two robots that are linked in the Delaunay triangulation. From a robot at p to one
at p + d, the bisector is p + d/2 + s i d; the border of the two cells ends where s is half the cotangent of the angle
that faces the link, in the triangle on either side. It is cut to the stage, and what the borders leave open along the
stage's edges closes the cells. No circumcentre is computed, so flat triangles with far ones do no harm.

In a small swarm every robot faces every pair: that takes three fifths of Qhull's time for 15 robots, as much for 25,
and spares importing it.
"""

from typing import NamedTuple

import numpy as np

from emovid.swarm.arrays import Array, Complex, Indices, Mask
from emovid.swarm.cell_clipping import cut_cells
from emovid.swarm.neighbor_pairs import all_pairs

_FEW = 20  # robots for which pairs are faster than Qhull
_TOLERANCE = 1e-9  # far above rounding (1e-12), far below what a wrong triangulation gives (1e-3)


class Fans(NamedTuple):
    """Triangles, each with one corner at a robot, that tile the robots' cells and so the stage.

    Attributes:
        cell_of: the cell of each robot (N,); robots at one place share it.
        robot: the place of each cell's robots (cells,) [m].
        cell: the cell of each triangle (K,).
        a, b: its other corners (K,) [m] as seen from the robot, counter-clockwise.
    """

    cell_of: Indices
    robot: Complex
    cell: Indices
    a: Complex
    b: Complex


class _Links(NamedTuple):
    """Pairs of neighbours i, j (L,), and the ends of their borders on the bisectors (L,): s, infinite for no end.

    `left` and `right` are as seen from i towards j.
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
        if links is None:  # robots at one place, on a line, or too near to each other
            robots, cell_of = np.unique(robots, return_inverse=True)
            links = _links(robots) or _links_on_a_line(robots)
        cell, a, b = _fans(robots, links, outline)
    stage = ((outline[1:-1] - outline[0]).conj() * (outline[2:] - outline[0])).imag.sum()
    if not abs((a.conj() * b).imag.sum() - stage) <= _TOLERANCE * stage:
        # Robots less than some 1e-7 of the swarm's extent apart: Qhull's rounding errors are as large.
        cells = cut_cells(robots, outline)
        cell = np.repeat(np.arange(len(cells)), [len(ring) for ring in cells])
        a, b = np.concatenate(cells), np.concatenate([np.roll(ring, -1) for ring in cells])
    return Fans(cell_of, robots, cell, a, b)


def voronoi_cells(points: Array, corners: Array) -> Array:
    """Return the Voronoi cells (N, M, 2) [m] of `points` (N, 2) within a convex polygon.

    Each row lists a cell's corners counter-clockwise; shorter rows repeat their last corner.

    Args:
        points: on the stage [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
    """
    cell_of, robot, cell, a, _ = voronoi_fans(points, corners)
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
    """Return the links, or None if robots at one place, on a line or too near to each other prevent that."""
    return _links_of_pairs(robots) if len(robots) <= _FEW else _delaunay_links(robots)


def _links_of_pairs(robots: Complex) -> _Links | None:
    """Return the links among all pairs, with borders as every third robot leaves them; None for two at one place."""
    i, j = all_pairs(len(robots))
    link = robots[j] - robots[i]
    if not link.all():
        return None
    to_i, to_j = robots[i] - robots[:, None], robots[j] - robots[:, None]  # from each third robot (N, pairs)
    # Twice the triangle's area, above 0 on the left of the link, is most exact where the shorter sides meet. It is not
    # -0.0: on the link's line, a robot between the two takes all of their border, and one beside them nothing.
    leftwards = (np.where(np.abs(to_i) < np.abs(to_j), to_i, to_j).conj() * link).imag + 0.0
    end = (to_i.conj() * to_j).real / leftwards / 2
    on_left = leftwards >= 0
    left = np.fmin.reduce(np.where(on_left, end, np.inf))
    right = np.fmax.reduce(np.where(on_left, -np.inf, end))
    linked = np.flatnonzero(right < left)
    return _Links(i[linked], j[linked], right[linked], left[linked])


def _delaunay_links(robots: Complex) -> _Links | None:
    """Return the links of the Delaunay triangulation, or None if Qhull finds none, or not one of all robots."""
    from scipy.spatial import Delaunay, QhullError  # noqa: PLC0415 - small swarms do without: see `near`

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
    if (right - left > _TOLERANCE * (1 + left**2 + right**2)).any():  # a border the wrong way round
        return None
    return _Links(robot[triangle, facing - 2], robot[triangle, facing - 1], right, left)


def _links_on_a_line(robots: Complex) -> _Links:
    """Return the links of robots on a line, or of one robot alone."""
    along = robots - robots[0]
    order = np.argsort((along * along[np.abs(along).argmax()].conj()).real)
    endless = np.full(len(order) - 1, np.inf)
    return _Links(order[:-1], order[1:], -endless, endless)


def _fans(robots: Complex, links: _Links, outline: Complex) -> tuple[Indices, Complex, Complex]:
    """Return the cell and the corners a and b of each triangle, as in `Fans`."""
    i, j, right, left = links
    d, middle = robots[j] - robots[i], (robots[i] + robots[j]) / 2
    side = np.concatenate([outline[1:], outline[:1]]) - outline
    near: Indices | slice = slice(None)
    rim = np.full(len(robots), True)
    if len(robots) > _FEW:
        # Only a cell with a corner farther off than the nearest edge can reach the rim of the stage.
        room = ((robots[:, None] - outline) * (side / np.abs(side)).conj()).imag.min(axis=1)
        far = (d.real**2 + d.imag**2) * (0.25 + np.maximum(left**2, right**2)) >= room[i] ** 2
        rim[:] = False
        rim[i[far]] = rim[j[far]] = True
        near = np.flatnonzero(rim[i] | rim[j])
    # A bisector meets the line of an edge at middle + s i d = corner + t side.
    link, to_corner = d[near, None], outline - middle[near, None]
    slope = (link * side.conj()).real + 0.0  # not -0.0: along such an edge, all is nearer to i, or all to j
    s = (to_corner * side.conj()).imag / slope
    t = (to_corner * link.conj()).real / -slope
    falling = slope < 0
    first = np.maximum.reduce(np.where(falling, -np.inf, s), axis=1)
    last = np.minimum.reduce(np.where(falling, s, np.inf), axis=1)
    left[near] = np.minimum(np.maximum(left[near], first), last)
    right[near] = np.minimum(np.maximum(right[near], first), last)
    stretch, begin, end = _along_edges(rim, i[near], j[near], t, falling)
    on_rim, edge = np.divmod(stretch, len(side))
    seen = np.flatnonzero(left != right)
    half, way = d[seen] / 2, 1j * d[seen]
    right_end, left_end = right[seen] * way, left[seen] * way
    start, stop = (outline[edge] + t * side[edge] - robots[on_rim] for t in (begin, end))
    a = np.concatenate([half + right_end, left_end - half, start])
    b = np.concatenate([half + left_end, right_end - half, stop])
    return np.concatenate([i[seen], j[seen], on_rim]), a, b


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
