"""How large the swarm is, and how round in space."""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from emovid.measure.descriptor import Descriptor
from emovid.measure.series import in_time, mean_where, series
from emovid.measure.stage_geometry import Ground
from emovid.measure.window import Window
from emovid.swarm.arrays import Array

_ROUNDING = 1e-9  # m; of positions

SHAPE = (
    *series("radius_of_gyration", "m", "root mean square distance of the robots from their centroid"),
    Descriptor("radius_of_gyration_diagonals", "diagonals", "radius_of_gyration_mean over the stage's diagonal"),
    *series(
        "hull_area_share",
        "share",
        "area of the convex hull of the robots' centres over the stage's, 0 if they are on a line",
    ),
    Descriptor(
        "hull_circularity",
        "1",
        "4 pi area / perimeter^2 of the convex hull, mean over time: 1 for a circle, 0.98 for fifteen robots evenly on "
        "one, 0 for a line",
        "isoperimetric quotient; circularity of E. P. Cox 1927",
    ),
    Descriptor(
        "radius_spread",
        "1",
        "standard deviation over mean of the robots' distances from their centroid, mean over time: 0 for a ring",
    ),
)


def shape(window: Window, ground: Ground) -> dict[str, float]:
    """Return the descriptors of size and roundness; NaN for what coincident robots have none of."""
    times = window.times()
    points = window.points(times)
    radii = distances_from_centroid(points)
    gyration = np.sqrt(np.mean(radii**2, axis=1))
    area, perimeter = np.transpose([hull_of(now) for now in points])
    apart = gyration > _ROUNDING
    with np.errstate(invalid="ignore", divide="ignore"):
        circularity = 4 * np.pi * area / perimeter**2
        spread = radii.std(axis=1) / radii.mean(axis=1)
    gyrations = in_time("radius_of_gyration", times, gyration)
    return {
        **gyrations,
        "radius_of_gyration_diagonals": gyrations["radius_of_gyration_mean"] / ground.diagonal,
        **in_time("hull_area_share", times, area / ground.area),
        "hull_circularity": mean_where(circularity, apart),
        "radius_spread": mean_where(spread, apart),
    }


def distances_from_centroid(points: Array) -> Array:
    """Return the distances (F, N) [m] of the points (F, N, 2) from their centroids (F,)."""
    off = points - points.mean(axis=1, keepdims=True)
    return np.hypot(off[..., 0], off[..., 1])


def hull_of(points: Array) -> tuple[float, float]:
    """Return area [m^2] and perimeter [m] of the convex hull of points (N, 2); for a line, 0 and twice its length."""
    if len(points) > 2:
        try:
            hull = ConvexHull(points)
        except QhullError:  # all on a line
            pass
        else:
            return hull.volume, hull.area  # Qhull's words for the plane
    end = points[np.argmax(_from(points[0], points))]
    return 0.0, 2 * float(_from(end, points).max())


def _from(point: Array, points: Array) -> Array:
    off = points - point
    return np.hypot(off[:, 0], off[:, 1])
