"""Workers on this machine: this process itself, or processes whose deaths do not affect each other."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import Any, NoReturn

from emovid.batch.scheduler import OnProgress
from emovid.errors import say_warnings_in_one_line
from emovid.signals import blocked_signals, held_signals, unblock_signals

_GRACE = 10.0  # seconds that a process has to undo its work
_PACE = 0.1  # seconds between two progress reports


class Stopped(BaseException):
    """Raised in a worker that receives SIGTERM, so that its unfinished work is undone."""


class InProcess:
    """This process: works on an item when it is submitted.

    Args:
        on_progress: receives the progress.
    """

    slots = attempts = 1
    deaths = ()
    is_remote = False

    def __init__(self, on_progress: OnProgress) -> None:
        self._on_progress = on_progress

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Return the finished future of `work(item, on_step)`."""
        future: Future[Any] = Future()
        try:
            future.set_result(work(item, lambda done, total: self._on_progress(item, done, total)))
        except Exception as error:
            future.set_exception(error)
        return future


class Processes:
    """Worker processes, one per slot, so that a death affects one known item.

    Args:
        slots: number of processes.
        on_progress: receives the progress, in another thread.
    """

    attempts = 3
    deaths = (BrokenProcessPool, Stopped)
    is_remote = False

    def __init__(self, slots: int, on_progress: OnProgress) -> None:
        self.slots = slots
        self._slots = [_Slot() for _ in range(slots)]
        self._on_progress = on_progress
        self._over = threading.Event()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Start `work(item, on_step)` in a free slot."""
        return next(slot for slot in self._slots if slot.is_free).submit(work, item)

    def close(self) -> None:
        """End all processes and their unfinished work."""
        with held_signals():
            self._over.set()
            self._listener.join()
            for slot in self._slots:
                slot.stop()
            for slot in self._slots:
                slot.join()

    def _listen(self) -> None:
        while not self._over.is_set():
            lines = {line: slot for slot in self._slots for line in slot.open_lines}
            ready = wait(list(lines), timeout=_PACE)
            for line in lines.keys() & ready:
                lines[line].receive(line, self._on_progress)
            if not lines:
                time.sleep(_PACE)


class _Slot:
    """A process, replaced when it dies, and the connection to it: it sends progress; closing it ends the process."""

    def __init__(self) -> None:
        self._item: Any = None
        self._number = 0  # of items
        # The submitting thread sets the first, the listening thread the second: a process may be replaced before its
        # end is noticed.
        self._line: Connection | None = None
        self._ended: Connection | None = None
        self._pool: ProcessPoolExecutor | None = None
        self._future: Future[Any] | None = None

    @property
    def open_lines(self) -> list[Connection]:
        """The connection to the process, unless it is closed."""
        line = self._line
        return [line] if line and line is not self._ended else []

    @property
    def is_free(self) -> bool:
        return self._future is None or self._future.done()

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        died = self._future is not None and isinstance(self._future.exception(), BrokenProcessPool)
        self._item, self._number, self._future = item, self._number + 1, None
        # A signal must not reach a process before it can handle it, nor this one before it knows the process.
        with held_signals(), blocked_signals():
            if self._pool is None or died:
                self._start()
            assert self._pool
            try:
                self._future = self._pool.submit(_in_worker, self._number, work, item)
            except BrokenProcessPool:  # it died while it was idle
                self._start()
                self._future = self._pool.submit(_in_worker, self._number, work, item)
        return self._future

    def receive(self, line: Connection, on_progress: OnProgress) -> None:
        """Pass on a progress report that has arrived."""
        try:
            number, done, total = line.recv()
        except (EOFError, OSError):  # the process died
            self._ended = line
        else:
            future = self._future  # None while it is being submitted
            if number == self._number and not (future and future.done()):  # otherwise the item has ended
                on_progress(self._item, done, total)

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")  # forking a process with threads can deadlock
        line, other = context.Pipe()
        self._pool = ProcessPoolExecutor(1, context, _enter_worker, (other,))
        self._line = line

    def stop(self) -> None:
        if self._line:
            self._line.close()

    def join(self) -> None:
        if self._pool:
            self._pool.shutdown(cancel_futures=True)


# --- in a worker process ---------------------------------------------------------------------------------------------

_line: Connection
_over = threading.Event()


def _enter_worker(line: Connection) -> None:
    """Set up a worker process: it ends with its parent or when told to, and ignores Ctrl-C itself."""
    global _line  # noqa: PLW0603 - a pool's initializer can leave it nowhere else
    _line = line
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    unblock_signals()
    say_warnings_in_one_line()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    with suppress(EOFError, OSError):
        _line.recv()  # the parent never sends anything; it closes the connection
    _over.set()
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_GRACE)
    os._exit(1)  # ffmpeg ends with its input; its unfinished file has a temporary name


def _on_sigterm(*_: object) -> NoReturn:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # a second signal must not interrupt the clean-up
    raise Stopped("terminated")


def _in_worker(number: int, work: Callable[..., Any], item: Any) -> Any:
    before = signal.signal(signal.SIGTERM, _on_sigterm)
    reported = 0.0

    def on_step(done: int, total: int) -> None:
        nonlocal reported
        if (now := time.monotonic()) - reported >= _PACE or done == total:
            reported = now
            with suppress(OSError):
                _line.send((number, done, total))

    try:
        return work(item, on_step)
    except Stopped:
        if _over.is_set():
            os._exit(1)  # the parent no longer waits
        raise
    finally:
        signal.signal(signal.SIGTERM, before)
