"""The one way in which many items are worked on, wherever that is: bounded in what is under way and in how often."""

import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any, TypeVar

from emovid.batch.pool import OnStep, Pool
from emovid.errors import EmovidError, reason

Item = TypeVar("Item")
OnDeath = Callable[[Any, int], None]  # is told of an item whose worker died, and which attempt that was


def run(
    work: Callable[..., Any],
    items: Iterable[Item],
    pool: Pool,
    on_death: OnDeath = lambda *_: None,
) -> Iterator[tuple[Item, Any]]:
    """Yield each item as it ends with what `work(item, on_step)` returned, or with the `EmovidError` that says why not.

    An item whose worker dies is tried again, as often as the pool says; the others are not touched.
    """
    waiting = deque((item, 1) for item in items)
    running: dict[Future[Any], tuple[Item, int]] = {}
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    while waiting or running:
        while waiting and len(running) < pool.slots:
            item, attempt = waiting.popleft()
            future = pool.submit(partial(_attempt, work), item)
            running[future] = (item, attempt)
            future.add_done_callback(done.put)
        future = done.get()
        item, attempt = running.pop(future)
        outcome = _outcome(future, pool)
        if outcome is not None:
            yield item, outcome
        elif attempt < pool.attempts:
            waiting.append((item, attempt + 1))
            on_death(item, attempt)
        else:
            yield item, EmovidError("its worker died each time: killed, or out of memory")


def _outcome(future: "Future[Any]", pool: Pool) -> Any:
    """Return what a future came to, or the error that says why not, or None if its worker has died."""
    try:
        return future.result()
    except EmovidError as error:
        return error
    except pool.deaths:
        return None


def _attempt(work: Callable[..., Any], item: Any, on_step: OnStep | None = None) -> Any:
    """Do an item where the work is done, and say there what went wrong."""
    try:
        return work(item, on_step)
    except Exception as error:
        raise _failure(error) from None


def _failure(error: Exception) -> EmovidError:
    """Return what ended one item, in one line; what should not have happened with the place where it did."""
    if isinstance(error, EmovidError):
        return error
    if isinstance(error, MemoryError):
        return EmovidError("not enough memory: fewer robots, a longer control_period or a shorter duration need less")
    if isinstance(error, OSError):
        return EmovidError(reason(error))
    where = traceback.extract_tb(error.__traceback__)
    place = f", at {Path(where[-1].filename).name}:{where[-1].lineno}" if where else ""
    return EmovidError(" ".join(f"unexpected {type(error).__name__}: {error}{place}".split()))
