"""Robots' files: read once, then part of the scene, so that a scene is all that a run needs."""

from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from emovid.errors import SourceError, nearest
from emovid.scene.resources import CONFIGS, read_text
from emovid.scene.robots import Body
from emovid.scene.validation_messages import complaint
from emovid.yaml_source import Places, place_of, read_yaml

_FOLDER = CONFIGS / "robots"
_SUFFIXES = (".yaml", ".yml")


def shipped_robots() -> list[str]:
    """Return the names of the robots that ship."""
    return sorted(path.stem for path in _FOLDER.glob("*.yaml"))


def load_robot(source: str | Path) -> Body:
    """Return the robot of a YAML file, or a shipped one by its name.

    Raises:
        SourceError: for a file that cannot be read or a robot that cannot be meant, with file, line and key.
    """
    path = _find(str(source), Path())
    return _robot(read_text(path, "robot"), str(path), path.stem)


def read_robot(data: Any, folder: Path, places: Places) -> None:
    """Read the robot that a scene names, and put it in; and its limits where the scene says so.

    Args:
        data: plain values as read from YAML, valid or not; changed in place.
        folder: that the files' names start from.
        places: of the keys.

    Raises:
        SourceError: as `load_robot`; for the limits of a robot that has none.
    """
    robot = data.get("robot") if isinstance(data, dict) else None
    if not isinstance(robot, dict):
        return
    model = robot.get("model")
    if isinstance(model, str):
        robot["model"] = model = _named(model, folder, places)
    if robot.get("limits") == "model" and isinstance(model, Body | dict):
        said = dict(model)  # a robot in the scene itself is not validated yet
        if said.get("limits") is None:
            where, name = place_of(("robot", "limits"), places), said.get("name", "robot")
            raise SourceError(where, f"model: a {name} has none; expected null or limits", key="robot.limits")
        robot["limits"] = said["limits"]


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
        return _FOLDER / f"{name}.yaml"
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
        raise complaint(error, places, Body) from None
