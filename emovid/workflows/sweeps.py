"""Sweeps from the sweep file to the table of results, and what a sweep would do."""

import json
from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, Protocol

from emovid.atomic_io import make_folder
from emovid.batch import contact_sheet, manifest
from emovid.batch.cache import Made, Reporter, is_current, make_jobs, touch, workers
from emovid.batch.check import state_of
from emovid.batch.manifest import Journal, Records, has_journals, read_manifest
from emovid.batch.results import PARQUET, TABLE, write_summary
from emovid.batch.sweep import Items
from emovid.errors import InputError
from emovid.swarm.simulate import check_start
from emovid.workflows.rendering import check_folder


class OpenReporter(Protocol):
    """Gives a reporter for a number of items."""

    def __call__(self, total: int) -> AbstractContextManager[Reporter]:
        """Open the reporter."""


@dataclass(frozen=True)
class SweepRun:
    """How a sweep is made.

    Attributes:
        folder: of the results.
        shard: number and count of the part to make.
        force: whether to make results again that are up to date.
        processes: number of items to work on at once, without a cluster.
        scheduler: address of a Dask scheduler.
        wait: seconds to wait for a worker of the cluster; None for no limit.
    """

    folder: Path
    shard: tuple[int, int] = (1, 1)
    force: bool = False
    processes: int = 1
    scheduler: str | None = None
    wait: float | None = None

    def numbers(self, items: Items) -> range:
        """Return the numbers of the shard's items."""
        number, count = self.shard
        return range(number, len(items) + 1, count)


@dataclass
class SweepOutcome:
    """Outcome of a sweep, complete or not.

    Attributes:
        items: number of items of the whole sweep.
        known: number of results that were up to date.
        made: outcome of the others.
        finished: number of finished items of the whole sweep, other runs included; None before the table is written.
    """

    items: int
    known: int = 0
    made: Made = field(default_factory=Made)
    finished: int | None = None


def check_output(folder: Path, items: Items) -> None:
    """Raise an `InputError` unless the results of a sweep can be written to a folder."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"-o {folder}: is a file; expected a folder")
    check_folder(folder, (manifest.NAME, manifest.PLAN, TABLE, PARQUET))
    if items.sweep.only != "measure" and contact_sheet.NAME not in read_manifest(folder):
        check_folder(folder, [contact_sheet.NAME])


def run_sweep(items: Items, run: SweepRun, open_reporter: OpenReporter, outcome: SweepOutcome) -> None:
    """Make every missing or outdated item of a sweep, the table of results and the contact sheet.

    An interrupted run, too, leaves the table of what is finished.

    Args:
        items: of the sweep.
        run: how to make them.
        open_reporter: gives a reporter for the items of the shard.
        outcome: is updated; after an interruption it tells what was done.

    Raises:
        InputError: for an invalid item, before anything is written, or if another sweep is being made in the folder.
        EmovidError: if nothing can be recorded, or the cluster cannot be used.
    """
    if not run.force:
        _check_plan(items, run.folder)
    numbers = run.numbers(items)
    with open_reporter(len(numbers)) as report:
        missing, moved = _missing(items, run, report, outcome)
        is_shared = has_journals(run.folder)
        jobs = (items.job(run.folder, items.item(number)) for number in (reversed(missing) if is_shared else missing))
        scheduler = run.scheduler if missing else None
        processes = min(run.processes, len(missing))
        with workers(processes, report.advanced, scheduler, items.sweep.only, report.noted, run.wait) as pool:
            make_folder(run.folder)
            with Journal(run.folder, items.sweep.plan(run.folder)) as journal:
                for name, record in moved.items():
                    journal.add(name, record)
                try:
                    make_jobs(jobs, journal, report, pool, outcome.made)
                except BaseException:
                    outcome.finished = write_summary(run.folder, items)
                    raise
    outcome.finished = write_summary(run.folder, items, run.processes)
    touch(run.folder / TABLE)


def _check_plan(items: Items, folder: Path) -> None:
    """Raise an `InputError` for a folder with results that are not in the sweep: its table would lose them."""
    try:
        plan = json.loads((folder / manifest.PLAN).read_bytes())
    except (OSError, ValueError):  # no sweep yet, or a damaged plan
        return
    if plan == json.loads(items.sweep.plan(folder).text) or plan.get("only", "video") != items.sweep.only:
        return
    records = read_manifest(folder)
    lost = {name for name, record in records.items() if record.only == items.sweep.only}
    lost -= set(items.numbers_of(records).values())
    if lost:  # or made by an older sweep file in which their settings stood elsewhere
        lost -= {item.name for item in items.expand(range(1, len(items) + 1))}
    if lost:
        problem = f"exists with other settings ({len(lost)} of its results are not in this sweep)"
        raise InputError(f"{folder / manifest.PLAN} {problem}; use --force to overwrite it, or -o")


def _missing(items: Items, run: SweepRun, report: Reporter, outcome: SweepOutcome) -> tuple[list[int], Records]:
    """Return the numbers of the items to make, and records of finished ones that have moved within a changed sweep.

    Every item of the shard is validated.
    """
    records = {} if run.force else read_manifest(run.folder)
    missing, moved = [], {}
    for item in items.expand(run.numbers(items)):
        job, record = items.job(run.folder, item), records.get(item.name)
        if record and is_current(record, job):
            if record.point != item.point:
                moved[item.name] = replace(record, point=item.point)
            outcome.known += 1
            touch(job.target)
            report.finished(job, record, made=False)
        else:
            check_start(item.scene)
            missing.append(item.number)
    return missing, moved


Action = Literal["make", "replace", "keep", "leave"]


@dataclass(frozen=True)
class Step:
    """Something that a sweep would do to a result: make, replace or keep it, or leave it although it has no item."""

    action: Action
    name: str
    reason: str = ""


def plan_sweep(items: Items, run: SweepRun) -> Iterator[Step]:
    """Yield what `run_sweep` would do, without doing it; raises as it does for invalid items."""
    records = read_manifest(run.folder)
    names = set()
    for item in items.expand(run.numbers(items)):
        names.add(item.name)
        found = state_of(run.folder, item.name, records.get(item.name), items.job(run.folder, item))
        if found.state == "current" and not run.force:
            yield Step("keep", item.name)
        elif found.state == "missing" and not found.reason:
            check_start(item.scene)
            yield Step("make", item.name)
        else:
            check_start(item.scene)
            reason = ": ".join(part for part in (found.state, found.reason) if part)
            yield Step("replace", item.name, "--force" if found.state == "current" else reason)
    if run.shard == (1, 1):
        for name in sorted(records.keys() - names):
            if records[name].only != "sheet":
                yield Step("leave", name, "no item of the sweep; needs --force")
