"""Coverage control (Appendix A): each robot heads for the centroid of its Voronoi cell under a density.

Centroids are exact to a millionth of the density's scale, and to rounding for a constant density; cells tile the stage
to rounding (tested against `scipy.integrate.dblquad`, cutting and closed forms).
"""

import numpy as np

from emovid.scene.behaviour import Coverage
from emovid.scene.stage import Stage
from emovid.swarm.arrays import Array
from emovid.swarm.densities import Density, density_of
from emovid.swarm.quadrature import mass_and_moment, polar_moment
from emovid.swarm.voronoi import voronoi_fans


def corners_of(stage: Stage) -> Array:
    """Return the stage's corners (C, 2) [m], counter-clockwise."""
    return np.array(stage.outline)


def coverage_velocity(law: Coverage, stage: Stage, points: Array) -> Array:
    """Return u = kappa (c - p), (N, 2) [m/s]: Appendix A, its length capped at `law.u_max` if there is one.

    A cell without mass leaves its robot where it is.
    """
    u = law.kappa * _to_centroids(points, corners_of(stage), density_of(law.density, stage))[1]
    if law.u_max is None:
        return u
    speed = np.hypot(u[:, 0], u[:, 1])
    return u * (law.u_max / np.maximum(speed, law.u_max))[:, None]


def mass_and_centroid(points: Array, corners: Array, density: Density) -> tuple[Array, Array]:
    """Return the mass (N,) and centroid (N, 2) [m] of the Voronoi cells of `points` within a convex polygon.

    A cell without mass has its robot for a centroid; robots at one place have the same cell.

    Args:
        points: on the stage (N, 2) [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
        density: over it.
    """
    mass, to_centroid = _to_centroids(points, corners, density)
    return mass, points + to_centroid


def locational_cost(points: Array, corners: Array, density: Density) -> float:
    """Return H, the sum over Voronoi cells of the integral of |q - p|^2 phi(q), p the cell's robot.

    The cost that coverage control descends: J. Cortes, S. Martinez, T. Karatas and F. Bullo, "Coverage control for
    mobile sensing networks", IEEE Trans. Robotics and Automation 20(2), 2004.

    Args:
        points: on the stage (N, 2) [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
        density: over it.
    """
    return polar_moment(voronoi_fans(points, corners), density)


def _to_centroids(points: Array, corners: Array, density: Density) -> tuple[Array, Array]:
    """Return the mass of each robot's cell (N,) and the vector from the robot to its centroid (N, 2) [m]."""
    fans = voronoi_fans(points, corners)
    mass, moment = mass_and_moment(fans, density)
    has_mass = mass > np.finfo(float).tiny  # below, digits are lost
    to_centroid = moment / np.where(has_mass, mass, np.inf)
    return mass[fans.cell_of], to_centroid[fans.cell_of].view(float).reshape(-1, 2)
