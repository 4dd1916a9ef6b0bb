"""sweep.yaml: which scenes, with which keys replaced by what, and from which seeds."""

import json
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn, get_args

import numpy as np

from emovid.batch.job import Kind
from emovid.errors import SourceError, nearest
from emovid.scene.load import Setting, read_robot, scene_keys, shipped_names
from emovid.scene.picture import read_pictures
from emovid.scene.resources import CONFIGS, read_text
from emovid.yaml_source import KeyPath, Places, place_of, read_yaml

KEYS = ("only", "scenes", "set", "list", "grid", "seeds")
_RANGE = ("from", "to", "count", "log")
_MAX_VALUES = 100_000


@dataclass(frozen=True)
class Template:
    """A scene before its keys are replaced: plain values, their places, and the folder its pictures are found from."""

    keys: dict[str, Any]
    places: Places
    folder: Path

    def whole(self) -> dict[str, Any]:
        """Return the keys with what is in the files that they name."""
        keys: dict[str, Any] = deepcopy(self.keys)
        read_pictures(keys, self.folder, self.places)
        robot = keys.get("robot")
        if isinstance(robot, dict) and isinstance(robot.get("model"), str):
            named = {"robot": {"model": robot["model"]}}  # its limits may be those of another that is set
            read_robot(named, self.folder, self.places)
            robot["model"] = named["robot"]["model"].model_dump(mode="json")
        return keys


@dataclass(frozen=True)
class SweepFile:
    """What a sweep.yaml says, every value with the place it stands at.

    Attributes:
        where: the file.
        only: what is made of each item.
        scenes: by the name that tables show.
        set: settings of all items.
        list: settings that go together.
        grid: the settings of each key, to be crossed.
        seeds: likewise; none where each scene has its own.
    """

    where: str
    only: Kind
    scenes: dict[str, Template]
    set: tuple[Setting, ...] = ()
    list: tuple[tuple[Setting, ...], ...] = ()
    grid: dict[str, tuple[Setting, ...]] = field(default_factory=dict)
    seeds: tuple[Setting, ...] = ()

    def plan(self) -> str:
        """Return the same sweep as JSON, as good as this one to `read_sweep_file`.

        It holds the pictures and robots that its scenes name; of those that are set it gives the whole path.
        """
        plan = {
            "only": self.only,
            "scenes": {name: template.whole() for name, template in self.scenes.items()},
            "set": self._values(self.set),
            "list": [self._values(entry) for entry in self.list],
            "grid": {key: [self._located(key, s.value) for s in settings] for key, settings in self.grid.items()},
            "seeds": [setting.value for setting in self.seeds],
        }
        kept = {key: value for key, value in plan.items() if value}
        return json.dumps(kept, indent=1, ensure_ascii=False) + "\n"

    def _values(self, settings: tuple[Setting, ...]) -> dict[str, Any]:
        return {setting.key: self._located(setting.key, setting.value) for setting in settings}

    def _located(self, key: str, value: Any) -> Any:
        """Return a value with the whole path of each file that it names: scenes find them beside them, a plan not."""
        if isinstance(value, dict):
            return {inner: self._located(inner, part) for inner, part in value.items()}
        if not isinstance(value, str) or key.rpartition(".")[2] not in ("file", "model"):
            return value
        files = (template.folder / value for template in self.scenes.values())
        return next((str(file.resolve()) for file in files if file.is_file()), value)


def find_sweep(source: Path) -> Path:
    """Return the file that is meant: this one, or, where there is none, the shipped one of that name."""
    shipped = CONFIGS / "sweeps" / f"{source}.yaml"
    return shipped if not source.exists() and shipped.is_file() else source


def read_sweep_file(path: Path, only: str | None = None) -> SweepFile:
    """Return what a sweep.yaml says, or the JSON of `SweepFile.plan`.

    Args:
        path: of the file.
        only: what is made of each item, whatever the file says.

    Raises:
        SourceError: for what cannot be meant, with file, line and key.
    """
    keys, places = _read(path)
    if only is not None and isinstance(keys, dict):
        keys, places = keys | {"only": only}, {**places, ("only",): "--only"}
    return _Reader(path, keys, places).sweep()


def _read(path: Path) -> tuple[Any, Places]:
    text = read_text(path, "sweep")
    try:
        if path.suffix == ".json":
            return json.loads(text), {(): str(path)}
    except (ValueError, RecursionError):
        raise SourceError(str(path), "not JSON: expected a plan that emovid sweep wrote") from None
    return read_yaml(text, str(path), "sweep")


