"""The stage as a measure: its size, its centre and how far its edge is."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import pdist

from emovid.scene.stage import Stage
from emovid.swarm.arrays import Array
from emovid.swarm.coverage import corners_of


class Ground(NamedTuple):
    """A convex stage in arrays.

    Attributes:
        edges: outward unit normals and offsets (C, 3): a point (x, y) on the stage has x e_0 + y e_1 <= e_2.
        area: [m^2].
        diagonal: the largest distance of two corners [m].
        centre: the centroid of the area (2,) [m].
    """

    edges: Array
    area: float
    diagonal: float
    centre: Array

    def distance_to_edge(self, points: Array) -> Array:
        """Return the distance (...) [m] of points (..., 2) from the nearest edge, negative off the stage."""
        return np.min(self.edges[:, 2] - points @ self.edges[:, :2].T, axis=-1)


def ground_of(stage: Stage) -> Ground:
    """Return the stage's measures."""
    corners = corners_of(stage)
    following = np.roll(corners, -1, axis=0)
    doubled = corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1]  # each triangle's area with the origin
    centre = np.sum(doubled[:, None] * (corners + following), axis=0) / (3 * doubled.sum())
    return Ground(np.array(stage.edges), float(doubled.sum() / 2), float(pdist(corners).max()), centre)
