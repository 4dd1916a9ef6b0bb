"""Numbers of a run that the paper's claims compare: its descriptors, and some that only claims need.

Numbers are of the whole run, unless the paper names a time: those of the run up to the emotion's last snapshot end in
`_to_snapshot`.
"""

import numpy as np
from scipy.spatial import cKDTree

from emovid.measure.arrangement import crowding, shape
from emovid.measure.convergence import costs
from emovid.measure.describe import describe
from emovid.measure.kinematics import speed
from emovid.measure.trace import path, turning, turns, visible_steps
from emovid.measure.window import Window, window_of
from emovid.scene.emotions import EMOTIONS
from emovid.scene.model import Scene
from emovid.swarm.arrays import Array
from emovid.swarm.laws import corners_of
from emovid.swarm.trajectory import Trajectory

_SECOND = 1.0  # s of the paper's videos; scenes for robots are slower
_COARSE = 4  # visible steps in a coarse one, 20 mm for a GRITSBot: the size of the motion, not of its detail
_RIPPLES = 6  # of happiness, the only shape number in the paper
_ANGLES = 64  # sectors around the swarm's middle in which the radius is averaged
_BACKWARDS = 0.01  # of the peak speed: slower reversal is rounding
_TO_SNAPSHOT = (
    "distance_travelled", "radius_of_gyration_start", "radius_of_gyration_mean", "radius_of_gyration_end",
    "nearest_neighbour_start", "nearest_neighbour_end", "hull_area_share_end", "distance_to_centre_start",
    "distance_to_centre_end", "distance_to_boundary_end", "cost_ratio", "cost_progress",
)  # fmt: skip


def claim_metrics(trajectory: Trajectory) -> dict[str, float]:
    """Return the numbers that claims compare; a ratio over 0, such as some of a lone robot, is NaN.

    Besides descriptors:

    - `slowest_second`, `fastest_second`: least and largest mean speed of the swarm in any second [m/s]; in a scene
      that reaches the paper's snapshots later, a second lasts as much longer.
    - `liveliness`: slowest_second over speed_mean.
    - `reverse_share`: share of the robots' time in which they drive backward.
    - `coarse_turning`: turning_per_metre with steps of four visible steps [rad/m].
    - `largest_turn`: largest turn between two of these steps [rad].
    - `look_ahead_steps`: l in visible steps.
    - `look_ahead_periods`: l over the distance of a control period at the 95 % speed.
    - `ripple_share`: share of the sixth harmonic in the variation of the radius around the swarm's middle.
    - `start_irregularity`: standard deviation over mean of nearest neighbors' distances at the start.
    - `neighbour_gain`, `centre_gain`, `size_gain`: end over start of nearest_neighbour, distance_to_centre and
      radius_of_gyration, to the snapshot.
    - `circumference_share`: distance_travelled over the circumference of a circle of the mean radius of gyration, to
      the snapshot.
    - `boundary_share`: distance_to_boundary_end over the stage's smaller side, to the snapshot.
    - `boundary_gap`: largest gap between robots along the boundary at the end, over the even gap.
    """
    last = float(trajectory.t[-1])
    whole, at = describe(trajectory, 0.0, last), _to_snapshot(window_of(trajectory))
    slowest, fastest = speeds_in_a_second(trajectory, _SECOND * _slowness(trajectory.scene))
    window = Window(trajectory, 0.0, last)
    left, bottom, right, top = trajectory.scene.stage.box
    return {
        **whole,
        **at,
        "slowest_second": slowest,
        "fastest_second": fastest,
        "liveliness": _ratio(slowest, whole["speed_mean"]),
        "reverse_share": reverse_share(trajectory),
        **_coarse_turns(window),
        **_look_ahead(window, whole["speed_p95"]),
        "ripple_share": ripple_share(window.points(np.linspace(0, last, 40 * _ANGLES))),
        "start_irregularity": irregularity(trajectory.poses[0, :, :2]),
        **{
            f"{name}_gain": _ratio(at[f"{of}_end_to_snapshot"], at[f"{of}_start_to_snapshot"])
            for name, of in (
                ("neighbour", "nearest_neighbour"), ("centre", "distance_to_centre"), ("size", "radius_of_gyration")
            )
        },
        "circumference_share": _ratio(
            at["distance_travelled_to_snapshot"], 2 * np.pi * at["radius_of_gyration_mean_to_snapshot"]
        ),
        "boundary_share": at["distance_to_boundary_end_to_snapshot"] / min(right - left, top - bottom),
        "boundary_gap": boundary_gap(trajectory),
    }  # fmt: skip


