"""What is wrong in a folder of results, and at which stage a difference to what is made here and now begins."""

import tempfile
from pathlib import Path
from typing import Literal, NamedTuple

from pydantic import ValidationError

from emovid.atomic_io import file_digest
from emovid.batch.job import Job, Record, make, versions
from emovid.batch.ledger import NAME, read_ledger
from emovid.batch.pool import OnStep
from emovid.batch.sweep import PLAN, items
from emovid.batch.sweep_file import read_sweep_file
from emovid.errors import InputError
from emovid.scene.model import Scene
from emovid.swarm.simulate import simulate
from emovid.video.render import frames_checksum

State = Literal["current", "missing", "stale", "corrupt", "changed"]
_ELSEWHERE = "recorded by another version of emovid"


class Found(NamedTuple):
    """A result's name, its state, and why that is so."""

    name: str
    state: State
    reason: str = ""


class Rebuild(NamedTuple):
    """A recorded result that can be made again: its name and its record."""

    name: str
    record: Record


def status(folder: Path) -> list[Found]:
    """Return the state of each result that belongs into a folder: of the items of its plan, or all that it records.

    Missing is what is not there or not recorded; stale, what was made of another scene or with other versions; corrupt,
    what is no longer what was made.

    Raises:
        InputError: if there is neither a plan nor a manifest.
    """
    if not (folder / PLAN).exists():
        return [_state(folder, name, record, _job(folder / name, record)) for name, record in _records(folder).items()]
    sweep, records = read_sweep_file(folder / PLAN), read_ledger(folder)
    jobs = [item.job(folder, sweep.only) for item in items(sweep)]
    return [_state(folder, job.target.name, records.get(job.target.name), job) for job in jobs]


def verify(folder: Path) -> list[Found]:
    """Return whether each file that a folder's manifest records is there and the same.

    Raises:
        InputError: if there is no manifest.
    """
    return [_same(folder / name, record) for name, record in _records(folder).items() if _has_file(record)]


def rebuildable(folder: Path) -> list[Rebuild]:
    """Return the results of a folder that are made of a scene alone, not of a finished run."""
    return [Rebuild(name, record) for name, record in _records(folder).items() if _is_rebuildable(record)]


def rebuild(what: Rebuild, on_step: OnStep | None = None) -> Found:
    """Make a recorded result again, apart from it, and say at which stage it begins to differ.

    The stages are trajectory, frames and encoding; of a result that is no video, trajectory and file or descriptors.
    """
    name, record = what
    job = _job(Path(name), record)
    if job is None:
        return Found(name, "stale", _ELSEWHERE)
    run = simulate(job.scene)
    if run.digest() != record.get("trajectory_sha256"):
        return Found(name, "changed", f"from the trajectory on{_versions(record)}")
    if job.only == "video" and frames_checksum(run) != record.get("frames_crc32"):
        return Found(name, "changed", f"from the frames on{_versions(record)}")
    with tempfile.TemporaryDirectory() as folder:
        again = make(Job(job.scene, Path(folder) / Path(name).name, run, job.only), on_step)
    if again.get("sha256") != record.get("sha256"):
        stage = "encoding" if job.only == "video" else "file"
        return Found(name, "changed", f"in the {stage}{_versions(record)}")
    if again.get("descriptors") != record.get("descriptors"):
        return Found(name, "changed", f"in the descriptors{_versions(record)}")
    return Found(name, "current")


def _records(folder: Path) -> dict[str, Record]:
    records = read_ledger(folder)
    if not records:
        raise InputError(f"{folder}: no results: expected a folder with a {NAME} that emovid has written")
    return records


def _job(target: Path, record: Record) -> Job | None:
    """Return the job that a result was made by; None if its record says too little of it for this version."""
    try:
        return Job(Scene.model_validate(record["scene"]), target, only=record["only"])
    except (KeyError, ValidationError):
        return None


def _has_file(record: Record) -> bool:
    return record["only"] != "measure"


def _is_rebuildable(record: Record) -> bool:
    return record["only"] != "sheet" and record.get("run") is None


def _state(folder: Path, name: str, record: Record | None, job: Job | None) -> Found:
    if record is None:
        there = (folder / name).exists()
        return Found(name, "missing", "there, but not recorded" if there else "")
    if _has_file(record) and (found := _same(folder / name, record)).state != "current":
        return found
    if record["only"] == "sheet":
        return Found(name, "current")
    if job is None:
        return Found(name, "stale", _versions(record).removeprefix(": ") or _ELSEWHERE)
    recipe = job.recipe | {"run": record.get("run")}
    if any(record.get(key) != value for key, value in recipe.items()):
        return Found(name, "stale", _versions(record).removeprefix(": ") or "made of another scene")
    return Found(name, "current")


def _same(file: Path, record: Record) -> Found:
    if not file.exists():
        return Found(file.name, "missing")
    return Found(file.name, "current" if file_digest(file) == record.get("sha256") else "corrupt")


def _versions(record: Record) -> str:
    """Return what other versions a result was made with: ": made with numpy 2.4.5, now 2.4.6"; "" without any."""
    now = versions(record["only"])
    then = {name: was for name, was in record.get("versions", {}).items() if name in now}
    changed = [f"{name} {was}, now {now[name]}" for name, was in then.items() if was != now[name]]
    return f": made with {'; '.join(changed)}" if changed else ""
