"""A replication beside the original: two confusion matrices of the same labels, from different participants."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from emovid.statistics.goodness import DRAWS
from emovid.statistics.pairs import newcombe
from emovid.statistics.recognition import holm

Matrix = tuple[NDArray[np.int64], tuple[str, ...], tuple[str, ...]]  # counts, labels and signalled labels


@dataclass(frozen=True)
class VideoCompared:
    """One video in two studies.

    Attributes:
        hits, n: right answers and answers in the original and in the replication.
        difference: of the rates, replication less original; NaN where a study has no answers.
        ci_low, ci_high: its 95 % interval, by R. Newcombe, "Interval estimation for the difference between
            independent proportions", Statistics in Medicine 17, 1998, method 10.
        statistic: Pearson's chi-squared of homogeneity of all answers, not of hits alone.
        dof: labels given in either study, less one.
        p: of a statistic at least as large when participants are shuffled over the studies, by Monte Carlo.
        p_holm: after Holm's correction over the videos that both studies have.
    """

    hits: tuple[int, int]
    n: tuple[int, int]
    difference: float
    ci_low: float
    ci_high: float
    statistic: float
    dof: int
    p: float
    p_holm: float


@dataclass(frozen=True)
class Compared:
    """Two studies.

    Attributes:
        videos: one by one.
        statistic: sum of their chi-squared.
        dof: sum of theirs.
        p: from the chi-squared distribution, poor where expected counts are below 5.
        p_monte_carlo: of a sum at least as large when participants are shuffled over the studies, video by video.
        draws, seed: of the shuffles.
    """

    videos: tuple[VideoCompared, ...]
    statistic: float
    dof: int
    p: float
    p_monte_carlo: float
    draws: int
    seed: int


def compare(original: NDArray[np.int64], replication: NDArray[np.int64], seed: int = 0) -> Compared:
    """Return the replication against the original, two confusion matrices (labels, signalled).

    Margins are held, as in A. Hope, "A simplified Monte Carlo significance test procedure", J. Royal Statistical
    Society B 30, 1968, and in R's chisq.test(simulate.p.value = TRUE). Matrices do not say who gave which answers, so
    the sum over videos takes those of one participant as independent; the tests of single videos need no such thing.

    Raises:
        ValueError: the matrices differ in shape.
    """
    if original.shape != replication.shape:
        raise ValueError(f"matrices of {original.shape} and {replication.shape} answers cannot be compared")
    rng = np.random.default_rng(seed)
    pairs = list(zip(original.T, replication.T, strict=True))
    statistics = np.array([homogeneity(b[None], a + b)[0] for a, b in pairs])
    shuffled = np.array([_shuffled(a, b, rng) for a, b in pairs]).reshape(len(pairs), DRAWS)
    dofs = [max(int(((a + b) > 0).sum()) - 1, 0) if a.any() and b.any() else 0 for a, b in pairs]
    p = (1 + (shuffled >= statistics[:, None] - 1e-9).sum(axis=1)) / (1 + DRAWS)
    adjusted = holm(p, np.array([bool(a.any() and b.any()) for a, b in pairs]))
    total, dof = statistics.sum(), sum(dofs)
    return Compared(
        videos=tuple(
            _video(j, a, b, float(statistics[j]), dofs[j], float(p[j]), float(adjusted[j]))
            for j, (a, b) in enumerate(pairs)
        ),
        statistic=float(total),
        dof=dof,
        p=float(chi2.sf(total, dof)) if dof else 1.0,
        p_monte_carlo=float((1 + (shuffled.sum(axis=0) >= total - 1e-9).sum()) / (1 + DRAWS)),
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
    j: int, a: NDArray[np.int64], b: NDArray[np.int64], statistic: float, dof: int, p: float, adjusted: float
) -> VideoCompared:
    hits, n = (int(a[j]), int(b[j])), (int(a.sum()), int(b.sum()))
    difference = low = high = float("nan")
    if all(n):
        difference = hits[1] / n[1] - hits[0] / n[0]
        low, high = newcombe(hits[::-1], n[::-1])
    return VideoCompared(hits, n, difference, low, high, statistic, dof, p, adjusted)


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