def _to_snapshot(window: Window) -> dict[str, float]:
    found = {**speed(window), **shape(window), **crowding(window), **costs(window)}
    return {f"{name}_to_snapshot": found[name] for name in _TO_SNAPSHOT}


def _slowness(scene: Scene) -> float:
    """Return by which factor a scene reaches its last snapshot later than the paper's emotion."""
    if not (scene.emotion and scene.snapshot_times):
        return 1.0
    return scene.snapshot_times[-1] / EMOTIONS[scene.emotion].snapshot_times[-1]


def speeds_in_a_second(trajectory: Trajectory, second: float = _SECOND) -> tuple[float, float]:
    """Return the least and the largest mean speed [m/s] of the swarm in any `second` [s] of its run.

    The distance traveled is piecewise linear in time with bends at the samples, so the extremes lie where a second
    starts or ends at a sample. A run of less than a second is one window.
    """
    t = trajectory.t
    distance = np.concatenate([[0.0], np.cumsum(np.abs(trajectory.commands[..., 0]).mean(axis=1) * np.diff(t))])
    length = min(second, float(t[-1] - t[0]))
    starts = np.concatenate([t, t - length])
    starts = starts[(starts >= t[0]) & (starts <= t[-1] - length + 1e-12)]
    speeds = (np.interp(starts + length, t, distance) - np.interp(starts, t, distance)) / length
    return float(speeds.min()), float(speeds.max())


def reverse_share(trajectory: Trajectory) -> float:
    """Return the share of the robots' time in which they drive backward."""
    v, seconds = trajectory.commands[..., 0], np.diff(trajectory.t)
    return float((seconds * (v < -_BACKWARDS * np.abs(v).max()).mean(axis=1)).sum() / seconds.sum())


def ripple_share(points: Array) -> float:
    """Return the share of the sixth harmonic in the variation of the radius with the angle, of points (F, N, 2)."""
    off = points - points.mean(axis=(0, 1))
    radius, angle = np.hypot(off[..., 0], off[..., 1]).ravel(), np.arctan2(off[..., 1], off[..., 0]).ravel()
    sector = np.floor(angle / (2 * np.pi) * _ANGLES).astype(int) % _ANGLES
    count = np.bincount(sector, minlength=_ANGLES)
    if not count.all() or radius.max() == 0:
        return 0.0
    power = np.abs(np.fft.rfft(np.bincount(sector, radius, _ANGLES) / count)[1:]) ** 2
    return float(power[_RIPPLES - 1] / power.sum()) if power.sum() > 1e-12 * radius.max() ** 2 else 0.0


def irregularity(points: Array) -> float:
    """Return standard deviation over mean of the distances of points (N, 2) from their nearest neighbors."""
    if len(points) < 2:
        return float("nan")
    distance = cKDTree(points).query(points, k=2)[0][:, 1]
    return float(distance.std() / distance.mean())


def boundary_gap(trajectory: Trajectory) -> float:
    """Return the largest gap between robots along the stage's boundary at the end, over the even gap.

    Each robot counts at the boundary's nearest point.
    """
    corners, points = corners_of(trajectory.scene.stage), trajectory.poses[-1, :, :2]
    side = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(side[:, 0], side[:, 1])
    along = np.sum((points[:, None] - corners) * side, axis=2) / length
    along = np.clip(along, 0.0, length)
    foot = corners + along[..., None] * (side / length[:, None])
    nearest = np.sum((points[:, None] - foot) ** 2, axis=2).argmin(axis=1)
    place = np.sort((np.cumsum(length) - length)[nearest] + along[np.arange(len(points)), nearest])
    gaps = np.diff(np.append(place, place[0] + length.sum()))
    return float(gaps.max() / (length.sum() / len(points)))


def _coarse_turns(window: Window) -> dict[str, float]:
    step = _COARSE * window.step
    walks = [visible_steps(path(window, robot), step) for robot in range(window.trajectory.poses.shape[1])]
    turned = [turns(walk) for walk in walks if len(walk) > 2]
    if not turned:
        return {"coarse_turning": float("nan"), "largest_turn": float("nan")}
    return {
        "coarse_turning": sum(map(turning, turned)) / (sum(map(len, turned)) * step),
        "largest_turn": float(max(np.abs(turn).max() for turn in turned)),
    }


def _look_ahead(window: Window, speed: float) -> dict[str, float]:
    robot, period = window.trajectory.scene.robot, window.trajectory.scene.control_period
    l = robot.l if robot.body.steers and robot.l else float("nan")
    return {"look_ahead_steps": l / window.step, "look_ahead_periods": _ratio(l, speed * period)}


def _ratio(value: float, over: float) -> float:
    return value / over if over else float("nan")
