"""Orders of presentation, random or balanced by squares, and the balance of any orders.

A Latin square has each video once in each position. A Williams square (E. J. Williams, Aust. J. Sci. Res. A 2, 149-168,
1949) also has each video once immediately after each other video, so that carry-over effects average out. For an odd
number of videos the construction needs two squares, the second with reversed rows (for 3, 5 and 7 videos no single
square exists).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from emovid.kit.seeded_random import shuffled

Scheme = Literal["random", "latin", "williams"]
Order = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Balance:
    """Counts of positions and of neighbors in some orders.

    Attributes:
        videos: in the order of the tables.
        places: (videos, positions), how often each video had each position.
        pairs: (videos, videos), how often the video of the column came immediately after that of the row.
    """

    videos: Order
    places: NDArray[np.int64]
    pairs: NDArray[np.int64]

    @property
    def places_range(self) -> tuple[int, int]:
        """The least and the largest count in `places`."""
        return _range(self.places)

    @property
    def pairs_range(self) -> tuple[int, int]:
        """The least and the largest count in `pairs` without its diagonal."""
        return _range(self.pairs[~np.eye(len(self.videos), dtype=bool)])

    @property
    def places_spread(self) -> int:
        """The largest difference of two counts in `places`."""
        least, most = self.places_range
        return most - least

    @property
    def pairs_spread(self) -> int:
        """The largest difference of two counts in `pairs` without its diagonal."""
        least, most = self.pairs_range
        return most - least

    def facts(self) -> dict[str, Any]:
        """Return everything in plain types."""
        (places_least, places_most), (pairs_least, pairs_most) = self.places_range, self.pairs_range
        return {
            "videos": list(self.videos),
            "places": self.places.tolist(),
            "neighbours": self.pairs.tolist(),
            "places_least": places_least,
            "places_most": places_most,
            "neighbours_least": pairs_least,
            "neighbours_most": pairs_most,
        }


def presentation_orders(scheme: Scheme, videos: Sequence[str], participants: int, seed: int) -> list[Order]:
    """Return the order of the videos for each participant; the orders of fewer participants are their beginning.

    Rows are shuffled and videos reassigned in each square, so that one order does not predict the next.
    """
    orders: list[Order] = []
    square = 0
    while len(orders) < participants:
        names = shuffled(videos, seed, "order", square)
        for half, rows in enumerate(_halves(scheme, len(videos))):
            orders += [tuple(names[i] for i in row) for row in shuffled(rows, seed, "rows", square, half)]
        square += 1
    return orders[:participants]


def square_size(scheme: Scheme, videos: int) -> int:
    """Return the number of participants after which all counts are equal; 1 for random orders, which are not."""
    return sum(map(len, _halves(scheme, videos)))


def largest_spread(scheme: Scheme, videos: int, participants: int) -> tuple[int | None, int | None]:
    """Return the largest difference of counts of positions and of ordered pairs; None where the scheme has no limit.

    Within a square it is one. Within the first of two squares some pairs occur twice and others not yet: there it is
    two.
    """
    if scheme == "random":
        return None, None
    part = participants % square_size(scheme, videos) != 0
    pairs = None if scheme == "latin" else part * (1 + videos % 2)
    return int(part), pairs


def balance_of(orders: Sequence[Sequence[str]], videos: Sequence[str], places: int = 0) -> Balance:
    """Return the balance of orders, possibly of different lengths; an empty text is a video that was not shown.

    The table of positions has as many columns as the longest order has positions, and at least `places`.
    """
    number = {video: i for i, video in enumerate(videos)}
    longest = max([places, *map(len, orders)])
    at = np.zeros((len(videos), longest), dtype=np.int64)
    after = np.zeros((len(videos), len(videos)), dtype=np.int64)
    for order in orders:
        for place, video in enumerate(order):
            if video in number:
                at[number[video], place] += 1
        for first, second in pairwise(order):
            if first in number and second in number:
                after[number[first], number[second]] += 1
    return Balance(tuple(videos), at, after)


def sets_of(orders: Iterable[Order]) -> dict[Order, list[Order]]:
    """Return the orders by the set of videos that they show, each set sorted."""
    found: dict[Order, list[Order]] = {}
    for order in orders:
        found.setdefault(tuple(sorted(order)), []).append(order)
    return found


def williams_square(n: int) -> list[list[int]]:
    """Return the rows of a Williams square of n videos: n of them, or 2 n for odd n.

    Row i is the zigzag 0, 1, n-1, 2, n-2, ... shifted by i: neighbors differ by +1, -2, +3, ..., which for an even n
    are all possible differences.
    """
    zigzag = [(place + 1) // 2 if place % 2 else (n - place // 2) % n for place in range(n)]
    rows = [[(step + i) % n for step in zigzag] for i in range(n)]
    return rows if n % 2 == 0 else [*rows, *(row[::-1] for row in rows)]


def _range(counts: NDArray[np.int64]) -> tuple[int, int]:
    return (int(counts.min()), int(counts.max())) if counts.size else (0, 0)


def _halves(scheme: Scheme, n: int) -> list[list[list[int]]]:
    """Return a square in parts that are used one after the other, each with every video once in every position."""
    if scheme == "random":
        return [[list(range(n))]]
    if scheme == "latin":
        return [[[(place + i) % n for place in range(n)] for i in range(n)]]
    rows = williams_square(n)
    return [rows[i : i + n] for i in range(0, len(rows), n)]
