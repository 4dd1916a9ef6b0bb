"""Differences between two scenes."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from emovid.scene.model import Scene

ABSENT = object()  # in place of a value: the scene has no such key


class Difference(NamedTuple):
    """A key with different values in two scenes; the value is ABSENT in a scene without the key.

    Attributes:
        key: dotted, as in options.
        first, second: the values in the two scenes.
    """

    key: str
    first: Any
    second: Any


def differences(first: Scene, second: Scene) -> list[Difference]:
    """Return the keys that differ between two resolved scenes, in the order of the file.

    Comments, the order of keys and explicit defaults make no difference. Lists of equal length are compared item by
    item, others as a whole.
    """
    return differences_of(first.resolved(), second.resolved())


def differences_of(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[Difference]:
    """Return the keys that differ between two scenes, in the form of `Scene.resolved`."""
    return list(_differing(first, second, ()))


def _differing(first: Any, second: Any, path: tuple[str, ...]) -> Iterator[Difference]:
    if isinstance(first, dict) and second is ABSENT:
        second = {}
    if isinstance(second, dict) and first is ABSENT:
        first = {}
    if isinstance(first, dict) and isinstance(second, dict):
        for key in first | second:
            yield from _differing(first.get(key, ABSENT), second.get(key, ABSENT), (*path, key))
    elif isinstance(first, list) and isinstance(second, list) and len(first) == len(second):
        for i, (one, other) in enumerate(zip(first, second, strict=True)):
            yield from _differing(one, other, (*path, str(i)))
    elif first != second:
        yield Difference(".".join(path), first, second)
