"""The part of a run that is measured, its stage, and the descriptors of quantities that change with time.

Nothing depends on the video. The smallest detail that counts scales with the robot's body: a scene that is three times
as large, robots included, has the same corners.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import pdist

from emovid.errors import InputError
from emovid.scene.behaviour import Recorded
from emovid.swarm.arrays import Array, Mask
from emovid.swarm.laws import corners_of
from emovid.swarm.trajectory import Trajectory

# A visible step as a share of the body's width: 5 mm for the 30 mm of a GRITSBot, which is about the width of a trail
# (4 mm) and five pixels of a shipped video. Half and twice this value separate smooth and angular scenes as clearly.
_STEP = 1 / 6

_STILL = 60.0  # s; a robot that needs longer for a visible step is stationary
_INTERVAL = 0.1  # s; between samples of the whole swarm
_MAX_SAMPLES = 300


class Descriptor(NamedTuple):
    """One row of docs/descriptors.md.

    Attributes:
        name: key of the value, in snake_case.
        unit: an SI unit, "diagonals" of the stage, "share" of a whole, or "1" for a number without a unit.
        definition: in words; over all robots and the window unless it says otherwise.
        source: who defined it; "" for a plain mean or count.
    """

    name: str
    unit: str
    definition: str
    source: str = ""


WINDOW = (Descriptor("window", "s", "length of the part of the run that is measured"),)


@dataclass(frozen=True)
class Window:
    """The part of a run from `start` to `end` [s].

    Raises:
        InputError: if it is empty or not within the run.
    """

    trajectory: Trajectory
    start: float
    end: float

    def __post_init__(self) -> None:
        first, last = self.trajectory.t[[0, -1]]
        if not first <= self.start < self.end <= last + 1e-9:
            message = f"expected a start before its end, both within the run of {first:g} to {last:g} s"
            raise InputError(f"the window from {self.start:g} to {self.end:g} s: {message}")

    @property
    def length(self) -> float:
        """From start to end [s]."""
        return self.end - self.start

    @property
    def seconds(self) -> Array:
        """Time of each control period that lies in the window, (T-1,) [s]."""
        return np.diff(np.clip(self.trajectory.t, self.start, self.end))

    @property
    def step(self) -> float:
        """The visible step [m]: smaller detail of a trace does not count."""
        return self.trajectory.scene.robot.body.width * _STEP

    @property
    def still(self) -> float:
        """Speed [m/s] below which a robot is stationary: one visible step per minute."""
        return self.step / _STILL

    @property
    def is_recorded(self) -> bool:
        """True if the motion was recorded elsewhere, so that commands and density are missing."""
        return isinstance(self.trajectory.scene.behaviour, Recorded)

    @cached_property
    def stage(self) -> "StageGeometry":
        """Measures of the stage."""
        corners = corners_of(self.trajectory.scene.stage)
        following = np.roll(corners, -1, axis=0)
        doubled = corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1]  # of triangles with the origin
        centre = np.sum(doubled[:, None] * (corners + following), axis=0) / (3 * doubled.sum())
        return StageGeometry(float(doubled.sum() / 2), float(pdist(corners).max()), centre)

    def times(self) -> Array:
        """Return the even sample times (F,) [s] of the whole swarm from start to end, two or more."""
        samples = max(round(self.length / _INTERVAL), 1) + 1
        return np.linspace(self.start, self.end, min(samples, _MAX_SAMPLES))

    def points(self, times: Array) -> Array:
        """Return the positions of the robots at `times` (F,) [s], (F, N, 2) [m]."""
        return self.trajectory.at(times)[..., :2]


class StageGeometry(NamedTuple):
    """Area [m^2], diagonal (the largest distance of two corners) [m] and centroid (2,) [m] of a stage."""

    area: float
    diagonal: float
    centre: Array


def window_of(trajectory: Trajectory, start: float = 0.0, end: float | None = None) -> Window:
    """Return the window; without an `end`, up to the scene's last snapshot, else up to the end of the run [s].

    Raises:
        InputError: if it is empty or not within the run.
    """
    last = float(trajectory.t[-1])
    if end is None:
        times = trajectory.scene.snapshot_times
        end = min(times[-1], last) if times else last
    return Window(trajectory, start, end)


def series(name: str, unit: str, definition: str, source: str = "") -> tuple[Descriptor, ...]:
    """Return the four descriptors of a quantity that changes with time."""
    return (
        Descriptor(f"{name}_mean", unit, f"{definition}; mean over time", source),
        Descriptor(f"{name}_start", unit, f"{definition}, at the window's start", source),
        Descriptor(f"{name}_end", unit, f"{definition}, at its end", source),
        Descriptor(
            f"{name}_growth", "1/s", f"slope of the least-squares line through {name} in time, over its mean", source
        ),
    )


def series_values(name: str, times: Array, values: Array) -> dict[str, float]:
    """Return the values of the descriptors of `series`, from `values` (F,) at even `times` (F,) [s]."""
    mean = float(values.mean())
    since = times - times.mean()
    slope = float((since * values).sum() / (since * since).sum())
    return {
        f"{name}_mean": mean,
        f"{name}_start": float(values[0]),
        f"{name}_end": float(values[-1]),
        f"{name}_growth": slope / mean if mean != 0 else float("nan"),
    }


def mean_where(values: Array, defined: Mask) -> float:
    """Return the mean of the values that are defined, NaN if none is."""
    return float(values[defined].mean()) if defined.any() else float("nan")
