"""Integrals of a density over Voronoi cells, given as fans of triangles about their robots.

Each triangle has a Gauss rule, of an order that follows from how much the density changes over it: the range of log
phi at its corners, plus half the square of its longest edge over the density's scale. Where that is too much for the
highest order, triangles are split. Weights and densities are positive, so a cell far out in a Gaussian's tail has as
exact a centroid as one at its peak: to a millionth of the density's scale, and to rounding for a constant density.
"""

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from emovid.swarm.arrays import Array, Complex, Indices, Mask
from emovid.swarm.densities import Density
from emovid.swarm.voronoi import Fans

# Nodes per direction, and the largest change of a density over which they give a triangle's centroid to a millionth of
# the scale and its mass to a millionth: the worst of 75 000 random triangles under peaks, ridges and sums of ridges, up
# to 35 standard deviations out. In a valley of such a sum its terms change by more than twice as much as it does, and
# cells are large there.
_NODES = (2, 3, 5, 8, 12, 16, 20)
_CHANGE = np.array([0.02, 0.1, 0.8, 2.9, 10.0, 30.0, 50.0])
_LEAST = np.finfo(float).tiny  # densities below have lost digits
_DIGITS = 12  # of nodes and weights: LAPACK gives further ones that differ between processors
_BLOCK = 1 << 14  # nodes at a time: what a cache holds


class _Triangles(NamedTuple):
    """Triangles (corner, corner + a, corner + b), all (K,) [m], in the cells named; corners are seen from the robot."""

    cell: Indices
    corner: Complex
    a: Complex
    b: Complex


def mass_and_moment(fans: Fans, density: Density) -> tuple[Array, Complex]:
    """Return the mass of each cell (cells,) and its first moment about the robot (cells,)."""
    if np.isinf(density.scale):  # constant: a triangle's centroid is the mean of its corners
        cell, a, b = fans.cell, fans.a, fans.b
        mass = float(density.phi(np.zeros(1), np.zeros(1))[0]) / 2 * (a.conj() * b).imag
        moment = mass / 3 * (a + b)
    else:
        (cell, corner, a, b), (mass, u, v) = _integrals(fans, density, degree=1)
        moment = mass * corner + u * a + v * b
    cells = len(fans.robot)
    masses = np.bincount(cell, mass, cells).astype(float)  # it is so already, but numpy's type says whole numbers
    return masses, np.bincount(cell, moment.real, cells) + 1j * np.bincount(cell, moment.imag, cells)


def polar_moment(fans: Fans, density: Density) -> float:
    """Return the integral over the stage of phi times the squared distance from the cell's robot."""
    (_, corner, a, b), (mass, u, v, uu, uv, vv) = _integrals(fans, density, degree=2)
    # |corner + u a + v b|^2, term by term
    about_corner = uu * np.abs(a) ** 2 + 2 * uv * (a.conj() * b).real + vv * np.abs(b) ** 2
    return float(np.sum(about_corner + (corner.conj() * (mass * corner + 2 * (u * a + v * b))).real))


def _integrals(fans: Fans, density: Density, degree: int) -> tuple[_Triangles, Array]:
    """Return the triangles (K,), split where need be, and integrals over them, (3, K) or for degree 2 (6, K).

    The integrals are those of phi times 1, u, v, and for degree 2 also u^2, u v, v^2, at corner + u a + v b.
    """
    triangles, numbers = _by_order(_Triangles(fans.cell, np.zeros_like(fans.a), fans.a, fans.b), fans.robot, density)
    cell, corner, a, b = triangles
    corner = corner + fans.robot[cell]
    axes = np.array([[corner.real, a.real, b.real], [corner.imag, a.imag, b.imag]])
    integrals = np.empty((3 if degree == 1 else 6, len(cell)))
    for k, (first, end) in enumerate(pairwise([0, *np.cumsum(numbers).tolist()])):
        nodes, weights = _rule(_NODES[k])
        block = _BLOCK // len(nodes)
        for start in range(first, end, block):
            some = slice(start, min(start + block, end))
            # einsum adds in a fixed order; products by BLAS differ between processors.
            x, y = np.einsum("qi,jik->jqk", nodes, axes[..., some])
            integrals[:, some] = np.einsum("iq,qk->ik", weights[: len(integrals)], density.phi(x, y))
    return triangles, integrals * (a.conj() * b).imag


def _by_order(triangles: _Triangles, robot: Complex, density: Density) -> tuple[_Triangles, Indices]:
    """Return the triangles (K,), split where need be and sorted by order, and how many have each in `_NODES`."""
    if np.isinf(density.scale):
        return triangles, np.array([len(triangles.cell)])
    while True:
        cell, corner, a, b = triangles
        corner = corner + robot[cell]
        places = np.array([corner, corner + a, corner + b])
        levels = np.log(np.maximum(density.phi(places.real, places.imag), _LEAST))
        longest = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(b - a))
        change = levels.max(axis=0) - levels.min(axis=0) + (longest / density.scale) ** 2 / 2
        big = change > _CHANGE[-1]
        if not big.any():
            order = np.searchsorted(_CHANGE, change)
            rank = np.argsort(order, kind="stable")
            return _Triangles(cell[rank], triangles.corner[rank], a[rank], b[rank]), np.bincount(order)
        triangles = _split(triangles, big)


def _split(triangles: _Triangles, big: Mask) -> _Triangles:
    """Cut the big triangles in four, at the middles of their edges."""
    cell, corner, a, b = (part[big] for part in triangles)
    quarters = (
        np.tile(cell, 4),
        np.concatenate([corner, corner + a / 2, corner + b / 2, corner + a / 2]),
        np.concatenate([a, a, a, b]) / 2,
        np.concatenate([b, b, b, b - a]) / 2,
    )
    return _Triangles(*(np.concatenate([old[~big], new]) for old, new in zip(triangles, quarters, strict=True)))


@cache
def _rule(nodes: int) -> tuple[Array, Array]:
    """Return the nodes (Q, 3), as (1, u, v), and their weights (6, Q) for the six integrals of `_integrals`.

    Gauss-Jacobi along the rays from the corner, Gauss-Legendre across: exact for polynomials of degree 2 nodes - 1.
    """
    ray, ray_weights = _jacobi(nodes)
    across, across_weights = (np.round(values, _DIGITS) for values in np.polynomial.legendre.leggauss(nodes))
    s, t = np.meshgrid((ray + 1) / 2, (across + 1) / 2, indexing="ij")
    u, v = (s * (1 - t)).ravel(), (s * t).ravel()
    one = np.ones_like(u)
    weights = np.outer(ray_weights / 4, across_weights / 2).ravel()
    return np.stack([one, u, v], axis=1), weights * np.stack([one, u, v, u * u, u * v, v * v])


def _jacobi(nodes: int) -> tuple[Array, Array]:
    """Return the Gauss-Jacobi rule for the weight 1 + x on [-1, 1], (nodes,) each.

    By G. Golub and J. Welsch, "Calculation of Gauss quadrature rules", Math. Comp. 23, 1969: nodes are the eigenvalues
    of the recurrence's matrix, weights the squares of the first components of its eigenvectors. scipy has it too, but
    takes longer to import than all else here takes.
    """
    k = np.arange(nodes, dtype=float)
    diagonal, beside = 1 / ((2 * k + 1) * (2 * k + 3)), np.sqrt(k[1:] * (k[1:] + 1)) / (2 * k[1:] + 1)
    roots, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(beside, -1))  # it reads the lower triangle
    return np.round(roots, _DIGITS), np.round(2 * vectors[0] ** 2, _DIGITS)
