"""What the answers of one participant have to do with each other: agreement, and use of labels.

A participant who may go back can play each label once, so answers to several videos are not independent. The tests
here shuffle within participants, or compare videos within them, and so hold whatever that dependence is.

`choices` is (participants, signalled): places in the labels, the signalled ones first, -1 where missing
(`Responses.choices`), so that the right answer to column j is j.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2
from statsmodels.stats.contingency_tables import cochrans_q
from statsmodels.stats.inter_rater import aggregate_raters, fleiss_kappa

from emovid.statistics.goodness import DRAWS

# Above these many participants the large-sample form of the same test is used: shuffling would take minutes and its
# p would differ by less than its own error.
MOST_SHUFFLED = 1_000


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
    """Cochran's Q: whether some videos are recognised more often than others.

    Attributes:
        statistic: Q, 0 where no participant has both hits and misses.
        dof: videos that were shown, less one.
        p: from the chi-squared distribution.
        participants: with complete answers.
    """

    statistic: float
    dof: int
    p: float
    participants: int


@dataclass(frozen=True, eq=False)
class LabelUse:
    """Whether some labels are preferred, whatever the video.

    Attributes:
        totals: answers by label (k,).
        never: share of participants who never gave the label (k,).
        repeated: share who gave it twice or more (k,).
        statistic: quadratic permutation statistic; Friedman's where participants rank the labels.
        dof: labels less one.
        p: of a statistic at least as large when each participant's use of labels is shuffled over the labels.
        method: "permutation" or "chi-squared".
        draws, seed: of the shuffles; 0 and None for "chi-squared".
    """

    totals: NDArray[np.int64]
    never: NDArray[np.float64]
    repeated: NDArray[np.float64]
    statistic: float
    dof: int
    p: float
    method: str
    draws: int
    seed: int | None


def agreement(choices: NDArray[np.int64], k: int) -> Agreement:
    """Return Fleiss' kappa of k labels (J. Fleiss, 1971), which takes each participant to have answered each video."""
    rows, shown = _complete(choices)
    complete = choices[np.ix_(rows, shown)]
    defined = min(complete.shape) > 1 and len(np.unique(complete)) > 1
    kappa = float(fleiss_kappa(aggregate_raters(complete.T, n_cat=k)[0])) if defined else float("nan")
    return Agreement(kappa, *complete.shape)


def videos_differ(choices: NDArray[np.int64]) -> VideosDiffer:
    """Return Cochran's Q (W. Cochran, 1950) of the hits of participants who answered every video that was shown."""
    hits = (choices == np.arange(choices.shape[1]))[np.ix_(*_complete(choices))]
    dof, mixed = max(hits.shape[1] - 1, 0), hits.any(axis=1) & ~hits.all(axis=1)
    if not mixed.any():  # Q is 0 / 0: nobody tells the videos apart
        return VideosDiffer(0.0, dof, 1.0, len(hits))
    test = cochrans_q(hits.astype(np.int64))
    return VideosDiffer(float(test.statistic), dof, float(test.pvalue), len(hits))


def _complete(choices: NDArray[np.int64]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the participants (True) who answered every video that was shown, and the videos that were."""
    answered = choices >= 0
    shown = np.asarray(answered.any(axis=0))  # not every label on offer need have a video
    return np.asarray(answered[:, shown].all(axis=1)), shown


def label_use(choices: NDArray[np.int64], k: int, seed: int = 0) -> LabelUse:
    """Return whether the k labels are used alike, by shuffling each participant's uses of the labels over the labels.

    Counting answers as independent would be wrong: someone who gives each label once has no preference to show. The
    uses are those of a design that shows every label equally often; elsewhere, preference and design are one.
    """
    used = (choices[:, :, None] == np.arange(k)).sum(axis=1)
    totals, scale = used.sum(axis=0), used.var(axis=1, ddof=1).sum()
    statistic = float(((totals - totals.mean()) ** 2).sum() / scale) if scale else 0.0
    shuffled = len(used) <= MOST_SHUFFLED
    people = max(len(used), 1)
    return LabelUse(
        totals=totals,
        never=(used == 0).sum(axis=0) / people,
        repeated=(used > 1).sum(axis=0) / people,
        statistic=statistic,
        dof=k - 1,
        p=_shuffled_uses(used, seed) if shuffled else float(chi2.sf(statistic, k - 1)),
        method="permutation" if shuffled else "chi-squared",
        draws=DRAWS if shuffled else 0,
        seed=seed if shuffled else None,
    )


def _shuffled_uses(used: NDArray[np.int64], seed: int) -> float:
    """Return the share of shuffles, the data among them, whose totals are at least as uneven as those of `used`."""
    rng = np.random.default_rng(seed)
    at_least = sum(
        (rng.permuted(used, axis=1).sum(axis=0) ** 2).sum() >= (used.sum(axis=0) ** 2).sum() for _ in range(DRAWS)
    )
    return float((1 + at_least) / (1 + DRAWS))
