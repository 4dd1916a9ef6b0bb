"""Loading: from YAML files of scenes and robots, with overrides, to a valid `Scene`; and the JSON Schema of scenes.

The robot and the pictures of a scene are read once and become part of it, so that a scene is all that a run needs.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from copy import deepcopy
from functools import lru_cache
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
from emovid.scene.robots import Body, schema_with
from emovid.yaml_models import source_error
from emovid.yaml_source import KeyPath, Places, key_path, place_of, read_yaml

_ROBOTS = CONFIGS / "robots"
_SUFFIXES = (".yaml", ".yml")


def shipped_robots() -> list[str]:
    """Return the names of the robots that ship."""
    return sorted(path.stem for path in _ROBOTS.glob("*.yaml"))


def load_robot(source: str | Path) -> Body:
    """Return the robot of a YAML file, or a shipped one by its name.

    Raises:
        SourceError: for a file that cannot be read or an invalid robot, with file, line and key.
    """
    path = _find(str(source), Path())
    return _robot(read_text(path, "robot"), str(path), path.stem)


def read_robot(data: Any, folder: Path, places: Places) -> None:
    """Replace the name of a robot in a scene by its keys, and `limits: model` by its limits.

    Args:
        data: plain values as read from YAML, valid or not; changed in place.
        folder: that file names are relative to.
        places: of the keys.

    Raises:
        SourceError: as in `load_robot`; for the limits of a robot that has none.
    """
    robot = data.get("robot") if isinstance(data, dict) else None
    if not isinstance(robot, dict):
        return
    model = robot.get("model")
    if isinstance(model, str):
        robot["model"] = model = _named(model, folder, places)
    if robot.get("limits") == "model" and isinstance(model, Body | dict):
        keys = dict(model)  # a robot in the scene itself is not validated yet
        if keys.get("limits") is None:
            where, name = place_of(("robot", "limits"), places), keys.get("name", "robot")
            raise SourceError(where, f"model: a {name} has none; expected null or limits", key="robot.limits")
        robot["limits"] = keys["limits"]


def _named(model: str, folder: Path, places: Places) -> Body:
    try:
        path = _find(model, folder)
        text = read_text(path, "robot")
    except SourceError as error:
        where = place_of(("robot", "model"), places)
        raise SourceError(where, f"{error.where}: {error.message}".removeprefix(": "), key="robot.model") from None
    return _robot(text, str(path), path.stem)


def _find(name: str, folder: Path) -> Path:
    if name.endswith(_SUFFIXES) and name.isprintable():
        return folder / name
    if name in (known := shipped_robots()):
        return _ROBOTS / f"{name}.yaml"
    expected = f"expected one of {', '.join(known)}, or a file that ends in .yaml"
    raise SourceError("", f"{name!r}: {expected}{nearest(name, known)}")


@lru_cache
def _robot(text: str, where: str, name: str) -> Body:
    data, places = read_yaml(text, where, "robot")
    if not isinstance(data, dict):
        raise SourceError(where, "not a robot: expected keys such as kinematics, shape, wheels")
    try:
        return Body.model_validate({"name": name} | data)
    except ValidationError as error:
        raise source_error(error, places, Body) from None


class Setting(NamedTuple):
    """A key of a scene to replace, and its new value.

    Attributes:
        key: dotted, as in ``robot.l``.
        value: text, read as in a scene; or a plain value.
        origin: its name in messages, as in ``--set robot.l=2``.
    """

    key: str
    value: Any
    origin: str


def load_scene(source: str | Path, settings: Iterable[Setting] | Mapping[str, Any] = ()) -> Scene:
    """Return the scene of a YAML file, or the shipped one of an emotion.

    Args:
        source: a file, or the name of an emotion, also with robotarium/ or robotarium-today/ before it.
        settings: keys to replace, in order; or dotted keys with their values, as in ``{"robot.l": 0.002}``.

    Raises:
        SourceError: for a file that cannot be read or an invalid scene, with file, line and key.
    """
    if not isinstance(source, str | Path):
        raise SourceError(repr(source), "expected the name of an emotion, or of a scene file")
    path = find_scene(source)
    if isinstance(settings, Mapping):
        settings = [Setting(key, value, "") for key, value in settings.items()]
    for setting in [settings] if isinstance(settings, str) else (settings := list(settings)):
        if not isinstance(setting, Setting):
            raise SourceError(repr(setting), 'expected settings as in {"robot.l": 0.002}')
    return parse_scene(read_text(path), str(path), settings, path.parent)


def find_scene(source: str | Path) -> Path:
    """Return the file of `source`: a shipped scene by its name, or an existing path."""
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
    if path.suffix.lower() == ".csv":
        raise SourceError(str(source), "is a table; expected a scene (.yaml), or a run as emovid simulate -o RUN.npz")
    return path


def shipped_names() -> list[str]:
    """Return the names of the shipped scenes: emotions, and `platform/emotion` for the testbeds."""
    return [*EMOTIONS, *(f"{platform}/{emotion}" for platform in PLATFORMS for emotion in EMOTIONS)]


def shipped_scene(name: str) -> Path:
    """Return the file of one of the `shipped_names`."""
    return CONFIGS / f"{name}.yaml"


def parse_scene(text: str, where: str, settings: Iterable[Setting] = (), folder: Path = Path()) -> Scene:
    """Return the scene in `text`; `where` is its name in messages, file names are relative to `folder`."""
    return scene_of(*_keys(text, where), settings, folder)


def scene_keys(source: str | Path) -> tuple[dict[str, Any], Places, Path]:
    """Return the keys of a scene's file as plain values, valid or not, their places, and the file."""
    path = find_scene(source)
    return *_keys(read_text(path), str(path)), path


