"""How near the robots are to each other, to the stage's centre and to its edge, and how their motion is ordered."""

import numpy as np
from scipy.spatial import cKDTree

from emovid.measure.descriptor import Descriptor
from emovid.measure.series import in_time, mean_where, series
from emovid.measure.stage_geometry import Ground
from emovid.measure.window import Window
from emovid.swarm.arrays import Array

_ROUNDING = 1e-9  # m; of positions

_ORDER = "Couzin et al. 2002; Tunstrøm et al. 2013"

CROWDING = (
    *series("nearest_neighbour", "m", "distance of a robot's centre from the nearest other, mean over robots"),
    Descriptor(
        "polarisation",
        "1",
        "length of the mean unit velocity of the robots that move, mean over time: 1 if all go one way, about 0.23 if "
        "fifteen go anyhow",
        _ORDER,
    ),
    Descriptor(
        "rotation",
        "1",
        "size of the mean cross product of a robot's unit radius from the robots' centroid and its unit velocity, mean "
        "over time: 1 for a ring that turns",
        _ORDER,
    ),
    *series("distance_to_centre", "m", "distance of a robot's centre from the stage's centroid, mean over robots"),
    *series(
        "distance_to_boundary", "m", "distance of a robot's centre from the stage's nearest edge, mean over robots"
    ),
)


def crowding(window: Window, ground: Ground) -> dict[str, float]:
    """Return the descriptors of crowding and order.

    Order is after I. D. Couzin, J. Krause, R. James, G. D. Ruxton and N. R. Franks, "Collective memory and spatial
    sorting in animal groups", J. Theor. Biol. 218(1), 2002, and K. Tunstrøm, Y. Katz, C. C. Ioannou, C. Huepe,
    M. J. Lutz and I. D. Couzin, "Collective states, multistability and transitional behavior in schooling fish", PLoS
    Comput. Biol. 9(2), 2013; with velocities, not headings: a robot that reverses goes where its back points. A robot
    that stands still has no direction, one in the centroid no radius.
    """
    times = window.times()
    points = window.points(times)
    off = points - ground.centre
    polarisation, rotation = order(points[:-1], directions(window, times[:-1]))
    return {
        **in_time("nearest_neighbour", times, np.array([nearest_neighbour(now) for now in points])),
        "polarisation": mean_where(polarisation, ~np.isnan(polarisation)),
        "rotation": mean_where(rotation, ~np.isnan(rotation)),
        **in_time("distance_to_centre", times, np.hypot(off[..., 0], off[..., 1]).mean(axis=1)),
        **in_time("distance_to_boundary", times, ground.distance_to_edge(points).mean(axis=1)),
    }


def nearest_neighbour(points: Array) -> float:
    """Return the mean distance [m] of points (N, 2) from their nearest neighbours, NaN for one point."""
    return float(cKDTree(points).query(points, k=2)[0][:, 1].mean()) if len(points) > 1 else float("nan")


def directions(window: Window, times: Array) -> Array:
    """Return the unit velocities (F, N, 2) at `times` (F,) [s], zero for robots that stand still."""
    trajectory = window.trajectory
    period = np.searchsorted(trajectory.t, times, side="right") - 1
    v = trajectory.commands[period, :, 0]
    way = np.where(np.abs(v) > window.still, np.sign(v), 0.0)
    heading = trajectory.at(times)[..., 2]
    return np.stack([way * np.cos(heading), way * np.sin(heading)], axis=-1)


def order(points: Array, velocities: Array) -> tuple[Array, Array]:
    """Return polarisation and rotation (F,) of robots at `points` with unit or zero `velocities`, both (F, N, 2).

    NaN where no robot has what they are the mean of.
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
