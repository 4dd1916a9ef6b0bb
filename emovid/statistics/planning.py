"""How many participants a k-choice recognition study needs, planned for one emotion with one answer of each.

For m emotions under Holm's correction plan with alpha / m (`holm_first`), the level of its first step: an emotion that
passes there passes whatever the others do.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, chi2

from emovid.statistics.goodness import partitions, tail_of_squares

# Ours: no one shows a video to more people.
MOST_PARTICIPANTS = 100_000
_MOST_EXACT = 100_000  # partitions: six labels reach it at n = 87
_SAMPLES = 20_000  # the standard error of a power of 0.8 is then 0.003
_TEETH = 4  # of the sawtooth


@dataclass(frozen=True)
class Plan:
    """Participants for the desired power.

    Attributes:
        alpha: of one video, after Holm's first step.
        chance: 1 / k.
        w: Cohen's effect size of the rate, wrong answers being spread evenly.
        n_goodness: participants for the goodness of fit; None if over `MOST_PARTICIPANTS`.
        power_goodness: with that many; NaN for None.
        goodness_error: standard error of that power: 0 where it is exact.
        n_binomial: participants for the exact binomial test; None if over `MOST_PARTICIPANTS`.
        critical_hits: fewest hits of `n_binomial` that are above chance.
        n: the larger of both, for a study that runs both tests.
    """

    alpha: float
    chance: float
    w: float
    n_goodness: int | None
    power_goodness: float
    goodness_error: float
    n_binomial: int | None
    critical_hits: int | None
    n: int | None


def plan(rate: float, k: int = 6, videos: int = 6, alpha: float = 0.05, power: float = 0.8) -> Plan:
    """Return how many participants find a video of true hit rate `rate` above chance among k labels with `power`.

    Raises:
        ValueError: a rate that is not above chance, or a probability that is not between 0 and 1.
    """
    if not 1 / k < rate <= 1:
        raise ValueError(f"a hit rate of {rate:g} is not above the chance of {1 / k:.4g} among {k} labels")
    if not (0 < alpha < 1 and 0 < power < 1):
        raise ValueError(f"alpha {alpha:g} and power {power:g} must lie between 0 and 1")
    level = holm_first(alpha, videos)
    goodness, reached, error = n_goodness(rate, k, level, power)
    binomial = n_binomial(rate, k, level, power)
    return Plan(
        alpha=level,
        chance=1 / k,
        w=w_of_rate(rate, k),
        n_goodness=goodness,
        power_goodness=reached,
        goodness_error=error,
        n_binomial=binomial,
        critical_hits=None if binomial is None else critical_hits(binomial, k, level),
        n=None if goodness is None or binomial is None else max(goodness, binomial),
    )


def holm_first(alpha: float, videos: int) -> float:
    """Return alpha / videos, the level of the smallest p (S. Holm, 1979)."""
    return alpha / videos


def w_of_rate(rate: float, k: int) -> float:
    """Return Cohen's w of one label with share `rate` and k - 1 others with equal shares of the rest."""
    return abs(rate * k - 1) / float(np.sqrt(k - 1))


def goodness_power(rate: float, n: int, k: int = 6, alpha: float = 0.05) -> tuple[float, float]:
    """Return the power of the exact goodness of fit, errors being spread evenly, and the standard error of that power.

    The power is exact, with error 0, where the test is; elsewhere it is simulated, with Pearson's critical value. The
    noncentral chi-squared (J. Cohen, 1988, ch. 7) promises too much here: 0.80 for 47 participants at a rate of 0.4
    and a level of 0.05 / 6, where the power is 0.716.
    """
    if partitions(n, k) <= _MOST_EXACT:
        sums, tail = tail_of_squares(n, k)
        rejected = tail <= alpha
        if not rejected.any():
            return 0.0, 0.0
        critical = int(sums[rejected.argmax()])
        likely = binom.pmf(np.arange(n + 1), n, rate).tolist()
        return float(sum(p * _others(n - hits, k - 1, critical - hits**2) for hits, p in enumerate(likely))), 0.0
    shares = np.array([rate] + [(1 - rate) / (k - 1)] * (k - 1))
    squares = (np.random.default_rng(n).multinomial(n, shares, size=_SAMPLES).astype(np.float64) ** 2).sum(axis=1)
    power = float((squares * k / n - n >= chi2.isf(alpha, k - 1)).mean())
    return power, float(np.sqrt(power * (1 - power) / _SAMPLES))


def _others(n: int, k: int, least: int) -> float:
    """Return the probability that n answers, spread evenly over k labels, have squared counts of at least `least`."""
    sums, tail = tail_of_squares(n, k)
    place = int(np.searchsorted(sums, least))
    return float(tail[place]) if place < len(tail) else 0.0


def n_goodness(rate: float, k: int = 6, alpha: float = 0.05, power: float = 0.8) -> tuple[int | None, float, float]:
    """Return the smallest n of which `goodness_power` reaches `power`, with that power and its error; None if too many.

    Power is a sawtooth over n, so the next few n have to reach it, too.
    """
    low, high = 0, 8
    while high <= MOST_PARTICIPANTS and goodness_power(rate, high, k, alpha)[0] < power:
        low, high = high, 2 * high
    if high > MOST_PARTICIPANTS:
        return None, float("nan"), float("nan")
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if goodness_power(rate, middle, k, alpha)[0] >= power else (middle, high)
    n = high
    while any(goodness_power(rate, n + step, k, alpha)[0] < power for step in range(_TEETH)):
        n += 1
    return n, *goodness_power(rate, n, k, alpha)


def critical_hits(n: int, k: int = 6, alpha: float = 0.05) -> int:
    """Return the fewest hits of n that the one-sided exact binomial test finds above 1 / k; n + 1 if none does."""
    return int(_critical(np.array([n]), k, alpha)[0])


def _critical(n: NDArray[np.int64], k: int, alpha: float) -> NDArray[np.int64]:
    return binom.isf(alpha, n, 1 / k).astype(np.int64) + 1


def n_binomial(rate: float, k: int = 6, alpha: float = 0.05, power: float = 0.8) -> int | None:
    """Return the smallest n from which on the exact power stays at `power` or above; None over `MOST_PARTICIPANTS`.

    Hits are whole, so power is a sawtooth over n: it reaches a value several times before it stays above it, and one
    participant who drops out would fall through an n that reaches it early.
    """
    n = np.arange(1, MOST_PARTICIPANTS + 1)
    short = np.flatnonzero(binom.sf(_critical(n, k, alpha) - 1, n, rate) < power)
    last = int(n[short[-1]]) if len(short) else 0
    return last + 1 if last < MOST_PARTICIPANTS else None
