"""Progress of a coverage behavior toward its end, and how far robots overshoot the centroids they head for.

The cost of a configuration is the locational cost H = sum_i of the integral over V_i of |q - p_i|^2 phi(q) dq
(J. Cortés, S. Martínez, T. Karatas and F. Bullo, "Coverage control for mobile sensing networks", IEEE Trans. Robot.
Autom. 20(2), 2004) over the density's mass: the mean square distance of the mass from its robot, independent of the
scale of phi. Its converged value is the cost at which Lloyd's iteration, started at the window's end, settles.
"""

import numpy as np

from emovid.measure.window import Descriptor, Window
from emovid.scene.behaviour import Coverage
from emovid.swarm.arrays import Array
from emovid.swarm.densities import Density, density_of
from emovid.swarm.laws import corners_of, lloyd, locational_cost, mass_and_centroid

_CONVERGED = 1e-6  # of the cost: the smallest gain for which Lloyd's iteration continues
_MAX_PERIODS = 60  # examined for overshoot
_MIN_LAG, _MAX_LAG = 3, 8  # control periods; a cycle of two shows at four

_COST = "locational cost of Cortés et al. 2004, over the density's mass"

CONVERGENCE = (
    Descriptor(
        "cost_start",
        "m^2",
        "mean square distance between the mass of the density and its nearest robot, at the start",
        _COST,
    ),
    Descriptor("cost_end", "m^2", "the same at the window's end", _COST),
    Descriptor(
        "cost_converged",
        "m^2",
        "the same where Lloyd's iteration ends, from the window's end: when a step gains less than a millionth of "
        "cost_end, or after 200 steps",
        _COST,
    ),
    Descriptor("cost_ratio", "1", "cost_end / cost_converged", _COST),
    Descriptor("cost_progress", "share", "(cost_start - cost_end) / (cost_start - cost_converged)", _COST),
    Descriptor(
        "overshoot_share",
        "share",
        "share of the control periods of all robots in which a robot moves past the centroid of its cell at the start "
        "of the period by more than a visible step along the line to it; at most 60 periods, evenly spread",
    ),
    Descriptor("overshoot_mean", "m", "distance past the centroid, mean over those periods; 0 if there are none"),
    Descriptor(
        "recurrence",
        "m",
        "closest return of the swarm to a former state: the minimum, over all times and lags of 3 to 8 control "
        "periods, of the largest distance of a robot from its former position",
    ),
)


def convergence(window: Window) -> dict[str, float]:
    """Return the descriptors of convergence; NaN for behaviors without a density."""
    scene = window.trajectory.scene
    if not isinstance(scene.behaviour, Coverage):
        return {descriptor.name: float("nan") for descriptor in CONVERGENCE}
    past = past_centroids(window, corners_of(scene.stage), density_of(scene.behaviour.density, scene.stage))
    passes, undefined = past > window.step, float("nan")
    return {
        **costs(window),
        "overshoot_share": float(passes.mean()) if passes.size else undefined,
        "overshoot_mean": float(past[passes].mean()) if passes.any() else 0.0 if passes.size else undefined,
        "recurrence": recurrence(window),
    }


def costs(window: Window) -> dict[str, float]:
    """Return the descriptors of the cost; NaN for behaviours without a density."""
    scene, undefined = window.trajectory.scene, float("nan")
    if not isinstance(scene.behaviour, Coverage):
        return {d.name: undefined for d in CONVERGENCE if d.name.startswith("cost")}
    corners, density = corners_of(scene.stage), density_of(scene.behaviour.density, scene.stage)
    first, last = window.points(np.array([window.start, window.end]))
    start, end = (mean_cost(points, corners, density) for points in (first, last))
    converged = mean_cost(lloyd(last, corners, density, gain=_CONVERGED * end), corners, density)
    gain = start - converged
    return {
        "cost_start": start,
        "cost_end": end,
        "cost_converged": converged,
        "cost_ratio": end / converged,
        "cost_progress": (start - end) / gain if gain > _CONVERGED * start else undefined,
    }


def recurrence(window: Window) -> float:
    """Return the smallest distance [m] between two states of the swarm that are 3 to 8 control periods apart.

    The distance of two states is that of the robot that moved farthest: below a centimeter, an observer sees the same
    configuration again. NaN for a window of fewer periods.
    """
    trajectory = window.trajectory
    samples = np.arange(0, len(trajectory.t), trajectory.scene.steps_held)
    t = trajectory.t[samples]
    points = trajectory.poses[samples[(t >= window.start - 1e-9) & (t <= window.end + 1e-9)], :, :2]
    return min(
        (float(_moved(points[lag:] - points[:-lag]).min()) for lag in range(_MIN_LAG, min(_MAX_LAG + 1, len(points)))),
        default=float("nan"),
    )


def _moved(off: Array) -> Array:
    return np.hypot(off[..., 0], off[..., 1]).max(axis=1)


def mean_cost(points: Array, corners: Array, density: Density) -> float:
    """Return the locational cost of points (N, 2) on a stage with `corners` (C, 2) over the density's mass [m^2]."""
    (mass,), _ = mass_and_centroid(corners[:1], corners, density)  # the cell of a single robot is the whole stage
    return locational_cost(points, corners, density) / float(mass)


def past_centroids(window: Window, corners: Array, density: Density) -> Array:
    """Return how far [m] robots move past their centroids, (periods, N), negative if they stay short."""
    trajectory, held = window.trajectory, window.trajectory.scene.steps_held
    samples = np.arange(0, len(trajectory.t), held)  # a barrier's own steps are parts of a control period
    ends = trajectory.t[samples]
    whole = np.flatnonzero((ends[:-1] >= window.start - 1e-9) & (ends[1:] <= window.end + 1e-9))
    evenly = np.linspace(0, len(whole) - 1, min(len(whole), _MAX_PERIODS)).round().astype(int)
    past = []
    for period in whole[evenly]:
        before, after = trajectory.poses[samples[period : period + 2], :, :2]
        _, centroid = mass_and_centroid(before, corners, density)
        ahead = centroid - before
        distance = np.hypot(ahead[:, 0], ahead[:, 1])
        along = np.sum((after - before) * ahead, axis=1) / np.where(distance > 0, distance, 1.0)
        past.append(along - distance)
    return np.array(past)
