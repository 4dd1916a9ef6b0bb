"""The emotions around the circle of valence and arousal, and whether confusions fall on near neighbours."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

# Degrees from pleasure (0) through arousal (90) to displeasure (180) of the words happy,
# astonished, angry, afraid and sad as J. Russell, "A circumplex model of affect", J. Personality and Social Psychology
# 39, 1980, scaled them with the method of R. Ross, "A statistic for circular series", J. Educational Psychology 29,
# 1938. No word for disgust was scaled; it stands at "distressed", between fear and sadness, where the paper has it:
# Table III lists the emotions counterclockwise in this order.
ANGLES = {"happiness": 7.8, "surprise": 69.8, "anger": 99.0, "fear": 116.0, "disgust": 138.0, "sadness": 207.5}


@dataclass(frozen=True)
class NearNeighbours:
    """Whether wrong answers lie near the signalled emotion on the circle.

    Attributes:
        confusions: wrong answers, both emotions having a place on the circle.
        mean_distance: of them from the signalled emotion [degrees]; NaN without confusions.
        expected: mean of that over relabellings [degrees].
        p: share of all relabellings with a mean distance as small; 1 without confusions.
    """

    confusions: int
    mean_distance: float
    expected: float
    p: float


def distances(labels: Sequence[str]) -> NDArray[np.float64]:
    """Return the angles (labels, labels) [degrees] between emotions, from 0 to 180, NaN where one has no place."""
    angles = np.array([ANGLES.get(label, np.nan) for label in labels])
    apart = np.abs(angles[:, None] - angles)
    return np.minimum(apart, 360 - apart)


def near_neighbours(counts: NDArray[np.int64], labels: Sequence[str]) -> NearNeighbours:
    """Return whether the confusions in `counts` (labels, signalled) fall on near neighbours of the circle.

    The emotions swap places on the circle in every way, all confusions kept: a quadratic assignment test (N. Mantel,
    1967; L. Hubert, 1987). It asks whether this circle fits the table, whoever gave the answers, and is one-sided.
    With six emotions no p is below 1 / 720. A label that is popular with everybody and stands in the middle of the
    others can pass for nearness.

    Args:
        counts: rows perceived, the first of them the signalled labels in the order of the columns.
        labels: of the rows; those without a place, and "none", are left out.
    """
    placed = [row for row, label in enumerate(labels) if label in ANGLES]
    columns = [row for row in placed if row < counts.shape[1]]
    wrong = np.zeros((len(placed), len(placed)))
    wrong[:, : len(columns)] = counts[np.ix_(placed, columns)]
    np.fill_diagonal(wrong, 0)
    total = int(wrong.sum())
    if not total:
        return NearNeighbours(0, float("nan"), float("nan"), 1.0)
    between = distances([labels[row] for row in placed])
    means = [(between[np.ix_(order, order)] * wrong).sum() / total for order in permutations(range(len(placed)))]
    observed = (between * wrong).sum() / total
    return NearNeighbours(
        confusions=total,
        mean_distance=float(observed),
        expected=float(np.mean(means)),
        p=float(np.mean(np.array(means) <= observed + 1e-9)),  # sums in another order may differ by rounding
    )
