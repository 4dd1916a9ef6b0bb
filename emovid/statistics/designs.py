"""Power of a whole study, by simulation, and sequential designs with their error rates.

Participants and videos vary: the log odds of a right answer are a constant plus a normal effect of the participant and
one of the video, and the constant is such that the mean rate is the planned one. Wrong answers are spread evenly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtrc, betainc, betaln, expit, ndtr, ndtri, stdtr, stdtrit
from scipy.stats import binom

Goal = Literal["h1", "difference", "equivalence"]
GOALS: tuple[Goal, ...] = ("h1", "difference", "equivalence")
MOST = 4_000  # participants; more could not be simulated in a minute
_STUDIES = 1_000  # the standard error of a power of 0.8 is then 0.013
_FINAL = 4_000  # and here 0.006


@dataclass(frozen=True)
class Design:
    """A study that is planned.

    Attributes:
        goal: "h1" (every emotion is recognized above chance, after Holm's correction), "difference" (the mean scores of
            two groups differ), or "equivalence" (two groups of one mean score are equivalent within the margin).
        rate: mean hit rate; of the first group for "difference".
        k: labels.
        emotions: that are shown.
        exemplars: videos of each emotion.
        participant_sd, video_sd: standard deviations of the log odds.
        difference: of the groups' rates, for "difference".
        margin: of equivalence, as a share.
        share: of the participants who are in the first group.
        alpha: level of the whole.
    """

    goal: Goal
    rate: float
    k: int = 6
    emotions: int = 6
    exemplars: int = 1
    participant_sd: float = 0.5
    video_sd: float = 0.0
    difference: float = 0.15
    margin: float = 0.15
    share: float = 0.5
    alpha: float = 0.05


@dataclass(frozen=True)
class Planned:
    """Participants for a design.

    Attributes:
        participants: smallest number that reaches the desired power; None if over `MOST`.
        power: with them; NaN for None.
        error: standard error of that power.
        studies: simulated for it.
    """

    participants: int | None
    power: float
    error: float
    studies: int


def participants_for(design: Design, power: float = 0.8, seed: int = 0) -> Planned:
    """Return how many participants a design needs.

    Raises:
        ValueError: for numbers that cannot be.
    """
    _check(design, power)
    low, high = 4, 16
    while high <= MOST and simulated_power(design, high, seed)[0] < power:
        low, high = high, 2 * high
    if high > MOST:
        return Planned(None, float("nan"), float("nan"), 0)
    while high - low > max(1, high // 50):
        middle = (low + high) // 2
        low, high = (low, middle) if simulated_power(design, middle, seed)[0] >= power else (middle, high)
    found, error = simulated_power(design, high, seed + 1, _FINAL)
    while found < power and high < MOST:
        high += max(1, high // 50)
        found, error = simulated_power(design, high, seed + 1, _FINAL)
    return Planned(high, found, error, _FINAL)


def _check(design: Design, power: float) -> None:
    if not 1 / design.k < design.rate < 1:
        raise ValueError(f"a hit rate of {design.rate:g} is not between the chance of {1 / design.k:.4g} and 1")
    if not 0 < design.rate - design.difference < 1 and design.goal == "difference":
        raise ValueError(f"a difference of {design.difference:g} leaves no rate between 0 and 1 for the second group")
    if not (0 < design.alpha < 1 and 0 < power < 1 and 0 < design.share < 1):
        raise ValueError(f"alpha {design.alpha:g}, power {power:g} and share {design.share:g} must be between 0 and 1")


def simulated_power(design: Design, participants: int, seed: int = 0, studies: int = _STUDIES) -> tuple[float, float]:
    """Return the share of simulated studies that reach the goal, and its standard error."""
    rng, reached = np.random.default_rng(seed), 0
    batch = max(1, 2_000_000 // (participants * design.emotions * design.exemplars))
    for first in range(0, studies, batch):
        many = min(batch, studies - first)
        rates = np.full(participants, design.rate)
        first_group = max(2, min(participants - 2, round(participants * design.share)))
        if design.goal == "difference":
            rates[first_group:] -= design.difference
        hits = _hits(design, rates, many, rng)
        if design.goal == "h1":
            reached += int(_all_above(hits, design, rng).sum())
        else:
            reached += int(_compared(hits.mean(axis=(2, 3)), first_group, design).sum())
    power = reached / studies
    return power, float(np.sqrt(max(power * (1 - power), 1 / studies) / studies))


def _hits(design: Design, rates: NDArray[np.float64], studies: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return hits (studies, participants, emotions, exemplars)."""
    spread = float(np.hypot(design.participant_sd, design.video_sd))
    constants = {rate: _constant(rate, spread) for rate in set(rates.tolist())}
    odds = np.array([constants[rate] for rate in rates.tolist()])[None, :, None, None]
    shape = (studies, len(rates), design.emotions, design.exemplars)
    participants = design.participant_sd * rng.standard_normal((studies, len(rates), 1, 1))
    videos = design.video_sd * rng.standard_normal((studies, 1, *shape[2:]))
    return np.asarray(rng.random(shape) < expit(odds + participants + videos))


