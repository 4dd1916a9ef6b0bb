"""Results are kept and made only if they are missing or out of date: which jobs are up to date, and making the rest."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple, Protocol

from emovid.atomic_io import clear_leftovers, file_digest, make_folder
from emovid.batch.cluster import connected
from emovid.batch.job import Job, Record, make
from emovid.batch.manifest import Journal, read_manifest
from emovid.batch.scheduler import OnProgress, Pool, run
from emovid.batch.workers import InProcess, Processes
from emovid.errors import EmovidError


class Reporter(Protocol):
    """Receives the progress of jobs, from the calling thread or another one of its process."""

    def advanced(self, job: Job, done: int, total: int) -> None:
        """A job has `done` of `total` steps done."""

    def finished(self, job: Job, record: Record, *, made: bool) -> None:
        """A job's result exists: it was made now, or was up to date."""

    def failed(self, job: Job) -> None:
        """A job failed; the errors are returned together with the other results."""

    def died(self, job: Job, attempt: int) -> None:
        """The worker of a job died in attempt number `attempt`; the job is tried again."""


class Made(NamedTuple):
    """Outcome of jobs by target: the records of those that were made, and the errors of the others."""

    records: dict[Path, Record]
    failures: dict[Path, EmovidError]


def find_current(jobs: Sequence[Job], reporter: Reporter) -> dict[Path, Record]:
    """Return the records, by target, of the jobs whose results exist and are up to date; write nothing."""
    manifests = {folder: read_manifest(folder) for folder in {job.target.parent for job in jobs}}
    records = {}
    for job in jobs:
        record = manifests[job.target.parent].get(job.target.name)
        if record and is_current(record, job):
            records[job.target] = record
            reporter.finished(job, record, made=False)
    return records


def is_current(record: Record, job: Job) -> bool:
    """Return whether a record is of a job's recipe, and its file exists and is unchanged."""
    if record.recipe != job.recipe:
        return False
    return not record.has_file or (job.target.exists() and file_digest(job.target) == record.sha256)


def make_missing(jobs: Sequence[Job], reporter: Reporter, pool: Pool) -> Made:
    """Make the results of jobs, and record each one when it is done.

    Args:
        jobs: with targets in one folder, which is made if it is missing.
        reporter: receives the progress.
        pool: does the work, see `workers`.

    Raises:
        EmovidError: if nothing can be recorded; errors of single jobs are returned.
    """
    made = Made({}, {})
    if not jobs:
        return made
    folder = jobs[0].target.parent
    make_folder(folder)
    clear_leftovers(folder)
    with Journal(folder) as journal:
        for job, outcome in run(make, jobs, pool, reporter.died):
            if error := _error(job, outcome):
                made.failures[job.target] = error
                reporter.failed(job)
                continue
            journal.add(job.target.name, outcome)
            made.records[job.target] = outcome
            reporter.finished(job, outcome, made=True)
    clear_leftovers(folder)
    return made


@contextmanager
def workers(processes: int, on_progress: OnProgress = lambda *_: None, scheduler: str | None = None) -> Iterator[Pool]:
    """Give a pool of workers: a Dask cluster, several processes, or this process alone.

    Args:
        processes: number of items to work on at once, without a cluster.
        on_progress: receives the progress of items, where the pool knows it.
        scheduler: address of a Dask scheduler.
    """
    if scheduler:
        with connected(scheduler) as cluster:
            yield cluster
    elif processes > 1:
        with closing(Processes(processes, on_progress)) as pool:
            yield pool
    else:
        yield InProcess(on_progress)


def _error(job: Job, outcome: Record | EmovidError) -> EmovidError | None:
    """Return the error of a job, naming its target; None for a result that can be used."""
    if isinstance(outcome, EmovidError):
        named = str(job.target) in str(outcome)
        return outcome if named else EmovidError(f"{job.target}: {outcome}")
    if outcome.recipe != job.recipe:
        there, here = outcome.recipe.versions, job.recipe.versions
        differ = [name for name in here if there.get(name) != here[name]]
        other = "; ".join(f"{name} {there.get(name)}, here {here[name]}" for name in differ)
        return EmovidError(f"{job.target}: its worker has other versions: {other}")
    if outcome.has_file and not job.target.exists():
        return EmovidError(f"{job.target}: made, but not here: workers must share the output folder")
    return None
