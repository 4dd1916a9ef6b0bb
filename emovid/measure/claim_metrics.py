"""What the claims look at: the descriptors of a run, and a few numbers made of them."""

import numpy as np

from emovid.measure.describe import describe
from emovid.swarm.trajectory import Trajectory

_SECOND = 1.0


def evidence(trajectory: Trajectory) -> dict[str, float]:
    """Return the descriptors up to the emotion's last snapshot and, besides, those that only a claim needs.

    `slowest_second` and `fastest_second`: least and largest mean speed of the swarm in any second of the whole run
    [m/s]. `neighbour_gain`: nearest_neighbour_end over _start. `centre_gain`: distance_to_centre_end over _start.
    `size_gain`: radius_of_gyration_end over _start. `circumference_share`: distance_travelled over the circumference of
    a circle of the mean radius of gyration. `boundary_share`: distance_to_boundary_end over the stage's smaller side.
    A ratio over 0, as some of a lone robot's are, is NaN.
    """
    found = describe(trajectory)
    slowest, fastest = speeds_in_a_second(trajectory)
    left, bottom, right, top = trajectory.scene.stage.box
    return {
        **found,
        "slowest_second": slowest,
        "fastest_second": fastest,
        "neighbour_gain": _ratio(found["nearest_neighbour_end"], found["nearest_neighbour_start"]),
        "centre_gain": _ratio(found["distance_to_centre_end"], found["distance_to_centre_start"]),
        "size_gain": _ratio(found["radius_of_gyration_end"], found["radius_of_gyration_start"]),
        "circumference_share": _ratio(found["distance_travelled"], 2 * np.pi * found["radius_of_gyration_mean"]),
        "boundary_share": found["distance_to_boundary_end"] / min(right - left, top - bottom),
    }


def speeds_in_a_second(trajectory: Trajectory) -> tuple[float, float]:
    """Return the least and the largest mean speed [m/s] of the swarm in any second of its run.

    With held commands the way done by a time is a line with bends at the samples, so the extremes lie where a second
    starts or ends at one. A run of less than a second is one window.
    """
    t = trajectory.t
    way = np.concatenate([[0.0], np.cumsum(np.abs(trajectory.commands[..., 0]).mean(axis=1) * np.diff(t))])
    length = min(_SECOND, float(t[-1] - t[0]))
    starts = np.concatenate([t, t - length])
    starts = starts[(starts >= t[0]) & (starts <= t[-1] - length + 1e-12)]
    speeds = (np.interp(starts + length, t, way) - np.interp(starts, t, way)) / length
    return float(speeds.min()), float(speeds.max())


def _ratio(value: float, over: float) -> float:
    return value / over if over else float("nan")