@dataclass(frozen=True)
class _Reader:
    path: Path
    keys: Any
    places: Places

    def sweep(self) -> SweepFile:
        if not isinstance(self.keys, dict):
            raise SourceError(str(self.path), f"not a sweep: expected some of {', '.join(KEYS)}")
        for key in self.keys:
            if key not in KEYS:
                self._refuse((key,), _unknown(key, KEYS))
        only = self.keys.get("only", "video")
        if only not in get_args(Kind):
            self._refuse(("only",), f"{only!r}: expected one of {', '.join(get_args(Kind))}")
        sweep = SweepFile(
            str(self.path),
            only,
            self._scenes(),
            self._settings(("set",), self.keys.get("set") or {}),
            self._list(),
            self._grid(),
            self._seeds(),
        )
        self._refuse_twice(sweep)
        return sweep

    def _scenes(self) -> dict[str, Template]:
        given = self.keys.get("scenes")
        if isinstance(given, dict) and given:
            return {name: self._inline(name, keys) for name, keys in given.items()}
        if not isinstance(given, list) or not given:
            self._refuse(("scenes",), "expected a list of emotions and scene files")
        scenes: dict[str, Template] = {}
        for i, source in enumerate(given):
            path: KeyPath = ("scenes", i)
            if not isinstance(source, str):
                self._refuse(path, f"{source!r}: expected an emotion or a scene file")
            try:
                keys, places, file = scene_keys(source if source in shipped_names() else self.path.parent / source)
            except SourceError as error:
                if error.message.startswith("no such file"):  # what it suggests instead is like the whole path
                    self._refuse(path, f"{source}: no such file or emotion{nearest(source, shipped_names())}")
                raise
            if file.stem in scenes:
                self._refuse(path, f"{source}: there is another scene called {file.stem}")
            scenes[file.stem] = Template(keys, places, file.parent)
        return scenes

    def _inline(self, name: str, keys: Any) -> Template:
        if not isinstance(keys, dict) or "/" in name:
            self._refuse(("scenes", name), "expected a name and the keys of a scene")
        places = {path[2:]: place for path, place in self.places.items() if path[:2] == ("scenes", name)}
        return Template(keys, places or self.places, self.path.parent)

    def _list(self) -> tuple[tuple[Setting, ...], ...]:
        given = self.keys.get("list") or []
        if not isinstance(given, list):
            self._refuse(("list",), "expected a list of groups of keys, as in - {robot.l: 0.002, robot.K: 6}")
        return tuple(self._settings(("list", i), entry) for i, entry in enumerate(given))

    def _settings(self, path: KeyPath, given: Any) -> tuple[Setting, ...]:
        if not isinstance(given, dict):
            self._refuse(path, "expected keys of a scene and their values, as in robot.l: 0.002")
        return tuple(Setting(key, value, self._place((*path, key))) for key, value in given.items())

    def _grid(self) -> dict[str, tuple[Setting, ...]]:
        given = self.keys.get("grid") or {}
        if not isinstance(given, dict):
            expected = "expected keys of a scene, each with a list of values, as in robot.l: [0.002, 0.004]"
            self._refuse(("grid",), expected)
        return {key: self._settings_of(key, values) for key, values in given.items()}

    def _settings_of(self, key: str, given: Any) -> tuple[Setting, ...]:
        """Return a setting for each value that a key of the grid takes."""
        path: KeyPath = ("grid", key)
        if isinstance(given, dict):
            return tuple(Setting(key, value, self._place(path)) for value in self._range(path, given))
        if not isinstance(given, list) or not given:
            self._refuse(path, "expected a list of values, or {from: 0.001, to: 0.01, count: 10}")
        return tuple(Setting(key, value, self._place((*path, i))) for i, value in enumerate(given))

    def _range(self, path: KeyPath, given: dict[str, Any]) -> list[float]:
        """Return evenly spaced numbers, or, with log, of evenly spaced logarithms; to 12 digits.

        Where both ends are whole numbers, so are those between that can be, as keys like `robots` need them.
        """
        for key in given:
            if key not in _RANGE:
                self._refuse((*path, key), _unknown(key, _RANGE))
        first, last, count, log = (given.get(key, False) for key in _RANGE)
        if not (self._is_number(first) and self._is_number(last) and self._is_count(count)):
            self._refuse(path, "expected numbers from and to, and a count of at least 1")
        if not isinstance(log, bool) or (log and min(first, last) <= 0):
            self._refuse(path, "log: expected true, with from and to above 0")
        spaced = np.geomspace(first, last, count) if log else np.linspace(first, last, count)
        values = [float(f"{value:.12g}") for value in spaced]
        whole = isinstance(first, int) and isinstance(last, int)
        return [int(value) if whole and value.is_integer() else value for value in values]

    def _seeds(self) -> tuple[Setting, ...]:
        given = self.keys.get("seeds")
        if given is None or given == []:
            return ()
        if self._is_count(given):
            given = list(range(1, given + 1))
        if not isinstance(given, list):
            self._refuse(("seeds",), "expected a list of seeds, or how many, from 1 on")
        return tuple(Setting("seed", seed, self._place(("seeds", i))) for i, seed in enumerate(given))

    def _refuse_twice(self, sweep: SweepFile) -> None:
        """Refuse a key that is set in two ways, of which one would be lost."""
        ways = {"set": sweep.set, "list": [s for entry in sweep.list for s in entry], "seeds": sweep.seeds}
        keys = {way: {setting.key for setting in settings} for way, settings in ways.items()}
        keys["grid"] = set(sweep.grid)
        for way, own in keys.items():
            for other, others in keys.items():
                if way < other and (both := sorted(own & others)):
                    self._refuse((way, both[0]), f"given in {other} too")

    @staticmethod
    def _is_number(value: Any) -> bool:
        return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9

    @staticmethod
    def _is_count(value: Any) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= _MAX_VALUES

    def _place(self, path: KeyPath) -> str:
        return place_of(path, self.places)

    def _refuse(self, path: KeyPath, message: str) -> NoReturn:
        raise SourceError(self._place(path), message, key=".".join(map(str, path)))


def _unknown(key: str, known: Sequence[str]) -> str:
    return f"unknown key{nearest(key, known)}" if nearest(key, known) else f"unknown key; expected {', '.join(known)}"
