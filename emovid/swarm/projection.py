"""The closest point of a convex polytope: the quadratic program of the barrier, min |x - p|^2 subject to A x <= b.

Least-distance programming by non-negative least squares: C. L. Lawson and R. J. Hanson, "Solving Least Squares
Problems", 1974, ch. 23. This active-set method ends at the solution itself, so that machines differ by rounding only.
"""

import numpy as np
from scipy.optimize import nnls

from emovid.swarm.arrays import Array

# The last residual of the least squares is 1 / (1 + |x - p|^2), and 0 where no point fulfills all rows.
_EMPTY = 1e-9


def nearest_within(point: Array, A: Array, b: Array) -> Array | None:
    """Return the point x (n,) with A x <= b that is closest to `point` (n,), or None if there is none.

    Lengths should be of the order of 1: a solution more than 30 000 away counts as none.

    Args:
        point: (n,).
        A: normals of the half-spaces (m, n), of any length but 0.
        b: their offsets (m,).
    """
    length = np.sqrt(np.sum(A * A, axis=1))
    missing = (np.einsum("mn,n->m", A, point) - b) / length  # distance of the point outside each half-space
    if missing.max(initial=0.0) <= 0:
        return point
    columns = np.vstack([-(A / length[:, None]).T, missing])
    target = np.zeros(len(columns))
    target[-1] = 1.0
    weights, _ = nnls(columns, target, maxiter=100 * len(A))
    residual = target - np.einsum("nm,m->n", columns, weights)
    if residual[-1] < _EMPTY:
        return None
    step: Array = residual[:-1] / -residual[-1]
    return point + step
