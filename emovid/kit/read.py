"""A finished kit, read back: for audits, exports and whoever serves it."""

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from emovid.errors import InputError, reason
from emovid.kit.folders import KitFolder
from emovid.kit.manifest import Manifest, read_manifest
from emovid.kit.orders import Order
from emovid.kit.study import Study
from emovid.responses.key import read_key
from emovid.responses.labels import NONE, Labels

_COLUMNS = ("participant", "position", "video_code")


@dataclass(frozen=True)
class Kit:
    """What a kit's folder holds.

    Attributes:
        folder: where.
        manifest: the public one.
        unknown: keys of the manifest that none should have.
        orders: the codes of each participant, by place.
        choices: the order of the answers of each participant, where that is their own.
        key: the emotion of each code; empty where there is no key.
        study: what the kit was made from; None where the private folder is not here.
    """

    folder: KitFolder
    manifest: Manifest
    unknown: tuple[str, ...]
    orders: Mapping[str, Order]
    choices: Mapping[str, Order]
    key: Mapping[str, str]
    study: Study | None

    @property
    def labels(self) -> list[str]:
        """The labels that videos may stand for."""
        return [answer.label for answer in self.manifest.choices.labels if answer.label != NONE]

    def need_orders(self) -> None:
        """Raise InputError if the kit has no orders."""
        if not self.orders:
            what = "a header alone" if self.folder.orders.exists() else "no such file"
            raise InputError(f"{self.folder.orders}: {what}; expected the orders of the kit")


def open_kit(path: Path, key: Path | None = None) -> Kit:
    """Return a finished kit.

    Args:
        path: its folder; orders and private folder may be elsewhere.
        key: instead of the private one.

    Raises:
        InputError: for a folder that is no finished kit, and for files of it that cannot be meant.
    """
    kit = open_public(path)
    file = key or kit.folder.key
    found = read_key(file, Labels(kit.labels)) if key or file.is_file() else {}
    return replace(kit, key=found, study=_study(kit.folder))


def open_public(path: Path) -> Kit:
    """Return a finished kit without a look into its private folder, key and study left empty. Raises as `open_kit`."""
    folder = KitFolder(path)
    if not path.is_dir():
        raise InputError(f"{path}: no such folder; expected a kit")
    manifest, unknown = read_manifest(folder.manifest)
    orders, choices = _orders(folder.orders) if folder.orders.exists() else ({}, {})
    return Kit(folder, manifest, tuple(unknown), orders, choices, {}, None)


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
        raise InputError(f"{folder.study}: not the study of a kit; expected what emovid study build wrote") from None
