"""Signals at moments when they would tear something apart: held back for a while, then delivered."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_ENDING = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def held_signals() -> Iterator[None]:
    """Hold back SIGINT and SIGTERM, in Python; they act when the block is left.

    A child process that is being started could otherwise be lost: an exception out of `Popen` leaves nobody who knows
    it. Unlike a blocked signal, a held one is not inherited by such a child. Only the main thread handles signals;
    elsewhere there is nothing to hold.
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
    """Block SIGINT and SIGTERM, also in child processes started meanwhile, until these call `unblock_signals`."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def unblock_signals() -> None:
    """Let SIGINT and SIGTERM through, in a process that was started under `blocked_signals`."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
