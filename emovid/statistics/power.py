"""How many participants a k-choice recognition study needs, planned for one video with one answer of each.

For m videos under Holm's correction plan with alpha / m (`holm_first`), the level of its first step: a video that
passes there passes whatever the others do.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, chi2, ncx2

# Ours: no one shows a video to more people.
MOST_PARTICIPANTS = 100_000


@dataclass(frozen=True)
class Plan:
    """Participants for a wished power.

    Attributes:
        alpha: of one video, after Holm's first step.
        chance: 1 / k.
        w: Cohen's effect size of the rate, wrong answers being spread evenly.
        n_goodness: participants for the goodness of fit; None if over `MOST_PARTICIPANTS`.
        n_binomial: participants for the exact binomial test; None if over `MOST_PARTICIPANTS`.
        critical_hits: fewest hits of `n_binomial` that are above chance.
        n: the larger of both, for a study that runs both tests.
    """

    alpha: float
    chance: float
    w: float
    n_goodness: int | None
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
    level, w = holm_first(alpha, videos), w_of_rate(rate, k)
    goodness, binomial = n_goodness(w, k, level, power), n_binomial(rate, k, level, power)
    return Plan(
        alpha=level,
        chance=1 / k,
        w=w,
        n_goodness=goodness,
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


def goodness_power(w: float, n: int, k: int = 6, alpha: float = 0.05) -> float:
    """Return the power of Pearson's goodness of fit, from the noncentral chi-squared (J. Cohen, 1988, ch. 7).

    An approximation like the test's own p, and as poor where n / k is below 5.
    """
    return float(ncx2.sf(chi2.isf(alpha, k - 1), k - 1, n * w**2))


def n_goodness(w: float, k: int = 6, alpha: float = 0.05, power: float = 0.8) -> int | None:
    """Return the smallest n of which `goodness_power` reaches `power`, None if over `MOST_PARTICIPANTS`."""
    n = np.arange(1, MOST_PARTICIPANTS + 1)
    reached = ncx2.sf(chi2.isf(alpha, k - 1), k - 1, n * w**2) >= power
    return int(n[reached.argmax()]) if reached.any() else None


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
