"""Building a kit: `emovid study build`."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from emovid.atomic_io import clear_leftovers, file_digest, make_folder
from emovid.csv_writer import csv_text
from emovid.errors import EmovidError, InputError, reason
from emovid.kit.folder import KitFolder, set_times, write_text
from emovid.kit.load import LoadedStudy
from emovid.kit.manifest import json_text, manifest_of, read_manifest, server_keys_of
from emovid.kit.mp4 import pad_to_equal_size
from emovid.kit.orders import Order, presentation_orders
from emovid.kit.seeded_random import commitment, fresh_seed, salt, shuffled
from emovid.kit.stimuli import Stimulus, blinded, extras_of, make
from emovid.kit.study import Study
from emovid.video.ffmpeg import count_frames

_OWNER_ONLY = 0o600


class VideoReporter(Protocol):
    """Receives the progress of the videos."""

    def advanced(self, frames: int) -> None:
        """Receive the number of finished frames of the current video."""

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        """Receive a finished video, its number from 1, the number of videos, and whether it was made just now."""


@dataclass(frozen=True)
class Built:
    """A finished kit: its folder, its private seed, the codes of its videos, and the number of orders."""

    folder: Path
    seed: int
    codes: tuple[str, ...]
    participants: int


class _Former(NamedTuple):
    """Seed and digest of the kit that is in the folder already."""

    seed: int
    digest: str


def build(
    loaded: LoadedStudy,
    folder: Path,
    participants: int,
    seed: int | None,
    report: VideoReporter,
    *,
    force: bool = False,
) -> Built:
    """Make a kit, or the missing parts of one.

    Args:
        loaded: the study.
        folder: folder of the kit.
        participants: number of orders.
        seed: random seed; None for that of the kit in the folder, or else a new secret one.
        report: receives progress.
        force: overwrite a kit of another study or seed, unless somebody has answered it.

    Raises:
        InputError: if the folder contains something else, a kit of another study or seed, or answers to one.
        EmovidError: if something cannot be written.
    """
    kit = KitFolder(folder)
    former = _former(kit)
    digest = loaded.digest()
    if former:
        _check_same(kit, former, digest, seed, force)
    chosen = seed if seed is not None else former.seed if former else fresh_seed()
    stimuli = blinded(loaded, chosen)
    if former and force:
        _clear(kit)
    _write_private(kit, loaded, digest, chosen, stimuli)
    orders = orders_of(loaded.study, stimuli, participants, chosen)
    extras = extras_of(loaded, chosen)
    _make_videos(kit, loaded.study, [*stimuli, *extras], chosen, report)
    write_text(kit.orders, orders_text(loaded.study, orders, chosen))
    committed = commitment(kit.salt.read_bytes(), kit.key.read_bytes())
    codes = [item.code for item in stimuli]
    practice, checks = _parted(loaded.study, [kit.video(item.code) for item in extras])
    videos = [kit.video(code) for code in codes]
    manifest = manifest_of(loaded.study, videos, participants, len(orders[0]), committed, practice, checks)
    manifest = manifest.model_copy(update={"version": _version(kit) if former else 1})
    write_text(kit.map, manifest.map_yaml())
    write_text(kit.survey, json_text(server_keys_of(loaded.study)), _OWNER_ONLY)
    write_text(kit.manifest, manifest.text())
    set_times(kit.public)
    return Built(folder, chosen, tuple(codes), participants)


def _parted(study: Study, extras: list[Path]) -> tuple[Path | None, list[Path]]:
    """Return the practice video, if there is one, and the videos of the attention checks."""
    return (extras[0], extras[1:]) if study.practice else (None, extras)


def orders_of(study: Study, stimuli: Sequence[Stimulus], participants: int, seed: int) -> list[Order]:
    """Return the codes that each participant sees, in order.

    With `one_of_each`, the first exemplars are one set, the second ones another, and so on; participants get the sets
    in turn, and each set has its own squares.
    """
    if study.orders.shown == "all":
        return presentation_orders(study.orders.scheme, [item.code for item in stimuli], participants, seed)
    by_emotion: dict[str, list[str]] = {}
    for item in sorted(stimuli, key=_in_study):
        by_emotion.setdefault(item.exemplar.emotion, []).append(item.code)
    sets = list(zip(*by_emotion.values(), strict=True))
    each = -(-participants // len(sets))
    columns = [presentation_orders(study.orders.scheme, sorted(codes), each, seed) for codes in sets]
    return [order for row in zip(*columns, strict=True) for order in row][:participants]


def orders_text(study: Study, orders: Sequence[Order], seed: int) -> str:
    """Return orders.csv, with the order of the answers if it is random for each participant."""
    header = ["participant", "position", "video_code"]
    rows: list[list[object]] = []
    for number, order in enumerate(orders, start=1):
        name = f"P{number:03}"
        drawn = ["|".join(shuffled(list(study.answers), seed, "choices", name))] if study.choices == "random" else []
        rows += [[name, place, code, *drawn] for place, code in enumerate(order, start=1)]
    return csv_text([*header, "choices"] if study.choices == "random" else header, rows)


def _in_study(item: Stimulus) -> tuple[Any, ...]:
    """Return a sorting key for the order of study.yaml, so that a set has the same levels for all emotions."""
    return item.exemplar.entry, list(item.exemplar.factors.items()), item.exemplar.number


def _former(kit: KitFolder) -> _Former | None:
    try:
        if kit.path.is_dir() and any(kit.path.iterdir()):
            found = json.loads(kit.study.read_text(encoding="utf-8"))
            return _Former(int(found["seed"]), str(found["digest"]))
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(f"{kit.path}: is not empty and contains no kit; expected a new folder, or a kit") from None
    if kit.path.exists() and not kit.path.is_dir():
        raise InputError(f"{kit.path}: is a file; expected a folder")
    return None


def _check_same(kit: KitFolder, former: _Former, digest: str, seed: int | None, force: bool) -> None:
    """Refuse to replace a kit of another study or seed, even with `force` if answers would lose their key."""
    other_seed = seed is not None and seed != former.seed
    if not other_seed and digest == former.digest:
        return
    if force:
        if any(kit.answers.glob("*.sqlite")):
            message = "contains answers to the existing kit; move them away, or choose another folder for the new kit"
            raise InputError(f"{kit.answers}: {message}")
    elif other_seed:
        message = "contains a kit with another seed; expected that seed, another folder, or --force"
        raise InputError(f"{kit.path}: {message}")
    else:
        message = "contains a kit of another study or of an earlier version; expected another folder, or --force"
        raise InputError(f"{kit.path}: {message}")


def _clear(kit: KitFolder) -> None:
    """Remove videos and manifest of a former kit, whose codes may now mean something else."""
    kit.manifest.unlink(missing_ok=True)
    for video in kit.videos.glob("*.mp4"):
        video.unlink()


def _write_private(kit: KitFolder, loaded: LoadedStudy, digest: str, seed: int, stimuli: Sequence[Stimulus]) -> None:
    make_folder(kit.videos)
    make_folder(kit.private)
    try:
        kit.private.chmod(0o700)
    except OSError as error:
        raise EmovidError(f"{kit.private}: cannot be made private: {reason(error)}") from None
    facts = [item.facts() for item in stimuli]
    study = {"digest": digest, "seed": str(seed), "study": loaded.study.resolved()}
    key = [(item.code, item.exemplar.emotion) for item in stimuli]
    for path, text in (  # the study first: it marks the folder as a kit that is being built
        (kit.study, json.dumps(study, indent=2, ensure_ascii=False) + "\n"),
        (kit.seed, f"{seed}\n"),
        (kit.salt, f"{salt(seed)}\n"),
        (kit.key, csv_text(("video_code", "true_emotion"), key)),
        (kit.stimuli, csv_text(list(facts[0]), [list(row.values()) for row in facts])),
    ):
        write_text(path, text, _OWNER_ONLY)


def _make_videos(kit: KitFolder, study: Study, stimuli: Sequence[Stimulus], seed: int, report: VideoReporter) -> None:
    """Make missing videos, in the order of their codes, and pad all to equal size."""
    clear_leftovers(kit.videos)
    known = _recorded(kit)
    for number, item in enumerate(stimuli, start=1):
        target = kit.video(item.code)
        made = not _is_complete(target, known.get(item.code), study.video.frames)
        if made:
            kit.manifest.unlink(missing_ok=True)
            make(item, study.video, target, seed, report.advanced)
        report.finished(target, number, len(stimuli), made=made)
    pad_to_equal_size([kit.video(item.code) for item in stimuli])


def _is_complete(video: Path, sha256: str | None, frames: int) -> bool:
    """Return whether a video matches the manifest or, without a manifest, has all its frames."""
    if not video.is_file():
        return False
    return file_digest(video) == sha256 if sha256 else count_frames(video) == frames


def _version(kit: KitFolder) -> int:
    """Return the version of the texts of a finished kit."""
    return read_manifest(kit.manifest)[0].version if kit.manifest.is_file() else 1


def _recorded(kit: KitFolder) -> dict[str, str]:
    """Return the SHA-256 of each video of a finished kit."""
    try:
        found = json.loads(kit.manifest.read_text(encoding="utf-8"))
        extras = [found.get("practice"), *(check["video"] for check in found.get("checks", ()))]
        return {video["code"]: video["sha256"] for video in (*found["videos"], *extras) if video}
    except (OSError, ValueError, KeyError, TypeError):
        return {}
