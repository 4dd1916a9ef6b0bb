"""Inputs of figures: each scene is read, and each run simulated, once for all figures."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from emovid.scene.load import Setting, load_scene, scene_text, shipped_scene
from emovid.scene.model import Scene
from emovid.scene.resources import read_text
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory

Tables = Mapping[str, Callable[["Material"], Any]]


class Material:
    """Runs of the shipped scenes, and tables from other rooms, made on first use and cached.

    Args:
        settings: keys to replace in every scene.
        tables: functions that make the tables, by name: ``study`` gives the results of a study.
    """

    def __init__(self, settings: Sequence[Setting] = (), tables: Tables = MappingProxyType({})) -> None:
        self._settings, self._makers = settings, tables
        self._scenes: dict[str, Scene] = {}
        self._runs: dict[str, Trajectory] = {}
        self._tables: dict[str, Any] = {}

    def scene(self, emotion: str) -> Scene:
        """Return the shipped scene of an emotion."""
        if emotion not in self._scenes:
            self._scenes[emotion] = load_scene(emotion, self._settings)
        return self._scenes[emotion]

    def text(self, emotion: str) -> str:
        """Return that scene as YAML: the shipped file, or all keys if some are replaced."""
        return scene_text(self.scene(emotion)) if self._settings else read_text(shipped_scene(emotion))

    def run(self, emotion: str) -> Trajectory:
        """Return the run of that scene."""
        if emotion not in self._runs:
            self._runs[emotion] = simulate(self.scene(emotion))
        return self._runs[emotion]

    def table(self, name: str) -> Any:
        """Return a table of another room."""
        if name not in self._tables:
            self._tables[name] = self._makers[name](self)
        return self._tables[name]
