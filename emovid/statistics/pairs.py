"""Two groups side by side: a difference, its interval, a bound of equivalence and a Bayes factor."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import betaln
from scipy.stats import norm
from scipy.stats import t as student
from statsmodels.stats.proportion import confint_proportions_2indep

# Scale of the Cauchy prior on the standardised difference: R. Morey and J. Rouder's BayesFactor, "medium".
_PRIOR_SCALE = np.sqrt(0.5)

_NO_SPREAD = 1e-12  # of scores: rounding errors of equal ones


@dataclass(frozen=True)
class Pair:
    """Two groups side by side.

    Attributes:
        levels: the two groups, the second is subtracted.
        difference: of rates, or of mean scores; NaN where a group has no answers.
        ci_low, ci_high: 95 % interval.
        bound: smallest margin within which the two are equivalent at 5 %, by two one-sided tests; NaN if unknown.
        bf01: how much likelier the answers are under no difference (over 1) than under one (below 1).
    """

    levels: tuple[str, str]
    difference: float
    ci_low: float
    ci_high: float
    bound: float
    bf01: float


def rate_pair(levels: tuple[str, str], hits: tuple[int, int], n: tuple[int, int]) -> Pair:
    """Return two rates side by side: the difference, R. Newcombe's interval (1998, method 10), bound and BF01."""
    if not all(n):
        return Pair(levels, *[float("nan")] * 5)
    low, high = newcombe(hits, n)
    bound = max(map(abs, newcombe(hits, n, 0.90)))
    return Pair(levels, hits[0] / n[0] - hits[1] / n[1], low, high, bound, rates_bf01(hits, n))


def newcombe(hits: tuple[int, int], n: tuple[int, int], confidence: float = 0.95) -> tuple[float, float]:
    """Return Newcombe's interval of hits[0] / n[0] - hits[1] / n[1], of two independent groups."""
    low, high = confint_proportions_2indep(
        hits[0], n[0], hits[1], n[1], method="newcomb", compare="diff", alpha=1 - confidence
    )
    return float(low), float(high)


def rates_bf01(hits: tuple[int, int], n: tuple[int, int]) -> float:
    """Return the Bayes factor of one rate for both groups against one for each, all uniform (H. Jeffreys, 1935)."""
    apart = sum(betaln(h + 1, m - h + 1) for h, m in zip(hits, n, strict=True))
    return float(np.exp(np.clip(betaln(sum(hits) + 1, sum(n) - sum(hits) + 1) - apart, -700, 700)))


def mean_pair(levels: tuple[str, str], a: NDArray[np.float64], b: NDArray[np.float64]) -> Pair:
    """Return two mean scores side by side, by B. Welch's interval (1947); NaN without spread or for one person."""
    difference = float(a.mean() - b.mean())
    if min(len(a), len(b)) < 2 or a.var() + b.var() < _NO_SPREAD:
        return Pair(levels, difference, *[float("nan")] * 4)
    parts = np.array([a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)])
    dof = parts.sum() ** 2 / (parts**2 / [len(a) - 1, len(b) - 1]).sum()
    half95, half90 = student.ppf([0.975, 0.95], dof) * np.sqrt(parts.sum())
    return Pair(
        levels,
        difference,
        difference - float(half95),
        difference + float(half95),
        abs(difference) + float(half90),
        means_bf01(a, b),
    )


def means_bf01(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the JZS Bayes factor of equal means (J. Rouder et al., Psychonomic Bulletin & Review 16, 2009).

    The standardised difference has a Cauchy prior; scores of few videos are coarse, so read it as a rough scale.
    """
    dof, size = len(a) + len(b) - 2, len(a) * len(b) / (len(a) + len(b))
    pooled = ((len(a) - 1) * a.var(ddof=1) + (len(b) - 1) * b.var(ddof=1)) / dof
    t2 = (a.mean() - b.mean()) ** 2 * size / pooled

    def likelihood(z: float) -> float:  # against no difference, g = (scale / z)^2 given
        wider = 1 + size * (_PRIOR_SCALE / z) ** 2
        exponent = (dof + 1) / 2 * (np.log1p(t2 / dof) - np.log1p(t2 / (wider * dof)))
        return float(2 * norm.pdf(z) * np.exp(min(exponent, 700)) / np.sqrt(wider))

    return 1 / float(quad(likelihood, 0, 12)[0])
