"""Signals held back while an interruption would leave something half done, then delivered."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_ENDING = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def held_signals() -> Iterator[None]:
    """Hold back SIGINT and SIGTERM in Python until the block is left.

    Otherwise an exception out of `Popen` could lose the child process that was being started. Unlike a blocked signal,
    a held one is not inherited by a child. Only the main thread handles signals; in other threads this does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = {number: signal.signal(number, lambda number, _: came.append(number)) for number in _ENDING}
    try:
        yield
    finally:
        for held, handler in before.items():
            signal.signal(held, handler)
        if came:
            signal.raise_signal(came[0])


@contextmanager
def blocked_signals() -> Iterator[None]:
    """Block SIGINT and SIGTERM, also in child processes started in the block, until these call `unblock_signals`."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def unblock_signals() -> None:
    """Unblock SIGINT and SIGTERM in a process that was started under `blocked_signals`."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
