"""A replication beside the original: two confusion matrices of the same labels, from different participants."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from emovid.statistics.goodness import DRAWS
from emovid.statistics.groups import Pair, rate_pair
from emovid.statistics.proportions import fisher_exact, holm, replication_bf, wilson

Matrix = tuple[NDArray[np.int64], tuple[str, ...], tuple[str, ...]]  # counts, labels and signaled labels


@dataclass(frozen=True)
class VideoCompared:
    """One emotion in two studies.

    Attributes:
        hits, n: right answers and answers in the original and in the replication.
        rates: the replication less the original: difference, interval, equivalence (`groups.Pair`).
        p: two-sided, of R. Fisher's exact test of the two rates; NaN where a study has no answers.
        p_holm: after Holm's correction over the emotions that both studies have.
        replication_bf: how much likelier the replication's hits are under the original's rate than under guessing.
        pooled, pooled_low, pooled_high: rate of both studies together, and its 95 % interval.
        statistic: Pearson's chi-squared of homogeneity of all answers, not of hits alone.
        dof: labels given in either study, less one.
        p_answers: of a statistic at least as large when answers are shuffled over the studies, by Monte Carlo.
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
        p_monte_carlo: of a sum at least as large when answers are shuffled over the studies, video by video. A matrix
            does not say who gave which answers: both take those of one participant as independent.
        draws, seed: of the shuffles.
    """

    videos: tuple[VideoCompared, ...]
    statistic: float
    dof: int
    p: float
    p_monte_carlo: float
    draws: int
    seed: int


def compare(
    original: NDArray[np.int64], replication: NDArray[np.int64], seed: int = 0, margin: float | None = None
) -> Compared:
    """Return the replication against the original, two confusion matrices (labels, signalled).

    Margins are held, as in A. Hope, "A simplified Monte Carlo significance test procedure", J. Royal Statistical
    Society B 30, 1968, and in R's chisq.test(simulate.p.value = TRUE).

    Args:
        original: answers of the first study.
        replication: answers of the second.
        seed: of the shuffles.
        margin: within which rates count as equal, as a share, set before the replication.

    Raises:
        ValueError: the matrices differ in shape.
    """
    if original.shape != replication.shape:
        raise ValueError(f"matrices of {original.shape} and {replication.shape} answers cannot be compared")
    rng = np.random.default_rng(seed)
    pairs = list(zip(original.T, replication.T, strict=True))
    statistics = np.array([homogeneity(b[None], a + b)[0] for a, b in pairs])
    shuffled = np.array([_shuffled(a, b, rng) for a, b in pairs]).reshape(len(pairs), DRAWS)
    both = np.array([bool(a.any() and b.any()) for a, b in pairs])
    p_answers = (1 + (shuffled >= statistics[:, None] - 1e-9).sum(axis=1)) / (1 + DRAWS)
    p_answers[~both] = np.nan
    p = np.array(
        [
            fisher_exact((int(a[j]), int(b[j])), (int(a.sum()), int(b.sum()))) if both[j] else np.nan
            for j, (a, b) in enumerate(pairs)
        ]
    )
    videos = tuple(
        _video(j, a, b, margin, (float(statistics[j]), *tests))
        for j, ((a, b), tests) in enumerate(
            zip(pairs, zip(p, holm(p), p_answers, holm(p_answers), strict=True), strict=True)
        )
    )
    total, dof = float(statistics.sum()), sum(video.dof for video in videos)
    return Compared(
        videos=videos,
        statistic=total,
        dof=dof,
        p=float(chdtrc(dof, total)) if dof else float("nan"),
        p_monte_carlo=float((1 + (shuffled.sum(axis=0) >= total - 1e-9).sum()) / (1 + DRAWS)) if dof else float("nan"),
        draws=DRAWS,
        seed=seed,
    )


def aligned(first: Matrix, second: Matrix) -> tuple[NDArray[np.int64], NDArray[np.int64], tuple[str, ...]]:
    """Return two matrices (counts, labels, signalled) with one order of labels, and their videos, of either.

    A video that only one study has is a column of zeros in the other.

    Raises:
        ValueError: the studies' labels differ.
    """
    (_, labels, signalled), (_, other_labels, other_signalled) = first, second
    if set(labels) != set(other_labels):
        raise ValueError(f"labels {labels} and {other_labels} differ")
    videos = (*signalled, *(name for name in other_signalled if name not in signalled))
    order = (*videos, *(label for label in labels if label not in videos))
    tables = []
    for counts, rows, columns in (first, second):
        table = np.zeros((len(order), len(videos)), dtype=np.int64)
        table[np.ix_([order.index(row) for row in rows], [videos.index(name) for name in columns])] = counts
        tables.append(table)
    return tables[0], tables[1], videos


def _video(
    j: int,
    a: NDArray[np.int64],
    b: NDArray[np.int64],
    margin: float | None,
    tests: tuple[float, float, float, float, float],
) -> VideoCompared:
    """Return one emotion from its answers and tests: statistic, p, p_holm, p_answers, p_answers_holm."""
    hits, n = (int(a[j]), int(b[j])), (int(a.sum()), int(b.sum()))
    statistic, p, p_holm, p_answers, p_answers_holm = map(float, tests)
    low, high = wilson(sum(hits), sum(n))
    return VideoCompared(
        hits=hits,
        n=n,
        rates=rate_pair(("replication", "original"), hits[::-1], n[::-1], margin),
        p=p,
        p_holm=p_holm,
        replication_bf=replication_bf((hits[0], n[0]), (hits[1], n[1]), 1 / len(a)) if all(n) else float("nan"),
        pooled=sum(hits) / sum(n) if sum(n) else float("nan"),
        pooled_low=low,
        pooled_high=high,
        statistic=statistic,
        dof=max(int(((a + b) > 0).sum()) - 1, 0) if all(n) else 0,
        p_answers=p_answers,
        p_answers_holm=p_answers_holm,
    )


def homogeneity(second: NDArray[np.int64], total: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return Pearson's chi-squared (S,) of tables whose one row is `second` (S, k) and whose rows add to `total` (k,).

    All rows of `second` have one sum. A table with an empty row has nothing to differ: 0.
    """
    n, everything, used = second[0].sum(), total.sum(), total > 0
    if n in (0, everything):
        return np.zeros(len(second))
    share = n / everything
    return ((second[:, used] - share * total[used]) ** 2 / (share * (1 - share) * total[used])).sum(axis=1)


def _shuffled(a: NDArray[np.int64], b: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the statistic (`DRAWS`,) of shuffles of the answers over two studies of the same sizes."""
    # Unlike "count", this method takes no longer for more answers.
    return homogeneity(rng.multivariate_hypergeometric(a + b, b.sum(), size=DRAWS, method="marginals"), a + b)
