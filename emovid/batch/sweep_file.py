"""The sweep file, sweep.yaml: scenes, the keys to replace in them, and seeds."""

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass, field
from itertools import chain, combinations
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import BeforeValidator, Field, ValidationError
from pydantic_core import PydanticCustomError

from emovid.atomic_io import file_digest
from emovid.batch.job import Kind
from emovid.batch.manifest import Plan
from emovid.errors import SourceError, nearest
from emovid.scene.load import Setting, read_robot, scene_keys, shipped_names
from emovid.scene.picture import read_pictures
from emovid.scene.resources import CONFIGS, read_text
from emovid.yaml_models import Keys, source_error
from emovid.yaml_source import KeyPath, Places, place_of, read_yaml

_MAX_VALUES = 100_000
_Model = TypeVar("_Model", bound=Keys)


# --- keys of the file -------------------------------------------------------------------------------------------------


def _expect(words: str, test: Callable[[Any], bool], null: Any = ...) -> BeforeValidator:
    """Return a validator that refuses values that fail a test; `words` say what is expected, `null` replaces null."""

    def check(given: Any) -> Any:
        if given is None and null is not ...:
            return null
        if not test(given):
            raise PydanticCustomError("sweep", "{words}", {"words": words})
        return given

    return BeforeValidator(check)


def _is_group(given: Any) -> bool:
    return isinstance(given, dict)


def _is_list(given: Any) -> bool:
    return isinstance(given, list)


def _is_count(given: Any) -> bool:
    return isinstance(given, int) and not isinstance(given, bool) and 1 <= given <= _MAX_VALUES


_KEYS = _expect("keys of a scene and their values, as in robot.l: 0.002", _is_group)
_NO_KEYS = _expect("keys of a scene and their values, as in robot.l: 0.002", _is_group, {})
_LIST = _expect("a list of groups of keys, as in - {robot.l: 0.002, robot.K: 6}", _is_list, [])
_GRID = _expect("keys of a scene, each with a list of values, as in robot.l: [0.002, 0.004]", _is_group, {})
_VALUES = _expect(
    "a list of values, or {from: 0.001, to: 0.01, count: 10}",
    lambda given: given != [] and isinstance(given, list | dict),
)
_SEEDS = _expect("a list of seeds, or how many, from 1 on", lambda given: _is_list(given) or _is_count(given), [])
_SCENE = _expect("an emotion or a scene file", lambda given: isinstance(given, str))
_SCENES = _expect("a list of emotions and scene files", lambda given: given != [] and _is_list(given))
_SCENES_BY_NAME = _expect("names of scenes and their keys", lambda given: given != {})

Group = Annotated[dict[str, Any], _KEYS]
Groups = Annotated[list[Group], _LIST]


class SweepKeys(Keys):
    """The keys of a sweep file, without its scenes."""

    only: Kind = Field("video", description="kind of the results")
    file: str | None = Field(None, description="in a plan: the sweep file, from the folder of the plan")
    set: Annotated[dict[str, Any], _NO_KEYS] = Field({}, description="keys of all items")
    list: Groups = Field([], description="groups of keys that change together")
    grid: Annotated[dict[str, Annotated[Any, _VALUES]], _GRID] = Field({}, description="keys to cross")
    seeds: Annotated[Any, _SEEDS] = Field([], description="seeds, or how many")


class SweepOfFiles(SweepKeys):
    """A sweep file that names emotions and scene files."""

    scenes: Annotated[list[Annotated[str, _SCENE]], _SCENES] = Field(description="a list of emotions and scene files")


class SweepOfScenes(SweepKeys):
    """A sweep file that contains its scenes, as plans do."""

    scenes: Annotated[dict[str, Group], _SCENES_BY_NAME] = Field(description="scenes by name")


class Range(Keys):
    """Evenly spaced values of a key; with `log`, their logarithms are evenly spaced."""

    first: float = Field(alias="from", description="first value", ge=-1e9, le=1e9)
    last: float = Field(alias="to", description="last value", ge=-1e9, le=1e9)
    count: int = Field(ge=1, le=_MAX_VALUES, description="number of values")
    log: bool = Field(False, description="whether the logarithms are evenly spaced")


