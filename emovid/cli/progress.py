"""Progress on stderr: bars on a terminal, one plain line for each finished item elsewhere."""

import itertools
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from rich.progress import Progress, TaskID

    from emovid.batch.cache import Reporter
    from emovid.batch.job import Job, Record

_WIDEST = 40  # characters of a name beside a bar


class _Silent:
    def advanced(self, job: "Job", done: int, total: int) -> None:
        pass

    def finished(self, job: "Job", record: "Record", *, made: bool) -> None:
        pass

    def failed(self, job: "Job") -> None:
        pass

    def died(self, job: "Job", attempt: int) -> None:
        pass


class _Lines:
    """Says when an item is done.

    Args:
        total: items.
        say: a line.
        each: whether to name the items that are up to date, too; else they are counted.
    """

    def __init__(self, total: int, say: Callable[[str], None], *, each: bool) -> None:
        self.total, self.say, self.each = total, say, each
        self.done = self.made = 0
        self.started = time.perf_counter()

    def advanced(self, job: "Job", done: int, total: int) -> None:
        pass

    def finished(self, job: "Job", record: "Record", *, made: bool) -> None:
        self.done += 1
        self.made += made
        if made or self.each:
            self.say(f"[{self.done}/{self.total}] {job.target}: {_result(record) if made else 'up to date'}")

    def failed(self, job: "Job") -> None:
        pass  # all failures are said together, at the end

    def died(self, job: "Job", attempt: int) -> None:
        self.say(f"{job.target}: its worker died, attempt {attempt}; another takes over")

    def close(self) -> None:
        make, made = ("render", "rendered") if self.each else ("make", "made")
        if self.done == self.total and not self.made:
            self.say(f"nothing to {make}: all is up to date")
        elif self.made:
            self.say(f"{made} {self.made} in {time.perf_counter() - self.started:.1f} s")


class _Bars(_Lines):
    """A bar for the whole, one for each item under way, and the lines above them."""

    def __init__(self, total: int, progress: "Progress", *, each: bool) -> None:
        super().__init__(total, lambda line: progress.console.print(line, highlight=False, markup=False), each=each)
        self.progress = progress
        self.whole = progress.add_task("all", total=total, visible=total > 1)
        self.tasks: dict[Path, TaskID | None] = {}  # by target; none once it is done
        self.lock = Lock()  # reports come from another thread, some after an item has ended

    def advanced(self, job: "Job", done: int, total: int) -> None:
        with self.lock:
            if job.target not in self.tasks:
                self.tasks[job.target] = self.progress.add_task(_short(job.target.name))
            if (task := self.tasks[job.target]) is not None:
                self.progress.update(task, completed=done, total=total)

    def finished(self, job: "Job", record: "Record", *, made: bool) -> None:
        super().finished(job, record, made=made)
        self.progress.update(self.whole, completed=self.done)
        self._end(job, over=True)

    def failed(self, job: "Job") -> None:
        self._end(job, over=True)

    def died(self, job: "Job", attempt: int) -> None:
        super().died(job, attempt)
        self._end(job, over=False)

    def _end(self, job: "Job", *, over: bool) -> None:
        with self.lock:
            if (task := self.tasks.pop(job.target, None)) is not None:
                self.progress.remove_task(task)
            if over:
                self.tasks[job.target] = None


def _result(record: "Record") -> str:
    """Return the size of a result."""
    if record.descriptors is not None:
        return f"{len(record.descriptors)} descriptors"
    return f"{record.samples} samples" if record.frames is None else f"{record.frames} frames"


def is_interactive() -> bool:
    """Return whether stderr is a terminal that someone watches."""
    return sys.stderr.isatty() and not os.environ.get("CI") and os.environ.get("TERM") != "dumb"


@contextmanager
def reporter(total: int, *, quiet: bool, each: bool = True) -> "Iterator[Reporter]":
    """Give what reports on the making of so many items, those `each` named that are up to date."""
    if quiet:
        yield _Silent()
    elif is_interactive():
        with _progress() as progress:
            bars = _Bars(total, progress, each=each)
            yield bars
        bars.close()
    else:
        lines = _Lines(total, lambda line: print(line, file=sys.stderr, flush=True), each=each)
        yield lines
        lines.close()


@contextmanager
def counting(what: str, *, quiet: bool) -> Iterator[Callable[[int, int], None] | None]:
    """Give what is told the steps done and their total; None where nobody watches."""
    if quiet or not is_interactive():
        yield None
        return
    with _progress() as progress:
        task = progress.add_task(_short(what), total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


@contextmanager
def listing(total: int, *, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Give what is told of each finished item: a bar that names it on a terminal, a plain line elsewhere."""
    if quiet:
        yield lambda _: None
    elif is_interactive():
        with _progress() as progress:
            task = progress.add_task("", total=total)
            yield lambda item: progress.update(task, advance=1, description=_short(item))
    else:
        count = itertools.count(1)
        yield lambda item: print(f"[{next(count)}/{total}] {item}", file=sys.stderr, flush=True)


def _short(name: str) -> str:
    """Return the end of a name or path, which says most, where all of it would leave no room for a bar."""
    return name if len(name) <= _WIDEST else f"…{name[1 - _WIDEST :]}"


def _progress() -> "Progress":
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), transient=True)