def scene_of(keys: dict[str, Any], known: Places, settings: Iterable[Setting] = (), folder: Path = Path()) -> Scene:
    """Return the scene of plain values, such as those of `scene_keys`, which it does not change.

    Args:
        keys: the values.
        known: the places of the keys.
        settings: keys to replace, in order. A shorter duration moves the file's later snapshots to its end.
        folder: that the file names of pictures and robots are relative to.

    Raises:
        SourceError: as in `load_scene`.
    """
    settings = list(settings)
    data, places = apply_settings(keys, known, settings)
    replaced = {setting.key.partition(".")[0] for setting in settings}
    if "duration" in replaced and "snapshots" not in replaced:
        _cut_snapshots(data, keys.get("duration"))
    read_pictures(data, folder, places)
    read_robot(data, folder, places)
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise source_error(error, places, Scene) from None
    scene.remember(places)
    return scene


def scene_text(scene: Scene) -> str:
    """Return the scene as YAML text with all keys."""
    return yaml.safe_dump(scene.resolved(), sort_keys=False, allow_unicode=True)


def scene_digest(scene: Scene) -> str:
    """Return the SHA-256 of the resolved scene: equal for scenes with equal keys; comments do not count."""
    canonical = json.dumps(scene.resolved(), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()


def _keys(text: str, where: str) -> tuple[dict[str, Any], Places]:
    data, places = yaml_source.read_yaml(text, where)
    if not isinstance(data, dict):
        raise SourceError(where, "not a scene: expected keys such as emotion, behaviour, robot")
    return data, places


def apply_settings(
    keys: dict[str, Any], known: Places, settings: Iterable[Setting]
) -> tuple[dict[str, Any], dict[KeyPath, str]]:
    """Return copies of plain values and their places with keys replaced."""
    data, places = deepcopy(keys), dict(known)
    for setting in settings:
        _apply(setting, data, places)
    return data, places


def _apply(setting: Setting, data: dict[str, Any], places: dict[KeyPath, str]) -> None:
    """Replace one key in `data`, and create groups that are missing or null."""
    if isinstance(setting.value, str):
        value = yaml_source.read_value(setting.value, setting.origin)
    else:
        value = _plain(setting.value)
    value = _located(setting.key, value)
    *parents, last = key_path(setting.key)
    target: Any = data
    for i, part in enumerate(parents):
        if isinstance(target, dict) and target.get(str(part)) is None:
            target[str(part)] = {}
            places.setdefault((*parents[:i], part), setting.origin)
        target = _child(target, part, setting)
    _child(target, last, setting, new=value)
    if last == "file":
        target.pop("pixels", None)  # of the file before
    path = (*parents, last if isinstance(target, list) else str(last))
    for inside in [known for known in places if known[: len(path)] == path]:
        del places[inside]
    places[path] = setting.origin


def _plain(value: Any) -> Any:
    """Return a copy of a value, with numpy's numbers and arrays as Python's."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else deepcopy(value)


def _located(key: str, value: Any) -> Any:
    """Return the value of a key, where it names an existing file of the user by its path from everywhere."""
    is_file = key.rpartition(".")[2] == "file" or (key == "robot.model" and str(value).endswith((".yaml", ".yml")))
    if not (is_file and isinstance(value, str)):
        return value
    try:
        return str(Path(value).resolve()) if Path(value).is_file() else value
    except OSError:  # a name that no file can have, such as one that is too long: validation reports it
        return value


def _cut_snapshots(data: dict[str, Any], own: Any) -> None:
    """Replace the snapshots between the end of a shorter run and the scene's `own` duration by that end."""
    times, end = data.get("snapshots"), data["duration"]
    if not (isinstance(times, list) and all(isinstance(value, int | float) for value in (*times, own, end))):
        return  # none, or invalid, which validation reports
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


def moved_scene(text: str, source: Path, target: Path) -> str:
    """Return the text of a scene for another folder, with the relative names of its files changed accordingly.

    Args:
        text: of the scene.
        source: its file.
        target: the new file.

    Raises:
        SourceError: for a name that spans lines, which cannot be replaced.
    """
    keys, places = _keys(text, str(source))
    lines = text.splitlines(keepends=True)
    for path, where in places.items():
        name = _at(keys, path)
        is_file = path[-1:] == ("file",) or (path == ("robot", "model") and str(name).endswith((".yaml", ".yml")))
        if is_file and isinstance(name, str) and not Path(name).is_absolute():
            number, moved = _line_of(where) - 1, os.path.relpath(source.parent / name, target.parent)
            if name not in lines[number]:
                raise SourceError(where, f"{name}: expected the name on one line", key=".".join(map(str, path)))
            lines[number] = moved.join(lines[number].rsplit(name, 1)) if moved != name else lines[number]
    return "".join(lines)


def _at(keys: Any, path: KeyPath) -> Any:
    for part in path:
        keys = keys[part]
    return keys


def _line_of(where: str) -> int:
    return int(where.rpartition(":")[2])


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a scene, for editors."""
    schema = Scene.model_json_schema()
    schema_with(shipped_robots(), schema["$defs"]["Robot"])
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "emovid scene"}
