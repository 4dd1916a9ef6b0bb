"""The confusion matrix: counts of answers, rows perceived and columns signalled labels."""

import numpy as np
from numpy.typing import NDArray

Counts = NDArray[np.int64]


def percent(counts: Counts) -> NDArray[np.float64]:
    """Return each count as a percentage of its column, (k, m); nan where a column is empty."""
    total = counts.sum(axis=0)
    return np.where(total > 0, 100 * counts / np.maximum(total, 1), np.nan)
