"""Tests that take the answers of a participant together: agreement, recognition as a whole, use of labels, order.

A participant who may go back can give each label once, and has one mood and one eye, so answers to several videos are
not independent. The tests here shuffle within participants, or compare videos within them, and so hold whatever that
dependence is.

`choices` is (participants, showings): places in the labels, -1 where missing; `right` (showings,) has the place of the
right answer, and is the number of the column where left out (`Showings`).
"""

from dataclasses import dataclass
from functools import cache
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtr

from emovid.statistics.confusions import quasi_independence
from emovid.statistics.goodness import DRAWS
from emovid.statistics.proportions import sum_tail
from emovid.statistics.recognition import MOST_CONVOLVED
from emovid.statistics.showings import Showings

Choices = NDArray[np.int64]

# Above these many participants the large-sample form of the same test is used: shuffling would take minutes and its
# p would differ by less than its own error.
MOST_SHUFFLED = 1_000
_BATCH = 2_000_000  # shuffled values at once
_FEWEST_ROWS, _FEWEST_CELLS = 4, 24  # of Cochran's Q


@dataclass(frozen=True)
class Agreement:
    """Fleiss' kappa over the participants who answered every video that was shown.

    Attributes:
        kappa: 1 for full agreement, 0 for none beyond the labels' shares; NaN for fewer than two participants or
            videos, or one label throughout.
        participants: with complete answers.
        videos: they saw.
    """

    kappa: float
    participants: int
    videos: int


@dataclass(frozen=True)
class VideosDiffer:
    """Cochran's Q: whether some videos are recognized more often than others.

    Attributes:
        statistic: Q; NaN where no participant has both hits and misses.
        dof: videos that were shown, less one.
        p: from the chi-squared distribution; NaN where too few participants are informative for it: fewer than 4, or
            fewer than 24 of their answers (M. Tate and S. Brown, JASA 65, 1970).
        participants: with complete answers.
        informative: those of them with both hits and misses, on whom alone the test rests.
        total: participants, with complete answers or not.
    """

    statistic: float
    dof: int
    p: float
    participants: int
    informative: int
    total: int


def agreement(choices: Choices, k: int) -> Agreement:
    """Return Fleiss' kappa of k labels (J. Fleiss, 1971), which takes each participant to have answered each video."""
    complete = choices[np.ix_(*_complete(choices))]
    people, videos = complete.shape
    if min(people, videos) < 2 or len(np.unique(complete)) < 2:
        return Agreement(float("nan"), people, videos)
    ratings = np.array([np.bincount(column, minlength=k) for column in complete.T])
    agreed = ((ratings**2).sum() - people * videos) / (videos * people * (people - 1))
    by_chance = ((ratings.sum(axis=0) / (people * videos)) ** 2).sum()
    return Agreement(float((agreed - by_chance) / (1 - by_chance)), people, videos)


def videos_differ(choices: Choices, right: NDArray[np.int64] | None = None) -> VideosDiffer:
    """Return Cochran's Q (W. Cochran, 1950) of the hits of participants who answered every video that was shown."""
    hits = _hits(choices, right)[np.ix_(*_complete(choices))].astype(np.int64)
    videos, by_person, by_video = hits.shape[1], hits.sum(axis=1), hits.sum(axis=0)
    dof, mixed = max(videos - 1, 0), int(((by_person > 0) & (by_person < videos)).sum())
    if not mixed:  # Q is 0 / 0: no participant distinguishes the videos
        return VideosDiffer(float("nan"), dof, float("nan"), len(hits), 0, len(choices))
    total = by_video.sum()
    q = dof * (videos * (by_video**2).sum() - total**2) / (videos * total - (by_person**2).sum())
    enough = mixed >= _FEWEST_ROWS and mixed * videos >= _FEWEST_CELLS
    p = float(chdtrc(dof, q)) if enough else float("nan")
    return VideosDiffer(float(q), dof, p, len(hits), mixed, len(choices))


def _hits(choices: Choices, right: NDArray[np.int64] | None) -> NDArray[np.bool_]:
    return np.asarray(choices == (np.arange(choices.shape[1]) if right is None else right))


