"""Recognition: how often each video's label was the answer, against guessing among the labels.

Counts are confusion matrices (labels, signalled), rows perceived, whose first rows are the signaled labels in the
order of the columns, as in `Responses`: the right answer to column j stands in row j. `uses` says, for each column, how
often each participant gave each label (participants, k); it is needed where participants answered several videos of an
emotion, since such answers depend on each other. Without it, answers to one emotion count as independent.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaincinv

from emovid.statistics.proportions import binomial_tail, effective_n, holm, sum_tail, uniform_bf10, wilson

_Test = TypeVar("_Test", bound="AgainstChance")

Counts = NDArray[np.int64]
Uses = Sequence[NDArray[np.int64]]

# Above these many participants sums of hits count as normal: convolving their distributions would take minutes.
MOST_CONVOLVED = 2_000


@dataclass(frozen=True)
class AgainstChance:
    """Hits against guessing, for the videos of one emotion.

    Attributes:
        hits: right answers.
        n: answers.
        participants: who gave them.
        effective_n: independent answers that they are worth: n for one answer each (`proportions.effective_n`).
        rate: hits / n, NaN without answers.
        ci_low, ci_high: two-sided 95 % interval of the rate (E. Wilson, 1927) with `effective_n` answers, not corrected
            for several videos; 0 and 1 without answers.
        chance: the rate that guessing would have.
        p_binomial: exact, one-sided: more hits than guessing; NaN without answers.
        method: of p, "exact binomial", or "exact permutation" where participants gave several answers: each one's
            answers are permuted over the labels, which is the binomial test where each gave one; "normal" for the same
            in large studies.
        p_holm: after Holm's correction over the emotions that have answers.
        above_chance: whether `p_holm` is at most alpha.
    """

    hits: int
    n: int
    participants: int
    effective_n: float
    rate: float
    ci_low: float
    ci_high: float
    chance: float
    p_binomial: float
    method: str
    p_holm: float
    above_chance: bool


@dataclass(frozen=True)
class Recognition(AgainstChance):
    """How one emotion was recognized.

    Attributes:
        verdict: "absolute majority" (over half of the answers), "relative majority" (more than any other label) or
            "neither". It describes the answers; `p_verdict` tests it.
        p_verdict: one-sided sign test: of an absolute majority against one half, of a relative one against the label
            that came next; NaN for "neither". Several answers of a participant change their sign together.
        hu: Wagner's unbiased hit rate, NaN where the label was never given or the emotion has no answers.
        hu_low, hu_high: its 95 % interval from resampled participants; NaN where they are not known.
        hu_chance: Wagner's chance level of it: the product of the shares of the label and of the video.
        pi: Rosenthal and Rubin's proportion index.
        bf10: Bayes factor of unknown shares of the labels, uniform on the simplex, against equal shares.
        bayes_low, bayes_high: 95 % credible interval of the rate, from the same prior (Dirichlet-multinomial). NaN,
            like `bf10`, where participants gave several answers.
    """

    verdict: str
    p_verdict: float
    hu: float
    hu_low: float
    hu_high: float
    hu_chance: float
    pi: float
    bf10: float
    bayes_low: float
    bayes_high: float


@dataclass(frozen=True)
class Accuracy:
    """All answers together.

    Attributes:
        hits: right answers.
        n: answers.
        participants: who gave them; None where that is not known.
        rate: hits / n, NaN without answers.
        ci_low, ci_high: two-sided 95 % interval of the rate (E. Wilson, 1927) with the effective number of answers, in
            which participants count as a whole; NaN where participants are not known.
        chance: the rate that guessing would have.
    """

    hits: int
    n: int
    participants: int | None
    rate: float
    ci_low: float
    ci_high: float
    chance: float


@dataclass(frozen=True, eq=False)
class Collapsed:
    """Recognition of a pole: positive or negative valence, high or low arousal.

    Attributes:
        table: answers (2, 2), rows perceived and columns signaled, the True pole first. Each participant stands in it
            several times, so it is not tested as a whole.
        videos: by signaled label, for those that have a pole; a hit is any answer of the same pole.
    """

    table: NDArray[np.int64]
    videos: Mapping[str, AgainstChance]


def recognize(
    counts: Counts, alpha: float = 0.05, uses: Uses | None = None, intervals: NDArray[np.float64] | None = None
) -> list[Recognition]:
    """Return the recognition of each column of `counts` (k, signalled), guessing being 1 / k.

    A "none of these" row counts as a label like any other; how often people who guess take it is not known (M. Frank
    and J. Stennett, 2001).

    Args:
        counts: the confusion matrix.
        alpha: level of "above chance", after Holm's correction.
        uses: as above.
        intervals: (signalled, 2) of the unbiased hit rates.
    """
    k, videos = counts.shape
    hu, chances = unbiased_hit_rates(counts), unbiased_chance(counts)
    ends = np.full((videos, 2), np.nan) if intervals is None else intervals
    tests = against_chance(counts, np.eye(k, videos, dtype=bool), alpha, uses)
    found = []
    for j, test in enumerate(tests):
        column = counts[:, j]
        word = verdict(column, j)
        once = test.participants == test.n
        bayes = betaincinv(1 + test.hits, k - 1 + test.n - test.hits, [0.025, 0.975]) if once else [np.nan, np.nan]
        found.append(
            Recognition(
                **vars(test),
                verdict=word,
                p_verdict=_verdict_p(word, column, j, None if uses is None else uses[j]),
                hu=float(hu[j]),
                hu_low=float(ends[j, 0]),
                hu_high=float(ends[j, 1]),
                hu_chance=float(chances[j]),
                pi=proportion_index(test.rate, k),
                bf10=uniform_bf10(column) if once else float("nan"),
                bayes_low=float(bayes[0]),
                bayes_high=float(bayes[1]),
            )
        )
    return found


def accuracy(counts: Counts, hits: NDArray[np.int64] | None = None, n: NDArray[np.int64] | None = None) -> Accuracy:
    """Return all answers in `counts` (k, signalled) together, and their interval from each participant's hits and n."""
    right, total, chance = int(np.diagonal(counts).sum()), int(counts.sum()), 1 / len(counts)
    rate = right / total if total else float("nan")
    if hits is None or n is None:
        return Accuracy(right, total, None, rate, float("nan"), float("nan"), chance)
    worth = effective_n(hits, n)
    low, high = wilson(rate * worth, worth) if total else (0.0, 1.0)
    return Accuracy(right, total, int((n > 0).sum()), rate, low, high, chance)


