"""Voronoi cells clipped to a convex stage, all cells at once.

A cell is what is left of the stage after cutting it with the bisectors to the other points, nearest first, until the
next point is too far to matter (twice the distance of the cell's farthest corner). Cutting with half-planes has no
degenerate cases: points may lie on the edge of the stage, and coincident points share a cell.
"""

import numpy as np
from scipy.spatial import cKDTree

from emovid.swarm.arrays import Array, Indices

_FIRST_NEIGHBOURS = 32  # a planar cell has six neighbours on average, and about 15 bisectors come near
_WIDEST = 16  # columns that may be carried along before repeated corners are dropped


def voronoi_cells(points: Array, corners: Array) -> Array:
    """Return the Voronoi cells (N, M, 2) [m] of `points` (N, 2) within a convex polygon.

    Each row lists a cell's corners counter-clockwise; shorter rows repeat their last corner.

    Args:
        points: on the stage [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
    """
    robots = len(points)
    cells = np.repeat(corners[None], robots, axis=0)
    tree = cKDTree(points)
    wanted, done = min(_FIRST_NEIGHBOURS, robots), 1  # the nearest neighbour of a point is itself
    open_rows = np.arange(robots)
    while done < robots and len(open_rows):
        distance, neighbour = tree.query(points[open_rows], k=wanted)
        for k in range(done, wanted):
            reach = 2 * _farthest(cells[open_rows], points[open_rows])
            still = distance[:, k] < reach
            if not still.any():
                return _trimmed(cells)
            open_rows, distance, neighbour = open_rows[still], distance[still], neighbour[still]
            cells = _cut(cells, open_rows, points, neighbour[:, k])
        done, wanted = wanted, min(4 * wanted, robots)
    return _trimmed(cells)


def _farthest(cells: Array, points: Array) -> Array:
    """Return the distance (R,) [m] of each cell's farthest corner from its point."""
    across = cells - points[:, None]
    return np.sqrt(np.max(across[..., 0] ** 2 + across[..., 1] ** 2, axis=1))


def _cut(cells: Array, rows: Indices, points: Array, others: Indices) -> Array:
    """Cut the cells of `rows` with the bisectors to the points `others`, and return all cells, one corner wider."""
    p, q = points[rows], points[others]
    normal = q - p
    offset = np.sum(normal * (p + q), axis=1) / 2
    ring = cells[rows]
    beyond = ring[..., 0] * normal[:, None, 0] + ring[..., 1] * normal[:, None, 1] - offset[:, None]
    hit = (beyond > 0).any(axis=1) & (beyond <= 0).any(axis=1)
    if not hit.any():
        return cells
    cut = _clip(ring[hit], beyond[hit])
    wider = np.concatenate([cells, cells[:, -1:]], axis=1)
    wider[rows[hit]] = cut
    return wider if wider.shape[1] <= _WIDEST else _trimmed(wider)


def _clip(ring: Array, beyond: Array) -> Array:
    """Cut convex polygons (R, M, 2) where `beyond` (R, M), linear over the plane, is positive: (R, M + 1, 2).

    The corners beyond the line are one run of the ring. The rest is kept, from the first corner after the run on; then
    come the two points at which the line crosses, the second repeated to the row's end.
    """
    size = ring.shape[1]
    row = np.arange(len(ring))
    out = beyond > 0
    first = np.argmax(out & ~np.roll(out, 1, axis=1), axis=1)
    length = out.sum(axis=1)
    leaving = _crossing(ring, beyond, row, (first - 1) % size, first)
    last = (first + length - 1) % size
    entering = _crossing(ring, beyond, row, last, (last + 1) % size)
    position = np.arange(size + 1)
    kept = ring[row[:, None], ((first + length)[:, None] + position) % size]
    end = (size - length)[:, None]
    choose = [(position < end)[..., None], (position == end)[..., None]]
    return np.where(choose[0], kept, np.where(choose[1], leaving[:, None], entering[:, None]))


def _crossing(ring: Array, beyond: Array, row: Indices, a: Indices, b: Indices) -> Array:
    """Return the points (R, 2) where the edges from corner `a` to corner `b` cross the line."""
    share = beyond[row, a] / (beyond[row, a] - beyond[row, b])
    return ring[row, a] + share[:, None] * (ring[row, b] - ring[row, a])


def _trimmed(cells: Array) -> Array:
    """Move repeated corners to the end of each row and drop the columns that no row needs."""
    repeated = (cells == np.roll(cells, 1, axis=1)).all(axis=2)
    repeated[:, 0] &= ~repeated.all(axis=1)
    width = int((~repeated).sum(axis=1).max())
    if width == cells.shape[1]:
        return cells
    order = np.argsort(repeated, axis=1, kind="stable")
    packed = np.take_along_axis(cells, order[..., None], axis=1)
    count = (~repeated).sum(axis=1)
    last = np.minimum(np.arange(width), count[:, None] - 1)
    return np.take_along_axis(packed, last[..., None], axis=1)
