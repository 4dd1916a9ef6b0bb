"""The items of a sweep: every scene, with every group of the list, at every point of the grid, from every seed."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from emovid.batch.job import Job, Kind
from emovid.batch.sweep_file import Sweep
from emovid.errors import InputError, SourceError
from emovid.scene.load import Setting, scene_digest, scene_of
from emovid.scene.model import Scene
from emovid.video.encoder import FORMATS

MAX_ITEMS = 100_000


@dataclass(frozen=True)
class Item:
    """One point of a sweep.

    Attributes:
        number: from 1, in the order of the sweep.
        name: of its result: the scene's name and twelve digits of its content, which stay when the sweep grows.
        cells: the scene's name and the settings, by key.
        scene: resolved.
    """

    number: int
    name: str
    cells: dict[str, Any]
    scene: Scene

    def job(self, folder: Path, only: Kind) -> Job:
        """Return the job that makes its result."""
        return Job(self.scene, folder / self.name, only=only)


def items(sweep: Sweep) -> list[Item]:
    """Return the items of a sweep, each a valid scene and none twice.

    Raises:
        SourceError: for the first invalid one, with the place of the key at fault.
    """
    count = prod(map(len, _levels(sweep)))
    if count > MAX_ITEMS:
        raise SourceError(sweep.where, f"{count} items: at most {MAX_ITEMS}")
    found = list(_items(sweep))
    numbers: dict[str, int] = {}
    for item in found:
        if (first := numbers.setdefault(item.name, item.number)) != item.number:
            raise SourceError(sweep.where, f"items {first} and {item.number} are the same scene: {_shown(item)}")
    return found


def axes(sweep: Sweep) -> list[tuple[str, list[str]]]:
    """Return the name of each axis of a sweep and its values as text, the slowest axis first."""
    scenes, groups, *grid, seeds = _levels(sweep)
    lists = [", ".join(f"{setting.key} {_text(setting.value)}" for setting in group) for group in groups]
    return [
        ("scene", list(scenes)),
        ("", lists),
        *((key, [_text(setting.value) for setting in level]) for key, level in zip(sweep.grid, grid, strict=True)),
        ("seed", [str(seed.value) for seed in seeds if seed]),
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


def _levels(sweep: Sweep) -> list[tuple[Any, ...]]:
    """Return the levels of each axis: scenes, groups of the list, keys of the grid, seeds; an unused axis has one."""
    return [tuple(sweep.scenes), sweep.list or ((),), *sweep.grid.values(), sweep.seeds or (None,)]


def _items(sweep: Sweep) -> Iterator[Item]:
    listed = [setting.key for group in sweep.list for setting in group]
    columns = dict.fromkeys(["scene", *listed, *sweep.grid, *(["seed"] if sweep.seeds else [])])
    for number, (name, group, *points) in enumerate(product(*_levels(sweep)), start=1):
        settings: list[Setting] = [*group, *(setting for setting in points if setting)]
        template = sweep.scenes[name]
        scene = scene_of(template.keys, template.places, [*sweep.set, *settings], template.folder)
        cells = columns | {"scene": name} | {setting.key: setting.value for setting in settings}
        suffix = {"video": FORMATS[scene.video.format].suffix, "trajectory": ".npz", "measure": ""}[sweep.only]
        yield Item(number, f"{name}-{scene_digest(scene)[:12]}{suffix}", cells, scene)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _shown(item: Item) -> str:
    return ", ".join(f"{key} {_text(value)}" for key, value in item.cells.items() if value is not None)
