"""Small batches: all items of a sweep, their jobs, and a silent reporter."""

from pathlib import Path

from emovid.batch.job import Job, Record
from emovid.batch.sweep import Item, Items
from emovid.batch.sweep_file import Sweep
from emovid.errors import EmovidError


class Silent:
    """A reporter that keeps its reports."""

    def __init__(self) -> None:
        self.made: list[str] = []
        self.kept: list[str] = []
        self.errors: list[str] = []
        self.notes: list[str] = []

    def advanced(self, job: Job, done: int, total: int) -> None: ...

    def finished(self, job: Job, record: Record, *, made: bool) -> None:
        (self.made if made else self.kept).append(job.target.name)

    def failed(self, job: Job, error: EmovidError) -> None:
        self.errors.append(str(error))

    def died(self, job: Job, attempt: int) -> None: ...

    def noted(self, line: str) -> None:
        self.notes.append(line)


def items(sweep: Sweep) -> list[Item]:
    """Return the items of a sweep, each validated."""
    all_of_them = Items(sweep)
    return list(all_of_them.expand(range(1, len(all_of_them) + 1)))


def jobs(sweep: Sweep, folder: Path) -> list[Job]:
    """Return the jobs of a sweep."""
    return [Items(sweep).job(folder, item) for item in items(sweep)]
