"""Differences between groups of participants, and the evidence for "no difference".

Participants, not answers, are compared: the answers of one person to several videos are never pooled as independent.
Beside each difference stand its interval, a Bayes factor and, with a margin set beforehand, a test of equivalence,
since a large p alone says nothing in favor of no difference.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from emovid.statistics.goodness import DRAWS
from emovid.statistics.proportions import effective_n, fisher_exact, holm, newcombe, rates_bf01
from emovid.statistics.showings import Showings

# Ours: in a smaller group one person moves a rate by 25 points or more.
MIN_GROUP = 5
_SHUFFLED_PARTICIPANTS = 20_000_000  # in all draws together: a few seconds
_BATCH = 2_000_000  # shuffled values at once
_PRIOR_SCALE = np.sqrt(0.5)  # of the Cauchy prior of a standardized difference: "medium" in R's BayesFactor package
_NO_SPREAD = 1e-12  # of scores: rounding errors of equal ones
_NAN = float("nan")


@dataclass(frozen=True)
class Pair:
    """Two groups side by side.

    Attributes:
        levels: the two groups; the second is subtracted.
        difference: of rates, or of mean scores; NaN where a group has no answers.
        ci_low, ci_high: 95 % interval, not corrected for several comparisons.
        bound: smallest margin within which two one-sided tests at 5 % would find the groups equivalent; it describes
            the data, and is no margin to test against. NaN if unknown.
        margin: set beforehand, NaN if none was.
        equivalent: whether the two are equivalent within the margin, None without one.
        bf01: how much likelier the answers are under no difference (over 1) than under one (below 1).
    """

    levels: tuple[str, str]
    difference: float
    ci_low: float
    ci_high: float
    bound: float
    margin: float
    equivalent: bool | None
    bf01: float


@dataclass(frozen=True)
class ScoresDiffer:
    """Mean scores of groups.

    Attributes:
        levels: the groups.
        n: participants in each.
        means: of their scores.
        p: of groups at least as far apart when participants are shuffled over groups; NaN for fewer than two groups.
        p_holm: after Holm's correction over the columns that were looked at.
        method: "exact" or "Monte Carlo".
        studentized: whether the distance is B. Welch's statistic (1951), which allows groups to vary differently; else,
            with a group of one, the spread of the means.
        draws, seed: of the shuffles; 0 and None for "exact".
        pairs: each two groups.
        tiny: groups of fewer than `MIN_GROUP`.
    """

    levels: tuple[str, ...]
    n: tuple[int, ...]
    means: tuple[float, ...]
    p: float
    p_holm: float
    method: str
    studentized: bool
    draws: int
    seed: int | None
    pairs: tuple[Pair, ...]
    tiny: tuple[str, ...]


@dataclass(frozen=True)
class RatesDiffer:
    """Hits of groups on one emotion.

    Attributes:
        levels: the groups.
        hits, n: right answers and answers of each.
        p: two-sided, of `method`; NaN where nothing can differ.
        p_holm: after Holm's correction over the emotions, and over the columns that were looked at.
        method: "exact" (Fisher's test), for more than two groups with answers "Monte Carlo" (Fisher, Freeman and
            Halton's); "permutation" of participants where they gave several answers, exact or Monte Carlo.
        draws, seed: of the random tables or shuffles; 0 and None for an exact p.
        pairs: each two groups.
        tiny: groups of fewer than `MIN_GROUP` participants with answers.
    """

    levels: tuple[str, ...]
    hits: tuple[int, ...]
    n: tuple[int, ...]
    p: float
    p_holm: float
    method: str
    draws: int
    seed: int | None
    pairs: tuple[Pair, ...]
    tiny: tuple[str, ...]


def levels_of(group: Sequence[object]) -> tuple[str, ...]:
    """Return the groups that occur in `group`, sorted; a participant without a value (empty, not text) is in none."""
    return tuple(sorted({level for level in group if isinstance(level, str) and level}))


def scores_differ(
    showings: Showings, group: Sequence[object], seed: int = 0, margin: float | None = None
) -> ScoresDiffer:
    """Return whether the groups' mean scores differ, a score being the share of a participant's answers that hit.

    Args:
        showings: the answers; participants without answers are excluded.
        group: of each participant.
        seed: of the shuffles.
        margin: of equivalence, as a share.
    """
    answered = showings.choices >= 0
    hits, n = (showings.choices == showings.right).sum(axis=1), answered.sum(axis=1)
    levels, samples = _samples(hits, n, group)
    p, studentized, draws = _shuffled_means(samples, seed)
    return ScoresDiffer(
        levels=levels,
        n=tuple(map(len, samples)),
        means=tuple(float(sample.mean()) for sample in samples),
        p=p,
        p_holm=p,
        method="Monte Carlo" if draws else "exact",
        studentized=studentized,
        draws=draws,
        seed=seed if draws else None,
        pairs=tuple(
            mean_pair((levels[i], levels[j]), samples[i], samples[j], margin)
            for i, j in combinations(range(len(levels)), 2)
        ),
        tiny=_tiny(levels, list(map(len, samples))),
    )


def _samples(
    hits: NDArray[np.int64], n: NDArray[np.int64], group: Sequence[object]
) -> tuple[tuple[str, ...], list[NDArray[np.float64]]]:
    """Return the groups with answers, and the shares of hits of their participants."""
    label = np.array([level if isinstance(level, str) else "" for level in group], dtype=object)
    label[n == 0] = ""
    levels = levels_of(label.tolist())
    shares = hits / np.maximum(n, 1)
    return levels, [shares[label == level] for level in levels]


def _tiny(levels: Sequence[str], sizes: Sequence[int]) -> tuple[str, ...]:
    return tuple(level for level, size in zip(levels, sizes, strict=True) if size < MIN_GROUP)


def _shuffled_means(samples: list[NDArray[np.float64]], seed: int) -> tuple[float, bool, int]:
    """Return p of the distance between groups, whether it is studentized, and the draws: 0 if all splits are listed.

    NaN where no split differs from another: one group, equal scores, or groups of one participant each.
    """
    if len(samples) < 2 or max(map(len, samples)) < 2 or np.ptp(np.concatenate(samples)) < _NO_SPREAD:
        return _NAN, True, 0
    scores, sizes = np.concatenate(samples), list(map(len, samples))
    studentized = min(sizes) > 1
    distance = _welch if studentized else _spread_of_means
    observed = distance(scores[None], sizes)[0]
    near = observed - 1e-9 * max(1.0, abs(float(np.nan_to_num(observed, posinf=0.0))))  # sums may differ by rounding
    splits, left = 1, len(scores)
    for size in sizes[:-1]:
        splits, left = splits * comb(left, size), left - size
    if splits <= DRAWS:
        orders = np.array(list(_splits(tuple(range(len(scores))), sizes)))
        return float((distance(scores[orders], sizes) >= near).mean()), studentized, 0
    draws = min(DRAWS, max(999, _SHUFFLED_PARTICIPANTS // len(scores)))
    rng, batch, at_least = np.random.default_rng(seed), max(1, _BATCH // len(scores)), 0
    for first in range(0, draws, batch):
        many = min(batch, draws - first)
        at_least += int((distance(rng.permuted(np.tile(scores, (many, 1)), axis=1), sizes) >= near).sum())
    return (1 + at_least) / (1 + draws), studentized, draws


def _splits(people: tuple[int, ...], sizes: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Yield every way to deal people out to groups of the sizes, group after group."""
    if len(sizes) == 1:
        yield people
        return
    for chosen in combinations(people, sizes[0]):
        for others in _splits(tuple(who for who in people if who not in chosen), sizes[1:]):
            yield chosen + others


def _welch(scores: NDArray[np.float64], sizes: Sequence[int]) -> NDArray[np.float64]:
    """Return Welch's statistic of each row (rows, participants), t squared for two groups; infinite without spread."""
    n = np.array(sizes)
    starts = np.cumsum(n) - n
    means = np.add.reduceat(scores, starts, axis=1) / n
    variances = np.maximum(np.add.reduceat(scores**2, starts, axis=1) / n - means**2, 0.0) * n / (n - 1)
    variances[variances < _NO_SPREAD] = _NO_SPREAD  # a group without spread weighs most, but not all
    weights = n / variances
    middle = (weights * means).sum(axis=1, keepdims=True) / weights.sum(axis=1, keepdims=True)
    return np.asarray((weights * (means - middle) ** 2).sum(axis=1))


def _spread_of_means(scores: NDArray[np.float64], sizes: Sequence[int]) -> NDArray[np.float64]:
    n = np.array(sizes)
    sums = np.add.reduceat(scores, np.cumsum(n) - n, axis=1)
    return np.asarray((sums**2 / n).sum(axis=1))


def rates_differ(
    showings: Showings, group: Sequence[object], seed: int = 0, margin: float | None = None
) -> list[RatesDiffer]:
    """Return, for each emotion, whether the groups recognize it equally well; arguments as for `scores_differ`."""
    levels = levels_of(group)
    member = np.array([[level == mine for mine in group] for level in levels], dtype=bool).reshape(
        len(levels), len(group)
    )
    tests = [
        _rates_differ(uses[:, emotion], uses.sum(axis=1), levels, member, seed, margin)
        for emotion, uses in enumerate(showings.by_emotion())
    ]
    return [_with_holm(test, p) for test, p in zip(tests, holm(np.array([t.p for t in tests])), strict=True)]


def _with_holm(test: RatesDiffer, p_holm: float) -> RatesDiffer:
    return RatesDiffer(**(vars(test) | {"p_holm": float(p_holm)}))


def _rates_differ(
    hits: NDArray[np.int64],
    n: NDArray[np.int64],
    levels: tuple[str, ...],
    member: NDArray[np.bool_],
    seed: int,
    margin: float | None,
) -> RatesDiffer:
    """Return the test of one emotion from the hits and answers of each participant."""
    h, m = [int(hits[mine].sum()) for mine in member], [int(n[mine].sum()) for mine in member]
    worth = [effective_n(hits[mine], n[mine]) for mine in member]
    several = bool((n > 1).any())
    if several:
        samples = [hits[mine & (n > 0)] / n[mine & (n > 0)] for mine in member]
        p, _, draws = _shuffled_means([sample for sample in samples if len(sample)], seed)
        method = "permutation"
    else:
        p, method, draws = _fisher(np.array(h), np.array(m), seed)
    return RatesDiffer(
        levels=levels,
        hits=tuple(h),
        n=tuple(m),
        p=p,
        p_holm=p,
        method=method,
        draws=draws,
        seed=seed if draws else None,
        pairs=tuple(
            rate_pair(
                (levels[a], levels[b]), (h[a], h[b]), (m[a], m[b]), margin, (worth[a], worth[b]) if several else None
            )
            for a, b in combinations(range(len(levels)), 2)
        ),
        tiny=_tiny(levels, [int((mine & (n > 0)).sum()) for mine in member]),
    )


def _fisher(hits: NDArray[np.int64], n: NDArray[np.int64], seed: int) -> tuple[float, str, int]:
    """Return p of the groups' hits, those without answers left out, the method as in `RatesDiffer`, and the draws."""
    table = np.array([hits, n - hits])[:, n > 0]
    if table.shape[1] < 2 or not table.any(axis=1).all() or n.max(initial=0) < 2:
        return _NAN, "exact", 0
    hits, n = table[0], table.sum(axis=0)
    if table.shape[1] == 2:
        return fisher_exact((int(hits[0]), int(hits[1])), (int(n[0]), int(n[1]))), "exact", 0
    drawn = np.random.default_rng(seed).multivariate_hypergeometric(n, hits.sum(), size=DRAWS, method="marginals")
    likely = _log_ways(drawn, n) <= _log_ways(hits, n) + 1e-7
    return float((1 + likely.sum()) / (1 + DRAWS)), "Monte Carlo", DRAWS


def _log_ways(hits: NDArray[np.int64], n: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the logarithm of the number of ways to give the groups their hits (..., groups)."""
    factorials = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, int(n.max()) + 1)))])
    return np.asarray((factorials[n] - factorials[hits] - factorials[n - hits]).sum(axis=-1))


def rate_pair(
    levels: tuple[str, str],
    hits: tuple[int, int],
    n: tuple[int, int],
    margin: float | None = None,
    worth: tuple[float, float] | None = None,
) -> Pair:
    """Return two rates side by side: the difference, R. Newcombe's interval (1998, method 10), equivalence and BF01.

    Args:
        levels: their names.
        hits: right answers.
        n: answers.
        margin: of equivalence, as a share.
        worth: effective numbers of answers, where they are not independent: there is no Bayes factor then.
    """
    if not all(n):
        return Pair(levels, _NAN, _NAN, _NAN, _NAN, _margin(margin), None, _NAN)
    many = (float(n[0]), float(n[1])) if worth is None else worth
    h = (hits[0] * many[0] / n[0], hits[1] * many[1] / n[1])
    low, high = newcombe(h, many)
    bound = max(map(abs, newcombe(h, many, 0.90)))
    bf01 = rates_bf01(hits, n) if worth is None else _NAN
    return Pair(
        levels, hits[0] / n[0] - hits[1] / n[1], low, high, bound, _margin(margin), _within(bound, margin), bf01
    )


def _margin(margin: float | None) -> float:
    return _NAN if margin is None else margin


def _within(bound: float, margin: float | None) -> bool | None:
    """Return whether two one-sided tests at 5 % each (D. Schuirmann, 1987) find equivalence within the margin."""
    return None if margin is None or np.isnan(bound) else bool(bound < margin)


def mean_pair(
    levels: tuple[str, str], a: NDArray[np.float64], b: NDArray[np.float64], margin: float | None = None
) -> Pair:
    """Return two mean scores side by side, by B. Welch's interval (1947); NaN without spread or for one person."""
    difference = float(a.mean() - b.mean())
    if min(len(a), len(b)) < 2 or a.var() + b.var() < _NO_SPREAD:
        return Pair(levels, difference, _NAN, _NAN, _NAN, _margin(margin), None, _NAN)
    parts = np.array([a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)])
    dof = parts.sum() ** 2 / (parts**2 / [len(a) - 1, len(b) - 1]).sum()
    half95, half90 = stdtrit(dof, np.array([0.975, 0.95])) * np.sqrt(parts.sum())
    bound = abs(difference) + float(half90)
    return Pair(
        levels,
        difference,
        difference - float(half95),
        difference + float(half95),
        bound,
        _margin(margin),
        _within(bound, margin),
        means_bf01(a, b),
    )


def means_bf01(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the JZS Bayes factor of equal means (J. Rouder et al., Psychonomic Bulletin & Review 16, 2009).

    The standardized difference has a Cauchy prior; scores of few videos are coarse, so read it as a rough scale.
    """
    dof, size = len(a) + len(b) - 2, len(a) * len(b) / (len(a) + len(b))
    pooled = ((len(a) - 1) * a.var(ddof=1) + (len(b) - 1) * b.var(ddof=1)) / dof
    t2 = (a.mean() - b.mean()) ** 2 * size / pooled
    # Against no difference, the variance g = (scale / z)^2 given; z is half-normal.
    z = np.linspace(0, 12, 2_001)[1:]  # Simpson's rule; the integrand is 0 at 0
    weights = np.resize([4, 2], len(z)) * (z[1] - z[0]) / 3
    weights[-1] /= 2
    wider = 1 + size * (_PRIOR_SCALE / z) ** 2
    exponent = (dof + 1) / 2 * (np.log1p(t2 / dof) - np.log1p(t2 / (wider * dof)))
    density = 2 / np.sqrt(2 * np.pi) * np.exp(-(z**2) / 2)
    return 1 / float((weights * density * np.exp(np.minimum(exponent, 700)) / np.sqrt(wider)).sum())
