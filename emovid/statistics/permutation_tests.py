"""Tests that shuffle the answers of each participant: recognition as a whole, and the effect of the order.

Arguments are as in `dependence`.
"""

from dataclasses import dataclass
from functools import cache
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from emovid.statistics.dependence import MOST_SHUFFLED
from emovid.statistics.goodness import DRAWS

# Above these many participants the sum of their hits is taken as normal: convolving would take minutes.
MOST_CONVOLVED = 2_000


@dataclass(frozen=True)
class TotalRecognition:
    """All hits against each participant's own answers, shuffled over the videos.

    Attributes:
        hits: right answers of everybody.
        n: answers.
        expected: mean of the hits when shuffled.
        p: of at least that many hits.
        method: "exact" or "normal".
    """

    hits: int
    n: int
    expected: float
    p: float
    method: str


def total_recognition(choices: NDArray[np.int64]) -> TotalRecognition:
    """Return the test of all hits that shuffles each participant's answers over the videos they answered.

    Unlike a binomial test over all answers it holds for people who give each label once, whose hits vary more than
    guesses do. Participants guess apart from each other, so their distributions of hits convolve.
    """
    hits = int((choices == np.arange(choices.shape[1])).sum())
    uses, people = np.unique(_uses(choices), axis=0, return_counts=True)
    nulls = [hit_distribution(tuple(row[1:]), row[0]) for row in uses.tolist()]
    means = np.array([np.arange(len(null)) @ null for null in nulls])
    exact = len(choices) <= MOST_CONVOLVED
    p = _convolved_tail(nulls, people, hits) if exact else _normal_tail(nulls, people, hits)
    expected = float(people @ means)
    return TotalRecognition(hits, int((choices >= 0).sum()), expected, p, "exact" if exact else "normal")