def against_chance(
    counts: Counts, right: NDArray[np.bool_], alpha: float = 0.05, uses: Uses | None = None
) -> list[AgainstChance]:
    """Return the test and the interval of each column of `counts`, with answers that are `right` (k, signalled)."""
    tests = [
        _against_chance(column, there, None if uses is None else uses[j])
        for j, (column, there) in enumerate(zip(counts.T, right.T, strict=True))
    ]
    return corrected(tests, alpha)


def corrected(tests: Sequence[_Test], alpha: float = 0.05) -> list[_Test]:
    """Return tests with Holm's correction over all of them."""
    adjusted = holm(np.array([test.p_binomial for test in tests], dtype=float))
    return [
        replace(test, p_holm=float(p), above_chance=bool(p <= alpha)) for test, p in zip(tests, adjusted, strict=True)
    ]


def _against_chance(column: Counts, right: NDArray[np.bool_], uses: NDArray[np.int64] | None) -> AgainstChance:
    hits, n, chance = int(column[right].sum()), int(column.sum()), float(right.mean())
    answers = np.ones(n, dtype=np.int64) if uses is None else uses.sum(axis=1)
    people = int((answers > 0).sum())
    method, worth = "exact binomial", float(n)
    if uses is None or people == n:
        p = binomial_tail(hits, n, chance) if n else float("nan")
    else:
        method = "exact permutation" if people <= MOST_CONVOLVED else "normal"
        worth, p = effective_n(uses[:, right].sum(axis=1), answers), _permuted_p(uses, int(right.sum()), hits)
    rate = hits / n if n else float("nan")
    low, high = wilson(hits * worth / n, worth) if n else (0.0, 1.0)
    return AgainstChance(hits, n, people, worth, rate, low, high, chance, p, method, p, False)


def _permuted_p(uses: NDArray[np.int64], right: int, hits: int) -> float:
    """Return the probability of as many hits when each participant's uses (participants, k) are permuted over labels.

    Exact for guessers, whatever their answers to several videos have to do with each other.
    """
    alike, often = np.unique(np.sort(uses[uses.any(axis=1)], axis=1), axis=0, return_counts=True)
    nulls = [_null_hits(tuple(used), right) for used in alike.tolist()]
    return sum_tail(nulls, often, hits, exact=int(often.sum()) <= MOST_CONVOLVED)