def _complete(choices: Choices) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the participants (True) who answered every video that was shown, and the videos that were."""
    answered = choices >= 0
    shown = np.asarray(answered.any(axis=0))  # not every label on offer need have a video
    return np.asarray(answered[:, shown].all(axis=1)), shown


@dataclass(frozen=True)
class TotalRecognition:
    """All hits against each participant's own answers, shuffled over the videos.

    Attributes:
        hits: right answers of everybody.
        n: answers.
        expected: mean of the hits when shuffled.
        p: one-sided, of at least that many hits; NaN where shuffling changes nothing, as with one emotion.
        method: "exact" or "normal".
    """

    hits: int
    n: int
    expected: float
    p: float
    method: str


def total_recognition(choices: Choices, right: NDArray[np.int64] | None = None) -> TotalRecognition:
    """Return the test of all hits that shuffles each participant's answers over the videos they answered.

    Unlike a binomial test over all answers it holds for people who give each label once, whose hits vary more than
    guesses do. Participants guess apart from each other, so their distributions of hits convolve.
    """
    right = np.arange(choices.shape[1]) if right is None else right
    hits, n = int(_hits(choices, right).sum()), int((choices >= 0).sum())
    if not n:
        return TotalRecognition(0, 0, 0.0, float("nan"), "exact")
    patterns, often = np.unique(_patterns(choices, right), axis=0, return_counts=True)
    nulls = [hit_distribution(tuple(map(tuple, row[1:].reshape(-1, 2).tolist())), int(row[0])) for row in patterns]
    expected = float(often @ [np.arange(len(null)) @ null for null in nulls])
    exact = len(choices) <= MOST_CONVOLVED
    fixed = all(null.max() > 1 - 1e-12 for null in nulls)
    p = float("nan") if fixed else sum_tail(nulls, often, hits, exact)
    return TotalRecognition(hits, n, expected, p, "exact" if exact else "normal")


def _patterns(choices: Choices, right: NDArray[np.int64]) -> Choices:
    """Return, per participant, the number of answers, then for each emotion how often it was given and how often shown.

    The order of the emotions does not matter to the number of hits, so they are sorted.
    """
    answered = choices >= 0
    pairs = [
        ((choices == emotion).sum(axis=1) * 1_000_000 + (answered & (right == emotion)).sum(axis=1))
        for emotion in np.unique(right)
    ]
    together = np.sort(np.stack(pairs, axis=1), axis=1)
    given, shown = np.divmod(together, 1_000_000)
    return np.column_stack(
        [answered.sum(axis=1), np.stack([given * (shown > 0), shown], axis=2).reshape(len(choices), -1)]
    )


@cache
def hit_distribution(emotions: tuple[tuple[int, int], ...], n: int) -> NDArray[np.float64]:
    """Return the probabilities (n + 1,) of 0 ... n hits when n answers are shuffled over n showings.

    The ways to place t hits are the product of the rook polynomials of rectangles, and inclusion and exclusion (I.
    Kaplansky and J. Riordan, 1946) counts the orders with exactly h.

    Args:
        emotions: for each emotion, how often its label is among the answers, and how often it was shown.
        n: answers.
    """
    rooks = [1] + [0] * n
    for given, shown in emotions:
        block = [comb(given, t) * comb(shown, t) * factorial(t) for t in range(min(given, shown) + 1)]
        rooks = [sum(block[s] * rooks[t - s] for s in range(min(t, len(block) - 1) + 1)) for t in range(n + 1)]
    ways = [
        sum((-1) ** (t - h) * comb(t, h) * rooks[t] * factorial(n - t) for t in range(h, n + 1)) for h in range(n + 1)
    ]
    return np.array([way / factorial(n) for way in ways])


@dataclass(frozen=True, eq=False)
class LabelUse:
    """Test of preferences for labels among wrong answers.

    Attributes:
        totals: answers by label (k,), right and wrong.
        never: share of participants who never gave the label (k,).
        repeated: share who gave it twice or more (k,).
        errors: wrong answers by label (k,).
        bias: how often each label (k,) is given by mistake, videos taken into account; 1 on average (`Errors.bias`).
        statistic: score statistic of an even share; NaN where the test is undefined: two labels, or no more
            participants with errors than degrees of freedom.
        dof: of its chi-squared distribution.
        p: from that distribution; NaN like the statistic.
        participants: with at least one error.
    """

    totals: NDArray[np.int64]
    never: NDArray[np.float64]
    repeated: NDArray[np.float64]
    errors: NDArray[np.int64]
    bias: NDArray[np.float64]
    statistic: float
    dof: int
    p: float
    participants: int


def label_use(showings: Showings, offered: NDArray[np.bool_] | None = None) -> LabelUse:
    """Return whether wrong answers prefer some labels, given how many errors each participant makes on each video.

    Without a preference each wrong label is as likely as another. What a participant gives beyond that is summed over
    their errors, and these sums are tested against 0 by a score test, whose covariance is taken about 0: about the
    mean, as in H. Hotelling's test (1931), 45 participants give 6 to 7 % of rejections instead of 5 %. Hits do not
    enter, so unequal recognition is no preference; the answers of a participant may depend on each other.

    Args:
        showings: the answers.
        offered: labels (k,) that are compared, all by default; "none of these" is not like the others.
    """
    k, choices = showings.k, showings.choices
    offered = np.ones(k, dtype=bool) if offered is None else offered
    used = showings.uses(np.ones(len(showings.right), dtype=bool))
    people = max(len(used), 1)
    beyond, erring = np.zeros((len(choices), k)), np.zeros(len(choices), dtype=bool)
    for column, right in zip(choices.T, showings.right, strict=True):
        others = offered & (np.arange(k) != right)
        wrong = (column >= 0) & (column != right) & np.where(column >= 0, offered[column], False)
        beyond[wrong] -= others / max(others.sum(), 1)
        beyond[np.flatnonzero(wrong), column[wrong]] += 1
        erring |= wrong
    counts = showings.counts()
    statistic, dof, p = _score_test(beyond[erring][:, offered])
    bias = np.full(k, np.nan)
    videos = int(offered[: showings.emotions].sum())
    if videos == showings.emotions:
        bias[offered] = quasi_independence(counts[offered]).bias
    return LabelUse(
        totals=used.sum(axis=0),
        never=(used == 0).sum(axis=0) / people,
        repeated=(used > 1).sum(axis=0) / people,
        errors=(counts * (np.eye(*counts.shape) == 0)).sum(axis=1),
        bias=bias,
        statistic=statistic,
        dof=dof,
        p=p,
        participants=int(erring.sum()),
    )


def _score_test(values: NDArray[np.float64]) -> tuple[float, int, float]:
    """Return the statistic, degrees of freedom and p of the mean of `values` (n, d) against 0; NaN if undefined."""
    n = len(values)
    if not n:
        return float("nan"), 0, float("nan")
    sizes, axes = np.linalg.eigh(values.T @ values / n)
    kept = sizes > 1e-9 * max(float(sizes.max()), 1e-12)
    rank = int(kept.sum())
    if n <= rank or rank < values.shape[1] - 1 or float(sizes.max()) < 1e-12:
        return float("nan"), rank, float("nan")
    statistic = n * float(((values.mean(axis=0) @ axes[:, kept]) ** 2 / sizes[kept]).sum())
    return statistic, rank, float(chdtrc(rank, statistic))


@dataclass(frozen=True, eq=False)
class Order:
    """Test of the relation between hits and the position of a video in the order of a participant.

    Attributes:
        hits, n: right answers and answers at the 1st, 2nd, ... position.
        slope: change of the hit rate per position, after the videos' own rates; NaN where `p` is.
        p: two-sided, of a slope as far from 0 when each participant's positions are shuffled; NaN where the order was
            the same for all, which leaves position and video one, and where nothing varies.
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


