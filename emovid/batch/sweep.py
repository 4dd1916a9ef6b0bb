"""The items of a sweep: every scene, with every group of the list, at every point of the grid, from every seed."""

import hashlib
import json
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import prod
from pathlib import Path
from typing import Any

from emovid.batch.job import Job, Record, SweepPoint
from emovid.batch.sweep_file import Sweep
from emovid.errors import InputError, SourceError
from emovid.scene.load import Setting, scene_digest, scene_of
from emovid.scene.model import Scene
from emovid.video.encoder import FORMATS

MAX_ITEMS = 100_000
Cells = Mapping[str, Any]


@dataclass(frozen=True)
class Item:
    """One point of a sweep.

    Attributes:
        number: from 1, in the order of the sweep.
        name: of its result: the scene's name and twelve digits of its content, which stay when the sweep grows.
        scene: resolved.
        point: the settings that lead to it.
    """

    number: int
    name: str
    scene: Scene
    point: SweepPoint


class Items:
    """The items of a sweep, made into scenes one by one: a shard pays for its own items.

    Args:
        sweep: to expand.

    Raises:
        SourceError: for too many items, or two equal levels of an axis.
    """

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        # The levels of each axis: scenes, groups of the list, keys of the grid, seeds. An unused axis has one level.
        self._levels: list[tuple[Any, ...]] = [
            tuple(sweep.scenes),
            sweep.list or ((),),
            *sweep.grid.values(),
            sweep.seeds or (None,),
        ]
        listed = [setting.key for group in sweep.list for setting in group]
        self.columns = list(dict.fromkeys(["scene", *listed, *sweep.grid, *(["seed"] if sweep.seeds else [])]))
        if len(self) > MAX_ITEMS:
            raise SourceError(sweep.where, f"{len(self)} items: at most {MAX_ITEMS}")
        for axis, keys in enumerate(self._keys):
            if len(keys) < len(self._levels[axis]):
                self._refuse_equal_levels(axis)

    def __len__(self) -> int:
        return prod(map(len, self._levels))

    def cells(self, number: int) -> Cells:
        """Return the scene's name and the settings of an item, by column; None in columns that it does not set."""
        name, settings = self._at(number)
        return dict.fromkeys(self.columns) | _cells(name, settings)

    def expand(self, numbers: Iterable[int]) -> Iterator[Item]:
        """Yield items, each a valid scene and none twice.

        Raises:
            SourceError: for the first invalid one, with the place of the key at fault.
        """
        first: dict[str, int] = {}
        for number in numbers:
            item = self.item(number)
            if (other := first.setdefault(item.name, number)) != number:
                raise self._equal(other, number)
            yield item

    def item(self, number: int) -> Item:
        """Return one item; raises as `expand`."""
        name, settings = self._at(number)
        template = self.sweep.scenes[name]
        scene = scene_of(template.keys, template.places, [*self.sweep.set, *settings], template.folder)
        suffix = {"video": FORMATS[scene.video.format].suffix, "trajectory": ".npz", "measure": ""}[self.sweep.only]
        result = f"{name}-{scene_digest(scene)[:12]}{suffix}"
        return Item(number, result, scene, SweepPoint(self._bases[name], _cells(name, settings)))

    def job(self, folder: Path, item: Item) -> Job:
        """Return the job that makes the result of an item."""
        return Job(item.scene, folder / item.name, only=self.sweep.only, point=item.point)

    def numbers_of(self, records: Mapping[str, Record]) -> dict[int, str]:
        """Return the names of the results in records that belong to this sweep, by the number of their item."""
        found = {}
        for name, record in records.items():
            if record.point and record.only == self.sweep.only and (number := self._number(record.point)):
                found[number] = name
        return dict(sorted(found.items()))

    @cached_property
    def _bases(self) -> dict[str, str]:
        """Digests, by scene, of everything that the items of a scene have in common.

        With its cells, the base identifies an item without the cost of making its scene.
        """
        plan, files = self.sweep.plan_values(), self.sweep.file_digests()
        return {name: _digest([keys, plan.get("set"), files]) for name, keys in plan["scenes"].items()}

    @cached_property
    def _keys(self) -> list[dict[Hashable, int]]:
        """The index of each level of each axis, by its settings."""
        return [{_level_key(level): i for i, level in enumerate(levels)} for levels in self._levels]

    def _number(self, point: SweepPoint) -> int:
        """Return the number of the item at a point, or 0."""
        cells = point.cells
        name = cells.get("scene")
        if not isinstance(name, str) or self._bases.get(name) != point.base:
            return 0
        crossed = [*self.sweep.grid, *(["seed"] if self.sweep.seeds else [])]
        listed = {key: value for key, value in cells.items() if key != "scene" and key not in crossed}
        wanted = [name, _value_key(listed), *(_value_key(cells.get(key)) for key in crossed)]
        wanted += [] if self.sweep.seeds else [None]
        number = 0
        for key, keys, levels in zip(wanted, self._keys, self._levels, strict=True):
            if key not in keys:
                return 0
            number = number * len(levels) + keys[key]
        return number + 1

    def _at(self, number: int) -> tuple[str, list[Setting]]:
        """Return the scene's name and the settings of an item."""
        rest, found = number - 1, list[Any]()
        for levels in reversed(self._levels):
            rest, index = divmod(rest, len(levels))
            found.append(levels[index])
        *points, group, name = found
        return name, [*group, *(point for point in reversed(points) if point)]

    def _refuse_equal_levels(self, axis: int) -> None:
        """Raise the error of two levels with equal settings."""
        step = prod(map(len, self._levels[axis + 1 :]))
        first: dict[Hashable, int] = {}
        for i, level in enumerate(self._levels[axis]):
            if (other := first.setdefault(_level_key(level), i)) != i:
                raise self._equal(1 + other * step, 1 + i * step)

    def _equal(self, first: int, number: int) -> SourceError:
        cells = ", ".join(f"{key} {_text(value)}" for key, value in self.cells(number).items() if value is not None)
        return SourceError(self.sweep.where, f"items {first} and {number} are the same scene: {cells}")


