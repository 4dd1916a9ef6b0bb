"""A Dask cluster as a pool. Its workers write files themselves, so they must share the output folder."""

import logging
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager
from typing import Any

from emovid.errors import EmovidError, InputError

_PATIENCE = 10  # seconds a scheduler may take to answer


class Cluster:
    """Whatever workers there are, now or later: the scheduler has all items at once.

    A dead worker's items go to the others; after the scheduler's own limit (`allowed-failures`, 3) one is given up.
    """

    slots, attempts = sys.maxsize, 1

    def __init__(self, executor: Any, deaths: tuple[type[BaseException], ...]) -> None:
        self._executor, self.deaths = executor, deaths

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Start `work(item)` on a worker."""
        return self._executor.submit(work, item)


@contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """Give the cluster of the scheduler at `address`, as in tcp://127.0.0.1:8786.

    Raises:
        InputError: if distributed is not installed, or the address is none.
        EmovidError: if no scheduler answers, or it is gone.
    """
    try:
        import distributed  # noqa: PLC0415 - an extra: not everyone has it
    except ImportError:
        raise InputError("--scheduler needs Dask: pip install 'emovid[dask]'") from None
    dask: Any = distributed  # it has no types
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what goes wrong is ours to say
    try:
        client: Any = dask.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (TypeError, ValueError) as error:  # the first where tls:// has no certificates
        raise InputError(f"--scheduler {address}: {error}; expected as in tcp://127.0.0.1:8786") from None
    except OSError:
        raise EmovidError(f"--scheduler {address}: no Dask scheduler answers there") from None
    try:
        with client.get_executor(pure=False) as executor:
            try:
                yield Cluster(executor, (dask.KilledWorker,))
            except BaseException:
                executor.shutdown(wait=False)  # else it would wait for all that was submitted
                raise
    except CancelledError:
        raise EmovidError(f"--scheduler {address}: the scheduler is gone: run again to make what is missing") from None
    finally:
        client.close(timeout=_PATIENCE)
