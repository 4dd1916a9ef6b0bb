"""What is measured: a part of a run, seen at stated scales of length and time.

Nothing here depends on the video. What an observer can tell apart goes with the robot's body, the one thing on the
stage whose size is known: a scene three times as large, robots and all, has the same corners.
"""

from dataclasses import dataclass

import numpy as np

from emovid.errors import InputError
from emovid.measure.descriptor import Descriptor
from emovid.swarm.arrays import Array
from emovid.swarm.trajectory import Trajectory

# A visible step, as a share of the body's width: 5 mm of a GRITSBot's 30 mm, about the 4 mm of a shipped trail and five
# pixels of a shipped video. Half and twice as much tell the smooth scenes from the angular ones as clearly.
_STEP = 1 / 6

_STILL = 60.0  # s; a robot that needs longer for a visible step stands still

WINDOW = (Descriptor("window", "s", "length of the part of the run that is measured"),)

_INTERVAL = 0.1  # s; between looks at the swarm as a whole
_MOST_LOOKS = 300


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
        """How much of each control period lies in the window, (T-1,) [s]."""
        t = np.clip(self.trajectory.t, self.start, self.end)
        return np.diff(t)

    @property
    def step(self) -> float:
        """The visible step [m]: detail of a trace that is smaller is not seen."""
        return self.trajectory.scene.robot.body.width * _STEP

    @property
    def still(self) -> float:
        """The speed [m/s] below which a robot stands still: a visible step a minute."""
        return self.step / _STILL

    def times(self) -> Array:
        """Return the even times (F,) [s] from start to end at which the swarm is looked at as a whole: two or more."""
        looks = max(round(self.length / _INTERVAL), 1) + 1
        return np.linspace(self.start, self.end, min(looks, _MOST_LOOKS))

    def points(self, times: Array) -> Array:
        """Return where the robots are, (F, N, 2) [m]."""
        return self.trajectory.at(times)[..., :2]


def window_of(trajectory: Trajectory, start: float = 0.0, end: float | None = None) -> Window:
    """Return the window; without an `end`, to the scene's last snapshot or else the end of its run [s].

    Raises:
        InputError: if it is empty or not within the run.
    """
    last = float(trajectory.t[-1])
    if end is None:
        times = trajectory.scene.snapshot_times
        end = min(times[-1], last) if times else last
    return Window(trajectory, start, end)