def _constant(rate: float, spread: float) -> float:
    """Return the log odds whose mean rate over normal effects is `rate`."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(41)
    low, high = -30.0, 30.0
    for _ in range(60):
        middle = (low + high) / 2
        mean = float(weights @ expit(middle + spread * nodes) / weights.sum())
        low, high = (middle, high) if mean < rate else (low, middle)
    return (low + high) / 2


def _all_above(hits: NDArray[np.bool_], design: Design, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return whether all emotions are above chance after Holm's correction (studies,)."""
    people, total = hits.shape[1], hits.sum(axis=(1, 3))
    if design.exemplars == 1:
        p = bdtrc(total - 1.0, people, 1 / design.k)
        p[total == 0] = 1.0
    else:  # the normal curve of the permutation test, from the labels that each participant gave
        wrong = rng.integers(design.k - 1, size=hits.shape)
        wrong_alike = np.stack([((wrong == label) & ~hits).sum(axis=3) for label in range(design.k - 1)])
        right = hits.sum(axis=3)
        mean = design.exemplars / design.k
        variance = ((wrong_alike - mean) ** 2).sum(axis=0) / design.k + (right - mean) ** 2 / design.k
        z = (total - people * mean - 0.5) / np.sqrt(np.maximum(variance.sum(axis=1), 1e-12))
        p = ndtr(-z)
    steps = design.alpha / np.arange(design.emotions, 0, -1)
    return np.asarray((np.sort(p, axis=1) <= steps).all(axis=1))


def _compared(scores: NDArray[np.float64], first: int, design: Design) -> NDArray[np.bool_]:
    """Return whether Welch's test finds a difference, or two one-sided tests equivalence (studies,)."""
    a, b = scores[:, :first], scores[:, first:]
    parts = np.array([a.var(axis=1, ddof=1) / a.shape[1], b.var(axis=1, ddof=1) / b.shape[1]]) + 1e-12
    error = np.sqrt(parts.sum(axis=0))
    dof = parts.sum(axis=0) ** 2 / (parts[0] ** 2 / (a.shape[1] - 1) + parts[1] ** 2 / (b.shape[1] - 1))
    apart = np.abs(a.mean(axis=1) - b.mean(axis=1))
    if design.goal == "difference":
        return np.asarray(2 * stdtr(dof, -apart / error) <= design.alpha)
    return np.asarray(apart + stdtrit(dof, 1 - design.alpha) * error < design.margin)


Rule = Literal["alpha", "bayes"]
RULES: tuple[Rule, ...] = ("alpha", "bayes")


@dataclass(frozen=True)
class Sequential:
    """A sequential test of one emotion against guessing, with a rule fixed beforehand.

    Attributes:
        rule: "alpha" (alpha spending by K. Lan and D. DeMets, Biometrika 70, 1983, with O'Brien and Fleming's
            function, exact binomial) or "bayes" (stop at a Bayes factor, F. Schönbrodt and E.-J. Wagenmakers,
            Psychonomic Bulletin & Review 25, 2018).
        looks: participants at each look.
        above: fewest hits at each look that stop for "above chance"; more than the participants where none do.
        chance_stop: most hits at each look that stop for "at chance"; -1 where none do.
        false_alarms: probability to stop for "above chance" when everybody guesses.
        power: probability to stop for it at the planned rate.
        expected: mean participants when everybody guesses, and at the planned rate.
        simulated_false_alarms, simulated_power: the same of 20,000 simulated studies.
    """

    rule: Rule
    looks: tuple[int, ...]
    above: tuple[int, ...]
    chance_stop: tuple[int, ...]
    false_alarms: float
    power: float
    expected: tuple[float, float]
    simulated_false_alarms: float
    simulated_power: float


