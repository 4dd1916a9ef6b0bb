"""Checks of a folder of results: what is missing, stale or corrupt, and what differs when it is made again."""

import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, NamedTuple

from pydantic import ValidationError

from emovid.atomic_io import file_digest
from emovid.batch.job import Job, Record, descriptors_digest, make
from emovid.batch.manifest import NAME, PLAN, Records, has_journals, read_manifest
from emovid.batch.results import PARQUET, TABLE, same_parquet, table_of
from emovid.batch.scheduler import OnStep, Pool, run
from emovid.batch.sweep import Items
from emovid.batch.sweep_file import read_sweep
from emovid.batch.versions import versions
from emovid.errors import EmovidError, InputError
from emovid.scene.model import Scene
from emovid.swarm.simulate import simulate
from emovid.video.render import frames_checksum

State = Literal["current", "missing", "stale", "corrupt", "changed", "unplanned"]
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
    """Return the state of each result of a folder: of the items of its sweep or, without a plan, of its records.

    A result is missing if its file or its record is missing, stale if it was made from another scene or with other
    versions, corrupt if its file has changed, and unplanned if the current sweep file has no such item.

    Raises:
        InputError: if there is neither a plan nor a manifest.
    """
    if not (folder / PLAN).exists():
        return [
            state_of(folder, name, record, _job(folder / name, record)) for name, record in _records(folder).items()
        ]
    records, planned = read_manifest(folder), read_sweep(folder / PLAN)
    sweep = read_sweep(planned.file, planned.only) if planned.file.is_file() else planned
    items, found = Items(sweep), []
    if sweep.plan_values() != planned.plan_values():
        found.append(Finding(PLAN, "stale", f"{sweep.where} has changed since"))
    known, names = items.numbers_of(records), set()
    for number in range(1, len(items) + 1):
        name = known.get(number, "")
        if name and str(records[name].scene_digest)[:12] in name:
            found.append(_recorded_state(folder, name, records[name]))
        else:
            item = items.item(number)
            name = item.name
            found.append(state_of(folder, name, records.get(name), items.job(folder, item)))
        names.add(name)
    for name in sorted(records.keys() - names):
        is_sheet = records[name].only == "sheet"
        found.append(_unchanged(folder, name, records[name]) if is_sheet else Finding(name, "unplanned"))
    return [*found, *_table_findings(folder, Items(planned), records)]


def verify(folder: Path) -> list[Finding]:
    """Return for each result in a folder's manifest, and for the table of a sweep, whether it exists and is unchanged.

    Raises:
        InputError: if there is no manifest.
    """
    records = _records(folder)
    found = [_unchanged(folder, name, record) for name, record in records.items()]
    if (folder / PLAN).exists():
        found += _table_findings(folder, Items(read_sweep(folder / PLAN)), records)
    return found


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
        if found[entry.name].state == "current" or (not entry.record.has_file and outcome.state != "current"):
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


def state_of(folder: Path, name: str, record: Record | None, job: Job | None) -> Finding:
    """Return the state of a result, given its record and the job that would make it now; None for missing ones."""
    if record is None:
        return Finding(name, "missing", "exists, but is not recorded" if (folder / name).exists() else "")
    if record.only == "sheet" or (job and record.recipe == replace(job.recipe, run=record.run)):
        return _unchanged(folder, name, record)
    found = _recorded_state(folder, name, record)
    if found.state != "current":
        return found
    return Finding(name, "stale", "made from another scene" if job else _UNREADABLE)


def _recorded_state(folder: Path, name: str, record: Record) -> Finding:
    """Return the state of a result whose scene is known to be that of its job."""
    found = _unchanged(folder, name, record)
    if found.state == "current" and record.versions != versions(record.only, barrier=record.has_barrier):
        return Finding(name, "stale", _versions(record).removeprefix(": ") or _UNREADABLE)
    return found


def _unchanged(folder: Path, name: str, record: Record) -> Finding:
    """Return whether a result exists and is as it was recorded."""
    if not record.has_file:
        is_same = record.sha256 in (None, descriptors_digest(record))
        return Finding(name, "current") if is_same else Finding(name, "corrupt", "its descriptors were changed")
    if not (folder / name).exists():
        return Finding(name, "missing")
    return Finding(name, "current" if file_digest(folder / name) == record.sha256 else "corrupt")


def _table_findings(folder: Path, items: Items, records: Records) -> list[Finding]:
    """Return the states of the table of results: it must be that of the results that some versions have made."""
    known = items.numbers_of(records)
    made_by = {json.dumps(records[name].versions): records[name].versions for name in known.values()}
    tables = [table_of(items, {}, records)] if not known else []
    for made in made_by.values():
        some = {number: name for number, name in known.items() if records[name].versions == made}
        there = {n: name for n, name in some.items() if not records[name].has_file or (folder / name).exists()}
        tables += [table_of(items, names, records) for names in (there, some)]
    expected = [(TABLE, [table.csv for table in tables])]
    if find_spec("pyarrow") and (known or (folder / PARQUET).exists()):
        expected.append((PARQUET, [table.parquet for table in tables]))
    return [_table_finding(folder, name, contents) for name, contents in expected]


def _table_finding(folder: Path, name: str, contents: Sequence[bytes]) -> Finding:
    if has_journals(folder):
        return Finding(name, "stale", "a run has not ended, or was killed: run the sweep again")
    try:
        found = (folder / name).read_bytes()
    except OSError:
        return Finding(name, "missing", "run the sweep again")
    is_known = found in contents or (name.endswith(".parquet") and any(same_parquet(found, made) for made in contents))
    return Finding(name, "current") if is_known else Finding(name, "corrupt", "not the table of these results")


def _versions(record: Record) -> str:
    """Return the versions that differ from those of now, as in ": made with numpy 2.4.5, now 2.4.6"; "" if none do."""
    then: Mapping[str, str] = record.versions or {}
    now = versions(record.only, barrier=record.has_barrier)
    changed = [f"{name} {then[name]}, now {now[name]}" for name in now if then.get(name, now[name]) != now[name]]
    return f": made with {'; '.join(changed)}" if changed else ""
