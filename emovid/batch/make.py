"""Many jobs: which are done, and making the others. The door of this room."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple, Protocol

from emovid.atomic_io import clear_leftovers, make_folder
from emovid.batch.cluster import connected
from emovid.batch.job import Job, Record, is_by_recipe, is_current, make
from emovid.batch.ledger import Ledger, read_ledger
from emovid.batch.local import InProcess, Processes
from emovid.batch.pool import Hear, Pool
from emovid.batch.run import run
from emovid.errors import EmovidError


class Reporter(Protocol):
    """Is told how the work goes, by the thread that asked for it or by another one of its process."""

    def advanced(self, job: Job, done: int, total: int) -> None:
        """A job has `done` of `total` steps done."""

    def finished(self, job: Job, record: Record, *, made: bool) -> None:
        """A job's result is there: made now, or before."""

    def failed(self, job: Job) -> None:
        """A job has failed; why, is returned with what came of the others."""

    def died(self, job: Job, attempt: int) -> None:
        """The worker that did a job has died, for the `attempt`th time; the job is tried again."""


class Made(NamedTuple):
    """What came of jobs, by target: a record of each that is done, and why the others are not."""

    records: dict[Path, Record]
    failures: dict[Path, EmovidError]


def done_before(jobs: Sequence[Job], reporter: Reporter) -> dict[Path, Record]:
    """Return the records, by target, of jobs whose results are there, whole and by today's recipe; write nothing."""
    ledgers = {folder: read_ledger(folder) for folder in {job.target.parent for job in jobs}}
    records = {}
    for job in jobs:
        known = ledgers[job.target.parent].get(job.target.name)
        if known and is_current(known, job):
            records[job.target] = known
            reporter.finished(job, known, made=False)
    return records


def make_missing(jobs: Sequence[Job], reporter: Reporter, pool: Pool) -> Made:
    """Make all jobs, and record each as it is done.

    Args:
        jobs: their targets are in one folder, which is made if it is missing.
        reporter: hears of progress.
        pool: does the work, see `workers`.

    Raises:
        EmovidError: if nothing can be recorded; why a single job failed is returned.
    """
    made = Made({}, {})
    if not jobs:
        return made
    folder = jobs[0].target.parent
    make_folder(folder)
    clear_leftovers(folder)
    with Ledger(folder) as ledger:
        for job, outcome in run(make, jobs, pool, reporter.died):
            if error := _error(job, outcome):
                made.failures[job.target] = error
                reporter.failed(job)
                continue
            ledger.add(job.target.name, outcome)
            made.records[job.target] = outcome
            reporter.finished(job, outcome, made=True)
    clear_leftovers(folder)
    return made


@contextmanager
def workers(processes: int, hear: Hear = lambda *_: None, scheduler: str | None = None) -> Iterator[Pool]:
    """Give a pool: the Dask cluster of a scheduler, or so many processes, or this one if that is all.

    Args:
        processes: to use at once.
        hear: is told how items go, where that can be known.
        scheduler: its address.
    """
    if scheduler:
        with connected(scheduler) as cluster:
            yield cluster
    elif processes > 1:
        with closing(Processes(processes, hear)) as pool:
            yield pool
    else:
        yield InProcess(hear)


def _error(job: Job, outcome: Record | EmovidError) -> EmovidError | None:
    """Return why a job failed, naming its target; None if it did not."""
    if isinstance(outcome, EmovidError):
        named = str(job.target) in str(outcome)
        return outcome if named else EmovidError(f"{job.target}: {outcome}")
    if not is_by_recipe(outcome, job):
        there, here = outcome["versions"], job.recipe["versions"]
        differ = [name for name in here if there.get(name) != here[name]]
        other = "; ".join(f"{name} {there.get(name)}, here {here[name]}" for name in differ)
        return EmovidError(f"{job.target}: its worker has other versions: {other}")
    if job.only != "measure" and not job.target.exists():
        return EmovidError(f"{job.target}: made, but not here: workers must share the output folder")
    return None
