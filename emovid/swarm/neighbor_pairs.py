"""Which points are near each other: few are compared pair by pair, many by a tree.

The tree is imported when there are many, since scipy.spatial takes as long to import as eight seconds of a video take
to draw.
"""

from functools import cache

import numpy as np

from emovid.swarm.arrays import Array, Indices

_FEW = 40  # points for which comparing all pairs is faster than building a tree


def pairs_within(points: Array, distance: float) -> tuple[Indices, Indices]:
    """Return the pairs i < j, (P,) each and in order, of points (N, 2) no farther apart than `distance`."""
    if len(points) <= _FEW:
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
