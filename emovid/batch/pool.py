"""What takes work: this process, processes of this machine, or a Dask cluster. All give futures."""

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Protocol

OnStep = Callable[[int, int], None]  # is told the steps done, and how many there are
Hear = Callable[[Any, int, int], None]  # is told of an item, its steps done, and how many there are


class Pool(Protocol):
    """Takes items of work."""

    @property
    def slots(self) -> int:
        """Items that may be under way at once."""

    @property
    def attempts(self) -> int:
        """How often an item is tried whose worker dies."""

    @property
    def deaths(self) -> tuple[type[BaseException], ...]:
        """What a future raises when its worker has died."""

    def submit(self, work: Callable[..., Any], item: Any) -> "Future[Any]":
        """Start `work(item, on_step)`; `on_step` is told the steps done and how many there are, or is None."""
