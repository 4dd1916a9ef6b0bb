"""Pools of this machine: the process itself, and processes that may die without harm to each other."""

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

from emovid.batch.pool import Hear
from emovid.errors import say_warnings_in_one_line
from emovid.signals import blocked_signals, held_signals, unblock_signals

_GRACE = 10.0  # seconds a process has to undo what it does
_PACE = 0.1  # seconds between two reports


class Stopped(BaseException):
    """Raised in a process that is terminated, so that what is under way is undone."""


class InProcess:
    """Does an item when it is submitted.

    Args:
        hear: is told how it goes.
    """

    slots = attempts = 1
    deaths = ()

    def __init__(self, hear: Hear) -> None:
        self._hear = hear

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Return the future of `work(item, on_step)`, which is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(work(item, lambda done, total: self._hear(item, done, total)))
        except Exception as error:
            future.set_exception(error)
        return future


class Processes:
    """Processes, one for each slot: a death ends one item, and it is known which.

    Args:
        slots: how many.
        hear: is told how items go, in another thread.
    """

    attempts = 3
    deaths = (BrokenProcessPool, Stopped)

    def __init__(self, slots: int, hear: Hear) -> None:
        self.slots = slots
        self._slots = [_Slot() for _ in range(slots)]
        self._hear = hear
        self._over = threading.Event()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Start `work(item, on_step)` in a slot that is free."""
        return next(slot for slot in self._slots if slot.is_free).submit(work, item)

    def close(self) -> None:
        """End all processes, and with them what is under way."""
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
                lines[line].hear(line, self._hear)
            if not lines:
                time.sleep(_PACE)


class _Slot:
    """A process, replaced once it has died, and the line to it: reports come in, and its end is the order to stop."""

    def __init__(self) -> None:
        self._item: Any = None
        self._number = 0  # of items
        # The first is set where items are submitted, the second where reports are heard: a process may be replaced
        # while its end is being noticed.
        self._line: Connection | None = None
        self._ended: Connection | None = None
        self._pool: ProcessPoolExecutor | None = None
        self._future: Future[Any] | None = None

    @property
    def open_lines(self) -> list[Connection]:
        """The line to the process, or none if nothing can come in."""
        line = self._line
        return [line] if line and line is not self._ended else []

    @property
    def is_free(self) -> bool:
        return self._future is None or self._future.done()

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        died = self._future is not None and isinstance(self._future.exception(), BrokenProcessPool)
        self._item, self._number, self._future = item, self._number + 1, None
        # A process must not be interrupted before it can handle that, nor we before it is known.
        with held_signals(), blocked_signals():
            if self._pool is None or died:
                self._start()
            assert self._pool
            try:
                self._future = self._pool.submit(_in_worker, self._number, work, item)
            except BrokenProcessPool:  # it has died with nothing to do
                self._start()
                self._future = self._pool.submit(_in_worker, self._number, work, item)
        return self._future

    def hear(self, line: Connection, hear: Hear) -> None:
        """Pass on a report that has come."""
        try:
            number, done, total = line.recv()
        except (EOFError, OSError):  # it has died
            self._ended = line
        else:
            future = self._future  # none while it is being submitted
            if number == self._number and not (future and future.done()):  # else it is over
                hear(self._item, done, total)

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
    """Set up a worker process: it ends when its parent says so or is gone, not by a Ctrl-C of its own."""
    global _line  # noqa: PLW0603 - a pool's initializer can leave it nowhere else
    _line = line
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    unblock_signals()
    say_warnings_in_one_line()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    with suppress(EOFError, OSError):
        _line.recv()  # nothing ever comes, but the end
    _over.set()
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_GRACE)
    os._exit(1)  # ffmpeg sees its input end; what it leaves has no final name


def _on_sigterm(*_: object) -> NoReturn:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # nothing may tear what is being undone
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
            os._exit(1)  # nobody waits for an answer
        raise
    finally:
        signal.signal(signal.SIGTERM, before)
