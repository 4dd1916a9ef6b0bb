"""From a YAML file, with overrides, to a valid `Scene`: the door of this room."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from pydantic import ValidationError

from emovid import yaml_source
from emovid.errors import SourceError, nearest, reason
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.model import Scene
from emovid.scene.picture import read_pictures
from emovid.scene.resources import CONFIGS, read_text
from emovid.scene.robot_files import read_robot
from emovid.scene.validation_messages import complaint
from emovid.yaml_source import KeyPath, Places, key_path


class Setting(NamedTuple):
    """One key of a scene replaced from outside.

    Attributes:
        key: dotted, as in ``robot.l``.
        value: as text, read as in a scene; or a plain value.
        origin: what to call it in messages, as in ``--set robot.l=2``.
    """

    key: str
    value: Any
    origin: str


def load_scene(source: str | Path, settings: Iterable[Setting] | Mapping[str, Any] = ()) -> Scene:
    """Return the scene of a YAML file, or the shipped one of an emotion.

    Args:
        source: a file, or a name: one of the six emotions, or robotarium/ or robotarium-today/ before it.
        settings: keys to replace, in order; or dotted keys with their values, as in ``{"robot.l": 0.002}``.

    Raises:
        SourceError: for a file that cannot be read or a scene that cannot be meant, with file, line and key.
    """
    path = find_scene(source)
    if isinstance(settings, Mapping):
        settings = [Setting(key, value, "") for key, value in settings.items()]
    return parse_scene(read_text(path), str(path), settings, path.parent)


def find_scene(source: str | Path) -> Path:
    """Return the file of `source`: a shipped scene by its name, or the path itself if there is such a file."""
    if str(source) in shipped_names():
        return shipped_scene(str(source))
    path = Path(source)
    try:
        found = path.exists()
    except OSError as error:
        raise SourceError(str(path), f"cannot be read: {reason(error)}") from None
    if not found:
        raise SourceError(str(source), f"no such file or emotion{nearest(str(source), shipped_names())}")
    if path.suffix.lower() == ".npz":
        raise SourceError(str(source), "is a finished run; expected a scene (.yaml) or an emotion")
    return path


def shipped_names() -> list[str]:
    """Return the names of the scenes that ship: emotions, and `platform/emotion` for the testbeds."""
    return [*EMOTIONS, *(f"{platform}/{emotion}" for platform in PLATFORMS for emotion in EMOTIONS)]


def shipped_scene(name: str) -> Path:
    """Return the file of one of the `shipped_names`."""
    return CONFIGS / f"{name}.yaml"


def parse_scene(text: str, where: str, settings: Iterable[Setting] = (), folder: Path = Path()) -> Scene:
    """Return the scene in `text`; `where` names it in messages, files are found from `folder`. See `load_scene`."""
    return scene_of(*_keys(text, where), settings, folder)


def scene_keys(source: str | Path) -> tuple[dict[str, Any], Places, Path]:
    """Return the keys of a scene's file as plain values, valid or not, their places, and the file. See `load_scene`."""
    path = find_scene(source)
    return *_keys(read_text(path), str(path)), path


def scene_of(keys: dict[str, Any], known: Places, settings: Iterable[Setting] = (), folder: Path = Path()) -> Scene:
    """Return the scene of plain values, as `scene_keys` gives them; they stay as they are.

    Args:
        keys: the values.
        known: the places of the keys.
        settings: keys to replace, in order. A shorter duration among them moves the file's later snapshots to its end.
        folder: that pictures and robots are found from.

    Raises:
        SourceError: as `load_scene`.
    """
    data, places = deepcopy(keys), dict(known)
    replaced: set[str] = set()
    for setting in settings:
        _apply(setting, data, places)
        replaced.add(setting.key.partition(".")[0])
    if "duration" in replaced and "snapshots" not in replaced:
        _cut_snapshots(data, keys.get("duration"))
    read_pictures(data, folder, places)
    read_robot(data, folder, places)
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise complaint(error, places) from None
    scene.remember(places)
    return scene


def scene_text(scene: Scene) -> str:
    """Return the scene as YAML text, every key spelled out."""
    return yaml.safe_dump(scene.resolved(), sort_keys=False, allow_unicode=True)


def scene_digest(scene: Scene) -> str:
    """Return the SHA-256 of the resolved scene: equal for scenes that mean the same, whatever their comments."""
    canonical = json.dumps(scene.resolved(), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()


def _keys(text: str, where: str) -> tuple[dict[str, Any], Places]:
    data, places = yaml_source.read_yaml(text, where)
    if not isinstance(data, dict):
        raise SourceError(where, "not a scene: expected keys such as emotion, behaviour, robot")
    return data, places


def _apply(setting: Setting, data: dict[str, Any], places: dict[KeyPath, str]) -> None:
    """Replace one key in `data`; groups on the way that are missing or null are made."""
    if isinstance(setting.value, str):
        value = yaml_source.read_value(setting.value, setting.origin)
    else:
        value = deepcopy(setting.value)  # later settings and files that it names go into it
    *parents, last = key_path(setting.key)
    target: Any = data
    for i, part in enumerate(parents):
        if isinstance(target, dict) and target.get(str(part)) is None:
            target[str(part)] = {}
            places.setdefault((*parents[:i], part), setting.origin)
        target = _child(target, part, setting)
    _child(target, last, setting, new=value)
    if last == "file":
        target.pop("pixels", None)  # what was read from the file before
    path = (*parents, last if isinstance(target, list) else str(last))
    for inside in [known for known in places if known[: len(path)] == path]:
        del places[inside]
    places[path] = setting.origin


def _cut_snapshots(data: dict[str, Any], own: Any) -> None:
    """Put the end of a shorter run in the place of the snapshots between it and the scene's `own` duration."""
    times, end = data.get("snapshots"), data["duration"]
    if not (isinstance(times, list) and all(isinstance(value, int | float) for value in (*times, own, end))):
        return  # none, or what will be said to be wrong
    if 0 < end < max(times, default=0) <= own:
        data["snapshots"] = list(dict.fromkeys(min(t, end) for t in times))


def _child(target: Any, part: str | int, setting: Setting, **new: Any) -> Any:
    """Return ``target[part]``, after setting it if `new` is given."""
    if isinstance(target, list) and isinstance(part, int) and part < len(target):
        key: Any = part
    elif isinstance(target, dict):
        key = str(part)
    else:
        raise SourceError(setting.origin, f"there is nothing at {part} to set", key=setting.key)
    if new:
        target[key] = new["new"]
    return target[key]
