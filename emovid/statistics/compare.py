"""A replication beside the original: two confusion matrices of the same labels, from different participants."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from emovid.statistics.goodness import DRAWS
from emovid.statistics.groups import Pair, rate_pair
from emovid.statistics.proportions import effective_n, fisher_exact, holm, replication_bf, wilson

Matrix = tuple[NDArray[np.int64], tuple[str, ...], tuple[str, ...]]  # counts, labels and signalled labels
Uses = NDArray[np.int64]  # (participants, labels, signalled): how often each participant gave each label

_SHUFFLED_PARTICIPANTS = 20_000_000  # in all draws together: a few seconds
_BATCH = 2_000_000  # shuffled participants at once


@dataclass(frozen=True)
class VideoCompared:
    """One emotion in two studies.

    Attributes:
        hits, n: right answers and answers in the original and in the replication.
        rates: the replication less the original: difference, interval, equivalence (`groups.Pair`).
        p: two-sided, of R. Fisher's exact test of the two rates, or of a difference as large when participants who
            gave several answers are shuffled over the studies; NaN where a study has no answers.
        p_holm: after Holm's correction over the emotions that both studies have.
        replication_bf: how much likelier the replication's hits are under the original's rate than under guessing.
        pooled, pooled_low, pooled_high: rate of both studies together, and its 95 % interval.
        statistic: Pearson's chi-squared of homogeneity of all answers, not of hits alone.
        dof: labels given in either study, less one.
        p_answers: of a statistic at least as large by `Compared.shuffled`, by Monte Carlo.
        p_answers_holm: after Holm's correction.
    """

    hits: tuple[int, int]
    n: tuple[int, int]
    rates: Pair
    p: float
    p_holm: float
    replication_bf: float
    pooled: float
    pooled_low: float
    pooled_high: float
    statistic: float
    dof: int
    p_answers: float
    p_answers_holm: float


@dataclass(frozen=True)
class Compared:
    """Two studies.

    Attributes:
        videos: one by one.
        statistic: sum of their chi-squared.
        dof: sum of theirs.
        p: from the chi-squared distribution, poor where expected counts are below 5; NaN where nothing is compared.
        p_monte_carlo: of a sum at least as large when participants, or answers, are shuffled over the studies.
        shuffled: "participants", which holds however the answers of a participant depend on each other; or "answers",
            where a study is a matrix that does not say who gave which: that takes all answers as independent.
        draws, seed: of the shuffles.
    """

    videos: tuple[VideoCompared, ...]
    statistic: float
    dof: int
    p: float
    p_monte_carlo: float
    shuffled: str
    draws: int
    seed: int


def compare(
    original: NDArray[np.int64],
    replication: NDArray[np.int64],
    seed: int = 0,
    margin: float | None = None,
    people: tuple[Uses, Uses] | None = None,
) -> Compared:
    """Return the replication against the original, two confusion matrices (labels, signalled).

    Without participants margins are held, as in A. Hope, "A simplified Monte Carlo significance test procedure", J.
    Royal Statistical Society B 30, 1968, and in R's chisq.test(simulate.p.value = TRUE).

    Args:
        original: answers of the first study.
        replication: answers of the second.
        seed: of the shuffles.
        margin: within which rates count as equal, as a share, set before the replication.
        people: participants of both studies, whose answers add up to the matrices; None where they are not known.

    Raises:
        ValueError: the matrices differ in shape.
    """
    if original.shape != replication.shape:
        raise ValueError(f"matrices of {original.shape} and {replication.shape} answers cannot be compared")
    rng, total = np.random.default_rng(seed), original + replication
    drawn = _shuffled_answers(original, replication, rng) if people is None else _shuffled_participants(*people, rng)
    statistics = homogeneity(replication[None], total)[0]
    shuffled = homogeneity(drawn, total)
    both = original.any(axis=0) & replication.any(axis=0)
    p_answers = (1 + (shuffled >= statistics - 1e-9).sum(axis=0)) / (1 + len(drawn))
    p_answers[~both] = np.nan
    several = people is not None and any((uses.sum(axis=1) > 1).any() for uses in people)
    worth = [_worth(uses) for uses in people] if people is not None and several else None
    p = _rate_tests(original, replication, drawn if worth is not None else None)
    p[~both] = np.nan
    tests = np.array([statistics, p, holm(p), p_answers, holm(p_answers)])
    videos = tuple(
        _video(
            j,
            original[:, j],
            replication[:, j],
            margin,
            tests[:, j],
            None if worth is None else (float(worth[0][j]), float(worth[1][j])),
        )
        for j in range(total.shape[1])
    )
    everything, dof = float(statistics.sum()), sum(video.dof for video in videos)
    extreme = int((shuffled.sum(axis=1) >= everything - 1e-9).sum())
    return Compared(
        videos=videos,
        statistic=everything,
        dof=dof,
        p=float(chdtrc(dof, everything)) if dof else float("nan"),
        p_monte_carlo=(1 + extreme) / (1 + len(drawn)) if dof else float("nan"),
        shuffled="answers" if people is None else "participants",
        draws=len(drawn),
        seed=seed,
    )


def _worth(uses: Uses) -> NDArray[np.float64]:
    """Return the effective number of answers to each emotion (signalled,)."""
    return np.array([effective_n(uses[:, j, j], uses[:, :, j].sum(axis=1)) for j in range(uses.shape[2])])


def _rate_tests(a: NDArray[np.int64], b: NDArray[np.int64], drawn: NDArray[np.int64] | None) -> NDArray[np.float64]:
    """Return the p of the difference of the hit rates of each emotion (signalled,).

    Fisher's exact test; or from replications `drawn` (draws, labels, signalled), whose participants were shuffled.
    """
    places = range(a.shape[1])
    if drawn is None:
        return np.array(
            [fisher_exact((int(a[j, j]), int(b[j, j])), (int(a[:, j].sum()), int(b[:, j].sum()))) for j in places]
        )

    def apart(second: NDArray[np.int64]) -> NDArray[np.float64]:
        first = a + b - second
        rates = [
            np.diagonal(table, axis1=-2, axis2=-1) / np.maximum(table.sum(axis=-2), 1) for table in (first, second)
        ]
        return np.asarray(np.abs(rates[1] - rates[0]))

    return np.asarray((1 + (apart(drawn) >= apart(b) - 1e-9).sum(axis=0)) / (1 + len(drawn)))


def aligned(
    first: Matrix, second: Matrix
) -> tuple[NDArray[np.int64], NDArray[np.int64], tuple[str, ...], tuple[str, ...]]:
    """Return two matrices (counts, labels, signalled) with one order of labels, the order, and their videos, of either.

    A video that only one study has is a column of zeros in the other.

    Raises:
        ValueError: the studies' labels differ.
    """
    (_, labels, signalled), (_, other_labels, other_signalled) = first, second
    if set(labels) != set(other_labels):
        raise ValueError(f"labels {labels} and {other_labels} differ")
    videos = (*signalled, *(name for name in other_signalled if name not in signalled))
    order = (*videos, *(label for label in labels if label not in videos))
    first_table, second_table = (arranged(*study, order, videos) for study in (first, second))
    return first_table, second_table, order, videos


def arranged(
    counts: NDArray[np.int64],
    rows: tuple[str, ...],
    columns: tuple[str, ...],
    order: tuple[str, ...],
    videos: tuple[str, ...],
) -> NDArray[np.int64]:
    """Return counts (..., labels, signalled) with labels and videos in another order."""
    table = np.zeros((*counts.shape[:-2], len(order), len(videos)), dtype=np.int64)
    table[..., [[order.index(row)] for row in rows], [videos.index(name) for name in columns]] = counts
    return table


def _video(
    j: int,
    a: NDArray[np.int64],
    b: NDArray[np.int64],
    margin: float | None,
    tests: NDArray[np.float64],
    worth: tuple[float, float] | None,
) -> VideoCompared:
    """Return one emotion from its answers, tests (statistic, p, p_holm, p_answers, p_answers_holm), and effective n."""
    hits, n = (int(a[j]), int(b[j])), (int(a.sum()), int(b.sum()))
    statistic, p, p_holm, p_answers, p_answers_holm = map(float, tests)
    many = (float(n[0]), float(n[1])) if worth is None else worth
    pooled = sum(hits) / sum(n) if sum(n) else float("nan")
    low, high = wilson(pooled * sum(many), sum(many)) if sum(n) else (0.0, 1.0)
    return VideoCompared(
        hits=hits,
        n=n,
        rates=rate_pair(("replication", "original"), hits[::-1], n[::-1], margin, worth and worth[::-1]),
        p=p,
        p_holm=p_holm,
        replication_bf=replication_bf((hits[0], n[0]), (hits[1], n[1]), 1 / len(a))
        if all(n) and worth is None
        else float("nan"),
        pooled=pooled,
        pooled_low=low,
        pooled_high=high,
        statistic=statistic,
        dof=max(int(((a + b) > 0).sum()) - 1, 0) if all(n) else 0,
        p_answers=p_answers,
        p_answers_holm=p_answers_holm,
    )


def homogeneity(second: NDArray[np.int64], total: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return Pearson's chi-squared (S, signalled) of tables whose one row is `second` (S, labels, signalled).

    The rows of each table add up to `total` (labels, signalled). A table with an empty row has nothing to differ: 0.
    """
    everything = np.maximum(total.sum(axis=0), 1)
    share = second.sum(axis=1) / everything
    spread = np.where(share * (1 - share) > 0, share * (1 - share), np.inf)
    return np.asarray(((second - share[:, None] * total) ** 2 / np.maximum(total, 1)).sum(axis=1) / spread)


def _shuffled_answers(a: NDArray[np.int64], b: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
    """Return replications (draws, labels, signalled) of shuffles of the answers to each emotion over both studies."""
    # Unlike "count", this method takes no longer for more answers.
    drawn = [
        rng.multivariate_hypergeometric(a[:, j] + b[:, j], b[:, j].sum(), size=DRAWS, method="marginals")
        for j in range(a.shape[1])
    ]
    return np.stack(drawn, axis=2)


def _shuffled_participants(first: Uses, second: Uses, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return replications (draws, labels, signalled) of shuffles of the participants over studies of the same sizes."""
    cells = np.concatenate([first, second]).reshape(len(first) + len(second), -1).astype(np.float64)
    draws = min(DRAWS, max(999, _SHUFFLED_PARTICIPANTS // len(cells)))
    batch, found = max(1, _BATCH // len(cells)), []
    for start in range(0, draws, batch):
        order = rng.random((min(batch, draws - start), len(cells)))
        limit = np.partition(order, len(second) - 1, axis=1)[:, len(second) - 1, None]
        found.append((order <= limit) @ cells)
    return np.rint(np.concatenate(found)).astype(np.int64).reshape(draws, *first.shape[1:])
