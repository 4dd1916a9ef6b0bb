"""What two scenes say differently."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from emovid.scene.model import Scene

ABSENT = object()  # in the place of a key's value: that scene has no such key


class Difference(NamedTuple):
    """One key that two scenes give other values; one of the values is ABSENT if only the other has the key.

    Attributes:
        key: dotted, as options replace it.
        first: the value in the one scene.
        second: the value in the other.
    """

    key: str
    first: Any
    second: Any


def differences(first: Scene, second: Scene) -> list[Difference]:
    """Return the keys that differ between two resolved scenes, in the order of the file.

    Comments, the order of keys and defaults that one spells out make no difference. Lists of one length are compared
    item by item, others as a whole.
    """
    return differences_of(first.resolved(), second.resolved())


def differences_of(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[Difference]:
    """Return the keys that differ between two scenes, given as `Scene.resolved` gives them."""
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
