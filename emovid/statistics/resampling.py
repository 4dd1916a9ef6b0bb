"""Intervals from resampled participants: a cluster bootstrap, which keeps the answers of a participant together."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emovid.statistics.confusions import mutual_information
from emovid.statistics.proportions import wilson
from emovid.statistics.recognition import unbiased_hit_rates
from emovid.statistics.showings import Showings

BOOTSTRAPS = 2_000
# Ours: distinct sets of answers times resamples; at most seconds, also for 100 000 participants.
_BOOTSTRAP_CELLS = 20_000_000
_ENDS = [2.5, 97.5]
FEWEST_RESAMPLED = 20


@dataclass(frozen=True)
class Information:
    """Statistics of the answers to each video.

    Attributes:
        bits: mutual information of answers and videos, as found; NaN without answers.
        corrected: less the bias that resampling shows: few answers look informative by chance; NaN like the interval.
        ci_low, ci_high: 95 % interval of the corrected value, from resampled participants; NaN for fewer than
            `FEWEST_RESAMPLED` participants, whose bootstrap shows too little of the error.
        most: bits of answers that are always right.
        draws, seed: of the bootstrap; 0 and None where participants are not known.
    """

    bits: float
    corrected: float
    ci_low: float
    ci_high: float
    most: float
    draws: int
    seed: int | None


def resampled_counts(showings: Showings, seed: int = 0) -> NDArray[np.float64]:
    """Return confusion matrices (draws, labels, signalled) of participants drawn with replacement."""
    people = len(showings.choices)
    if not people:
        return np.zeros((1, showings.k, showings.emotions))
    alike, often = np.unique(showings.choices, axis=0, return_counts=True)
    same = Showings(alike, alike, showings.right, showings.videos, showings.k, showings.emotions)
    cells = np.stack(same.by_emotion(), axis=2).reshape(len(alike), -1).astype(np.float64)
    draws = min(BOOTSTRAPS, max(200, _BOOTSTRAP_CELLS // max(len(alike), 1)))
    chosen = np.random.default_rng(seed).multinomial(people, often / people, size=draws)
    return np.asarray(chosen @ cells).reshape(draws, showings.k, showings.emotions)


def unbiased_hit_intervals(showings: Showings, samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 95 % percentile intervals (signalled, 2) of Wagner's rate, NaN where the rate is undefined.

    Resamples in which the rate is undefined are left out. Where all resamples agree, since no participant answered
    unlike the others, the bootstrap sees no error at all; there the ends are products of the ends of Wilson's intervals
    for the two shares whose product the rate is, with as many answers as participants.
    """
    counts = showings.counts()
    rates = unbiased_hit_rates(counts)
    intervals = np.full((counts.shape[1], 2), np.nan)
    found = unbiased_hit_rates(samples)
    for j in np.flatnonzero(np.isfinite(rates)):
        intervals[j] = np.nanpercentile(found[:, j], _ENDS)
        if intervals[j, 1] - intervals[j, 0] < 1e-9:
            people = int((showings.choices[:, showings.right == j] >= 0).any(axis=1).sum())
            shares = counts[j, j] / np.array([counts[:, j].sum(), counts[j].sum()])
            intervals[j] = np.prod([wilson(share * people, people) for share in shares], axis=0)
    return intervals


def information(
    counts: NDArray[np.int64], samples: NDArray[np.float64] | None, seed: int = 0, participants: int = FEWEST_RESAMPLED
) -> Information:
    """Return the mutual information of answers and videos in `counts`, with its interval from `samples` of it."""
    nan = float("nan")
    bits = mutual_information(counts)
    most = float(np.log2(max(int(counts.any(axis=0).sum()), 1)))
    if samples is None or not np.isfinite(bits):
        return Information(bits, nan, nan, nan, most, 0, None)
    found = np.array([mutual_information(sample) for sample in samples])
    if np.ptp(found) < 1e-9 or participants < FEWEST_RESAMPLED:  # where all answer alike it sees no error at all
        return Information(bits, nan, nan, nan, most, len(samples), seed)
    bias = float(np.nanmean(found) - bits)
    low, high = np.clip(np.nanpercentile(found, _ENDS) - 2 * bias, 0.0, most)
    return Information(bits, max(bits - bias, 0.0), float(low), float(high), most, len(samples), seed)
