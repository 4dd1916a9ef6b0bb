"""Goodness of fit: whether the answers to the videos of an emotion are spread evenly over the labels.

One answer of each participant makes independent answers; several are permuted over the labels together. A rejection
says that the answers are not uniform, not that the emotion was recognized: a wrong label that everyone gives rejects as
well (`recognition` asks the other question).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, gammaln

# Ours: a third of a second. Six labels reach it at n = 144, twelve at n = 70.
MOST_PARTITIONS = 1_000_000
# Ours: the standard error of a p of 0.05 is then 0.002.
DRAWS = 9_999
_BATCH = 2_000_000  # permuted values at once


@dataclass(frozen=True)
class Goodness:
    """Answers to the videos of one emotion against equal shares of all labels.

    Attributes:
        n: answers.
        statistic: Pearson's chi-squared; where participants gave several answers, the quadratic permutation statistic,
            which is Pearson's where each gave one.
        dof: its degrees of freedom, one less than there are labels.
        p: from the chi-squared distribution, poor where `expected` is below 5 (Cochran 1954); NaN with fewer than two
            answers.
        p_exact: probability, under equal shares, of a statistic at least as large; an estimate if `draws` is not 0.
        method: of `p_exact`, "exact" or "Monte Carlo" (multinomial samples, or permutations of each participant's
            answers over the labels).
        draws: Monte Carlo samples.
        seed: of the samples, None for an exact p.
        cohens_w: effect size, NaN without answers.
        expected: answers per label under equal shares.
        participants: who gave several answers each, so that `statistic` is not Pearson's; None for one answer each.
    """

    n: int
    statistic: float
    dof: int
    p: float
    p_exact: float
    method: str
    draws: int
    seed: int | None
    cohens_w: float
    expected: float
    participants: int | None = None


def goodness_of_fit(counts: NDArray[np.int64], seed: int = 0, uses: NDArray[np.int64] | None = None) -> Goodness:
    """Return Pearson's test of `counts` (k,) against equal shares.

    The exact p orders outcomes by the statistic, as R's chisq.test(simulate.p.value = TRUE) does, and not by their
    probability: the two orders differ. Above `MOST_PARTITIONS` it is estimated from `DRAWS` samples.

    Args:
        counts: answers by label.
        seed: of the samples.
        uses: answers by participant and label (participants, k), which add up to `counts`; needed where participants
            gave several answers.
    """
    k, n = len(counts), int(counts.sum())
    several = uses is not None and bool((uses.sum(axis=1) > 1).any())
    exact = not several and partitions(n, k) <= MOST_PARTITIONS
    statistic, p, p_exact = float("nan"), float("nan"), float("nan")
    if several:
        assert uses is not None
        statistic, p_exact = _permuted(uses, np.random.default_rng(seed))
    elif n > 1:  # a single answer is as uneven as any
        statistic = float((counts**2).sum() * k / n - n)
        p_exact = exact_p(counts) if exact else monte_carlo_p(counts, np.random.default_rng(seed))
    if n and not np.isnan(statistic):
        p = float(chdtrc(k - 1, max(statistic, 0.0)))
    return Goodness(
        n=n,
        statistic=statistic,
        dof=k - 1,
        p=p,
        p_exact=p_exact,
        method="exact" if exact else "Monte Carlo",
        draws=0 if exact else DRAWS,
        seed=None if exact else seed,
        cohens_w=cohens_w(float((counts**2).sum() * k / max(n, 1) - n), n),
        expected=n / k,
        participants=int(uses.any(axis=1).sum()) if several and uses is not None else None,
    )


def _permuted(uses: NDArray[np.int64], rng: np.random.Generator) -> tuple[float, float]:
    """Return the quadratic statistic of label totals, and its p when each participant's uses are permuted over labels.

    Participants who give all labels equally often say nothing. With fewer than two others both numbers are NaN: all
    permutations of one participant's answers are as uneven as they are.
    """
    totals, scale = uses.sum(axis=0), float(uses.var(axis=1, ddof=1).sum())
    if (np.ptp(uses, axis=1) > 0).sum() < 2:
        return float("nan"), float("nan")
    at_least, most = 0, (totals**2).sum()
    batch = max(1, _BATCH // uses.size)
    for first in range(0, DRAWS, batch):
        many = min(batch, DRAWS - first)
        shuffled = rng.permuted(np.broadcast_to(uses, (many, *uses.shape)), axis=2).sum(axis=1)
        at_least += int(((shuffled**2).sum(axis=1) >= most).sum())
    return float(((totals - totals.mean()) ** 2).sum() / scale), (1 + at_least) / (1 + DRAWS)


def cohens_w(statistic: float, n: int) -> float:
    """Return sqrt(statistic / n): 0.1 small, 0.3 medium, 0.5 large (J. Cohen, 1988); it can exceed 1."""
    return float(np.sqrt(statistic / n)) if n else float("nan")


def exact_p(counts: NDArray[np.int64]) -> float:
    """Return the exact p of `counts` (k,) under equal shares.

    There the statistic is k / n times the sum of squared counts, less n: outcomes are ordered by that sum, an integer,
    so that ties are exact.
    """
    sums, tail = tail_of_squares(int(counts.sum()), len(counts))
    return float(tail[np.searchsorted(sums, (counts**2).sum())])


def monte_carlo_p(counts: NDArray[np.int64], rng: np.random.Generator, draws: int = DRAWS) -> float:
    """Return (1 + samples at least as extreme) / (1 + draws): never 0 (A. Davison and D. Hinkley, 1997, ch. 4)."""
    samples = rng.multinomial(counts.sum(), np.full(len(counts), 1 / len(counts)), size=draws)
    return float((1 + ((samples**2).sum(axis=1) >= (counts**2).sum()).sum()) / (1 + draws))


@cache
def partitions(n: int, k: int) -> int:
    """Return in how many ways n is a sum of at most k parts, order aside; `MOST_PARTITIONS` + 1 where more."""
    if k > 1 and n // 2 >= MOST_PARTITIONS:  # two parts alone are n // 2 + 1 ways; spares arrays of huge n
        return MOST_PARTITIONS + 1
    ways = np.ones(n + 1, dtype=np.int64)
    for part in range(2, k + 1):  # as many as there are with parts of at most k (the conjugate partitions)
        for first in range(part):
            ways[first::part] = np.minimum(np.cumsum(ways[first::part]), MOST_PARTITIONS + 1)
    return int(ways[n])


@cache
def tail_of_squares(n: int, k: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the sums of squares that k counts of n answers can have, ascending, and P(at least as large).

    Equal shares make all orders of the counts equally likely, so only partitions of n into at most k parts are listed,
    largest part first: each weighs n! / prod(part!) outcomes times k! / prod(multiplicity!) orders.
    """
    left, cap, run, squares = (np.array([start]) for start in (n, n, 0, 0))
    log_weight = np.array([gammaln(n + 1) + gammaln(k + 1) - n * np.log(k)])
    for cells in range(k, 0, -1):
        least = -(-left // cells)
        choices = np.minimum(cap, left) - least + 1
        parent = np.repeat(np.arange(len(left)), choices)
        part = np.arange(len(parent)) - np.repeat(np.cumsum(choices) - choices, choices) + least[parent]
        run = np.where(part == cap[parent], run[parent] + 1, 1)
        log_weight = log_weight[parent] - gammaln(part + 1) - np.log(run)
        left, cap, squares = left[parent] - part, part, squares[parent] + part**2
    sums, place = np.unique(squares, return_inverse=True)
    probability = np.zeros(len(sums))
    np.add.at(probability, place, np.exp(log_weight))
    tail = probability[::-1].cumsum()[::-1]
    return sums, tail / tail[0]
