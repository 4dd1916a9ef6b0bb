"""Rates and their differences: intervals, exact tests, Bayes factors, and Holm's correction.

Everything is written out with `scipy.special`: importing `scipy.stats` and `statsmodels` would take longer than the
analysis of a study. Tests compare each function with theirs.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtrc, betainc, betaln, gammaln, ndtr, ndtri, stdtrit

_ROUNDING = 1e-7  # relative: tables as likely as the one found, as in R's fisher.test


def holm(p: NDArray[np.float64], tested: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
    """Return p (m,) after Holm's step-down correction (S. Holm, 1979) over those `tested`, all by default."""
    chosen = np.isfinite(p) if tested is None else tested & np.isfinite(p)
    order = np.argsort(p[chosen], kind="stable")
    steps = np.maximum.accumulate(p[chosen][order] * np.arange(len(order), 0, -1))
    adjusted = p.copy()
    adjusted[np.flatnonzero(chosen)[order]] = np.minimum(steps, 1.0)
    return adjusted


def wilson(hits: float, n: float, confidence: float = 0.95) -> tuple[float, float]:
    """Return the two-sided interval of hits / n by E. Wilson (1927); Brown, Cai and DasGupta (2001) advise it.

    Without answers it is (0, 1). Hits and n may be effective numbers (`effective_n`).
    """
    if not n:
        return 0.0, 1.0
    z2 = float(ndtri((1 + confidence) / 2)) ** 2
    middle = (hits + z2 / 2) / (n + z2)
    half = float(np.sqrt(z2 * (hits * (n - hits) / n + z2 / 4))) / (n + z2)
    return max(middle - half, 0.0) if hits else 0.0, min(middle + half, 1.0) if hits < n else 1.0


def newcombe(hits: tuple[float, float], n: tuple[float, float], confidence: float = 0.95) -> tuple[float, float]:
    """Return R. Newcombe's interval (1998, method 10) of hits[0] / n[0] - hits[1] / n[1], two independent groups."""
    rates = [h / m for h, m in zip(hits, n, strict=True)]
    (low0, high0), (low1, high1) = (wilson(h, m, confidence) for h, m in zip(hits, n, strict=True))
    difference = rates[0] - rates[1]
    return (
        difference - float(np.hypot(rates[0] - low0, high1 - rates[1])),
        difference + float(np.hypot(high0 - rates[0], rates[1] - low1)),
    )


def binomial_tail(hits: float, n: float, chance: float) -> float:
    """Return the probability of at least `hits` of n at the rate `chance`; effective numbers may be fractions."""
    if hits <= 0:
        return 1.0
    if float(hits).is_integer() and float(n).is_integer():
        return float(bdtrc(int(hits) - 1, int(n), chance))
    return float(betainc(hits, n - hits + 1, chance))


def effective_n(hits: NDArray[np.int64], n: NDArray[np.int64]) -> float:
    """Return how many independent answers the answers of participants are worth, for the interval of their rate.

    The variance of the rate between participants is compared with that of independent answers, and the number is cut
    by a t factor, since few participants tell little about that variance (E. Korn and B. Graubard, Survey Methodology
    24, 1998). It is the number of answers where each participant gives one answer, never more, and the number of
    participants where all answers hit or all miss.

    Args:
        hits: of each participant.
        n: answers of each participant.
    """
    hits, n = hits[n > 0], n[n > 0]
    total, people = int(n.sum()), len(n)
    if people == total or people < 2:
        return float(people)
    rate = hits.sum() / total
    if rate in (0.0, 1.0):
        return float(people)
    variance = people / (people - 1) * float(((hits - rate * n) ** 2).sum()) / total**2
    if not variance:
        return float(total)
    few = float(ndtri(0.975) / stdtrit(people - 1, 0.975)) ** 2
    return float(min(total, max(few * rate * (1 - rate) / variance, 1.0)))


def fisher_exact(hits: tuple[int, int], n: tuple[int, int]) -> float:
    """Return the two-sided p of R. Fisher's exact test of two rates; NaN where hits or misses are all there is."""
    total = sum(hits)
    if not all(n) or total in (0, sum(n)):
        return float("nan")
    first = np.arange(max(0, total - n[1]), min(total, n[0]) + 1)
    weights = _log_choose(n[0], first) + _log_choose(n[1], total - first)
    weights = np.exp(weights - weights.max())
    return float(min(1.0, weights[weights <= weights[hits[0] - first[0]] * (1 + _ROUNDING)].sum() / weights.sum()))


def _log_choose(n: int, taken: NDArray[np.int64]) -> NDArray[np.float64]:
    return np.asarray(gammaln(n + 1) - gammaln(taken + 1) - gammaln(n - taken + 1))


def rates_bf01(hits: tuple[int, int], n: tuple[int, int]) -> float:
    """Return the Bayes factor of one rate for both groups against one for each, all uniform (H. Jeffreys, 1935)."""
    apart = sum(betaln(h + 1, m - h + 1) for h, m in zip(hits, n, strict=True))
    return _bounded_exp(betaln(sum(hits) + 1, sum(n) - sum(hits) + 1) - apart)


def replication_bf(original: tuple[int, int], replication: tuple[int, int], chance: float) -> float:
    """Return the Bayes factor of the original's rate against guessing, from the hits and n of the replication.

    The rate has a uniform prior that the original study updates (J. Verhagen and E.-J. Wagenmakers, J. Experimental
    Psychology: General 143, 2014).
    """
    (h, n), (hits, m) = original, replication
    as_original = betaln(h + hits + 1, n - h + m - hits + 1) - betaln(h + 1, n - h + 1)
    return _bounded_exp(as_original - hits * np.log(chance) - (m - hits) * np.log1p(-chance))


def uniform_bf10(counts: NDArray[np.int64]) -> float:
    """Return the Bayes factor of unknown shares (k,), uniform on the simplex, against equal shares."""
    k, n = len(counts), int(counts.sum())
    return _bounded_exp(gammaln(counts + 1).sum() + gammaln(k) - gammaln(n + k) + n * np.log(k))


def _bounded_exp(log: float) -> float:
    return float(np.exp(np.clip(log, -700, 700)))


def sum_tail(nulls: list[NDArray[np.float64]], often: NDArray[np.int64], hits: int, exact: bool) -> float:
    """Return the probability that independent counts add up to at least `hits`.

    Args:
        nulls: distributions (n + 1,) of counts of 0 ... n.
        often: how many counts have each distribution.
        hits: the sum.
        exact: whether the distributions are convolved; else the sum counts as normal, with a correction for continuity.
    """
    if exact:
        total = np.ones(1)
        for null, times in zip(nulls, often, strict=True):
            for _ in range(times):
                total = np.convolve(total, null)
        return min(1.0, float(total[hits:].sum()))
    values = [np.arange(len(null)) for null in nulls]
    means = np.array([value @ null for value, null in zip(values, nulls, strict=True)])
    squares = np.array([value**2 @ null for value, null in zip(values, nulls, strict=True)])
    spread = np.sqrt(often @ (squares - means**2))
    return float(ndtr((often @ means - hits + 0.5) / spread)) if spread else 1.0