def _uses(choices: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return, per participant, the number of answers, then how often each label was given whose video was answered.

    The order of the labels does not matter to the number of hits, so they are sorted.
    """
    answered = choices >= 0
    given = (choices[:, :, None] == np.arange(choices.shape[1])).sum(axis=1) * answered
    return np.column_stack([answered.sum(axis=1), np.sort(given, axis=1)])


@cache
def hit_distribution(given: tuple[int, ...], n: int) -> NDArray[np.float64]:
    """Return the probabilities (n + 1,) of 0 ... n hits when n answers are shuffled over n videos.

    An answer hits in one video alone, so the ways to place t hits are the elementary symmetric polynomial of `given`,
    and inclusion and exclusion (rook numbers: I. Kaplansky and J. Riordan, 1946) counts the orders with exactly h.

    Args:
        given: how often each video's label is among the answers.
        n: answers.
    """
    rooks = [1] + [0] * n
    for often in given:
        rooks = [r + (often * rooks[t - 1] if t else 0) for t, r in enumerate(rooks)]
    ways = [
        sum((-1) ** (t - h) * comb(t, h) * rooks[t] * factorial(n - t) for t in range(h, n + 1)) for h in range(n + 1)
    ]
    return np.array([way / factorial(n) for way in ways])


def _convolved_tail(nulls: list[NDArray[np.float64]], people: NDArray[np.int64], hits: int) -> float:
    """Return the probability of at least `hits` in all, from each null and how many people have it."""
    total = np.ones(1)
    for null, often in zip(nulls, people, strict=True):
        for _ in range(often):
            total = np.convolve(total, null)
    return min(1.0, float(total[hits:].sum()))


def _normal_tail(nulls: list[NDArray[np.float64]], people: NDArray[np.int64], hits: int) -> float:
    """Return the normal approximation of `_convolved_tail`, with a correction for continuity."""
    values = [np.arange(len(null)) for null in nulls]
    means = np.array([value @ null for value, null in zip(values, nulls, strict=True)])
    squares = np.array([value**2 @ null for value, null in zip(values, nulls, strict=True)])
    mean, spread = people @ means, np.sqrt(people @ (squares - means**2))
    return float(norm.sf((hits - 0.5 - mean) / spread)) if spread else 1.0


@dataclass(frozen=True, eq=False)
class Order:
    """Whether hits come with the place of a video in a participant's order.

    Attributes:
        hits, n: right answers and answers at the 1st, 2nd, ... position.
        slope: change of the hit rate per position, after the videos' own rates; NaN where `p` is.
        p: two-sided, of a slope as far from 0 when each participant's positions are shuffled; NaN where the order was
            the same for all, which leaves position and video one.
        method: "permutation" or "normal".
        draws, seed: of the shuffles; 0 and None for "normal".
    """

    hits: NDArray[np.int64]
    n: NDArray[np.int64]
    slope: float
    p: float
    method: str
    draws: int
    seed: int | None


def order_effect(choices: NDArray[np.int64], positions: NDArray[np.int64], seed: int = 0) -> Order:
    """Return whether participants get better or worse along their order, by shuffling each one's positions.

    A randomisation test, since a study like this draws the orders: it needs no model of how answers of a person
    depend on each other, while a GEE has too small standard errors for few participants and none at all when every
    answer is a hit. Orders from a square, not from all, are taken as if from all. Hits are compared with the rate of
    their video, lest an uneven order of hard videos look like fatigue.

    Args:
        choices: (participants, signalled).
        positions: (participants, signalled) from 1, -1 where unknown.
        seed: of the shuffles.
    """
    known = (choices >= 0) & (positions >= 1)
    hit = (choices == np.arange(choices.shape[1])) & known
    n = np.bincount(positions[known])[1:]
    beyond = np.where(known, hit - hit.sum(axis=0) / np.maximum(known.sum(axis=0), 1), 0.0)
    groups = [_compact(beyond, positions, known, count) for count in range(2, choices.shape[1] + 1)]
    shuffled = len(choices) <= MOST_SHUFFLED
    slope, p = _slope(groups, shuffled, seed)
    if all(len(np.unique(column[there])) < 2 for column, there in zip(positions.T, known.T, strict=True)):
        slope = p = float("nan")
    return Order(
        hits=np.bincount(positions[hit], minlength=len(n) + 1)[1:],
        n=n,
        slope=slope,
        p=p,
        method="permutation" if shuffled else "normal",
        draws=DRAWS if shuffled else 0,
        seed=seed if shuffled else None,
    )


def _compact(
    beyond: NDArray[np.float64], positions: NDArray[np.int64], known: NDArray[np.bool_], count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return residual hits and positions (participants, count), centred, of those with `count` known answers."""
    rows = known.sum(axis=1) == count
    chosen = known & rows[:, None]
    y, x = beyond[chosen].reshape(-1, count), positions[chosen].reshape(-1, count).astype(np.float64)
    return y - y.mean(axis=1, keepdims=True), x - x.mean(axis=1, keepdims=True)


def _slope(
    groups: list[tuple[NDArray[np.float64], NDArray[np.float64]]], shuffled: bool, seed: int
) -> tuple[float, float]:
    """Return the least-squares slope within participants and its two-sided p, by shuffles or the normal curve."""
    total, squares = sum((y * x).sum() for y, x in groups), sum((x**2).sum() for _, x in groups)
    variance = sum(((y**2).sum(axis=1) * (x**2).sum(axis=1)).sum() / (x.shape[1] - 1) for y, x in groups)
    if not squares or not variance:
        return 0.0, 1.0
    if not shuffled:
        return float(total / squares), float(2 * norm.sf(abs(total) / np.sqrt(variance)))
    rng, near = np.random.default_rng(seed), 1e-9 * np.sqrt(variance)  # sums in another order may differ by rounding
    draws = [abs(sum((rng.permuted(y, axis=1) * x).sum() for y, x in groups)) for _ in range(DRAWS)]
    return float(total / squares), float((1 + (np.array(draws) >= abs(total) - near).sum()) / (1 + DRAWS))
