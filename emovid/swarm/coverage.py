"""Coverage control (Appendix A): the mass and centroid of Voronoi cells under a density.

The integrals are Gauss-Legendre sums over triangles, of an order that follows from a triangle's size against the
density's scale; triangles too large for the highest order are split. All terms are positive, so a cell far out in a
Gaussian's tail has as exact a centroid as one at its peak. Centroids are exact to a millionth of the density's scale,
and to rounding for a constant density (tested against `scipy.integrate.dblquad` and against closed forms).
"""

from functools import cache

import numpy as np

from emovid.scene.behaviour import Coverage
from emovid.scene.model import Stage
from emovid.swarm.arrays import Array, Indices
from emovid.swarm.densities import Density, density_of
from emovid.swarm.voronoi import voronoi_cells

# Nodes per direction, and the largest triangle (longest edge over the density's scale) they integrate to 1e-7 of the
# scale, from trials on random triangles under Gaussian peaks and ridges. Two nodes are exact for a constant density.
_ORDERS = ((2, 0.0), (6, 1.5), (10, 5.0), (16, 9.5))


def corners_of(stage: Stage) -> Array:
    """Return the stage's corners (4, 2) [m], counter-clockwise."""
    x, y = stage.width / 2, stage.height / 2
    return np.array([[-x, -y], [x, -y], [x, y], [-x, y]])


def coverage_velocity(law: Coverage, stage: Stage, points: Array) -> Array:
    """Return u = kappa (c - p), (N, 2) [m/s]: Appendix A, its length capped at `law.u_max` if there is one.

    A cell without mass leaves its robot where it is.
    """
    cells = voronoi_cells(points, corners_of(stage))
    mass, centroid = mass_and_centroid(cells, density_of(law.density, stage))
    u = law.kappa * np.where(mass[:, None] > 0, centroid - points, 0.0)
    if law.u_max is None:
        return u
    speed = np.hypot(u[:, 0], u[:, 1])
    return u * (law.u_max / np.maximum(speed, law.u_max))[:, None]


def mass_and_centroid(cells: Array, density: Density) -> tuple[Array, Array]:
    """Return the mass (N,) and centroid (N, 2) [m] of convex cells (N, M, 2), corners counter-clockwise.

    A cell without mass has the centroid (0, 0).
    """
    owner, corners = _triangles(cells)
    owner, corners = _split(owner, corners, _ORDERS[-1][1] * density.scale)
    size = _longest_edge(corners) / density.scale
    mass, moment = np.zeros(len(cells)), np.zeros((len(cells), 2))
    smaller = -1.0
    for nodes, largest in _ORDERS:
        mine = (size > smaller) & (size <= largest)
        smaller = largest
        if mine.any():
            triangle_mass, triangle_moment = _integrals(corners[mine], density, nodes)
            mass += np.bincount(owner[mine], triangle_mass, len(cells))
            for axis in (0, 1):
                moment[:, axis] += np.bincount(owner[mine], triangle_moment[:, axis], len(cells))
    return mass, moment / np.where(mass > 0, mass, 1.0)[:, None]


def _triangles(cells: Array) -> tuple[Indices, Array]:
    """Return the triangles (K, 3, 2) of the cells, as fans from their first corners, and each one's cell (K,)."""
    fan = np.stack([np.broadcast_to(cells[:, :1], cells[:, 2:].shape), cells[:, 1:-1], cells[:, 2:]], axis=2)
    proper = _doubled_area(fan) > 0  # a row's repeated corners make empty ones
    return np.nonzero(proper)[0], fan[proper]


def _split(owner: Indices, corners: Array, longest: float) -> tuple[Indices, Array]:
    """Cut triangles in four until no edge is longer than `longest` [m]."""
    while (big := _longest_edge(corners) > longest).any():
        a, b, c = corners[big, 0], corners[big, 1], corners[big, 2]
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        quarters = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3, 2)
        owner = np.concatenate([owner[~big], np.repeat(owner[big], 4)])
        corners = np.concatenate([corners[~big], quarters])
    return owner, corners


def _doubled_area(corners: Array) -> Array:
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])


def _longest_edge(corners: Array) -> Array:
    edges = corners - np.roll(corners, 1, axis=1)
    return np.sqrt(np.max(edges[..., 0] ** 2 + edges[..., 1] ** 2, axis=1))


def _integrals(corners: Array, density: Density, nodes: int) -> tuple[Array, Array]:
    """Return mass (K,) and first moment (K, 2) of the density over triangles (K, 3, 2)."""
    barycentric, weights = _rule(nodes)
    x = np.einsum("kc,qc->kq", corners[..., 0], barycentric)
    y = np.einsum("kc,qc->kq", corners[..., 1], barycentric)
    share = np.einsum("kq,qc->kc", density.phi(x, y), weights[:, None] * barycentric)
    share *= _doubled_area(corners)[:, None]
    return share.sum(axis=1), np.einsum("kc,kcd->kd", share, corners)


@cache
def _rule(nodes: int) -> tuple[Array, Array]:
    """Return barycentric nodes (Q, 3) and weights (Q,) on a triangle: Gauss-Legendre squared, collapsed at a corner."""
    node, weight = np.polynomial.legendre.leggauss(nodes)
    s, t = np.meshgrid((node + 1) / 2, (node + 1) / 2, indexing="ij")
    weights = np.outer(weight / 2, weight / 2) * s
    return np.stack([1 - s, s * (1 - t), s * t], axis=-1).reshape(-1, 3), weights.reshape(-1)
