"""The scheduler: hands items to a pool of workers, a bounded number at once, and retries items whose worker died."""

import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Protocol, TypeVar

from emovid.errors import EmovidError, reason

Item = TypeVar("Item")
OnStep = Callable[[int, int], None]  # receives the steps done and their total
OnProgress = Callable[[Any, int, int], None]  # receives an item, its steps done and their total
OnDeath = Callable[[Any, int], None]  # receives an item whose worker died, and the number of the attempt
_PACE = 0.2  # seconds between two checks for new workers and new items


class Pool(Protocol):
    """Workers: this process, processes of this machine, or a Dask cluster."""

    @property
    def slots(self) -> int:
        """Number of items that may run at once; 0 while there is no worker."""

    @property
    def attempts(self) -> int:
        """Number of attempts at an item whose worker dies."""

    @property
    def deaths(self) -> tuple[type[BaseException], ...]:
        """Exceptions of a future whose worker died."""

    @property
    def is_remote(self) -> bool:
        """True if the workers may lack access to the folders of this process."""

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Start `work(item, on_step)`; `on_step` may be None."""


def run(
    work: Callable[..., Any],
    items: Iterable[Item | None],
    pool: Pool,
    on_death: OnDeath = lambda *_: None,
) -> Iterator[tuple[Item, Any]]:
    """Yield each item when it ends, with the result of `work(item, on_step)` or the `EmovidError` that it failed with.

    An item whose worker dies is tried again, up to `pool.attempts` times; other items are not affected.

    Args:
        work: to do.
        items: taken one by one when a worker is free; None stands for an item that cannot start yet.
        pool: of workers.
        on_death: receives items whose worker died.
    """
    source, again = iter(items), deque[tuple[Item, int]]()
    running: dict[Future[Any], tuple[Item, int]] = {}
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    is_exhausted = False
    while True:
        while len(running) < pool.slots and not (is_exhausted and not again):
            try:
                item, attempt = again.popleft() if again else (next(source), 1)
            except StopIteration:
                is_exhausted = True
                break
            if item is None:
                break
            future = pool.submit(partial(_attempt, work), item)
            running[future] = (item, attempt)
            future.add_done_callback(done.put)
        if not running:
            if is_exhausted and not again:
                return
            time.sleep(_PACE)
            continue
        try:
            future = done.get(timeout=_PACE)
        except Empty:
            continue
        item, attempt = running.pop(future)
        outcome = _outcome(future, pool)
        if outcome is not None:
            yield item, outcome
        elif attempt < pool.attempts:
            again.append((item, attempt + 1))
            on_death(item, attempt)
        else:
            yield item, EmovidError("its worker died in every attempt: killed, or out of memory")


def _outcome(future: "Future[Any]", pool: Pool) -> Any:
    """Return the result of a future, the error that it failed with, or None if its worker died."""
    try:
        return future.result()
    except EmovidError as error:
        return error
    except pool.deaths:
        return None


def _attempt(work: Callable[..., Any], item: Any, on_step: OnStep | None = None) -> Any:
    """Do the work on a worker; every failure becomes an `EmovidError`."""
    try:
        return work(item, on_step)
    except Exception as error:
        raise _failure(error) from None


def _failure(error: Exception) -> EmovidError:
    """Return an error as one line; for an unexpected one the line names the place in the code."""
    if isinstance(error, EmovidError):
        return error
    if isinstance(error, MemoryError):
        return EmovidError("not enough memory: fewer robots, a longer control_period or a shorter duration need less")
    if isinstance(error, OSError):
        return EmovidError(reason(error))
    where = traceback.extract_tb(error.__traceback__)
    place = f", at {Path(where[-1].filename).name}:{where[-1].lineno}" if where else ""
    return EmovidError(" ".join(f"unexpected {type(error).__name__}: {error}{place}".split()))
