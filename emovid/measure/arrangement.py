"""Arrangement of the swarm: size and roundness, distances of robots from each other and the stage, order of motion.

Order is that of I. D. Couzin, J. Krause, R. James, G. D. Ruxton and N. R. Franks, "Collective memory and spatial
sorting in animal groups", J. Theor. Biol. 218(1), 2002, and K. Tunstrøm, Y. Katz, C. C. Ioannou, C. Huepe, M. J. Lutz
and I. D. Couzin, "Collective states, multistability and transitional behavior in schooling fish", PLoS Comput. Biol.
9(2), 2013, with velocities in place of headings: a reversing robot moves where its back points. A robot that stands
still has no direction, and a robot in the centroid of the swarm has no radius.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from emovid.measure.window import Descriptor, Window, mean_where, series, series_values
from emovid.swarm.arrays import Array
from emovid.swarm.clearance import room_on_stage

_ROUNDING = 1e-9  # m; of positions
_ORDER = "Couzin et al. 2002; Tunstrøm et al. 2013"

SHAPE = (
    *series("radius_of_gyration", "m", "root mean square distance of the robots from their centroid"),
    Descriptor("radius_of_gyration_diagonals", "diagonals", "radius_of_gyration_mean over the stage's diagonal"),
    *series(
        "hull_area_share",
        "share",
        "area of the convex hull of the robots' centers over that of the stage, 0 if they are on a line",
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

CROWDING = (
    *series(
        "nearest_neighbour", "m", "distance between the centers of a robot and its nearest neighbor, mean over robots"
    ),
    Descriptor(
        "polarisation",
        "1",
        "length of the mean unit velocity of the robots that move, mean over time: 1 if all move in one direction, "
        "about 0.23 if fifteen move in random directions",
        _ORDER,
    ),
    Descriptor(
        "rotation",
        "1",
        "size of the mean cross product of a robot's unit radius from the robots' centroid and its unit velocity, mean "
        "over time: 1 for a ring that turns",
        _ORDER,
    ),
    *series("distance_to_centre", "m", "distance of a robot's center from the stage's centroid, mean over robots"),
    *series(
        "distance_to_boundary", "m", "distance of a robot's center from the nearest edge of the stage, mean over robots"
    ),
)


def shape(window: Window) -> dict[str, float]:
    """Return the descriptors of size and roundness; NaN where coincident robots have none."""
    times = window.times()
    points = window.points(times)
    radii = distances_from_centroid(points)
    gyration = np.sqrt(np.mean(radii**2, axis=1))
    area, perimeter = np.transpose([hull_of(now) for now in points])
    apart = gyration > _ROUNDING
    with np.errstate(invalid="ignore", divide="ignore"):
        circularity = 4 * np.pi * area / perimeter**2
        spread = radii.std(axis=1) / radii.mean(axis=1)
    gyrations = series_values("radius_of_gyration", times, gyration)
    return {
        **gyrations,
        "radius_of_gyration_diagonals": gyrations["radius_of_gyration_mean"] / window.stage.diagonal,
        **series_values("hull_area_share", times, area / window.stage.area),
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
    end = points[np.argmax(_distances(points[0], points))]
    return 0.0, 2 * float(_distances(end, points).max())


def _distances(point: Array, points: Array) -> Array:
    off = points - point
    return np.hypot(off[:, 0], off[:, 1])


def crowding(window: Window) -> dict[str, float]:
    """Return the descriptors of crowding and order."""
    times = window.times()
    points = window.points(times)
    off = points - window.stage.centre
    polarisation, rotation = order(points[:-1], window.trajectory.directions(times[:-1], window.still))
    edge = room_on_stage(points, window.trajectory.scene.stage)
    return {
        **series_values("nearest_neighbour", times, np.array([nearest_neighbour(now) for now in points])),
        "polarisation": mean_where(polarisation, ~np.isnan(polarisation)),
        "rotation": mean_where(rotation, ~np.isnan(rotation)),
        **series_values("distance_to_centre", times, np.hypot(off[..., 0], off[..., 1]).mean(axis=1)),
        **series_values("distance_to_boundary", times, edge.mean(axis=1)),
    }


def nearest_neighbour(points: Array) -> float:
    """Return the mean distance [m] of points (N, 2) from their nearest neighbors, NaN for one point."""
    return float(cKDTree(points).query(points, k=2)[0][:, 1].mean()) if len(points) > 1 else float("nan")


def order(points: Array, velocities: Array) -> tuple[Array, Array]:
    """Return polarization and rotation (F,) of robots at `points` with unit or zero `velocities`, both (F, N, 2).

    NaN where no robot has a direction or a radius.
    """
    moving = velocities.any(axis=-1)
    off = points - points.mean(axis=1, keepdims=True)
    radius = np.hypot(off[..., 0], off[..., 1])
    turning = moving & (radius > _ROUNDING)
    across = (off[..., 0] * velocities[..., 1] - off[..., 1] * velocities[..., 0]) / np.where(turning, radius, 1.0)
    total = velocities.sum(axis=1)
    with np.errstate(invalid="ignore"):
        polarisation = np.hypot(total[:, 0], total[:, 1]) / moving.sum(axis=1)
        rotation = np.abs(np.sum(across * turning, axis=1)) / turning.sum(axis=1)
    return polarisation, rotation
