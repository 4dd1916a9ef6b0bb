"""Figures of a run for `scene check`: how often commands were cut, smallest distance of bodies, speeds."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from emovid.swarm.arrays import Array, Indices
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import look_ahead, move

_RESOLUTION = 1e-6  # m


@dataclass(frozen=True)
class Summary:
    """Figures of one run.

    Attributes:
        stage_cut_share: share of (robot, period) in which v was cut to stay on the stage.
        separation_cut_share: share of (robot, period) in which v was cut to keep bodies apart.
        body_distance: smallest distance between two bodies at any time [m], negative where they overlap; None for one
            robot.
        mean_speed, peak_speed: of |v| over robots and time [m/s].
    """

    stage_cut_share: float
    separation_cut_share: float
    body_distance: float | None
    mean_speed: float
    peak_speed: float


def summarize(trajectory: Trajectory) -> Summary:
    """Return the figures of a run."""
    seconds = np.diff(trajectory.t)[:, None]
    speed = np.abs(trajectory.commands[..., 0])
    ahead, radius = trajectory.scene.robot.body.disc
    middles = closest_approach(trajectory, ahead)
    return Summary(
        stage_cut_share=float(trajectory.stage_cut.mean()),
        separation_cut_share=float(trajectory.separation_cut.mean()),
        body_distance=None if middles is None else middles - 2 * radius,
        mean_speed=float((speed * seconds).sum() / (seconds.sum() * speed.shape[1])),
        peak_speed=float(speed.max()),
    )


def closest_approach(trajectory: Trajectory, ahead: float = 0.0) -> float | None:
    """Return the smallest distance [m] of two robots at any time, between samples too, to 1e-6 m.

    Measured between the points `ahead` [m] of their poses.

    Over an interval two robots come no nearer than half of (their distances at its ends minus their two path
    lengths); intervals that might hold the smallest distance are halved until that bound says they cannot.
    """
    points = look_ahead(trajectory.poses, ahead)
    if points.shape[1] < 2:
        return None
    best = min(float(cKDTree(p).query(p, k=2)[0][:, 1].min()) for p in points)
    for k, seconds in enumerate(np.diff(trajectory.t)):
        poses, commands = trajectory.poses[k], trajectory.commands[k]
        reach = 2 * _speed_bound(commands, ahead).max() * seconds
        pairs = cKDTree(points[k]).query_pairs(best + reach, output_type="ndarray")
        best = _nearest_in_period(poses, commands, ahead, seconds, pairs, best)
    return best


def _speed_bound(commands: Array, ahead: float) -> Array:
    """Return a bound (N,) of the speeds [m/s] of the points `ahead` [m] of the poses."""
    return np.abs(commands[:, 0]) + np.abs(ahead * commands[:, 1])


def _nearest_in_period(
    poses: Array, commands: Array, ahead: float, seconds: float, pairs: Indices, best: float
) -> float:
    """Return the smaller of `best` [m] and the smallest distance of the `pairs` (C, 2) within one control period."""

    def distance(pairs: Indices, times: Array) -> Array:
        a, b = (look_ahead(move(poses[robot], commands[robot], times), ahead) for robot in pairs.T)
        return np.hypot(*(a - b).T)

    start, length = np.zeros(len(pairs)), np.full(len(pairs), seconds)
    while len(pairs):
        first, last = distance(pairs, start), distance(pairs, start + length)
        best = min(best, float(first.min()), float(last.min()))
        path = _speed_bound(commands, ahead)[pairs].sum(axis=1) * length
        open_ = (first + last - path) / 2 < best - _RESOLUTION
        pairs, start, length = pairs[open_], start[open_], length[open_] / 2
        pairs, start, length = np.tile(pairs, (2, 1)), np.concatenate([start, start + length]), np.tile(length, 2)
    return best
