"""Output on a terminal: progress, tables that fit its width, and the errors of failed items.

Progress goes to stderr: bars on a terminal, one plain line per finished item elsewhere.
"""

import itertools
import os
import sys
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from math import ceil
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from rich.console import Console
from rich.measure import Measurement
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Column, Table

from emovid.errors import EmovidError

if TYPE_CHECKING:  # commands that render nothing import no drawing and no encoder
    from emovid.batch.cache import Reporter
    from emovid.batch.job import Job, Record

_NAME_WIDTH = 40  # characters of a name beside a bar
_UNLIMITED = 100_000  # columns of text, for a table that is not shown on a terminal
_REMEDY = "run again to make what is missing"


def is_interactive() -> bool:
    """Return whether stderr is a terminal that a person watches."""
    return sys.stderr.isatty() and not os.environ.get("CI") and os.environ.get("TERM") != "dumb"


def raise_failures(failures: Collection[EmovidError], count: int, items: str = "items") -> None:
    """Raise an error with the number of items out of `count` that failed, if any; reporters have printed each one."""
    if failures and count == 1:
        raise EmovidError(f"{next(iter(failures))}; {_REMEDY}")
    if failures:
        raise EmovidError(f"{len(failures)} of {count} {items} failed: {_REMEDY}")


class _Silent:
    """Reports nothing but the failures of several items; that of a single one ends the command."""

    def __init__(self, total: int) -> None:
        self.total = total

    def advanced(self, job: "Job", done: int, total: int) -> None:
        pass

    def finished(self, job: "Job", record: "Record", *, made: bool) -> None:
        pass

    def failed(self, job: "Job", error: EmovidError) -> None:  # noqa: ARG002 - see Reporter
        if self.total > 1:
            print(error, file=sys.stderr, flush=True)

    def died(self, job: "Job", attempt: int) -> None:
        pass

    def noted(self, line: str) -> None:
        pass


class _Lines(_Silent):
    """Prints a line when an item is finished.

    Args:
        total: number of items.
        say: prints a line.
        each: whether to name the items that are up to date, too; else they are only counted.
    """

    def __init__(self, total: int, say: Callable[[str], None], *, each: bool) -> None:
        self.total, self.say, self.each = total, say, each
        self.done = self.made = 0
        self.started = time.perf_counter()

    def finished(self, job: "Job", record: "Record", *, made: bool) -> None:
        self.done += 1
        self.made += made
        if made or self.each:
            self.say(f"[{self.done}/{self.total}] {job.target}: {_size(record) if made else 'up to date'}")

    def failed(self, job: "Job", error: EmovidError) -> None:  # noqa: ARG002 - see Reporter
        if self.total > 1:  # the failure of a single item ends the command
            self.say(str(error))

    def died(self, job: "Job", attempt: int) -> None:
        self.say(f"{job.target}: its worker died, attempt {attempt}; another worker tries again")

    def noted(self, line: str) -> None:
        self.say(line)

    def close(self) -> None:
        make, made = ("render", "rendered") if self.each else ("make", "made")
        if self.done == self.total and not self.made:
            self.say(f"nothing to {make}: all is up to date")
        elif self.made:
            self.say(f"{made} {self.made} in {time.perf_counter() - self.started:.1f} s")


class _Bars(_Lines):
    """Shows a bar for the total and one for each running item, below the lines of finished items."""

    def __init__(self, total: int, progress: Progress, *, each: bool) -> None:
        super().__init__(total, lambda line: progress.console.print(line, highlight=False, markup=False), each=each)
        self.progress = progress
        self.whole = progress.add_task("all", total=total, visible=total > 1)
        self.tasks: dict[Path, TaskID | None] = {}  # by target; None once it is done
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

    def failed(self, job: "Job", error: EmovidError) -> None:
        super().failed(job, error)
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


def _size(record: "Record") -> str:
    """Return the size of a result in words."""
    if record.descriptors is not None:
        return f"{len(record.descriptors)} descriptors"
    return f"{record.samples} samples" if record.frames is None else f"{record.frames} frames"


@contextmanager
def reporter(total: int, *, quiet: bool, each: bool = True) -> "Iterator[Reporter]":
    """Yield a reporter of progress for `total` items; `each` also names the items that are up to date."""
    if quiet:
        yield _Silent(total)
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
def counting(name: str, *, quiet: bool) -> Iterator[Callable[[int, int], None] | None]:
    """Yield a function to call with the steps done and their total; None without an interactive terminal."""
    if quiet or not is_interactive():
        yield None
        return
    with _progress() as progress:
        task = progress.add_task(_short(name), total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


@contextmanager
def listing(total: int, *, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Yield a function to call with the name of each finished item: a bar on a terminal, a plain line elsewhere."""
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
    """Return the end of a name or path, its most telling part, short enough to leave room for a bar."""
    return name if len(name) <= _NAME_WIDTH else f"…{name[1 - _NAME_WIDTH :]}"


def _progress() -> Progress:
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), transient=True)


def show_table(table: Table, heads: int = 1) -> None:
    """Print a table to stdout; on a terminal that is too narrow for it, in parts under each other.

    Args:
        table: if not even one column fits, its cells are folded.
        heads: how many first columns are repeated in each part.
    """
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=_UNLIMITED)
    for column in table.columns:
        column.overflow = "fold"
    for part in _parts(table, heads, console):
        console.print(part)


def _parts(table: Table, heads: int, console: Console) -> list[Table]:
    """Return the fewest parts, of about equally many columns, in which a table fits; else a part for each column."""
    first, others = table.columns[:heads], table.columns[heads:]
    parts = [table]
    for count in range(2, len(others) + 1):
        if all(_width(part, console) <= console.width for part in parts):
            break
        each = ceil(len(others) / count)
        parts = [_part(table, [*first, *others[k : k + each]]) for k in range(0, len(others), each)]
    return parts


def _width(table: Table, console: Console) -> int:
    return Measurement.get(console, console.options.update(max_width=_UNLIMITED), table).maximum


def _part(table: Table, columns: Sequence[Column]) -> Table:
    part = Table(*(column.copy() for column in columns), title=table.title, box=table.box, padding=table.padding)
    for row, cells in zip(table.rows, zip(*(column.cells for column in columns), strict=True), strict=True):
        part.add_row(*cells, end_section=row.end_section)
    return part
