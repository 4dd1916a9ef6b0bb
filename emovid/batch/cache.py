"""Results are kept and made only if they are missing or out of date: which jobs are up to date, and making the rest."""

import os
import shutil
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from emovid.atomic_io import clear_leftovers, file_digest, make_folder, not_written, owner, whole_file, whole_folder
from emovid.batch.cluster import connected
from emovid.batch.job import Delivery, Job, Order, Record, descriptors_digest, fulfill
from emovid.batch.manifest import Journal, read_manifest
from emovid.batch.scheduler import Pool, run
from emovid.batch.versions import RecordKind, differences
from emovid.batch.workers import InProcess, Processes
from emovid.errors import EmovidError
from emovid.video.encoder import check_sequence

OnAdvance = Callable[[Job, int, int], None]  # receives a job, its steps done and their total


class Reporter(Protocol):
    """Receives the progress of jobs, from the calling thread or another one of its process."""

    def advanced(self, job: Job, done: int, total: int) -> None:
        """A job has `done` of `total` steps done."""

    def finished(self, job: Job, record: Record, *, made: bool) -> None:
        """A job's result exists: it was made now, or was up to date."""

    def failed(self, job: Job, error: EmovidError) -> None:
        """A job failed."""

    def died(self, job: Job, attempt: int) -> None:
        """The worker of a job died in attempt number `attempt`; the job is tried again."""

    def noted(self, line: str) -> None:
        """Something about the workers that the user should know."""


@dataclass
class Made:
    """Outcome of jobs by target.

    Attributes:
        records: of the jobs that were made.
        elsewhere: records of the jobs that another run into the folder made meanwhile.
        failures: errors of the others.
    """

    records: dict[Path, Record] = field(default_factory=dict)
    elsewhere: dict[Path, Record] = field(default_factory=dict)
    failures: dict[Path, EmovidError] = field(default_factory=dict)


def find_current(jobs: Sequence[Job], reporter: Reporter) -> dict[Path, Record]:
    """Return the records, by target, of the jobs whose results exist and are up to date.

    The modification time of their files is updated, so that `make` and similar tools do not run again.
    """
    manifests = {folder: read_manifest(folder) for folder in {job.target.parent for job in jobs}}
    records = {}
    for job in jobs:
        record = manifests[job.target.parent].get(job.target.name)
        if record and is_current(record, job):
            records[job.target] = record
            touch(job.target)
            reporter.finished(job, record, made=False)
    return records


def is_current(record: Record, job: Job) -> bool:
    """Return whether a record is of a job's recipe, and its file exists and is unchanged."""
    if record.recipe != job.recipe:
        return False
    if not record.has_file:
        return record.sha256 == descriptors_digest(record)
    return job.target.exists() and file_digest(job.target) == record.sha256


def touch(file: Path) -> None:
    """Update the modification time of an existing file, where this is allowed."""
    with suppress(OSError):
        os.utime(file)


def make_missing(jobs: Sequence[Job], reporter: Reporter, pool: Pool) -> Made:
    """Make the results of jobs in one folder, which is made if it is missing, and record each one when it is done.

    Args:
        jobs: with targets in one folder.
        reporter: receives the progress.
        pool: does the work, see `workers`.

    Raises:
        EmovidError: if nothing can be recorded; errors of single jobs are returned.
    """
    made = Made()
    if jobs:
        folder = jobs[0].target.parent
        make_folder(folder)
        with Journal(folder) as journal:
            make_jobs(jobs, journal, reporter, pool, made)
    return made


def make_jobs(jobs: Iterable[Job], journal: Journal, reporter: Reporter, pool: Pool, made: Made) -> None:
    """Make the results of jobs in a journal's folder; raises as `make_missing`.

    Workers write to a folder of this run, or send their results; this process compares digests and puts each result in
    its place. Parallel runs into the folder share the jobs.

    Args:
        jobs: are taken one by one when a worker is free.
        journal: receives the records.
        reporter: receives the progress.
        pool: does the work, see `workers`.
        made: is updated; after an interruption it tells what was made.
    """
    folder = journal.folder
    clear_leftovers(folder)
    with _staging(folder) as staging:
        orders = _orders(jobs, journal, reporter, made, None if pool.is_remote else staging)
        for order, outcome in run(fulfill, orders, pool, lambda order, attempt: reporter.died(order.job, attempt)):
            job: Job = order.job
            try:
                record = _placed(job, outcome, staging / job.target.name)
            except EmovidError as error:
                made.failures[job.target] = error
                reporter.failed(job, error)
                continue
            journal.add(job.target.name, record)
            made.records[job.target] = record
            reporter.finished(job, record, made=True)
    clear_leftovers(folder)


