"""Orders of presentation: random, or balanced by squares; and the balance that any orders have.

A Latin square has each video once in each place. A Williams square (E. J. Williams, Aust. J. Sci. Res. A 2, 149-168,
1949) has, besides, each video once right after each other one, so that what one video does to the next averages out.
For an odd number of videos this construction gives no single square, and for 3, 5 and 7 none exists: it takes a pair,
the second the mirror image of the first.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from emovid.kit.seeded_random import shuffled

Scheme = Literal["random", "latin", "williams"]
Order = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Balance:
    """How often what was shown where.

    Attributes:
        videos: in the order of the tables.
        places: (videos, places), how often each video stood in each place.
        pairs: (videos, videos), how often the column's video came right after the row's.
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
        """The least and the largest count in `pairs`, a video after itself left out."""
        return _range(self.pairs[~np.eye(len(self.videos), dtype=bool)])

    @property
    def places_spread(self) -> int:
        """The largest difference of two counts in `places`."""
        least, most = self.places_range
        return most - least

    @property
    def pairs_spread(self) -> int:
        """The largest difference of two counts in `pairs`, a video after itself left out."""
        least, most = self.pairs_range
        return most - least


def presentation_orders(scheme: Scheme, videos: Sequence[str], participants: int, seed: int) -> list[Order]:
    """Return the order of the videos for each participant; more participants begin with the orders of fewer.

    Each square has its rows shuffled and its videos named anew, so that an order does not tell the next one.
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
    """Return how many participants make the orders' counts equal; 1 for random orders, which promise nothing."""
    return sum(map(len, _halves(scheme, videos)))


def largest_spread(scheme: Scheme, videos: int, participants: int) -> tuple[int | None, int | None]:
    """Return by how much counts of places and of ordered pairs may differ; None where the scheme does not say.

    After a part of a square they differ by one. In the first half of a pair of squares some ordered pairs occur twice,
    and the others not yet: there it is two, and cannot be less, since for 3, 5 and 7 videos no single square has all.
    """
    if scheme == "random":
        return None, None
    part = participants % square_size(scheme, videos) != 0
    pairs = None if scheme == "latin" else part * (1 + videos % 2)
    return int(part), pairs


def balance_of(orders: Sequence[Sequence[str]], videos: Sequence[str], places: int = 0) -> Balance:
    """Return the balance of orders, of which some may be shorter than others: an empty text is a video not shown.

    The table of places has as many columns as the longest order has places, and `places` at least.
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


def williams_square(n: int) -> list[list[int]]:
    """Return the rows of a Williams square of n videos: n of them, or 2 n where n is odd.

    Row i is the zigzag 0, 1, n-1, 2, n-2, ... shifted by i: neighbours differ by +1, -2, +3, ..., which for an even n
    are all the differences there are.
    """
    zigzag = [(place + 1) // 2 if place % 2 else (n - place // 2) % n for place in range(n)]
    rows = [[(step + i) % n for step in zigzag] for i in range(n)]
    return rows if n % 2 == 0 else [*rows, *(row[::-1] for row in rows)]


def _range(counts: NDArray[np.int64]) -> tuple[int, int]:
    return (int(counts.min()), int(counts.max())) if counts.size else (0, 0)


def _halves(scheme: Scheme, n: int) -> list[list[list[int]]]:
    """Return a square in the parts that are used up one after the other, each with every video once in every place."""
    if scheme == "random":
        return [[list(range(n))]]
    if scheme == "latin":
        return [[[(place + i) % n for place in range(n)] for i in range(n)]]
    rows = williams_square(n)
    return [rows[i : i + n] for i in range(0, len(rows), n)]