def order_effect(choices: Choices, positions: Choices, right: NDArray[np.int64] | None = None, seed: int = 0) -> Order:
    """Return whether participants get better or worse along their order, by shuffling each one's positions.

    A randomization test, since a study like this draws the orders: it needs no model of how answers of a person
    depend on each other, while a GEE has too small standard errors for few participants and none at all when every
    answer is a hit. Orders from a square, not from all, are taken as if from all. Hits are compared with the rate of
    their video, lest an uneven order of hard videos look like fatigue.

    Args:
        choices: (participants, showings).
        positions: (participants, showings) from 1, -1 where unknown.
        right: (showings,).
        seed: of the shuffles.
    """
    known = (choices >= 0) & (positions >= 1)
    hit = _hits(choices, right) & known
    n = np.bincount(positions[known])[1:]
    beyond = np.where(known, hit - hit.sum(axis=0) / np.maximum(known.sum(axis=0), 1), 0.0)
    groups = [_compact(beyond, positions, known, count) for count in range(2, choices.shape[1] + 1)]
    shuffled = len(choices) <= MOST_SHUFFLED
    slope, p = _slope([group for group in groups if len(group[0])], shuffled, seed)
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
    beyond: NDArray[np.float64], positions: Choices, known: NDArray[np.bool_], count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return residual hits and positions (participants, count), centered, of those with `count` known answers."""
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
        return (0.0, float("nan")) if squares else (float("nan"), float("nan"))
    if not shuffled:
        return float(total / squares), float(2 * ndtr(-abs(total) / np.sqrt(variance)))
    rng, near = np.random.default_rng(seed), 1e-9 * np.sqrt(variance)  # sums in another order may differ by rounding
    draws = np.zeros(DRAWS)
    for y, x in groups:
        batch = max(1, _BATCH // y.size)
        for first in range(0, DRAWS, batch):
            many = min(batch, DRAWS - first)
            draws[first : first + many] += (rng.permuted(np.broadcast_to(y, (many, *y.shape)), axis=2) * x).sum(
                axis=(1, 2)
            )
    return float(total / squares), float((1 + (np.abs(draws) >= abs(total) - near).sum()) / (1 + DRAWS))
