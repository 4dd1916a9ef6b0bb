"""Voronoi cells within a convex stage, as fans of triangles about the robots, in time N log N.

Places and vectors of the plane are complex numbers here: conj(a) b is their dot product plus i times their cross product.

Where two cells meet, they do along the bisector of two neighbours in the Delaunay triangulation. From a robot at p to
its neighbour at p + d the bisector is p + d/2 + s i d. Their common border ends where s is half the cotangent of the
angle that faces d, in the triangles on either side. It is cut to the stage, and the stretches of the stage's edges
between the borders close the cells. No circumcentre is computed, so flat triangles with far ones do no harm.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import Delaunay, QhullError

from emovid.swarm.arrays import Array, Complex, Indices, Mask
from emovid.swarm.cutting import cut_cells

_ROUNDING = 1e-9  # of a border's ends, and of the stage's area


class Fans(NamedTuple):
    """Triangles, each with a corner at a robot, that tile the robots' cells and with them the stage.

    Attributes:
        cell_of: the cell of each robot (N,); robots at one place share it.
        robot: the place of each cell's robots (cells,) [m].
        cell: the cell of each triangle (K,).
        a, b: the triangle's other corners (K,) [m] from its robot, counter-clockwise.
    """

    cell_of: Indices
    robot: Complex
    cell: Indices
    a: Complex
    b: Complex


class _Links(NamedTuple):
    """Pairs of neighbours, and the borders between them.

    Attributes:
        i, j: two robots (L,).
        right, left: the border's ends on their bisector (L,), as seen from i to j; infinite where it has none.
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
    robots, outline = _complex(points - corners[0]), _complex(corners - corners[0])
    cell_of = np.arange(len(robots))
    with np.errstate(divide="ignore", invalid="ignore"):
        links = _delaunay(robots)
        if links is None:  # robots at one place, or all on a line
            robots, cell_of = np.unique(robots, return_inverse=True)
            links = _delaunay(robots) or _on_a_line(robots)
        cell, a, b = _fans(robots, links, outline)
    stage = (outline[1:-1].conj() * outline[2:]).imag.sum()
    if not abs((a.conj() * b).imag.sum() - stage) <= _ROUNDING * stage:
        # Qhull does not resolve robots that are apart by less than some 1e-8 of the swarm's extent.
        cells = cut_cells(robots, outline)
        cell = np.repeat(np.arange(len(cells)), [len(ring) for ring in cells])
        a, b = np.concatenate(cells), np.concatenate([np.roll(ring, -1) for ring in cells])
    return Fans(cell_of, robots + complex(*corners[0]), cell, a, b)


def voronoi_cells(points: Array, corners: Array) -> Array:
    """Return the Voronoi cells (N, M, 2) [m] of `points` (N, 2) within a convex polygon.

    Each row lists a cell's corners counter-clockwise; shorter rows repeat their last corner.

    Args:
        points: on the stage [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
    """
    fans = voronoi_fans(points, corners)
    cells = len(fans.robot)
    size = np.bincount(fans.cell, minlength=cells)
    inside = (np.bincount(fans.cell, fans.a.real) + 1j * np.bincount(fans.cell, fans.a.imag)) / size
    ring = fans.a[np.lexsort((np.angle(fans.a - inside[fans.cell]), fans.cell))]
    position = np.minimum(np.arange(size.max()), size[:, None] - 1)
    ring = (fans.robot[:, None] + ring[(np.cumsum(size) - size)[:, None] + position])[fans.cell_of]
    return np.stack([ring.real, ring.imag], axis=-1)


def _complex(points: Array) -> Complex:
    return points[:, 0] + 1j * points[:, 1]


