"""Differences between groups of participants, and how much "no difference" is worth.

Participants, not answers, are compared: the answers of one person to several videos are never pooled as independent.
Beside each difference stand the smallest bound at which equivalence would hold and a Bayes factor, since a large p
alone says nothing in favour of no difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import factorial

import numpy as np
from numpy.typing import NDArray
from scipy.stats import MonteCarloMethod, chi2_contingency, fisher_exact, permutation_test

from emovid.statistics.goodness import DRAWS
from emovid.statistics.pairs import Pair, mean_pair, rate_pair
from emovid.statistics.recognition import holm

# Ours: in a smaller group one person moves a rate by 25 points or more.
MIN_GROUP = 5
# Of more answers than this, more than two groups are compared by Pearson's test, which is then as good; scipy's random
# tables fail for more than `DRAWS` times the number of cells.
_MOST_SHUFFLED = 10_000
_SHUFFLED_PARTICIPANTS = 20_000_000  # in all draws together: a few seconds


@dataclass(frozen=True)
class ScoresDiffer:
    """Mean scores of groups.

    Attributes:
        levels: the groups.
        n: participants in each.
        means: of their scores.
        p: of means at least as far apart when participants are shuffled over groups; 1 for fewer than two groups.
        method: "exact" or "Monte Carlo".
        draws, seed: of the shuffles; 0 and None for "exact".
        pairs: each two groups.
        tiny: groups of fewer than `MIN_GROUP`.
    """

    levels: tuple[str, ...]
    n: tuple[int, ...]
    means: tuple[float, ...]
    p: float
    method: str
    draws: int
    seed: int | None
    pairs: tuple[Pair, ...]
    tiny: tuple[str, ...]


@dataclass(frozen=True)
class RatesDiffer:
    """Hits of groups on one video.

    Attributes:
        levels: the groups.
        hits, n: right answers and answers of each.
        p: of `method`; 1 where nothing can differ.
        p_holm: after Holm's correction over the videos.
        method: "exact" (Fisher's test), for more than two groups with answers "Monte Carlo" (Fisher, Freeman and
            Halton's) or "chi-squared" (Pearson's, in large studies).
        draws, seed: of the random tables; 0 and None unless "Monte Carlo".
        pairs: each two groups.
        tiny: groups of fewer than `MIN_GROUP` answers.
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
    """Return the groups that occur in `group`, sorted; who says nothing (empty, not text) is in none."""
    return tuple(sorted({level for level in group if isinstance(level, str) and level}))


def scores_differ(choices: NDArray[np.int64], group: Sequence[object], seed: int = 0) -> ScoresDiffer:
    """Return whether the groups' mean scores differ, a score being the share of a participant's answers that hit.

    Args:
        choices: (participants, signalled) as `Responses.choices`; who answered nothing is left out.
        group: of each participant.
        seed: of the shuffles.
    """
    answered = (choices >= 0).sum(axis=1)
    scores = (choices == np.arange(choices.shape[1])).sum(axis=1) / np.maximum(answered, 1)
    label = np.array([level if isinstance(level, str) else "" for level in group], dtype=object)
    label[answered == 0] = ""
    levels = levels_of(label.tolist())
    samples = [scores[label == level] for level in levels]
    p, draws = _shuffled_means(samples, seed)
    return ScoresDiffer(
        levels=levels,
        n=tuple(map(len, samples)),
        means=tuple(float(sample.mean()) for sample in samples),
        p=p,
        method="Monte Carlo" if draws else "exact",
        draws=draws,
        seed=seed if draws else None,
        pairs=tuple(
            mean_pair((levels[i], levels[j]), samples[i], samples[j]) for i, j in combinations(range(len(levels)), 2)
        ),
        tiny=tuple(level for level, sample in zip(levels, samples, strict=True) if len(sample) < MIN_GROUP),
    )


def _shuffled_means(samples: list[NDArray[np.float64]], seed: int) -> tuple[float, int]:
    """Return the p of the spread between means over shuffles, and the draws; 0 draws where all shuffles were listed."""
    if len(samples) < 2:
        return 1.0, 0
    scores, sizes = np.concatenate(samples), np.array(list(map(len, samples)))
    draws = min(DRAWS, max(999, _SHUFFLED_PARTICIPANTS // len(scores)))

    def between(shuffled: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
        sums = np.add.reduceat(shuffled, np.cumsum(sizes) - sizes, axis=axis)
        return (np.moveaxis(sums, axis, -1) ** 2 / sizes).sum(axis=-1)

    test = permutation_test(
        (scores,),
        between,
        permutation_type="pairings",  # "independent" lists fewer shuffles, but refuses groups of one
        vectorized=True,
        n_resamples=draws,
        batch=max(1, 2_000_000 // len(scores)),
        alternative="greater",
        rng=np.random.default_rng(seed),
    )
    return float(test.pvalue), 0 if factorial(min(len(scores), 20)) <= draws else draws


def rates_differ(choices: NDArray[np.int64], group: Sequence[object], seed: int = 0) -> list[RatesDiffer]:
    """Return, for each video, whether the groups recognise it alike; arguments as for `scores_differ`."""
    levels = levels_of(group)
    member = np.array([[level == mine for mine in group] for level in levels], dtype=bool).reshape(
        len(levels), len(group)
    )
    n = member.astype(np.int64) @ (choices >= 0)
    hits = member.astype(np.int64) @ (choices == np.arange(choices.shape[1]))
    tests = [_fisher(h, m, seed) for h, m in zip(hits.T, n.T, strict=True)]
    adjusted = holm(np.array([p for p, _ in tests]), (n > 0).sum(axis=0) > 1)
    return [
        RatesDiffer(
            levels=levels,
            hits=tuple(h.tolist()),
            n=tuple(m.tolist()),
            p=tests[j][0],
            p_holm=float(adjusted[j]),
            method=tests[j][1],
            draws=DRAWS if tests[j][1] == "Monte Carlo" else 0,
            seed=seed if tests[j][1] == "Monte Carlo" else None,
            pairs=tuple(
                rate_pair((levels[a], levels[b]), (int(h[a]), int(h[b])), (int(m[a]), int(m[b])))
                for a, b in combinations(range(len(levels)), 2)
            ),
            tiny=tuple(level for level, often in zip(levels, m, strict=True) if often < MIN_GROUP),
        )
        for j, (h, m) in enumerate(zip(hits.T, n.T, strict=True))
    ]


def _fisher(hits: NDArray[np.int64], n: NDArray[np.int64], seed: int) -> tuple[float, str]:
    """Return the p of hits and misses (2, groups), those without answers left out, and the method as `RatesDiffer`."""
    table = np.array([hits, n - hits])[:, n > 0]
    if table.shape[1] < 2 or not table.any(axis=1).all():
        return 1.0, "exact"
    if table.shape[1] == 2:
        return float(fisher_exact(table).pvalue), "exact"
    if table.sum() > _MOST_SHUFFLED:
        return float(chi2_contingency(table).pvalue), "chi-squared"
    method = MonteCarloMethod(n_resamples=DRAWS, rng=np.random.default_rng(seed))
    p = np.squeeze(fisher_exact(table, method=method).pvalue)  # an array where all shuffles are alike
    return float(p), "Monte Carlo"
