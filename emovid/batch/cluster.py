"""A Dask cluster as a pool of workers. Workers send their results to the client, so they need no shared folder."""

import logging
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from emovid.batch.versions import RecordKind, differences, versions
from emovid.errors import EmovidError, InputError

_PATIENCE = 10  # seconds that a scheduler may take to answer
_PACE = 1.0  # seconds between two checks for new workers
_REMINDER = 60.0  # seconds between two lines while there is no worker
_PER_THREAD = 2  # items at a worker for each of its threads, so that it never waits for the next one


@dataclass
class _Task:
    """An item at the cluster: its work, the Dask future, and the workers that may do it."""

    work: Callable[..., Any]
    item: Any
    future: Any
    workers: set[str]


class Cluster:
    """The workers of a Dask scheduler, now and later, that have the same versions as this process.

    The items of a dead worker go to the others; the scheduler gives up on an item after its own limit
    (`allowed-failures`, 3).

    Args:
        client: of Dask.
        address: of the scheduler, for messages.
        only: kind of the results.
        say: receives lines about workers.
        wait: seconds to wait for a usable worker; None for no limit.
    """

    attempts, is_remote = 1, True

    def __init__(
        self, client: Any, address: str, only: RecordKind, say: Callable[[str], None], wait: float | None
    ) -> None:
        self.deaths = (import_module("distributed").KilledWorker,)
        self._client, self._address, self._only, self._say, self._wait = client, address, only, say, wait
        self._versions = versions(only)
        self._threads: dict[str, int] = {}  # of usable workers
        self._refused: dict[str, str] = {}  # reasons, by address
        self._tasks: dict[Future[Any], _Task] = {}
        self._looked = self._said = 0.0
        self._alone_since: float | None = None

    @property
    def slots(self) -> int:
        """Number of items that may be at the workers at once.

        Raises:
            EmovidError: if there has been no usable worker for too long, or all present ones have other versions.
        """
        if time.monotonic() - self._looked >= _PACE:
            self._look()
            self._looked = time.monotonic()
        return _PER_THREAD * sum(self._threads.values())

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Start `work(item)` on a usable worker."""
        future: Future[Any] = Future()
        self._start(future, work, item)
        return future

    def _start(self, future: "Future[Any]", work: Callable[..., Any], item: Any) -> None:
        workers = set(self._threads)
        started = self._client.submit(work, item, workers=list(workers), pure=False)
        self._tasks[future] = _Task(work, item, started, workers)
        started.add_done_callback(lambda done: self._finish(future, done))

    def _finish(self, future: "Future[Any]", done: Any) -> None:
        task = self._tasks.get(future)
        if task is None or task.future is not done:
            return  # it was started again elsewhere
        del self._tasks[future]
        try:
            future.set_result(done.result())
        except BaseException as error:
            future.set_exception(error)

    def _look(self) -> None:
        """Find new workers, compare their versions, and start items again whose workers are all gone."""
        present: dict[str, int] = self._client.nthreads()
        for known in (self._threads, self._refused):
            for gone in known.keys() - present.keys():
                del known[gone]
        new = [address for address in present if address not in self._threads and address not in self._refused]
        for address, found in (
            self._client.run(versions, self._only, workers=new, on_error="return") if new else {}
        ).items():
            if reason := self._refusal(found):
                self._refused[address] = reason
                self._say(f"worker {address} is not used: {reason}")
            else:
                self._threads[address] = present[address]
        if self._threads:
            self._alone_since = None
            for future, task in [
                (f, task) for f, task in self._tasks.items() if not task.workers & self._threads.keys()
            ]:
                self._start(future, task.work, task.item)
                task.future.cancel()
        else:
            self._wait_for_workers()

    def _refusal(self, found: Any) -> str:
        """Return why a worker cannot be used, given its versions or the error that came in their place; or ""."""
        if isinstance(found, EmovidError):
            return str(found)
        if not isinstance(found, dict):
            return f"emovid cannot be imported there ({type(found).__name__}: {found})"
        return differences(found, self._versions)

    def _wait_for_workers(self) -> None:
        now = time.monotonic()
        self._alone_since = now if self._alone_since is None else self._alone_since
        if self._wait is None and self._refused:
            raise EmovidError(f"--scheduler {self._address}: no worker can be used: install the same versions there")
        if self._wait is not None and now - self._alone_since >= self._wait:
            raise EmovidError(
                f"--scheduler {self._address}: no worker within {self._wait:g} s: start some and run again"
            )
        if now - self._said >= _REMINDER:
            limit = "--wait SECONDS sets a limit" if self._wait is None else f"at most {self._wait:g} s"
            self._say(f"no workers yet at {self._address}: waiting ({limit})")
            self._said = now


@contextmanager
def connected(address: str, only: RecordKind, say: Callable[[str], None], wait: float | None) -> Iterator[Cluster]:
    """Give the cluster of the scheduler at an address such as tcp://127.0.0.1:8786; see `Cluster` for the rest.

    Raises:
        InputError: if distributed is not installed, or the address is invalid.
        EmovidError: if no scheduler answers, or it goes away.
    """
    try:
        dask: Any = import_module("distributed")
    except ImportError:
        raise InputError("--scheduler needs Dask: pip install 'emovid[dask]'") from None
    logging.disable(logging.CRITICAL)  # our own messages say the same in one line
    try:
        client: Any = dask.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (TypeError, ValueError) as error:  # the first for tls:// without certificates
        raise InputError(f"--scheduler {address}: {error}; expected as in tcp://127.0.0.1:8786") from None
    except OSError:
        raise EmovidError(f"--scheduler {address}: no Dask scheduler answers there") from None
    try:
        yield Cluster(client, address, only, say, wait)
    except (CancelledError, OSError) as error:
        if isinstance(error, OSError) and client.status == "running":
            raise
        raise EmovidError(f"--scheduler {address}: the scheduler is gone: run again to make what is missing") from None
    finally:
        with suppress(OSError, TimeoutError):
            client.close(timeout=_PATIENCE)