@contextmanager
def workers(
    processes: int,
    on_progress: OnAdvance = lambda *_: None,
    scheduler: str | None = None,
    only: RecordKind = "video",
    note: Callable[[str], None] = lambda _: None,
    wait: float | None = None,
) -> Iterator[Pool]:
    """Give a pool of workers: a Dask cluster, several processes, or this process alone.

    Args:
        processes: number of items to work on at once, without a cluster.
        on_progress: receives the progress of jobs, where the pool knows it.
        scheduler: address of a Dask scheduler.
        only: kind of the results, for a cluster.
        note: receives lines about the workers of a cluster.
        wait: seconds to wait for a worker of the cluster; None for no limit.
    """

    def advanced(item: object, done: int, total: int) -> None:
        if isinstance(item, Order):
            on_progress(item.job, done, total)

    if scheduler:
        with connected(scheduler, only, note, wait) as cluster:
            yield cluster
    elif processes > 1:
        with closing(Processes(processes, advanced)) as pool:
            yield pool
    else:
        yield InProcess(advanced)


def _orders(
    jobs: Iterable[Job], journal: Journal, reporter: Reporter, made: Made, staging: Path | None
) -> Iterator[Order | None]:
    """Yield an order for each job that no other run is making or has made; None while only such jobs are left."""
    before = dict(journal.records)
    deferred: deque[Job] = deque()

    def order(job: Job) -> Order | None:
        name = job.target.name
        if name in journal.claimed_elsewhere():
            deferred.append(job)
            return None
        record = journal.records.get(name)
        if record and record != before.get(name) and is_current(record, job):
            made.elsewhere[job.target] = record
            reporter.finished(job, record, made=False)
            return None
        journal.claim(name)
        return Order(job, job.recipe.versions, staging)

    for job in jobs:
        if found := order(job):
            yield found
    while deferred:
        for _ in range(len(deferred)):
            if found := order(deferred.popleft()):
                yield found
        yield None


@contextmanager
def _staging(folder: Path) -> Iterator[Path]:
    """Give a hidden folder for the results of this run that are not in their places yet."""
    staging = folder / f".results.{owner()}.part"
    shutil.rmtree(staging, ignore_errors=True)
    try:
        staging.mkdir()
    except OSError as error:
        raise not_written(folder if folder.name else Path.cwd(), error, "written to") from None
    try:
        yield staging
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _placed(job: Job, outcome: Delivery | EmovidError, staged: Path) -> Record:
    """Compare a delivered result with its record, put it in its place, and return the record.

    Raises:
        EmovidError: why there is no result, naming the target.
    """
    if isinstance(outcome, EmovidError):
        raise outcome if str(job.target) in str(outcome) else EmovidError(f"{job.target}: {outcome}")
    record, recipe = outcome.record, job.recipe
    if record.recipe != recipe:
        other = differences(record.recipe.versions, recipe.versions) or "another recipe"
        raise EmovidError(f"{job.target}: its worker has other versions: {other}")
    try:
        if outcome.content is not None:
            _write(outcome.content, staged)
        digest = file_digest(staged) if record.has_file else descriptors_digest(record)
        if digest != record.sha256:
            raise EmovidError(f"{job.target}: not what its worker recorded: it was damaged on its way")
        if not record.has_file:
            return record
        if staged.is_dir():
            check_sequence(job.target)
        with (whole_folder if staged.is_dir() else whole_file)(job.target) as part:
            staged.rename(part)
    except OSError as error:
        raise not_written(job.target, error) from None
    return record


def _write(content: Mapping[str, bytes], staged: Path) -> None:
    if "" in content:
        staged.write_bytes(content[""])
        return
    staged.mkdir()
    for name, data in content.items():
        (staged / name).write_bytes(data)
