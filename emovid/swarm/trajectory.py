"""The motion of a run: poses at the ends of control periods and, between them, exact arcs."""

import hashlib
from dataclasses import dataclass

import numpy as np

from emovid.scene.model import Scene
from emovid.swarm.arrays import Array, Mask
from emovid.swarm.unicycle import move


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The motion of a swarm; time, robot, coordinate.

    Attributes:
        scene: the scene that was run.
        t: sample times (T,) [s]: the starts of the control periods, and the end.
        poses: (T, N, 3) = x [m], y [m], heading [rad] at those times; an omnidirectional robot's heading is the
            direction of its motion in the period that starts there.
        commands: (T-1, N, 2) = v [m/s], omega [rad/s], held from one sample to the next.
        stage_cut: (T-1, N), whether v was cut to keep the body on the stage.
        separation_cut: (T-1, N), whether v was cut to keep bodies apart.
        bend: (T-1, N), how far a barrier moved each command [m/s], see `Certified`; None without a barrier.
        relaxed: (T-1, N), where the barrier's program had no solution and this robot was too near to another; None
            without a barrier.
    """

    scene: Scene
    t: Array
    poses: Array
    commands: Array
    stage_cut: Mask
    separation_cut: Mask
    bend: Array | None = None
    relaxed: Mask | None = None

    def at(self, times: Array) -> Array:
        """Return the poses (F, N, 3) at `times` (F,) [s] within the run.

        Raises:
            ValueError: for a time outside the run.
        """
        times = np.asarray(times, dtype=float)
        if times.size and not (self.t[0] <= times.min() and times.max() <= self.t[-1] + 1e-9):
            raise ValueError(f"times from {times.min():g} to {times.max():g} s: the run is 0 to {self.t[-1]:g} s")
        period = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.commands) - 1)
        elapsed = (times - self.t[period])[:, None]
        return move(self.poses[period], self.commands[period], elapsed)

    def trace(self, robot: int, tolerance: float) -> tuple[Array, Array]:
        """Return times (P,) [s] and points (P, 2) [m] of one robot's path.

        The straight lines between the points stray from its arcs by at most `tolerance` [m].
        """
        v, omega = self.commands[:, robot].T
        seconds = np.diff(self.t)
        length, turn = np.abs(v) * seconds, np.abs(omega) * seconds
        # An arc of length s that turns by a rises by at most s a / 8 above its chord, and each of n parts by 1 / n^2 of
        # that. A circle of radius s / a below half the tolerance needs no parts, however often the robot runs it.
        visible = length > turn * tolerance / 2
        parts = np.ceil(np.sqrt(np.where(visible, length * turn, 0.0) / (8 * tolerance))).astype(int)
        parts = np.maximum(parts, 1)
        period = np.repeat(np.arange(len(parts)), parts)
        within = np.arange(len(period)) - np.repeat(np.cumsum(parts) - parts, parts)
        elapsed = seconds[period] * within / parts[period]
        points = move(self.poses[period, robot], self.commands[period, robot], elapsed)[:, :2]
        end = self.at(self.t[-1:])[:, robot, :2]
        return np.append(self.t[period] + elapsed, self.t[-1]), np.concatenate([points, end])

    def directions(self, times: Array, still: float) -> Array:
        """Return the unit velocities (F, N, 2) at `times` (F,) [s], zero for robots no faster than `still` [m/s]."""
        v = self.commands[np.searchsorted(self.t, times, side="right") - 1, :, 0]
        sign = np.where(np.abs(v) > still, np.sign(v), 0.0)
        heading = self.at(times)[..., 2]
        return np.stack([sign * np.cos(heading), sign * np.sin(heading)], axis=-1)

    def digest(self) -> str:
        """Return the SHA-256 of times, poses and commands: of the motion, however it is drawn."""
        sha = hashlib.sha256()
        for array in (self.t, self.poses, self.commands):
            sha.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
        return sha.hexdigest()
