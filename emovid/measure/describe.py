"""All descriptors of a run, and the further numbers that only the paper's claims need."""

import numpy as np

from emovid.measure.arrangement import CROWDING, SHAPE, crowding, shape
from emovid.measure.convergence import CONVERGENCE, convergence
from emovid.measure.kinematics import SMOOTHNESS, SPEED, smoothness, speed
from emovid.measure.trace import TRACE, trace
from emovid.measure.window import WINDOW, Descriptor, window_of
from emovid.swarm.trajectory import Trajectory

# By family, in the order of docs/descriptors.md, which has a row for each.
FAMILIES: dict[str, tuple[Descriptor, ...]] = {
    "Window": WINDOW,
    "Speed": SPEED,
    "Angularity of the trace": TRACE,
    "Smoothness": SMOOTHNESS,
    "Size and roundness": SHAPE,
    "Crowding and order": CROWDING,
    "Convergence": CONVERGENCE,
}
DESCRIPTORS: dict[str, Descriptor] = {each.name: each for family in FAMILIES.values() for each in family}

_SECOND = 1.0


def describe(trajectory: Trajectory, start: float = 0.0, end: float | None = None) -> dict[str, float]:
    """Return the value of each of the `DESCRIPTORS`, in their order; NaN where a run has none.

    Args:
        trajectory: of any scene; its `video` has no influence.
        start: of the window that is measured [s].
        end: of the window [s]; by default the last of the scene's `snapshots`, else of the paper's for its emotion; the
            run's end without either, or if that comes first.

    Raises:
        InputError: if the window is empty or not within the run.
    """
    window = window_of(trajectory, start, end)
    return {
        "window": window.length,
        **speed(window),
        **trace(window),
        **smoothness(window),
        **shape(window),
        **crowding(window),
        **convergence(window),
    }


def claim_metrics(trajectory: Trajectory) -> dict[str, float]:
    """Return the descriptors up to the emotion's last snapshot, and the numbers that only claims need.

    `slowest_second` and `fastest_second`: least and largest mean speed of the swarm in any second of the whole run
    [m/s]. `neighbour_gain`: nearest_neighbour_end over _start. `centre_gain`: distance_to_centre_end over _start.
    `size_gain`: radius_of_gyration_end over _start. `circumference_share`: distance_travelled over the circumference of
    a circle of the mean radius of gyration. `boundary_share`: distance_to_boundary_end over the stage's smaller side.
    A ratio over 0, such as some of a lone robot, is NaN.
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

    The distance travelled is piecewise linear in time with bends at the samples, so the extremes lie where a second
    starts or ends at a sample. A run of less than a second is one window.
    """
    t = trajectory.t
    distance = np.concatenate([[0.0], np.cumsum(np.abs(trajectory.commands[..., 0]).mean(axis=1) * np.diff(t))])
    length = min(_SECOND, float(t[-1] - t[0]))
    starts = np.concatenate([t, t - length])
    starts = starts[(starts >= t[0]) & (starts <= t[-1] - length + 1e-12)]
    speeds = (np.interp(starts + length, t, distance) - np.interp(starts, t, distance)) / length
    return float(speeds.min()), float(speeds.max())


def _ratio(value: float, over: float) -> float:
    return value / over if over else float("nan")
