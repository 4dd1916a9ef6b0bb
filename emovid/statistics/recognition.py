"""Recognition: how often each video's label was the answer, against guessing among the labels.

Counts are confusion matrices (labels, signalled), rows perceived, whose first rows are the signalled labels in the
order of the columns, as in `Responses`: the right answer to column j stands in row j.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import proportion_confint

# Santos and Egerstedt 2021, the footnote on valence after Frijda 1986: True is positive.
VALENCE = {"happiness": True, "surprise": True, "anger": False, "fear": False, "disgust": False, "sadness": False}
# True is high: the upper half of the circle of J. Russell, "A circumplex model of affect", 1980 (`circumplex.ANGLES`).
# Happiness lies just above its middle (8 degrees, "excited" at 49), so the choice matters most for it.
AROUSAL = {"happiness": True, "surprise": True, "anger": True, "fear": True, "disgust": True, "sadness": False}

_BOOTSTRAPS = 2_000
# Ours: distinct sets of answers times resamples; at most seconds, also for 100 000 participants.
_BOOTSTRAP_CELLS = 20_000_000


@dataclass(frozen=True)
class AgainstChance:
    """Hits against guessing, for one video.

    Attributes:
        hits: right answers.
        n: answers.
        rate: hits / n, NaN without answers.
        ci_low, ci_high: two-sided 95 % interval of the rate (E. Wilson, 1927), 0 and 1 without answers.
        chance: the rate that guessing would have.
        p_binomial: exact, one-sided: more hits than guessing; 1 without answers.
        p_holm: after Holm's correction over the videos that have answers.
        above_chance: whether `p_holm` is at most alpha.
    """

    hits: int
    n: int
    rate: float
    ci_low: float
    ci_high: float
    chance: float
    p_binomial: float
    p_holm: float
    above_chance: bool


@dataclass(frozen=True)
class Recognition(AgainstChance):
    """How one video was recognised.

    Attributes:
        verdict: "absolute majority" (over half of the answers), "relative majority" (more than any other label) or
            "neither".
        hu: Wagner's unbiased hit rate, NaN where the label was never given or the video has no answers.
        pi: Rosenthal and Rubin's proportion index.
    """

    verdict: str
    hu: float
    pi: float


@dataclass(frozen=True, eq=False)
class Collapsed:
    """Recognition of a pole: positive or negative valence, high or low arousal.

    Attributes:
        table: answers (2, 2), rows perceived and columns signalled, the True pole first. Each participant stands in it
            several times, so it is not tested as a whole.
        videos: by signalled label, for those that have a pole; a hit is any answer of the same pole.
    """

    table: NDArray[np.int64]
    videos: dict[str, AgainstChance]


def recognise(counts: NDArray[np.int64], alpha: float = 0.05) -> list[Recognition]:
    """Return the recognition of each column of `counts` (k, signalled), guessing being 1 / k.

    A "none of these" row counts as a label like any other; how often people who guess take it is not known (M. Frank
    and J. Stennett, 2001).
    """
    k, videos = counts.shape
    hits, hu = np.diagonal(counts), unbiased_hit_rates(counts)
    tests = against_chance(hits, counts.sum(axis=0), np.full(videos, 1 / k), alpha)
    return [
        Recognition(**vars(test), verdict=verdict(counts[:, j], j), hu=float(hu[j]), pi=proportion_index(test.rate, k))
        for j, test in enumerate(tests)
    ]


def against_chance(
    hits: NDArray[np.int64], n: NDArray[np.int64], chance: NDArray[np.float64], alpha: float = 0.05
) -> list[AgainstChance]:
    """Return the exact binomial test and the interval of each video from its `hits`, answers and chance (videos,)."""
    rows = [(int(h), int(m), float(c)) for h, m, c in zip(hits, n, chance, strict=True)]
    p = np.array([binomtest(h, m, c, alternative="greater").pvalue if m else 1.0 for h, m, c in rows])
    adjusted = holm(p, n > 0)
    return [
        AgainstChance(
            h, m, h / m if m else float("nan"), *wilson(h, m), c, float(p[j]), float(adjusted[j]), bool(above)
        )
        for j, ((h, m, c), above) in enumerate(zip(rows, (adjusted <= alpha) & (n > 0), strict=True))
    ]


def wilson(hits: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return Wilson's two-sided interval of hits / n, advised for small n by Brown, Cai and DasGupta (2001)."""
    if not n:
        return 0.0, 1.0
    low, high = proportion_confint(hits, n, alpha=1 - confidence, method="wilson")
    return float(low), float(high)


