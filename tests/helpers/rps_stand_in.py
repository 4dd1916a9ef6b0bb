"""A stand-in for both Python simulators of the Robotarium, without a figure or real time.

From their behavior (github.com/robotarium/robotarium_python_simulator, 2024-10 for 1.x and 2026-04 for 2.x): the
order of calls is asserted, each wheel is limited separately, the step is an Euler step, and errors are counted first.
"""

import sys
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np

from emovid.scene.model import Scene
from emovid.swarm.trajectory import Trajectory

STEP, WHEEL_RADIUS, MAX_WHEEL = 0.033, 0.016, 12.5
HALF_WIDTH, HALF_HEIGHT = 1.6, 1.0
OFFSET, COLLISION = 0.025, 0.135


class _Line:
    def __init__(self, **look: Any) -> None:
        self.look, self.points = look, np.empty((2, 0))

    def set_data(self, x: Any, y: Any) -> None:
        self.points = np.array([x, y], dtype=float)


class _Axes:
    def __init__(self) -> None:
        self.lines: list[_Line] = []

    def plot(self, x: Any, y: Any, **look: Any) -> list[_Line]:
        line = _Line(**look)
        line.set_data(x, y)
        self.lines.append(line)
        return [line]


class StandIn:
    """The common part of both interfaces. `made` is the instance that a script created last."""

    made: "StandIn"
    files: dict[str, str]
    base: float

    def __init__(
        self, number_of_robots: int, show_figure: bool, initial_conditions: np.ndarray, sim_in_real_time: bool
    ):
        assert isinstance(number_of_robots, int)
        assert 0 < number_of_robots <= 50
        assert isinstance(show_figure, bool)
        assert isinstance(sim_in_real_time, bool)
        assert initial_conditions.shape == (3, number_of_robots)
        type(self).made = StandIn.made = self
        self.robots = number_of_robots
        self._state = initial_conditions
        self._velocity = np.zeros((2, number_of_robots))
        self._may_step, self._may_look, self.ended = False, True, False
        self.errors = {"boundary": 0, "collision": 0, "actuator": 0}
        self.seen: list[np.ndarray] = []
        self.done: list[np.ndarray] = []
        self.canvas = _Axes()

    def get_poses(self) -> np.ndarray:
        assert self._may_look, "get_poses() once per step()"
        self._may_look, self._may_step = False, True
        self.seen.append(self._state.copy())
        return self._look()

    def step(self) -> None:
        assert self._may_step, "get_poses() before step()"
        assert not self.ended
        self._may_look, self._may_step = True, False
        self._count_errors()
        wheels = np.clip(self._wheels(), -MAX_WHEEL, MAX_WHEEL)
        v = WHEEL_RADIUS / 2 * (wheels[0] + wheels[1])
        omega = WHEEL_RADIUS / self.base * (wheels[1] - wheels[0])
        x, y, heading = self._state
        self.done.append(np.array([v, omega]))
        turned = heading + STEP * omega
        self._state[:] = (
            x + STEP * v * np.cos(heading),
            y + STEP * v * np.sin(heading),
            np.arctan2(np.sin(turned), np.cos(turned)),
        )

    def run_of(self, scene: Scene) -> Trajectory:
        """Return the poses and commands of the last steps, as many as the scene has."""
        steps = round(scene.duration / STEP)
        assert len(self.seen) > steps
        poses = np.array([*self.seen[-steps:], self._state]).transpose(0, 2, 1)
        commands = np.array(self.done[-steps:]).transpose(0, 2, 1)
        nothing = np.zeros(commands.shape[:2], dtype=bool)
        return Trajectory(scene, STEP * np.arange(steps + 1), poses, commands, nothing, nothing)

    def _look(self) -> np.ndarray:
        raise NotImplementedError

    def _wheels(self) -> np.ndarray:
        v, omega = self._velocity
        return np.array([2 * v - self.base * omega, 2 * v + self.base * omega]) / (2 * WHEEL_RADIUS)

    def _count_errors(self) -> None:
        x, y, heading = self._state
        self.errors["boundary"] += int(np.any((np.abs(x) > HALF_WIDTH) | (np.abs(y) > HALF_HEIGHT)))
        points = np.array([x + OFFSET * np.cos(heading), y + OFFSET * np.sin(heading)])
        apart = np.hypot(*(points[:, :, None] - points[:, None]))
        self.errors["collision"] += int(np.sum(apart[np.triu_indices(self.robots, 1)] <= COLLISION))
        self.errors["actuator"] += int(np.any(np.abs(self._wheels()) > MAX_WHEEL))

    def _end(self) -> None:
        assert not self._may_step, "step() after the last get_poses()"
        self.ended = True


class Robotarium1(StandIn):
    """1.x: positional arguments too, and the array it works with handed out."""

    base = 0.105

    def __init__(
        self,
        number_of_robots: int = -1,
        show_figure: bool = True,
        sim_in_real_time: bool = True,
        initial_conditions: Any = (),
    ) -> None:
        super().__init__(number_of_robots, show_figure, initial_conditions, sim_in_real_time)
        self.axes, self.base_length = self.canvas, self.base

    def set_velocities(self, ids: np.ndarray, velocities: np.ndarray) -> None:
        assert np.array_equal(ids, np.arange(self.robots))
        self._velocity = velocities

    def call_at_scripts_end(self) -> None:
        self._end()

    def _look(self) -> np.ndarray:
        return self._state


class Robotarium2(StandIn):
    """2.x: keywords only, a copy handed out, other names."""

    base = 0.11

    def __init__(self, **kwargs: Any) -> None:
        keys = ("number_of_robots", "show_figure", "initial_conditions", "sim_in_real_time")
        super().__init__(*(kwargs[key] for key in keys))
        self._state = self._state.copy()
        self._axes_handle = self.canvas

    def set_velocities(self, ids: np.ndarray, velocities: np.ndarray) -> None:
        assert velocities.shape == (2, self.robots)
        self._velocity[:, ids] = velocities

    def debug(self) -> None:
        self._end()

    def _look(self) -> np.ndarray:
        return self._state.copy()


@contextmanager
def installed(interface: type[StandIn]) -> Iterator[None]:
    """Let `import rps.robotarium` find a module whose `Robotarium` is this interface."""
    names = {name: ModuleType(name) for name in ("rps", "rps.robotarium")}
    names["rps"].robotarium = names["rps.robotarium"]  # type: ignore[attr-defined]
    names["rps.robotarium"].Robotarium = interface  # type: ignore[attr-defined]
    sys.modules.update(names)
    try:
        yield
    finally:
        for name in names:
            del sys.modules[name]


def run(script: str, interface: type[StandIn], path: Path = Path("script.py")) -> tuple[StandIn, dict[str, Any]]:
    """Run a script with an interface in place of `rps`; return the stand-in, and what the script has defined.

    Files that it writes are read into `StandIn.made.files`.
    """
    names: dict[str, Any] = {"__name__": "__main__"}
    with installed(interface), TemporaryDirectory() as folder, chdir(folder):
        exec(compile(script, str(path), "exec"), names)  # noqa: S102 - our own
        StandIn.made.files = {file.name: file.read_text() for file in Path(folder).iterdir()}
    assert StandIn.made.ended
    return StandIn.made, names
