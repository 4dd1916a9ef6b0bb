"""The folder of a kit: its paths, and reading a finished kit back."""

import csv
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from emovid.atomic_io import writing
from emovid.errors import InputError, reason
from emovid.kit.manifest import Manifest, ServerKeys, read_manifest, read_server_keys
from emovid.kit.orders import Order
from emovid.kit.study import Return, Study
from emovid.responses.key import read_key
from emovid.responses.labels import NONE, Labels

# Modification time of all public files and folders: 2000-01-01T00:00:00Z. Their real times could tell which video
# took long to make.
TIME = 946_684_800

_COLUMNS = ("participant", "position", "video_code")


class KitFolder:
    """The paths of a kit.

    Attributes:
        path: the kit.
        public: may be public.
        videos: the stimuli, CODE.mp4.
        manifest: what the pages of a survey need; written last, so that a kit without it is unfinished.
        orders: the codes that each participant sees, in order.
        map: labels and their texts, for `study analyze --map`.
        exports: a folder for each tool.
        survey: what only the survey's server may know: completion codes, return links, answers of attention checks.
        answers: what the survey recorded.
        private: must stay closed until the data are complete.
        key: the emotion of each code.
        salt: the salt of the commitment to the key.
        seed: the random seed.
        study: the study with every key, and its digest.
        stimuli: how each stimulus was made.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.public = path / "public"
        self.videos = self.public / "videos"
        self.manifest = self.public / "manifest.json"
        self.orders = path / "orders.csv"
        self.map = path / "map.yaml"
        self.exports = path / "exports"
        self.survey = path / "survey.json"
        self.answers = path / "answers"
        self.private = path / "private"
        self.key = self.private / "key.csv"
        self.salt = self.private / "salt.txt"
        self.seed = self.private / "seed.txt"
        self.study = self.private / "study.json"
        self.stimuli = self.private / "stimuli.csv"

    def video(self, code: str) -> Path:
        """Return the file of a stimulus."""
        return self.videos / f"{code}.mp4"

    def inside(self, path: Path) -> str:
        """Return a path relative to the kit."""
        return str(path.relative_to(self.path))


@dataclass(frozen=True)
class Kit:
    """A finished kit.

    Attributes:
        folder: its paths.
        manifest: its manifest, with the completion code and the return link.
        server: known only to the server of the survey.
        unknown: keys of the manifest that do not belong there.
        orders: the codes of each participant, by position.
        choices: the order of the answers of each participant, if it is random.
        key: the emotion of each code; empty without a key.
        study: the study; None without the private folder.
    """

    folder: KitFolder
    manifest: Manifest
    server: ServerKeys
    unknown: tuple[str, ...]
    orders: Mapping[str, Order]
    choices: Mapping[str, Order]
    key: Mapping[str, str]
    study: Study | None

    @property
    def labels(self) -> list[str]:
        """The labels that videos may signal."""
        return [answer.label for answer in self.manifest.choices.labels if answer.label != NONE]

    def need_orders(self) -> None:
        """Raise InputError if the kit has no orders."""
        if not self.orders:
            what = "only a header" if self.folder.orders.exists() else "no such file"
            raise InputError(f"{self.folder.orders}: {what}; expected the orders of the kit")


def open_kit(path: Path, key: Path | None = None) -> Kit:
    """Return a finished kit.

    Args:
        path: its folder; orders and private folder may be elsewhere.
        key: a key to use instead of the private one.

    Raises:
        InputError: for a folder that is not a finished kit, and for invalid files in it.
    """
    kit = open_public(path)
    file = key or kit.folder.key
    found = read_key(file, Labels(kit.labels)) if key or file.is_file() else {}
    return replace(kit, key=found, study=_study(kit.folder))


def open_public(path: Path) -> Kit:
    """Return a finished kit without reading its private folder: `key` and `study` are empty. Raises as `open_kit`."""
    folder = KitFolder(path)
    if not path.is_dir():
        raise InputError(f"{path}: no such folder; expected a kit")
    manifest, unknown = read_manifest(folder.manifest)
    orders, choices = _orders(folder.orders) if folder.orders.exists() else ({}, {})
    server = read_server_keys(folder.survey)
    if server is None:
        server = ServerKeys(complete=Return(code=manifest.thanks.code, link=manifest.thanks.link))
    thanks = manifest.thanks.model_copy(update=dict(server.complete))
    manifest = manifest.model_copy(update={"thanks": thanks})
    return Kit(folder, manifest, server, tuple(unknown), orders, choices, {}, None)


def write_text(path: Path, text: str, mode: int | None = None) -> None:
    """Write a file atomically, with the permissions `mode`. Raises as `writing`."""
    with writing(path) as file:
        if mode is not None:
            os.fchmod(file.fileno(), mode)
        file.write(text.encode())


def set_times(folder: Path) -> None:
    """Give a folder and everything in it the same modification time."""
    for path in [*folder.rglob("*"), folder]:
        os.utime(path, (TIME, TIME))


def _orders(path: Path) -> tuple[dict[str, Order], dict[str, Order]]:
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines(), strict=True))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason(error)}") from None
    except (csv.Error, ValueError):
        raise InputError(f"{path}: not CSV; expected {','.join(_COLUMNS)}") from None
    shown: dict[str, list[tuple[int, str]]] = {}
    choices: dict[str, Order] = {}
    for line, row in enumerate(rows, start=2):
        name, place, code = (row.get(column) or "" for column in _COLUMNS)
        if not (name and code and place.isdecimal()):
            raise InputError(f"{path}:{line}: expected {','.join(_COLUMNS)}, the position a whole number")
        shown.setdefault(name, []).append((int(place), code))
        if row.get("choices"):
            choices[name] = tuple(row["choices"].split("|"))
    return {name: tuple(code for _, code in sorted(places)) for name, places in shown.items()}, choices


def _study(folder: KitFolder) -> Study | None:
    try:
        return Study.model_validate_json(json.dumps(json.loads(folder.study.read_text(encoding="utf-8"))["study"]))
    except OSError:
        return None
    except (ValueError, KeyError, TypeError):
        message = "not the study of a kit; expected the file that emovid study build wrote"
        raise InputError(f"{folder.study}: {message}") from None
