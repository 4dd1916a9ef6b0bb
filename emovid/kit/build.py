"""The making of a kit: `emovid study build`."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from emovid.atomic_io import clear_leftovers, file_digest, make_folder
from emovid.errors import EmovidError, InputError, reason
from emovid.kit.folders import KitFolder, csv_text, set_times, write_text
from emovid.kit.load import LoadedStudy
from emovid.kit.manifest import manifest_of
from emovid.kit.mp4 import pad_alike
from emovid.kit.orders import Order, presentation_orders
from emovid.kit.seeded_random import commitment, fresh_seed, salt, shuffled
from emovid.kit.stimuli import Stimulus, blinded, make
from emovid.kit.study import Study
from emovid.video.ffmpeg import count_frames

_OWNER_ONLY = 0o600


class Reporter(Protocol):
    """Is told how the making of videos goes."""

    def advanced(self, frames: int) -> None:
        """The video under way has so many frames done."""

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        """The number-th of so many videos is there: made now, or before."""


@dataclass(frozen=True)
class Built:
    """A finished kit.

    Attributes:
        folder: where.
        seed: its private seed.
        codes: of its videos.
        participants: with an order each.
    """

    folder: Path
    seed: int
    codes: tuple[str, ...]
    participants: int


def build(
    loaded: LoadedStudy, folder: Path, participants: int, seed: int | None, report: Reporter, *, force: bool = False
) -> Built:
    """Make a kit, or what is missing of one.

    Args:
        loaded: the study.
        folder: of the kit.
        participants: that get an order.
        seed: that all is drawn from; None: the one of the kit that is there, else a fresh secret.
        report: hears of progress.
        force: make it again, even for another study or seed, as long as nobody has answered.

    Raises:
        InputError: if the folder holds something else, a kit of another study or seed, or answers to such a one.
        EmovidError: if something cannot be written.
    """
    kit = KitFolder(folder)
    known = _known(kit)
    digest = loaded.digest()
    if known:
        _check_same(kit, known, digest, seed, force)
    chosen = seed if seed is not None else int(known["seed"]) if known else fresh_seed()
    stimuli = blinded(loaded, chosen)
    if known and force:
        _clear(kit)
    _write_private(kit, loaded, digest, chosen, stimuli)
    orders = orders_of(loaded.study, stimuli, participants, chosen)
    _make_videos(kit, loaded.study, stimuli, chosen, report)
    write_text(kit.orders, orders_text(loaded.study, orders, chosen))
    committed = commitment(kit.salt.read_bytes(), kit.key.read_bytes())
    codes = [item.code for item in stimuli]
    manifest = manifest_of(loaded.study, kit, codes, participants, len(orders[0]), committed)
    write_text(kit.map, manifest.map_yaml())
    write_text(kit.manifest, manifest.text())
    set_times(kit.public)
    return Built(folder, chosen, tuple(codes), participants)


def orders_of(study: Study, stimuli: Sequence[Stimulus], participants: int, seed: int) -> list[Order]:
    """Return who sees which codes in which order.

    Where one of each emotion is shown, the first exemplars are one set, the second another, and so on; participants get
    the sets in turn, and each set has squares of its own.
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
    """Return orders.csv; where choices come in an order of the participant's own, it has that too."""
    header = ["participant", "position", "video_code"]
    rows: list[list[object]] = []
    for number, order in enumerate(orders, start=1):
        name = f"P{number:03}"
        drawn = ["|".join(shuffled(list(study.answers), seed, "choices", name))] if study.choices == "random" else []
        rows += [[name, place, code, *drawn] for place, code in enumerate(order, start=1)]
    return csv_text([*header, "choices"] if study.choices == "random" else header, rows)


def _in_study(item: Stimulus) -> tuple[Any, ...]:
    """Return what sorts stimuli as the study lists them: equal places of two emotions share their factors' levels."""
    return item.exemplar.entry, list(item.exemplar.factors.items()), item.exemplar.number


def _known(kit: KitFolder) -> dict[str, Any] | None:
    """Return what a kit that is there says of its making, None where there is nothing."""
    try:
        if kit.path.is_dir() and any(kit.path.iterdir()):
            said = json.loads(kit.study.read_text(encoding="utf-8"))
            return {"seed": int(said["seed"]), "digest": str(said["digest"])}
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(
            f"{kit.path}: is not empty and no kit in the making; expected a new folder, or a kit"
        ) from None
    if kit.path.exists() and not kit.path.is_dir():
        raise InputError(f"{kit.path}: is a file; expected a folder")
    return None


def _check_same(kit: KitFolder, known: dict[str, Any], digest: str, seed: int | None, force: bool) -> None:
    """Refuse to make a kit of another study or seed; by force only where no answers would lose their key."""
    other_seed = seed is not None and seed != known["seed"]
    if not other_seed and digest == known["digest"]:
        return
    if force:
        if any(kit.answers.glob("*.sqlite")):
            message = "answers to the kit that is there; expected another folder for the new one, or these elsewhere"
            raise InputError(f"{kit.answers}: {message}")
    elif other_seed:
        raise InputError(f"{kit.path}: is a kit of another seed; expected that one, another folder, or --force")
    else:
        message = "is a kit of another study, or of an earlier version of it; expected another folder, or --force"
        raise InputError(f"{kit.path}: {message}")


def _clear(kit: KitFolder) -> None:
    """Remove the videos and the manifest of a former kit: their codes may stand for something else now."""
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
    for path, text in (  # the study first: with it, the folder is a kit in the making
        (kit.study, json.dumps(study, indent=2, ensure_ascii=False) + "\n"),
        (kit.seed, f"{seed}\n"),
        (kit.salt, f"{salt(seed)}\n"),
        (kit.key, csv_text(("video_code", "true_emotion"), key)),
        (kit.stimuli, csv_text(list(facts[0]), [list(row.values()) for row in facts])),
    ):
        write_text(path, text, _OWNER_ONLY)


def _make_videos(kit: KitFolder, study: Study, stimuli: Sequence[Stimulus], seed: int, report: Reporter) -> None:
    """Make the videos that are missing, in the order of their codes, and make all equally long."""
    clear_leftovers(kit.videos)
    known = _recorded(kit)
    for number, item in enumerate(stimuli, start=1):
        target = kit.video(item.code)
        made = not _is_whole(target, known.get(item.code), study.video.frames)
        if made:
            kit.manifest.unlink(missing_ok=True)
            make(item, study.video, target, seed, report.advanced)
        report.finished(target, number, len(stimuli), made=made)
    pad_alike([kit.video(item.code) for item in stimuli])


def _is_whole(video: Path, sha256: str | None, frames: int) -> bool:
    """Return whether a video is there as the manifest has it, or, while there is none, has all its frames."""
    if not video.is_file():
        return False
    return file_digest(video) == sha256 if sha256 else count_frames(video) == frames


def _recorded(kit: KitFolder) -> dict[str, str]:
    """Return the SHA-256 of each video of a finished kit."""
    try:
        said = json.loads(kit.manifest.read_text(encoding="utf-8"))
        return {video["code"]: video["sha256"] for video in said["videos"]}
    except (OSError, ValueError, KeyError, TypeError):
        return {}
