"""Corrected texts for a finished kit: `emovid study update`. Videos, orders, key and answers do not change."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from emovid.errors import InputError
from emovid.kit.folder import KitFolder, open_kit, set_times, write_text
from emovid.kit.load import LoadedStudy
from emovid.kit.manifest import json_text, manifest_of, server_keys_of

# Keys of study.yaml that change only texts for participants or published facts about the study. A star
# stands for any key or place in a list.
_TEXTS = (
    "title", "authors", "language", "question", "labels.*", "none_of_these", "translations", "ratings.*.question",
    "ratings.*.low", "ratings.*.high", "demographics.*.question", "questions_after.*.question", "checks.*.question",
    "consent", "instructions", "thanks", "texts", "debriefing", "recruitment", "requirements", "ethics", "hypotheses",
    "participants",
)  # fmt: skip
_OWNER_ONLY = 0o600


@dataclass(frozen=True)
class Updated:
    """An updated kit: the version of its texts, and the keys that differ from the version before."""

    version: int
    changed: tuple[str, ...]


def update(loaded: LoadedStudy, folder: Path) -> Updated:
    """Replace the texts of a finished kit by those of its study.yaml, as a new version.

    Args:
        loaded: the corrected study.
        folder: folder of the kit.

    Raises:
        InputError: if the folder is no finished kit with its private folder, and if the study differs in more than
            texts, with the first such key.
    """
    kit = open_kit(folder)
    former = kit.study
    if former is None:
        raise InputError(f"{kit.folder.study}: no such file; expected the kit's private folder")
    changed = tuple(_differences(former.resolved(), loaded.study.resolved()))
    for key in changed:
        if not _is_text(key):
            message = f"{key}: changes more than a text; build a new kit for it, or restore the value of the kit"
            raise InputError(f"{loaded.path}: {message}")
    stored = json.loads(kit.folder.study.read_text(encoding="utf-8"))
    if replace(loaded, study=former).digest() != stored["digest"]:
        raise InputError(f"{loaded.path}: a scene or video differs from that of the kit; build a new kit for it")
    if not changed:
        return Updated(kit.manifest.version, ())
    _write(kit.folder, loaded, stored, kit.manifest.version + 1)
    return Updated(kit.manifest.version + 1, changed)


def _write(folder: KitFolder, loaded: LoadedStudy, stored: dict[str, Any], version: int) -> None:
    kit = open_kit(folder.path)
    manifest = manifest_of(
        loaded.study,
        [folder.video(code) for code in kit.manifest.codes],
        kit.manifest.participants,
        kit.manifest.videos_shown,
        kit.manifest.key_commitment,
        folder.video(kit.manifest.practice.code) if kit.manifest.practice else None,
        [folder.video(check.video.code) for check in kit.manifest.checks],
    ).model_copy(update={"version": version})
    study = stored | {"digest": loaded.digest(), "study": loaded.study.resolved()}
    write_text(folder.study, json.dumps(study, indent=2, ensure_ascii=False) + "\n", _OWNER_ONLY)
    write_text(folder.map, manifest.map_yaml())
    write_text(folder.survey, json_text(server_keys_of(loaded.study)), _OWNER_ONLY)
    write_text(folder.manifest, manifest.text())
    set_times(folder.public)


def _differences(old: Any, new: Any, at: str = "") -> Iterator[str]:
    """Yield the keys that differ, as paths with dots."""
    if isinstance(old, dict) and isinstance(new, dict) and old.keys() == new.keys():
        for key in old:
            yield from _differences(old[key], new[key], f"{at}.{key}" if at else key)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for place, pair in enumerate(zip(old, new, strict=True)):
            yield from _differences(*pair, f"{at}.{place}")
    elif old != new:
        yield at


def _is_text(key: str) -> bool:
    """Return whether a key, or a key above it, is one of the texts."""
    parts = key.split(".")
    for text in _TEXTS:
        wanted = text.split(".")
        if len(parts) >= len(wanted) and all(w in ("*", part) for w, part in zip(wanted, parts, strict=False)):
            return True
    return False
