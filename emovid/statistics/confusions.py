"""The confusion matrix and its errors: which wrong answers are frequent, and whether they are near neighbors.

Counts are matrices (labels, signalled), rows perceived, whose first rows are the signaled labels in the order of the
columns, as in `Responses`: the right answer to column j stands in row j, and everything else is an error.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from emovid.statistics.circumplex import ANGLES, distances

Counts = NDArray[np.int64]
Table = NDArray[np.float64]

# Ours: the standard error of a p of 0.05 is then 0.003.
NEAR_DRAWS = 3_999
# Ours: of more errors, or participants with errors, the normal curve serves as well, and the draws would take minutes.
MOST_SHUFFLED_ERRORS = 1_000
_SWEEPS = 12  # through all errors; each swaps about half of them
_ROUNDS, _CLOSE = 5_000, 1e-10  # of proportional fitting


def percent(counts: NDArray[np.int64]) -> Table:
    """Return each count as a percentage of its column (labels, signalled); NaN where a column is empty."""
    total = counts.sum(axis=0)
    return np.where(total > 0, 100 * counts / np.maximum(total, 1), np.nan)


def mutual_information(counts: NDArray[np.int64] | Table) -> float:
    """Return how much an answer tells about the video [bits]: C. Shannon's information of the two margins (1948).

    0 for guessing, log2 of the number of videos for answers that are always right; NaN without answers.
    """
    if not counts.sum():
        return float("nan")
    shares = counts / counts.sum()
    apart = shares.sum(axis=1, keepdims=True) * shares.sum(axis=0, keepdims=True)
    given = shares > 0
    return float((shares[given] * np.log2(shares[given] / apart[given])).sum())


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors against quasi-independence: a model in which a label's share among wrong answers is the same everywhere.

    Attributes:
        expected: errors (labels, signalled) under the model, 0 for right answers.
        residuals: adjusted residuals (labels, signalled): beyond 1.96 an error stands out. NaN for right answers, and
            where the model leaves a cell no freedom, as with two labels.
        bias: how often each label (labels,) is given by mistake, when the videos are taken into account; 1 on average.
            The bias parameters of R. Luce's choice model (1963) with equal similarities. NaN without errors.
    """

    expected: Table
    residuals: Table
    bias: NDArray[np.float64]


def quasi_independence(counts: Counts) -> Errors:
    """Return the errors in `counts` (labels, signalled) against L. Goodman's quasi-independence (JASA 63, 1968).

    Right answers are structural zeros, so recognition does not enter: happiness that is recognized less often than
    anger is not a preference for anger. Errors count as independent: a guide to confusions, not a test.
    """
    errors, free = _errors(counts)
    expected, bias = _fitted(errors, free)
    residuals = np.full(counts.shape, np.nan)
    there = expected > 0
    if there.any():
        weights = np.sqrt(expected[there])
        leverage = (_projection(expected, there) ** 2).sum(axis=1)
        spread = np.where(leverage < 1 - 1e-8, np.sqrt(np.maximum(1 - leverage, 1e-12)), np.nan)
        residuals[there] = (errors[there] - expected[there]) / weights / spread
    return Errors(expected, residuals, bias)


def _errors(counts: Counts) -> tuple[Counts, NDArray[np.bool_]]:
    """Return the wrong answers (labels, signalled) and where wrong answers can be."""
    free = np.eye(*counts.shape) == 0
    return counts * free, free


def _fitted(errors: Counts, free: NDArray[np.bool_]) -> tuple[Table, NDArray[np.float64]]:
    """Return the expected errors of the margins of `errors`, by proportional fitting, and the bias of each label."""
    bias, rows, columns = np.ones(len(errors)), errors.sum(axis=1), errors.sum(axis=0)
    if not errors.sum():
        return np.zeros(errors.shape), np.full(len(errors), np.nan)
    expected = np.zeros(errors.shape)
    for _ in range(_ROUNDS):
        column_sums = bias @ free
        of_videos = np.divide(columns, column_sums, out=np.zeros(len(columns)), where=column_sums > 0)
        expected = bias[:, None] * free * of_videos
        now = expected.sum(axis=1)
        if np.abs(now - rows).max() < _CLOSE * rows.sum():
            break
        bias = bias * np.divide(rows, now, out=np.zeros(len(rows)), where=now > 0)
    return expected, bias / bias.mean()


def _projection(expected: Table, there: NDArray[np.bool_]) -> Table:
    """Return an orthonormal basis (cells, r) of what the margins fix, cells weighted by the root of `expected`."""
    row, column = np.nonzero(there)
    design = np.zeros((len(row), sum(expected.shape)))
    design[np.arange(len(row)), row] = design[np.arange(len(row)), expected.shape[0] + column] = np.sqrt(
        expected[there]
    )
    basis, sizes, _ = np.linalg.svd(design, full_matrices=False)
    return basis[:, sizes > 1e-9 * sizes.max()]


@dataclass(frozen=True)
class NearNeighbors:
    """Test of wrong answers: are they nearer to the signaled emotion on the circumplex than their margins imply?

    Attributes:
        confusions: wrong answers, both emotions having a place on the circle.
        mean_distance: of them from the signaled emotion [degrees]; NaN without confusions.
        expected: mean of that under quasi-independence, given how many errors each video and each label has [degrees].
        p: one-sided, of a mean distance as small; NaN where the margins leave nothing to chance, as with two or three
            labels: the test cannot reject there.
        method: of p, "Monte Carlo", "normal", or "sign flips" where participants answered several videos of an emotion.
        draws, seed: of the Monte Carlo tables or sign flips; 0 and None for "normal".
    """

    confusions: int
    mean_distance: float
    expected: float
    p: float
    method: str
    draws: int
    seed: int | None