def sequential(
    rule: Rule,
    looks: Sequence[int],
    rate: float,
    k: int = 6,
    alpha: float = 0.05,
    threshold: float = 10.0,
    seed: int = 0,
) -> Sequential:
    """Return a sequential test with looks after these numbers of participants.

    Args:
        rule: as in `Sequential`.
        looks: ascending.
        rate: planned hit rate.
        k: labels.
        alpha: level, for "alpha".
        threshold: Bayes factor of a rate above chance, uniform there, against chance; and its inverse.
        seed: of the simulated studies.

    Raises:
        ValueError: for numbers that cannot be.
    """
    if not 1 / k < rate <= 1 or list(looks) != sorted({*looks}) or not looks or looks[0] < 1:
        raise ValueError("expected a rate above chance, and looks after ascending numbers of participants")
    if rule == "alpha":
        above, stop = _spent(looks, 1 / k, alpha), [-1] * len(looks)
    else:
        bounds = [_bayes_bounds(n, 1 / k, threshold) for n in looks]
        above, stop = [bound[0] for bound in bounds], [bound[1] for bound in bounds]
    false, under_chance = _stopped(looks, above, stop, 1 / k)
    power, under_rate = _stopped(looks, above, stop, rate)
    rng = np.random.default_rng(seed)
    return Sequential(
        rule=rule,
        looks=tuple(looks),
        above=tuple(above),
        chance_stop=tuple(stop),
        false_alarms=false,
        power=power,
        expected=(under_chance, under_rate),
        simulated_false_alarms=_simulated(looks, above, stop, 1 / k, rng),
        simulated_power=_simulated(looks, above, stop, rate, rng),
    )


def _spent(looks: Sequence[int], chance: float, alpha: float) -> list[int]:
    """Return the fewest hits at each look whose probability by chance stays within what may be spent by then."""
    above, spent, going, before = [], 0.0, np.ones(1), 0
    for n in looks:
        going = np.convolve(going, _pmf(n - before, chance))
        allowed = 2 * float(ndtr(-ndtri(1 - alpha / 2) / np.sqrt(n / looks[-1])))
        tail = going[::-1].cumsum()[::-1]
        fits = np.flatnonzero(tail <= allowed - spent)
        critical = int(fits[0]) if len(fits) else n + 1
        spent += float(going[critical:].sum())
        going[critical:] = 0.0
        above.append(critical)
        before = n
    return above


def _bayes_bounds(n: int, chance: float, threshold: float) -> tuple[int, int]:
    """Return the fewest hits of n whose Bayes factor reaches the threshold, and the most whose inverse does."""
    hits = np.arange(n + 1)
    beyond = np.log(np.maximum(1 - betainc(hits + 1, n - hits + 1, chance), 1e-300)) - np.log1p(-chance)
    log_bf = betaln(hits + 1, n - hits + 1) + beyond - hits * np.log(chance) - (n - hits) * np.log1p(-chance)
    above, below = np.flatnonzero(log_bf >= np.log(threshold)), np.flatnonzero(log_bf <= -np.log(threshold))
    return int(above[0]) if len(above) else n + 1, int(below[-1]) if len(below) else -1


def _pmf(n: int, rate: float) -> NDArray[np.float64]:
    return np.asarray(binom.pmf(np.arange(n + 1), n, rate))


def _stopped(looks: Sequence[int], above: Sequence[int], stop: Sequence[int], rate: float) -> tuple[float, float]:
    """Return the probability to stop for "above chance" at a true rate, and the expected number of participants."""
    going, crossed, expected, before = np.ones(1), 0.0, 0.0, 0
    for n, critical, low in zip(looks, above, stop, strict=True):
        expected += (n - before) * float(going.sum())
        going = np.convolve(going, _pmf(n - before, rate))
        crossed += float(going[critical:].sum())
        going[critical:], going[: low + 1] = 0.0, 0.0
        before = n
    return crossed, expected


def _simulated(
    looks: Sequence[int], above: Sequence[int], stop: Sequence[int], rate: float, rng: np.random.Generator
) -> float:
    """Return the share of 20,000 simulated studies that stop for "above chance"."""
    steps = np.diff([0, *looks])
    hits = np.cumsum(rng.binomial(steps, rate, (20_000, len(steps))), axis=1)
    up, down = hits >= np.array(above), hits <= np.array(stop)
    first_up = np.where(up.any(axis=1), up.argmax(axis=1), len(looks))
    first_down = np.where(down.any(axis=1), down.argmax(axis=1), len(looks))
    return float(((first_up < len(looks)) & (first_up <= first_down)).mean())
