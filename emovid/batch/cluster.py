"""A Dask cluster as a pool of workers, which must share the output folder."""

import logging
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from emovid.errors import EmovidError, InputError

_PATIENCE = 10  # seconds that a scheduler may take to answer


class Cluster:
    """All workers of a Dask scheduler, now or later: the scheduler gets all items at once.

    The items of a dead worker go to the others; the scheduler gives up on an item after its own limit
    (`allowed-failures`, 3).
    """

    slots, attempts = sys.maxsize, 1

    def __init__(self, executor: Any, deaths: tuple[type[BaseException], ...]) -> None:
        self._executor, self.deaths = executor, deaths

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Start `work(item)` on a worker."""
        return self._executor.submit(work, item)


@contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """Give the cluster of the scheduler at an address such as tcp://127.0.0.1:8786.

    Raises:
        InputError: if distributed is not installed, or the address is invalid.
        EmovidError: if no scheduler answers, or it goes away.
    """
    try:
        dask: Any = import_module("distributed")
    except ImportError:
        raise InputError("--scheduler needs Dask: pip install 'emovid[dask]'") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # our own messages say the same in one line
    try:
        client: Any = dask.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (TypeError, ValueError) as error:  # the first for tls:// without certificates
        raise InputError(f"--scheduler {address}: {error}; expected as in tcp://127.0.0.1:8786") from None
    except OSError:
        raise EmovidError(f"--scheduler {address}: no Dask scheduler answers there") from None
    try:
        with client.get_executor(pure=False) as executor:
            try:
                yield Cluster(executor, (dask.KilledWorker,))
            except BaseException:
                executor.shutdown(wait=False)  # otherwise it would wait for all submitted items
                raise
    except CancelledError:
        raise EmovidError(f"--scheduler {address}: the scheduler is gone: run again to make what is missing") from None
    finally:
        client.close(timeout=_PATIENCE)
