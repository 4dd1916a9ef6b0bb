"""The contours of happiness, surprise and sadness, and the points that run along them (Appendix A)."""

import numpy as np

from emovid.scene.behaviour import Circle, CircularSinusoid, Contour, ExpandingCircle
from emovid.swarm.arrays import Array


def start_angles(robots: int) -> Array:
    """Return theta_i(0) = 2 pi i / N, i = 1..N, (N,) [rad]."""
    return 2 * np.pi * np.arange(1, robots + 1) / robots


def radius(contour: Contour, theta: Array, t: float) -> Array:
    """Return the distance [m] of the contour from its centre at the angles `theta` (N,) [rad] and time `t` [s].

    Circular sinusoid: R + A sin(f theta). Expanding circle: mod(c t, R_max - R_min) + R_min with c the expansion rate;
    the paper prints c = 1 m/s, which would cross its stage in under a second, and then a controller that holds R(0) for
    ever. Text and figure show a radius that expands, so ours does; where the mod acts, it starts again at R_min.
    """
    match contour:
        case CircularSinusoid():
            return contour.R + contour.A * np.sin(contour.f * theta)
        case ExpandingCircle():
            grown = np.mod(contour.expansion_rate * t, contour.R_max - contour.R_min)
            return np.full_like(theta, grown + contour.R_min)
        case Circle():  # pragma: no branch - there is no other
            return np.full_like(theta, contour.R)


def followed_points(contour: Contour, theta_0: Array, t: float) -> Array:
    """Return the points (N, 2) [m] that the robots follow at time `t` [s], having started from the angles `theta_0`.

    The paper runs theta_i(t) = t + theta_i(0); ours has a rate, since sadness turns by an eighth in 8 s.
    """
    theta = theta_0 + contour.angular_rate * t
    r = radius(contour, theta, t)
    return np.stack([contour.centre.x + r * np.cos(theta), contour.centre.y + r * np.sin(theta)], axis=-1)


def start_headings(contour: Contour, theta_0: Array) -> Array:
    """Return the directions (N,) [rad] in which the followed points set off: tangent to their paths at t = 0."""
    r = radius(contour, theta_0, 0.0)
    along = contour.angular_rate * r
    outwards = np.zeros_like(r)
    if isinstance(contour, CircularSinusoid):
        outwards = contour.angular_rate * contour.A * contour.f * np.cos(contour.f * theta_0)
    elif isinstance(contour, ExpandingCircle):
        outwards = np.full_like(r, contour.expansion_rate)
    still = (along == 0) & (outwards == 0)
    return theta_0 + np.arctan2(np.where(still, 1.0, along), outwards)