def near_neighbors(
    counts: Counts, labels: Sequence[str], seed: int = 0, uses: Sequence[Counts] | None = None
) -> NearNeighbors:
    """Return whether the confusions in `counts` (labels, signalled) fall on near neighbors of the circle.

    Errors swap their labels, so that the number of errors of each video and of each label stays, and no error becomes a
    right answer; a popular label in the middle of the others cannot pass for nearness. The swaps are a Markov chain
    whose p is exact however few there are (J. Besag and P. Clifford, Biometrika 76, 1989). Errors of one participant
    count as independent there. Participants who answered several videos of an emotion repeat their errors, so with
    `uses` the test flips the sign of each participant's part of the mean distance: what their errors add beyond both
    margins (J. Hemerik, J. Goeman and L. Finos, JRSS B 82, 2020).

    Args:
        counts: rows perceived, the first of them the signaled labels in the order of the columns.
        labels: of the rows; those without a place, and "none", are left out.
        seed: of the swaps or sign flips.
        uses: for each column, how often each participant gave each label (participants, labels).
    """
    placed = [row for row, label in enumerate(labels) if label in ANGLES]
    columns = [row for row in placed if row < counts.shape[1]]
    errors, free = _errors(counts[np.ix_(placed, columns)])
    total = int(errors.sum())
    nan = float("nan")
    if not total:
        return NearNeighbors(0, nan, nan, nan, "normal", 0, None)
    apart = distances([labels[row] for row in placed])[:, : len(columns)]
    expected, _ = _fitted(errors, free)
    mean, by_chance = float((apart * errors).sum() / total), float((apart * expected).sum() / total)
    beyond = _beyond_margins(apart, expected)
    spread = np.sqrt((expected * beyond**2).sum())
    if spread < 1e-6:
        return NearNeighbors(total, mean, by_chance, nan, "normal", 0, None)
    rng, independent = np.random.default_rng(seed), total
    if uses is not None:
        parts = (np.stack(uses, axis=2)[:, placed][:, :, columns] * free * beyond).sum(axis=(1, 2))
        parts = parts[np.abs(parts) > 1e-9]
        spread, independent = np.linalg.norm(parts), len(parts)
    if independent > MOST_SHUFFLED_ERRORS:
        p = float(ndtr((mean - by_chance) * total / spread))
        return NearNeighbors(total, mean, by_chance, p, "normal", 0, None)
    p, method = (
        (_swapped_p(apart, errors, rng), "Monte Carlo") if uses is None else (_flipped_p(parts, rng), "sign flips")
    )
    return NearNeighbors(total, mean, by_chance, p, method, NEAR_DRAWS, seed)


def _beyond_margins(apart: Table, expected: Table) -> Table:
    """Return the part of each distance that both margins leave free; its expected sum is 0."""
    there = expected > 0
    weights, basis = np.sqrt(expected[there]), _projection(expected, there)
    beyond = np.zeros(expected.shape)
    beyond[there] = apart[there] - basis @ (basis.T @ (weights * apart[there])) / weights
    return beyond


def _flipped_p(parts: NDArray[np.float64], rng: np.random.Generator) -> float:
    """Return the share of sums, the data's among them, as small when participants' parts have flipped signs."""
    flipped = (1 - 2 * rng.integers(2, size=(NEAR_DRAWS, len(parts)), dtype=np.int8)) @ parts
    return float((1 + (flipped <= parts.sum() + 1e-6).sum()) / (1 + NEAR_DRAWS))


def _swapped_p(apart: Table, errors: Counts, rng: np.random.Generator) -> float:
    """Return the share of tables, the data among them, whose errors lie as near when errors have swapped labels."""
    label, video = (np.repeat(index, errors.ravel()) for index in np.indices(errors.shape).reshape(2, -1))
    pairings = [rng.permutation(len(label))[: len(label) // 2 * 2].reshape(2, -1) for _ in range(_SWEEPS)]
    start = label[None].astype(np.int8)
    for pairing in reversed(pairings):
        start = _swap(start, video, pairing, rng)
    tables = np.repeat(start, NEAR_DRAWS, axis=0)
    for pairing in pairings:
        tables = _swap(tables, video, pairing, rng)
    sums = apart[tables, video].sum(axis=1)
    return float((1 + (sums <= (apart * errors).sum() + 1e-6).sum()) / (1 + NEAR_DRAWS))


def _swap(
    labels: NDArray[np.int8], video: NDArray[np.int64], pairing: NDArray[np.int64], rng: np.random.Generator
) -> NDArray[np.int8]:
    """Return labels (tables, errors) after each pair of errors has swapped them or not, at random."""
    first, second = pairing
    a, b = labels[:, first], labels[:, second]
    swaps = (a != video[second]) & (b != video[first]) & (rng.integers(2, size=a.shape, dtype=np.int8) == 1)
    swapped = labels.copy()
    swapped[:, first], swapped[:, second] = np.where(swaps, b, a), np.where(swaps, a, b)
    return swapped