# --- sweeps -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Template:
    """A scene before keys are replaced: plain values, their places, and the folder of the files that they name."""

    keys: dict[str, Any]
    places: Places
    folder: Path

    def whole(self) -> dict[str, Any]:
        """Return the keys, with the contents of the files that they name."""
        keys: dict[str, Any] = deepcopy(self.keys)
        read_pictures(keys, self.folder, self.places)
        robot = keys.get("robot")
        if isinstance(robot, dict) and isinstance(robot.get("model"), str):
            named = {"robot": {"model": robot["model"]}}  # without its limits, which may belong to another model
            read_robot(named, self.folder, self.places)
            robot["model"] = named["robot"]["model"].model_dump(mode="json")
        return keys


@dataclass(frozen=True)
class Sweep:
    """A sweep; each setting knows its place in the file.

    Attributes:
        where: the file that was read, for messages.
        file: the sweep file; of a plan, the one that the plan was made from.
        only: kind of the results.
        scenes: by the name that tables show.
        set: settings of all items.
        list: groups of settings that change together.
        grid: for each key, the settings to cross.
        seeds: settings to cross; empty if each scene keeps its own seed.
    """

    where: str
    file: Path
    only: Kind
    scenes: dict[str, Template]
    set: tuple[Setting, ...] = ()
    list: tuple[tuple[Setting, ...], ...] = ()
    grid: dict[str, tuple[Setting, ...]] = field(default_factory=dict)
    seeds: tuple[Setting, ...] = ()

    def plan(self, folder: Path) -> Plan:
        """Return the plan of the sweep in a folder: JSON that `read_sweep` reads, and the path of the sweep file."""
        values = self.plan_values()
        digest = hashlib.sha256(json.dumps(values).encode()).hexdigest()
        file = os.path.relpath(self.file, folder.resolve())
        return Plan(json.dumps({"file": file} | values, indent=1, ensure_ascii=False) + "\n", digest)

    def plan_values(self) -> dict[str, Any]:
        """Return the sweep as plain values.

        They contain the pictures and robots that its scenes name, and absolute paths of those in settings.
        """
        plan = {
            "only": self.only,
            "scenes": {name: template.whole() for name, template in self.scenes.items()},
            "set": self._values(self.set),
            "list": [self._values(group) for group in self.list],
            "grid": {key: [self._located(key, s.value) for s in settings] for key, settings in self.grid.items()},
            "seeds": [setting.value for setting in self.seeds],
        }
        return {key: value for key, value in plan.items() if value}

    def file_digests(self) -> tuple[str, ...]:
        """Return the digests of the files that settings name."""
        settings = [*self.set, *chain(*self.list), *chain(*self.grid.values())]
        files = {file for s in settings for file in self._files(s.key, s.value)}
        return tuple(sorted(file_digest(file) for file in files))

    def _values(self, settings: tuple[Setting, ...]) -> dict[str, Any]:
        return {setting.key: self._located(setting.key, setting.value) for setting in settings}

    def _located(self, key: str, value: Any) -> Any:
        """Return a value with absolute paths of the files in it, which are relative to the scenes' folders."""
        if isinstance(value, dict):
            return {inner: self._located(inner, part) for inner, part in value.items()}
        return next((str(file) for file in self._files(key, value)), value)

    def _files(self, key: str, value: Any) -> Iterator[Path]:
        """Yield the absolute paths of the files that a value names."""
        if isinstance(value, dict):
            for inner, part in value.items():
                yield from self._files(inner, part)
        elif isinstance(value, str) and key.rpartition(".")[2] in ("file", "model"):
            files = (template.folder / value for template in self.scenes.values())
            yield from (file.resolve() for file in files if file.is_file())


# --- reading ----------------------------------------------------------------------------------------------------------


def find_sweep(source: Path) -> Path:
    """Return a sweep file: this path, or, if it does not exist, the shipped sweep of that name."""
    shipped = CONFIGS / "sweeps" / f"{source}.yaml"
    return shipped if not source.exists() and shipped.is_file() else source


def read_sweep(path: Path, only: str | None = None) -> Sweep:
    """Return the sweep of a sweep.yaml or a plan.json.

    Args:
        path: of the file.
        only: kind of the results, in place of the file's.

    Raises:
        SourceError: for an invalid file, with line and key.
    """
    values, places = _read(path)
    if not isinstance(values, dict):
        raise SourceError(str(path), "not a sweep: expected some of scenes, only, set, list, grid, seeds")
    if only is not None:
        values, places = values | {"only": only}, {**places, ("only",): "--only"}
    reader = _Reader(path, places)
    if isinstance(values.get("scenes"), dict):
        return reader.sweep(_validated(SweepOfScenes, values, places))
    return reader.sweep(_validated(SweepOfFiles, values, places))


