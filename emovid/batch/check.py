"""Checks of a folder of results: what is missing, stale or corrupt, and what differs when it is made again."""

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from pydantic import ValidationError

from emovid.atomic_io import file_digest
from emovid.batch.job import Job, Record, make, versions
from emovid.batch.manifest import NAME, Records, read_manifest
from emovid.batch.results import PLAN
from emovid.batch.scheduler import OnStep, Pool, run
from emovid.batch.sweep import items
from emovid.batch.sweep_file import read_sweep
from emovid.errors import EmovidError, InputError
from emovid.scene.model import Scene
from emovid.swarm.simulate import simulate
from emovid.video.render import frames_checksum

State = Literal["current", "missing", "stale", "corrupt", "changed"]
_UNREADABLE = "recorded by another version of emovid"


@dataclass(frozen=True)
class Finding:
    """The state of a result, and the reason for it."""

    name: str
    state: State
    reason: str = ""


class Rebuild(NamedTuple):
    """A recorded result that can be made again."""

    name: str
    record: Record


def status(folder: Path) -> list[Finding]:
    """Return the state of each result of a folder: of the items of its plan or, without a plan, of its records.

    A result is missing if its file or its record is missing, stale if it was made from another scene or with other
    versions, and corrupt if its file has changed.

    Raises:
        InputError: if there is neither a plan nor a manifest.
    """
    if not (folder / PLAN).exists():
        return [_state(folder, name, record, _job(folder / name, record)) for name, record in _records(folder).items()]
    sweep, records = read_sweep(folder / PLAN), read_manifest(folder)
    jobs = [item.job(folder, sweep.only) for item in items(sweep)]
    return [_state(folder, job.target.name, records.get(job.target.name), job) for job in jobs]


def verify(folder: Path) -> list[Finding]:
    """Return for each file in a folder's manifest whether it exists and is unchanged.

    Raises:
        InputError: if there is no manifest.
    """
    return [_unchanged(folder / name, record) for name, record in _records(folder).items() if record.has_file]


def verify_again(folder: Path, pool: Pool, on_result: Callable[[int, int], None]) -> list[Finding]:
    """Return the findings of `verify`, and of making again every result that a scene alone decides.

    Args:
        folder: of the results.
        pool: does the work.
        on_result: receives the number of results that were made again, and their total.

    Raises:
        EmovidError: if a result cannot be made again.
    """
    found = {finding.name: finding for finding in verify(folder)}
    work = rebuildable(folder)
    for done, (entry, outcome) in enumerate(run(rebuild, work, pool), start=1):
        if isinstance(outcome, EmovidError):
            raise outcome
        known = found.get(entry.name)
        if known is None or known.state == "current":
            found[entry.name] = outcome
        on_result(done, len(work))
    return list(found.values())


def rebuildable(folder: Path) -> list[Rebuild]:
    """Return the results of a folder that a scene alone decides, without a finished run."""
    records = _records(folder).items()
    return [Rebuild(name, record) for name, record in records if record.only != "sheet" and record.run is None]


def rebuild(what: Rebuild, on_step: OnStep | None = None) -> Finding:
    """Make a recorded result again, outside its folder, and find the stage where it starts to differ.

    A video has the stages trajectory, frames and encoding; other results a trajectory, and a file or descriptors.
    """
    name, record = what
    job = _job(Path(name), record)
    if job is None:
        return Finding(name, "stale", _UNREADABLE)
    run = simulate(job.scene)
    if run.digest() != record.trajectory_sha256:
        return Finding(name, "changed", f"from the trajectory on{_versions(record)}")
    if job.only == "video" and frames_checksum(run) != record.frames_crc32:
        return Finding(name, "changed", f"from the frames on{_versions(record)}")
    with tempfile.TemporaryDirectory() as folder:
        again = make(Job(job.scene, Path(folder) / Path(name).name, run, job.only), on_step)
    if again.sha256 != record.sha256:
        stage = "encoding" if job.only == "video" else "file"
        return Finding(name, "changed", f"in the {stage}{_versions(record)}")
    if again.descriptors != record.descriptors:
        return Finding(name, "changed", f"in the descriptors{_versions(record)}")
    return Finding(name, "current")


def _records(folder: Path) -> Records:
    records = read_manifest(folder)
    if not records:
        raise InputError(f"{folder}: no results: expected a folder with a {NAME} that emovid has written")
    return records


def _job(target: Path, record: Record) -> Job | None:
    """Return the job of a recorded result; None if this version cannot read its scene."""
    try:
        return Job(Scene.model_validate(record.scene), target, only=record.only) if record.only != "sheet" else None
    except ValidationError:
        return None


def _state(folder: Path, name: str, record: Record | None, job: Job | None) -> Finding:
    if record is None:
        return Finding(name, "missing", "exists, but is not recorded" if (folder / name).exists() else "")
    if record.has_file and (found := _unchanged(folder / name, record)).state != "current":
        return found
    if record.only == "sheet":
        return Finding(name, "current")
    other = _versions(record).removeprefix(": ")
    if job is None:
        return Finding(name, "stale", other or _UNREADABLE)
    recipe, known = job.recipe, record.recipe
    if (known.scene_digest, known.versions, known.encoder) != (recipe.scene_digest, recipe.versions, recipe.encoder):
        return Finding(name, "stale", other or "made from another scene")
    return Finding(name, "current")


def _unchanged(file: Path, record: Record) -> Finding:
    if not file.exists():
        return Finding(file.name, "missing")
    return Finding(file.name, "current" if file_digest(file) == record.sha256 else "corrupt")


def _versions(record: Record) -> str:
    """Return the versions that differ from those of now, as in ": made with numpy 2.4.5, now 2.4.6"; "" if none do."""
    then: Mapping[str, str] = record.versions or {}
    now = versions(record.only)
    changed = [f"{name} {then[name]}, now {now[name]}" for name in now if then.get(name, now[name]) != now[name]]
    return f": made with {'; '.join(changed)}" if changed else ""