def _delaunay(robots: Complex) -> _Links | None:
    """Return the links of the Delaunay triangulation; None if Qhull finds none that is one, with all robots in it."""
    try:
        triangulation = Delaunay((robots - robots[0]).view(float).reshape(-1, 2))
    except QhullError:
        return None
    if len(triangulation.coplanar):
        return None
    # (T, 3): the robot at a corner, and the triangle beyond the side that faces it.
    robot, beyond = triangulation.simplices.astype(np.intp), triangulation.neighbors.astype(np.intp)
    corner = robots[robot]
    angle = (corner[:, [1, 2, 0]] - corner).conj() * (corner[:, [2, 0, 1]] - corner)
    end = angle.real / np.abs(angle.imag) / 2
    # Each link once, from the later of its two triangles.
    triangle, facing = np.nonzero(beyond < np.arange(len(robot))[:, None])
    other = beyond[triangle, facing]
    back = (beyond[other] == triangle[:, None]).argmax(axis=1)
    left, right = end[triangle, facing], -end[other, back]
    right[other < 0] = -np.inf
    if (right - left > _ROUNDING * (1 + left**2 + right**2)).any():
        return None
    return _Links(robot[triangle, facing - 2], robot[triangle, facing - 1], right, left)


def _on_a_line(robots: Complex) -> _Links:
    """Return the links of robots on a line, or of one alone."""
    along = robots - robots[0]
    order = np.argsort((along * along[np.argmax(np.abs(along))].conj()).real)
    endless = np.full(len(order) - 1, np.inf)
    return _Links(order[:-1], order[1:], -endless, endless)


def _fans(robots: Complex, links: _Links, outline: Complex) -> tuple[Indices, Complex, Complex]:
    """Return the cell and the corners a and b of each triangle, as in `Fans`."""
    i, j, right, left = links
    p, q = robots[i], robots[j]
    d, middle = q - p, (p + q) / 2
    side = np.concatenate([outline[1:], outline[:1]]) - outline
    # Only the cells on the rim, with a corner farther off than the nearest edge, can reach beyond the stage.
    room = ((robots[:, None] - outline) * (side / np.abs(side)).conj()).imag.min(axis=1)
    far = (d.real**2 + d.imag**2) * (0.25 + np.maximum(left**2, right**2)) > room[i] ** 2
    rim = np.full(len(robots), len(robots) == 1)
    rim[i[far]] = rim[j[far]] = True
    near = np.flatnonzero(rim[i] | rim[j])
    # A bisector meets the line of an edge at middle + s i d = corner + t side.
    across = d[near, None]
    to_corner = outline - middle[near, None]
    slope = (across * side.conj()).real + 0.0  # no -0.0: a bisector along the edge leaves all of it to one robot
    s = (to_corner * side.conj()).imag / slope
    t = (to_corner * across.conj()).real / -slope
    falling = slope < 0
    first, last = np.where(falling, -np.inf, s).max(axis=1), np.where(falling, s, np.inf).min(axis=1)
    left[near] = np.minimum(np.maximum(left[near], first), last)
    right[near] = np.minimum(np.maximum(right[near], first), last)
    cell, a, b = _along_edges(rim, i[near], j[near], t, falling, outline, side)
    seen = np.flatnonzero(left != right)
    i, j, d, middle = i[seen], j[seen], 1j * d[seen], middle[seen]
    right_end, left_end = middle + right[seen] * d, middle + left[seen] * d
    cell = np.concatenate([i, j, cell])
    robot = robots[cell]
    return cell, np.concatenate([right_end, left_end, a]) - robot, np.concatenate([left_end, right_end, b]) - robot


def _along_edges(
    rim: Mask, i: Indices, j: Indices, t: Array, falling: Mask, outline: Complex, side: Complex
) -> tuple[Indices, Complex, Complex]:
    """Return the stretches of the stage's edges that belong to the cells on the rim: cell, beginning and end [m].

    Args:
        rim: which cells (cells,) those are.
        i, j: the links (L,) of those cells.
        t: where their bisectors meet the edges (L, C), 0 at an edge's beginning and 1 at its end.
        falling: whether j has the part of the edge before t, and i that after it (L, C).
        outline: corners of the stage (C,) [m].
        side: from each to the next (C,) [m].
    """
    edges = len(side)
    i, j = i[:, None] * edges + np.arange(edges), j[:, None] * edges + np.arange(edges)
    begin, end = np.zeros(len(rim) * edges), np.repeat(rim.astype(float), edges)
    np.maximum.at(begin, np.where(falling, i, j).ravel(), t.ravel())
    np.minimum.at(end, np.where(falling, j, i).ravel(), t.ravel())
    owned = np.flatnonzero(begin < end)
    cell, edge = np.divmod(owned, edges)
    return cell, outline[edge] + begin[owned] * side[edge], outline[edge] + end[owned] * side[edge]