def holm(p: NDArray[np.float64], tested: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
    """Return p (m,) after Holm's step-down correction (S. Holm, 1979) over those `tested`, all by default."""
    adjusted = p.copy()
    chosen = np.ones(len(p), dtype=bool) if tested is None else tested
    if chosen.any():
        adjusted[chosen] = multipletests(p[chosen], method="holm")[1]
    return adjusted


def verdict(column: NDArray[np.int64], right: int) -> str:
    """Return which majority of the answers (k,) to a video its label, in row `right`, has."""
    if 2 * column[right] > column.sum():
        return "absolute majority"
    return "relative majority" if (column[right] > np.delete(column, right)).all() else "neither"


def unbiased_hit_rates(counts: NDArray[np.int64] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return hits^2 / (row total * column total) of each column of `counts` (k, signalled), NaN where that is 0 / 0.

    It discounts a label given to everything: H. Wagner, "On measuring performance in category judgment studies of
    nonverbal behavior", J. Nonverbal Behavior 17, 1993.
    """
    videos = counts.shape[1]
    margins = counts.sum(axis=1)[:videos] * counts.sum(axis=0)
    return np.divide(np.diagonal(counts) ** 2.0, margins, out=np.full(videos, np.nan), where=margins > 0)


def unbiased_hit_intervals(choices: NDArray[np.int64], k: int, seed: int = 0) -> NDArray[np.float64]:
    """Return 95 % percentile intervals (signalled, 2) of Wagner's rate, from resampled participants.

    Participants are resampled as a whole, so their answers may depend on each other. NaN where the rate is; resamples
    in which it is undefined are left out. A rate of 0 or 1 has an interval without width: the bootstrap cannot see
    what no participant did.

    Args:
        choices: (participants, signalled) places in the k labels, -1 where missing (`Responses.choices`).
        k: labels.
        seed: of the resampling.
    """
    people, videos = choices.shape
    rates = unbiased_hit_rates(_counted(choices, k).sum(axis=0))
    if not people:
        return np.full((videos, 2), np.nan)
    alike, often = np.unique(choices, axis=0, return_counts=True)
    rng, cells = np.random.default_rng(seed), _counted(alike, k).reshape(len(alike), -1).astype(np.float64)
    draws, shares = min(_BOOTSTRAPS, max(200, _BOOTSTRAP_CELLS // len(alike))), often / people
    samples = np.array(
        [unbiased_hit_rates((rng.multinomial(people, shares) @ cells).reshape(k, videos)) for _ in range(draws)]
    )
    return np.array(
        [
            np.nanpercentile(sample, [2.5, 97.5]) if np.isfinite(rate) else (np.nan, np.nan)
            for rate, sample in zip(rates, samples.T, strict=True)
        ]
    )


def _counted(choices: NDArray[np.int64], k: int) -> NDArray[np.int64]:
    """Return each participant's own confusion matrix (participants, k, signalled) of zeros and ones."""
    return (choices[:, None, :] == np.arange(k)[:, None]).astype(np.int64)


def proportion_index(rate: float, k: int) -> float:
    """Return the rate of right answers that two choices would have had, one half at chance for any number k.

    R. Rosenthal and D. Rubin, "Effect size estimation for one-sample multiple-choice-type data", Psychological
    Bulletin 106, 1989.
    """
    return rate * (k - 1) / (1 + rate * (k - 2))


def collapse(
    counts: NDArray[np.int64], labels: Sequence[str], poles: Mapping[str, bool], alpha: float = 0.05
) -> Collapsed:
    """Return the recognition of `poles` (`VALENCE` or `AROUSAL`) from `counts` (labels, signalled).

    A guess has the right pole as often as there are labels of it: 2 / 6 for positive valence, 4 / 6 for negative.
    Answers without a pole ("none") count as misses; videos without one are left out.
    """
    pole = np.array([poles.get(label, -1) for label in labels], dtype=np.int64)
    same = (pole[:, None] == pole[None, : counts.shape[1]]) & (pole[:, None] >= 0)
    known = [j for j in range(counts.shape[1]) if pole[j] >= 0]
    tests = against_chance(
        (counts * same).sum(axis=0)[known], counts.sum(axis=0)[known], same.mean(axis=0)[known], alpha
    )
    sides = pole[None, :] == np.array([[True], [False]])
    return Collapsed(
        table=sides @ counts @ sides[:, : counts.shape[1]].T,
        videos={labels[j]: test for j, test in zip(known, tests, strict=True)},
    )
