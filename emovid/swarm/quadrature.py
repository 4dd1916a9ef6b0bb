"""Integrals of a density over Voronoi cells, given as fans of triangles about their robots.

Each triangle has a Gauss rule, of an order that follows from how much the density changes over it: the range of
log phi at its corners, plus half the square of its longest edge over the density's scale. Where that is too much for the
highest order, triangles are split. Weights and densities are positive, so a cell far out in a Gaussian's tail has as
exact a centroid as one at its peak: to a millionth of the density's scale, and to rounding for a constant density.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import roots_jacobi

from emovid.swarm.arrays import Array, Complex, Indices
from emovid.swarm.densities import Density
from emovid.swarm.voronoi import Fans

# Nodes per direction, and the largest change of a density for which they give a triangle's centroid to 1e-6 of the
# scale: found by trials on random triangles under peaks, ridges and sums of ridges, up to 35 standard deviations out.
_NODES, _CHANGE = (2, 3, 5, 8, 12, 16, 20), np.array([0.04, 0.1, 0.9, 3.4, 10.0, 40.0, 75.0])
_LEAST = float(np.finfo(float).tiny)
_BLOCK = 1 << 16  # nodes at a time: what fits into a cache


class _Triangles(NamedTuple):
    """Triangles (corner, corner + a, corner + b), each array (K,), in the cells named; the corner is seen from the robot."""

    cell: Indices
    corner: Complex
    a: Complex
    b: Complex


def mass_and_moment(fans: Fans, density: Density) -> tuple[Array, Complex]:
    """Return each cell's mass (cells,) and its first moment about its robot (cells,) [m]."""
    triangles, (mass, u, v) = _sums(fans, density, degree=1)
    cell, corner, a, b = triangles
    moment = mass * corner + u * a + v * b
    cells = len(fans.robot)
    along_x, along_y = np.bincount(cell, moment.real, cells), np.bincount(cell, moment.imag, cells)
    return np.bincount(cell, mass, cells), along_x + 1j * along_y


def polar_moment(fans: Fans, density: Density) -> float:
    """Return the integral of phi times the squared distance from the cell's robot, over all cells [m^2]."""
    triangles, (mass, u, v, uu, uv, vv) = _sums(fans, density, degree=2)
    _, corner, a, b = triangles
    linear = corner.conj() * (mass * corner + 2 * (u * a + v * b))
    return float(np.sum(linear.real + uu * np.abs(a) ** 2 + 2 * uv * (a.conj() * b).real + vv * np.abs(b) ** 2))


def _sums(fans: Fans, density: Density, degree: int) -> tuple[_Triangles, Array]:
    """Return the triangles, split where need be, and the integrals over them of phi times 1, u, v (, u^2, u v, v^2).

    u and v are the coordinates corner + u a + v b.
    """
    triangles, order = _ordered(_Triangles(fans.cell, np.zeros_like(fans.a), fans.a, fans.b), fans.robot, density)
    cell, corner, a, b = triangles
    corner = corner + fans.robot[cell]
    ends = np.array([[corner.real, a.real, b.real], [corner.imag, a.imag, b.imag]])
    sums = np.empty((6 if degree == 2 else 3, len(cell)))
    for k in np.unique(order):
        mine = np.flatnonzero(order == k)
        at, weights = _rule(_NODES[k])
        block = _BLOCK // len(at)
        for start in range(0, len(mine), block):
            some = mine[start:start+block]
            x, y = at @ ends[..., some]
            sums[:, some] = weights[:len(sums)] @ density.phi(x, y)
    return triangles, sums * (a.conj() * b).imag


def _ordered(triangles: _Triangles, robot: Complex, density: Density) -> tuple[_Triangles, Indices]:
    """Return the triangles, split where need be, and the order of each (K,), an index to `_NODES`."""
    cell, corner, a, b = triangles
    if np.isinf(density.scale):
        return triangles, np.zeros(len(cell), dtype=int)
    place = robot[cell] + corner
    ends = np.stack([place, place + a, place + b])
    levels = np.log(np.maximum(density.phi(ends.real, ends.imag), _LEAST))
    longest = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(b - a))
    change = levels.max(axis=0) - levels.min(axis=0) + (longest / density.scale) ** 2 / 2
    big = change > _CHANGE[-1]
    if big.any():
        a, b = a[big], b[big]
        quarters = _Triangles(
            np.tile(cell[big], 4),
            np.concatenate([corner[big] + shift for shift in (0, a / 2, b / 2, a / 2)]),
            np.concatenate([a, a, a, b]) / 2,
            np.concatenate([b, b, b, b - a]) / 2,
        )
        rest = _Triangles(*(part[~big] for part in triangles))
        split = _Triangles(*(np.concatenate(parts) for parts in zip(rest, quarters, strict=True)))
        return _ordered(split, robot, density)
    return triangles, np.searchsorted(_CHANGE, change)

@cache
def _rule(nodes: int) -> tuple[Array, Array]:
    """Return the nodes (Q, 3), as shares of corner, a and b, and the weights (6, Q) for the six integrals.

    Gauss-Jacobi along rays from the corner times Gauss-Legendre across them: exact to degree 2 nodes - 1.
    """
    ray, ray_weights = roots_jacobi(nodes, 0, 1)
    across, across_weights = np.polynomial.legendre.leggauss(nodes)
    s, t = np.meshgrid((ray + 1) / 2, (across + 1) / 2, indexing="ij")
    u, v = (s * (1 - t)).ravel(), (s * t).ravel()
    weights = np.outer(ray_weights / 4, across_weights / 2).ravel()
    one = np.ones_like(u)
    return np.stack([one, u, v], axis=1), weights * np.stack([one, u, v, u * u, u * v, v * v])