def _read(path: Path) -> tuple[Any, Places]:
    text = read_text(path, "sweep")
    try:
        if path.suffix == ".json":
            return json.loads(text), {(): str(path)}
    except (ValueError, RecursionError):
        raise SourceError(str(path), "not JSON: expected a plan that emovid sweep wrote") from None
    return read_yaml(text, str(path), "sweep")


def _validated(model: type[_Model], values: Any, places: Places) -> _Model:
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise source_error(error, places, model) from None


@dataclass(frozen=True)
class _Reader:
    """Turns the keys of a file into a sweep, with the place of each setting."""

    path: Path
    places: Places

    def sweep(self, keys: SweepOfFiles | SweepOfScenes) -> Sweep:
        seeds = range(1, keys.seeds + 1) if isinstance(keys.seeds, int) else keys.seeds
        sweep = Sweep(
            str(self.path),
            (self.path.parent / keys.file if keys.file else self.path).resolve(),
            keys.only,
            self._scenes(keys.scenes),
            self._settings(("set",), keys.set),
            tuple(self._settings(("list", i), group) for i, group in enumerate(keys.list)),
            {key: self._values(key, values) for key, values in keys.grid.items()},
            tuple(Setting("seed", seed, self._place(("seeds", i))) for i, seed in enumerate(seeds)),
        )
        self._refuse_double_keys(sweep)
        return sweep

    def _scenes(self, given: list[str] | dict[str, Any]) -> dict[str, Template]:
        if isinstance(given, dict):
            for name in given:
                if "/" in name:
                    raise self._error(("scenes", name), "expected a name without /")
            return {
                name: Template(keys, self._inside("scenes", name), self.path.parent) for name, keys in given.items()
            }
        scenes: dict[str, Template] = {}
        for i, source in enumerate(given):
            try:
                keys, places, file = scene_keys(source if source in shipped_names() else self.path.parent / source)
            except SourceError as error:
                if error.message.startswith("no such file"):  # with a hint for the given name, not for the whole path
                    raise self._error(
                        ("scenes", i), f"{source}: no such file or emotion{nearest(source, shipped_names())}"
                    ) from None
                raise
            if file.stem in scenes:
                raise self._error(("scenes", i), f"{source}: there is another scene called {file.stem}")
            scenes[file.stem] = Template(keys, places, file.parent)
        return scenes

    def _settings(self, path: KeyPath, given: dict[str, Any]) -> tuple[Setting, ...]:
        return tuple(Setting(key, value, self._place((*path, key))) for key, value in given.items())

    def _values(self, key: str, given: Any) -> tuple[Setting, ...]:
        """Return a setting for each value of a key of the grid."""
        path = ("grid", key)
        if isinstance(given, list):
            return tuple(Setting(key, value, self._place((*path, i))) for i, value in enumerate(given))
        try:
            spaced = _validated(Range, given, self._inside(*path))
        except SourceError as error:
            raise SourceError(error.where, error.message, key=".".join((*path, error.key))) from None
        if spaced.log and min(spaced.first, spaced.last) <= 0:
            raise self._error(path, "log: expected from and to above 0")
        numbers = (np.geomspace if spaced.log else np.linspace)(spaced.first, spaced.last, spaced.count)
        values = [float(f"{number:.12g}") for number in numbers]
        if isinstance(given["from"], int) and isinstance(given["to"], int):  # keys such as `robots` need 5, not 5.0
            values = [int(value) if value.is_integer() else value for value in values]
        return tuple(Setting(key, value, self._place(path)) for value in values)

    def _refuse_double_keys(self, sweep: Sweep) -> None:
        """Refuse a key that is set in two ways: one of them would be lost."""
        ways = {"grid": set(sweep.grid), "list": {s.key for group in sweep.list for s in group}}
        ways |= {way: {s.key for s in settings} for way, settings in (("seeds", sweep.seeds), ("set", sweep.set))}
        for (way, keys), (other, others) in combinations(ways.items(), 2):
            if both := sorted(keys & others):
                raise self._error((way, both[0]), f"given in {other} too")

    def _inside(self, *path: str | int) -> Places:
        """Return the places of the keys inside a group."""
        size = len(path)
        inside = {known[size:]: place for known, place in self.places.items() if known[:size] == path}
        return inside or {(): self._place(path)}

    def _place(self, path: KeyPath) -> str:
        return place_of(path, self.places)

    def _error(self, path: KeyPath, message: str) -> SourceError:
        return SourceError(self._place(path), message, key=".".join(map(str, path)))
