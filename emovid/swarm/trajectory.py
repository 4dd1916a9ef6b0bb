"""The motion of a run: poses at the ends of control periods and, between them, exact arcs.

Motion that was recorded elsewhere, of a testbed or a tracker, has positions at samples, and straight lines between.
"""

import hashlib
from dataclasses import dataclass

import numpy as np

from emovid.errors import InputError
from emovid.scene.behaviour import Recorded
from emovid.scene.emotions import EmotionName
from emovid.scene.model import Scene
from emovid.scene.robots import Body, Robot
from emovid.scene.stage import InStage, Stage
from emovid.scene.video import Video
from emovid.swarm.arrays import Array, Mask
from emovid.swarm.unicycle import move, wrapped


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

    def __repr__(self) -> str:
        robots, samples = self.poses.shape[1], len(self.t)
        return f"Trajectory({self.scene.emotion or 'scene'}, {robots} robots, {samples} samples, {self.t[-1]:g} s)"

    def at(self, times: Array) -> Array:
        """Return the poses (F, N, 3) at `times` (F,) [s] within the run.

        Raises:
            ValueError: for a time outside the run.
        """
        times = self._within(times)
        period = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.commands) - 1)
        elapsed = (times - self.t[period])[:, None]
        return move(self.poses[period], self.commands[period], elapsed)

    def _within(self, times: Array) -> Array:
        times = np.asarray(times, dtype=float)
        if times.size and not (self.t[0] <= times.min() and times.max() <= self.t[-1] + 1e-9):
            raise ValueError(f"times from {times.min():g} to {times.max():g} s: the run is 0 to {self.t[-1]:g} s")
        return times

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

    @staticmethod
    def from_poses(
        t: Array,
        poses: Array,
        *,
        body: Body,
        stage: Stage,
        emotion: EmotionName | None = None,
        video: Video | None = None,
        snapshots: tuple[float, ...] | None = None,
    ) -> "RecordedTrajectory":
        """Return a recorded motion as a trajectory that can be measured and rendered.

        Args:
            t: sample times (T,) [s], rising; the first becomes 0.
            poses: (T, N, 3) = x [m], y [m], heading [rad]; or (T, N, 2): robots then face where they move.
            body: of the robots, or whatever was recorded: its width sets the visible step of measures.
            stage: with the origin of coordinates.
            emotion: that it expresses, if any.
            video: appearance; by default that of scenes.
            snapshots: times [s] of its figure; measures end at the last.

        Raises:
            InputError: for fewer than two samples, times that do not rise, other shapes or infinite numbers.
            ValidationError: for a stage and body that do not fit.
        """
        t, poses = np.asarray(t, dtype=float), np.asarray(poses, dtype=float)
        if t.ndim != 1 or len(t) < 2 or poses.ndim != 3 or len(poses) != len(t) or poses.shape[2] not in (2, 3):
            raise InputError(
                f"poses {poses.shape} at times {t.shape}: expected (T, N, 3) or (T, N, 2) at (T,), T at least 2"
            )
        if not (np.isfinite(t).all() and np.isfinite(poses).all()):
            raise InputError("poses and times: expected finite numbers")
        if (np.diff(t) <= 0).any():
            raise InputError(f"times: expected rising ones; sample {int(np.argmax(np.diff(t) <= 0)) + 1} is not later")
        scene = Scene(
            emotion=emotion,
            behaviour=Recorded(law="recorded"),
            robot=Robot(model=body, K=1.0, l=body.width if body.steers else None),
            robots=poses.shape[1],
            stage=stage,
            start=InStage(place="stage"),
            control_period=float(min(np.diff(t).min(), 60.0)),
            duration=float(t[-1] - t[0]),
            seed=0,
            snapshots=snapshots,
            video=video or Video(),
        )
        return recorded(scene, t - t[0], poses)

    def digest(self) -> str:
        """Return the SHA-256 of times, poses and commands: of the motion, however it is drawn."""
        sha = hashlib.sha256()
        for array in (self.t, self.poses, self.commands):
            sha.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
        return sha.hexdigest()


@dataclass(frozen=True, eq=False)
class RecordedTrajectory(Trajectory):
    """A recorded motion. Its `commands` are speeds and turning rates between samples, not commands of a robot."""

    def at(self, times: Array) -> Array:
        """Return the poses (F, N, 3) at `times` (F,) [s], on straight lines between samples.

        Raises:
            ValueError: for a time outside the recording.
        """
        times = self._within(times)
        period = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 2)
        share = ((times - self.t[period]) / (self.t[period + 1] - self.t[period]))[:, None, None]
        step = self.poses[period + 1] - self.poses[period]
        step[..., 2] = wrapped(step[..., 2])
        poses = self.poses[period] + share * step
        poses[..., 2] = wrapped(poses[..., 2])
        return poses

    def trace(self, robot: int, tolerance: float) -> tuple[Array, Array]:  # noqa: ARG002 - straight lines are exact
        """Return times (T,) [s] and points (T, 2) [m] of one robot's path, which is straight between them."""
        return self.t, self.poses[:, robot, :2]

    def directions(self, times: Array, still: float) -> Array:
        """Return the unit velocities (F, N, 2) at `times` (F,) [s], zero for robots no faster than `still` [m/s]."""
        period = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 2)
        step = self.poses[period + 1, :, :2] - self.poses[period, :, :2]
        length = np.hypot(step[..., 0], step[..., 1])[..., None]
        moves = length > still * (self.t[period + 1] - self.t[period])[:, None, None]
        return np.where(moves, step / np.where(moves, length, 1.0), 0.0)


def recorded(scene: Scene, t: Array, poses: Array) -> RecordedTrajectory:
    """Return the trajectory of a recorded scene from its times (T,) [s] and poses (T, N, 3) or positions (T, N, 2)."""
    step = np.diff(poses[..., :2], axis=0)
    speed = np.hypot(step[..., 0], step[..., 1]) / np.diff(t)[:, None]
    heading = poses[..., 2] if poses.shape[2] == 3 else _courses(step)
    turning = wrapped(np.diff(heading, axis=0)) / np.diff(t)[:, None]
    poses = np.concatenate([poses[..., :2], wrapped(heading)[..., None]], axis=2)
    uncut = np.zeros(speed.shape, dtype=bool)
    return RecordedTrajectory(scene, t, poses, np.stack([speed, turning], axis=-1), uncut, uncut)


def sampled(trajectory: Trajectory, t: Array) -> RecordedTrajectory:
    """Return what a recording at the times `t` (T,) [s] would have kept of a run, as far as that goes."""
    t = t[t <= trajectory.t[-1] + 1e-9]
    scene = trajectory.scene.model_copy(
        update={"behaviour": Recorded(law="recorded"), "start": InStage(place="stage"), "duration": float(t[-1])}
    )
    return recorded(scene, t, trajectory.at(t))


def _courses(step: Array) -> Array:
    """Return headings (T, N) [rad] along the steps (T-1, N, 2); a robot that stands still keeps its last one."""
    course = np.arctan2(step[..., 1], step[..., 0])
    moves = step.any(axis=-1)
    last = np.maximum.accumulate(np.where(moves, np.arange(len(step))[:, None], 0), axis=0)
    heading = np.take_along_axis(course, last, axis=0)
    return np.concatenate([heading, heading[-1:]])