def axes(sweep: Sweep) -> list[tuple[str, list[str]]]:
    """Return the name of each axis of a sweep and its values as text, the slowest axis first."""
    lists = [", ".join(f"{setting.key} {_text(setting.value)}" for setting in group) for group in sweep.list or ((),)]
    return [
        ("scene", list(sweep.scenes)),
        ("", lists),
        *((key, [_text(setting.value) for setting in settings]) for key, settings in sweep.grid.items()),
        ("seed", [str(seed.value) for seed in sweep.seeds]),
    ]


def shard_of(given: str) -> tuple[int, int]:
    """Return the number and the count of a shard such as ``3/40``.

    Raises:
        InputError: for anything else.
    """
    number, _, count = given.partition("/")
    if not (number.isdecimal() and count.isdecimal() and len(given) < 20 and 1 <= int(number) <= int(count)):
        raise InputError(f"--shard {given}: expected a number and a count, from 1/40 to 40/40")
    return int(number), int(count)


def _cells(name: str, settings: Iterable[Setting]) -> dict[str, Any]:
    return {"scene": name} | {setting.key: setting.value for setting in settings}


def _level_key(level: Any) -> Hashable:
    """Return a key for the settings of a level: equal for equal settings."""
    if isinstance(level, Setting):
        return _value_key(level.value)
    return _value_key({s.key: s.value for s in level}) if isinstance(level, tuple) else level


def _value_key(value: Any) -> Hashable:
    """Return a key for a plain value: equal for 2 and 2.0, different for 1 and true."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value
    return json.dumps(_with_floats(value), sort_keys=True)


def _with_floats(value: Any) -> Any:
    """Return plain values with 2.0 in place of 2."""
    if isinstance(value, dict):
        return {key: _with_floats(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_with_floats(part) for part in value]
    return float(value) if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**53 else value


def _digest(values: Any) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