@cache
def _null_hits(used: tuple[int, ...], right: int) -> NDArray[np.float64]:
    """Return the probabilities of 0, 1, ... hits if any `right` of the labels could be the right ones."""
    sums = np.array([sum(chosen) for chosen in combinations(used, right)])
    return np.bincount(sums, minlength=sum(used) + 1) / len(sums)


def verdict(column: NDArray[np.int64], right: int) -> str:
    """Return which majority of the answers (k,) to a video its label, in row `right`, has."""
    if 2 * column[right] > column.sum():
        return "absolute majority"
    return "relative majority" if (column[right] > np.delete(column, right)).all() else "neither"


def _verdict_p(word: str, column: NDArray[np.int64], right: int, uses: NDArray[np.int64] | None) -> float:
    """Return the sign test of the verdict: the exact binomial test where each participant gave one answer."""
    if word == "neither":
        return float("nan")
    rivals = [row for row in range(len(column)) if row != right]
    if word == "relative majority":
        rivals = [max(rivals, key=lambda row: column[row])]
    if uses is None or int((uses.sum(axis=1) > 0).sum()) == int(uses.sum()):
        return binomial_tail(int(column[right]), int(column[right] + column[rivals].sum()), 0.5)
    lead = uses[:, right] - uses[:, rivals].sum(axis=1)
    sizes, often = np.unique(np.abs(lead[lead != 0]), return_counts=True)
    nulls = [np.concatenate([[0.5], np.zeros(int(size) - 1), [0.5]]) for size in sizes]
    return sum_tail(nulls, often, int(lead[lead > 0].sum()), exact=int(often.sum()) <= MOST_CONVOLVED)


def unbiased_hit_rates(counts: NDArray[np.int64] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return hits^2 / (row total * column total) of each column of `counts` (k, signalled), NaN where that is 0 / 0.

    It discounts a label given to everything: H. Wagner, "On measuring performance in category judgment studies of
    nonverbal behavior", J. Nonverbal Behavior 17, 1993. Matrices may be stacked (..., k, signalled).
    """
    videos = counts.shape[-1]
    margins = counts.sum(axis=-1)[..., :videos] * counts.sum(axis=-2)
    hits = np.diagonal(counts, axis1=-2, axis2=-1) ** 2.0
    return np.divide(hits, margins, out=np.full(hits.shape, np.nan), where=margins > 0)


def unbiased_chance(counts: Counts) -> NDArray[np.float64]:
    """Return Wagner's chance level of the unbiased hit rate of each column: share of the label times that of the video.

    1 / k^2 where labels and videos are used alike; NaN without answers.
    """
    total = counts.sum()
    margins = counts.sum(axis=1)[: counts.shape[1]] * counts.sum(axis=0) / max(int(total), 1) ** 2
    return np.asarray(margins) if total else np.full(counts.shape[1], np.nan)


def proportion_index(rate: float, k: int) -> float:
    """Return the rate of right answers that two choices would have had, one half at chance for any number k.

    R. Rosenthal and D. Rubin, "Effect size estimation for one-sample multiple-choice-type data", Psychological
    Bulletin 106, 1989.
    """
    return rate * (k - 1) / (1 + rate * (k - 2))


def collapse(
    counts: Counts,
    labels: Sequence[str],
    poles: Mapping[str, bool],
    alpha: float = 0.05,
    uses: Uses | None = None,
) -> Collapsed:
    """Return the recognition of `poles` (`VALENCE` or `AROUSAL`) from `counts` (labels, signalled).

    A guess has the right pole as often as there are labels of it: 2 / 6 for positive valence, 4 / 6 for negative.
    Answers without a pole ("none") count as misses; videos without one are left out, and so are those whose pole all
    labels have: no answer can miss there.
    """
    pole = np.array([poles.get(label, -1) for label in labels], dtype=np.int64)
    same = (pole[:, None] == pole[None, : counts.shape[1]]) & (pole[:, None] >= 0)
    known = [j for j in range(counts.shape[1]) if pole[j] >= 0 and not same[:, j].all()]
    tests = against_chance(counts[:, known], same[:, known], alpha, None if uses is None else [uses[j] for j in known])
    sides = pole[None, :] == np.array([[True], [False]])
    return Collapsed(
        table=sides @ counts @ sides[:, : counts.shape[1]].T,
        videos={labels[j]: test for j, test in zip(known, tests, strict=True)},
    )
