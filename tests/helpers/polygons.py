"""Slow and obvious references for cells and their integrals."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.integrate import dblquad
from scipy.spatial import ConvexHull, Voronoi

Phi = Callable[[np.ndarray, np.ndarray], np.ndarray]


def mirrored_voronoi(points: np.ndarray, width: float, height: float) -> list[np.ndarray]:
    """Return the corners of each cell, by Qhull: mirror images across the edges make the edges bisectors."""
    images = [points]
    for axis, half in ((0, width / 2), (1, height / 2)):
        for sign in (1, -1):
            image = points.copy()
            image[:, axis] = sign * 2 * half - image[:, axis]
            images.append(image)
    diagram = Voronoi(np.concatenate(images))
    return [diagram.vertices[diagram.regions[diagram.point_region[i]]] for i in range(len(points))]


def area(corners: np.ndarray) -> float:
    return float(ConvexHull(corners).volume)


def shoelace(corners: np.ndarray) -> tuple[float, np.ndarray]:
    """Return area and centroid of a polygon, corners counter-clockwise, by the textbook formula."""
    x, y = corners.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    doubled = cross.sum()
    centroid = [((c + np.roll(c, -1)) * cross).sum() / (3 * doubled) for c in (x, y)]
    return doubled / 2, np.array(centroid)


def centroid_by_dblquad(corners: np.ndarray, phi: Phi) -> tuple[float, np.ndarray]:
    """Return mass and centroid of a density over a convex polygon, slab by slab between its corners."""
    corners = corners[np.sort(np.unique(corners, axis=0, return_index=True)[1])]
    xs = np.unique(corners[:, 0])
    xs = xs[np.append(True, np.diff(xs) > 1e-12)]  # corners that differ only by rounding give no slab
    closed = np.concatenate([corners, corners[:1]])

    def bounds(x: float) -> list[float]:
        ys = []
        for (x0, y0), (x1, y1) in pairwise(closed):
            if min(x0, x1) <= x <= max(x0, x1) and x0 != x1:
                ys.append(y0 + (x - x0) / (x1 - x0) * (y1 - y0))
        return [min(ys), max(ys)]

    def integral(weight: Callable[[float, float], float]) -> float:
        def integrand(y: float, x: float) -> float:
            return weight(x, y) * float(phi(np.array(x), np.array(y)))

        slabs = [
            dblquad(integrand, a, b, lambda x: bounds(x)[0], lambda x: bounds(x)[1], epsabs=1e-13, epsrel=1e-9)[0]
            for a, b in pairwise(xs)
        ]
        return sum(slabs)

    mass = integral(lambda x, y: 1.0)
    return mass, np.array([integral(lambda x, y: x), integral(lambda x, y: y)]) / mass
