"""The laws of Appendix A: points that run along a contour, and coverage of a density.

Contours: happiness, surprise, sadness. Coverage: fear, disgust, anger; each robot heads for the centroid of its Voronoi
cell under a density. Centroids are exact to a millionth of the density's scale, and to rounding for a constant density;
cells tile the stage to rounding (tested against `scipy.integrate.dblquad`, clipped polygons and closed forms).
"""

from math import cos, pi

import numpy as np

from emovid.scene.behaviour import Circle, CircularSinusoid, Contour, Coverage, ExpandingCircle
from emovid.scene.stage import Stage
from emovid.swarm.arrays import Array, Complex
from emovid.swarm.densities import Density, density_of
from emovid.swarm.line_integrals import line_integrals
from emovid.swarm.quadrature import mass_and_moment, polar_moment
from emovid.swarm.voronoi import voronoi_fans

# --- contours ---------------------------------------------------------------------------------------------------------


def start_angles(robots: int) -> Array:
    """Return theta_i(0) = 2 pi i / N, i = 1..N, (N,) [rad]."""
    return 2 * np.pi * np.arange(1, robots + 1) / robots


def radius(contour: Contour, theta: Array, t: float) -> Array:
    """Return the distance [m] of the contour from its center at the angles `theta` (N,) [rad] and time `t` [s].

    Circular sinusoid: R + A sin(f theta). Expanding circle: mod(c t, R_max - R_min) + R_min with c the expansion rate;
    the paper prints c = 1 m/s, which would cross its stage in under a second, and then a controller that holds R(0)
    throughout. Its text and figure show a radius that grows, so this one does; the mod makes it restart at R_min. That
    jump makes all robots reverse and hook, while the paper calls surprise smooth: with a `return_time`, the radius
    returns as half a cosine instead.
    """
    match contour:
        case CircularSinusoid():
            return contour.R + contour.A * np.sin(contour.f * theta)
        case ExpandingCircle():
            return np.full_like(theta, expanding_radius(contour, t))
        case Circle():  # pragma: no branch - there is no other
            return np.full_like(theta, contour.R)


def expanding_radius(contour: ExpandingCircle, t: float) -> float:
    """Return the radius [m] of an expanding circle at time `t` [s]."""
    growth = contour.R_max - contour.R_min
    if not contour.return_time:
        return contour.R_min + (contour.expansion_rate * t) % growth
    expansion = growth / contour.expansion_rate
    phase = t % (expansion + contour.return_time)
    if phase < expansion:
        return contour.R_min + min(contour.expansion_rate * phase, growth)
    return contour.R_min + growth * (1 + cos(pi * (phase - expansion) / contour.return_time)) / 2


def settled_points(contour: Contour, theta_0: Array, K: float) -> Array:
    """Return the positions (N, 2) [m] at t = 0 of points that have followed the contour with the gain `K` for long.

    A point that obeys p' = K (x - p) follows each harmonic exp(i n w t) of x by the factor K / (K + i n w). An
    expanding circle counts as if it had always grown.
    """
    w = contour.angular_rate

    def followed(harmonic: Complex, n: float) -> Complex:
        return harmonic * K / (K + 1j * n * w)

    turn: Complex = np.exp(1j * theta_0)
    match contour:
        case CircularSinusoid():
            ripple = contour.A / 2j * np.exp(1j * contour.f * theta_0)
            place = followed(contour.R * turn, 1) + followed(ripple * turn, contour.f + 1)
            place = place + followed(ripple.conj() * turn, 1 - contour.f)
        case ExpandingCircle():
            place = followed(contour.R_min * turn, 1) - contour.expansion_rate * turn * K / (K + 1j * w) ** 2
        case Circle():  # pragma: no branch - there is no other
            place = followed(contour.R * turn, 1)
    return np.stack([contour.centre.x + place.real, contour.centre.y + place.imag], axis=-1)


def followed_points(contour: Contour, theta_0: Array, t: float) -> Array:
    """Return the points (N, 2) [m] that the robots follow at time `t` [s], having started from the angles `theta_0`.

    The paper has theta_i(t) = t + theta_i(0). Here the angle has a rate, since sadness turns by an eighth in 8 s.
    """
    theta = theta_0 + contour.angular_rate * t
    r = radius(contour, theta, t)
    return np.stack([contour.centre.x + r * np.cos(theta), contour.centre.y + r * np.sin(theta)], axis=-1)


def start_headings(contour: Contour, theta_0: Array) -> Array:
    """Return the directions (N,) [rad] in which the followed points start: tangent to their paths at t = 0."""
    r = radius(contour, theta_0, 0.0)
    along = contour.angular_rate * r
    outwards = np.zeros_like(r)
    if isinstance(contour, CircularSinusoid):
        outwards = contour.angular_rate * contour.A * contour.f * np.cos(contour.f * theta_0)
    elif isinstance(contour, ExpandingCircle):
        outwards = np.full_like(r, contour.expansion_rate)
    still = (along == 0) & (outwards == 0)
    return theta_0 + np.arctan2(np.where(still, 1.0, along), outwards)


# --- coverage ---------------------------------------------------------------------------------------------------------


def corners_of(stage: Stage) -> Array:
    """Return the stage's corners (C, 2) [m], counter-clockwise."""
    return np.array(stage.outline)


def coverage_velocity(law: Coverage, stage: Stage, points: Array) -> Array:
    """Return u = kappa (c - p), (N, 2) [m/s]: Appendix A, its length capped at `law.u_max` if there is one.

    A robot whose cell has no mass stays where it is.
    """
    u = law.kappa * _to_centroids(points, corners_of(stage), density_of(law.density, stage))[1]
    if law.u_max is None:
        return u
    speed = np.hypot(u[:, 0], u[:, 1])
    return u * (law.u_max / np.maximum(speed, law.u_max))[:, None]


def mass_and_centroid(points: Array, corners: Array, density: Density) -> tuple[Array, Array]:
    """Return the mass (N,) and centroid (N, 2) [m] of the Voronoi cells of `points` within a convex polygon.

    The centroid of a cell without mass is its robot; coincident robots have the same cell.

    Args:
        points: on the stage (N, 2) [m].
        corners: of the stage (C, 2) [m], counter-clockwise.
        density: over it.
    """
    mass, to_centroid = _to_centroids(points, corners, density)
    return mass, points + to_centroid


def lloyd(points: Array, corners: Array, density: Density, *, gain: float, steps: int = 200) -> Array:
    """Return the points (N, 2) [m] where Lloyd's iteration converges: all points move at once to their centroids.

    It ends when a step would lower the mean cost of the present cells by less than `gain` [m^2], or after `steps`.
    """
    for _ in range(steps):
        mass, centroid = mass_and_centroid(points, corners, density)
        if (mass * np.sum((centroid - points) ** 2, axis=1)).sum() < gain * mass.sum():  # the parallel axis theorem
            break
        points = centroid
    return points


def locational_cost(points: Array, corners: Array, density: Density) -> float:
    """Return H, the sum over Voronoi cells of the integral of |q - p|^2 phi(q), p the cell's robot.

    The cost that coverage control descends: J. Cortés, S. Martínez, T. Karatas and F. Bullo, "Coverage control for
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
    if density.gaussians:
        mass, moment = line_integrals(fans, density.gaussians)
    else:
        mass, moment = mass_and_moment(fans, density)
    has_mass = mass > np.finfo(float).tiny  # below, digits are lost
    to_centroid = moment / np.where(has_mass, mass, np.inf)
    return mass[fans.cell_of], to_centroid[fans.cell_of].view(float).reshape(-1, 2)
