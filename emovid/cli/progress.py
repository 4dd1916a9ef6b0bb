"""Progress on stderr: bars on a terminal, one plain line for each finished item elsewhere."""

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from emovid.batch.manifest import Record
    from emovid.batch.videos import Job, Reporter


class _Silent:
    def advanced(self, job: "Job", frames: int) -> None:
        pass

    def finished(self, job: "Job", entry: "Record", *, made: bool) -> None:
        pass


class _Lines:
    """Says when a video is done."""

    def __init__(self, total: int, say: Callable[[str], None]) -> None:
        self.total, self.say = total, say
        self.done = self.made = 0
        self.started = time.perf_counter()

    def advanced(self, job: "Job", frames: int) -> None:
        pass

    def finished(self, job: "Job", entry: "Record", *, made: bool) -> None:
        self.done += 1
        self.made += made
        self.say(f"[{self.done}/{self.total}] {job.target}: " + (f"{entry['frames']} frames" if made else "up to date"))

    def close(self) -> None:
        if self.done == self.total and not self.made:
            self.say("nothing to render: all is up to date")
        elif self.made:
            self.say(f"rendered {self.made} in {time.perf_counter() - self.started:.1f} s")


class _Bars(_Lines):
    """A bar for each video under way, and the lines above them."""

    def __init__(self, total: int, progress: "Progress") -> None:
        super().__init__(total, lambda line: progress.console.print(line, highlight=False, markup=False))
        self.progress = progress
        self.tasks: dict[object, TaskID] = {}

    def advanced(self, job: "Job", frames: int) -> None:
        if job.target not in self.tasks:
            self.tasks[job.target] = self.progress.add_task(job.target.name, total=job.scene.frames)
        self.progress.update(self.tasks[job.target], completed=frames)

    def finished(self, job: "Job", entry: "Record", *, made: bool) -> None:
        super().finished(job, entry, made=made)
        if job.target in self.tasks:
            self.progress.remove_task(self.tasks.pop(job.target))


def is_interactive() -> bool:
    """Return whether stderr is a terminal that someone watches."""
    return sys.stderr.isatty() and not os.environ.get("CI") and os.environ.get("TERM") != "dumb"


@contextmanager
def reporter(jobs: "Sequence[Job]", *, quiet: bool) -> "Iterator[Reporter]":
    """Give what reports on the making of videos."""
    if quiet:
        yield _Silent()
    elif is_interactive():
        with _progress() as progress:
            bars = _Bars(len(jobs), progress)
            yield bars
        bars.close()
    else:
        lines = _Lines(len(jobs), lambda line: print(line, file=sys.stderr, flush=True))
        yield lines
        lines.close()


@contextmanager
def counting(what: str, *, quiet: bool) -> Iterator[Callable[[int, int], None] | None]:
    """Give what is told the steps done and their total; None where nobody watches."""
    if quiet or not is_interactive():
        yield None
        return
    with _progress() as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def _progress() -> "Progress":
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), transient=True)
