"""Write docs/validation.md: the size of every test and the coverage of every interval, by simulation."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emovid.responses.responses import EMOTIONS
from emovid.statistics.compare import compare
from emovid.statistics.confusions import mutual_information, near_neighbors
from emovid.statistics.goodness import goodness_of_fit
from emovid.statistics.groups import rate_pair, rates_differ, scores_differ
from emovid.statistics.participants import label_use, order_effect, total_recognition, videos_differ
from emovid.statistics.proportions import holm
from emovid.statistics.recognition import accuracy, recognize, unbiased_hit_rates
from emovid.statistics.resampling import information, resampled_counts, unbiased_hit_intervals
from emovid.statistics.showings import Showings

K, PEOPLE = 6, 45
# Table III: rows perceived, columns signaled.
TABLE = np.array(
    [
        [29, 8, 4, 2, 2, 6],
        [5, 26, 4, 1, 0, 0],
        [4, 0, 25, 6, 7, 2],
        [3, 6, 9, 18, 16, 7],
        [3, 2, 2, 12, 18, 1],
        [1, 3, 1, 6, 2, 29],
    ]
)
Random = np.random.Generator
Choices = NDArray[np.int64]


class Case(NamedTuple):
    """A test or an interval under a situation in which its null hypothesis, or its parameter, is known."""

    name: str
    situation: str
    nominal: float
    runs: int
    found: Callable[[Random], float]  # 1 for a rejection or a covered parameter, or a share of several


def showings(choices: Choices, exemplars: int = 1, positions: Choices | None = None) -> Showings:
    """Return answers, columns in the order of the emotions, with several exemplars of each."""
    right = np.repeat(np.arange(choices.shape[1] // exemplars), exemplars)
    names = tuple(f"v{j}" for j in range(len(right)))
    places = np.full_like(choices, -1) if positions is None else positions
    return Showings(choices, places, right, names, K, len(right) // exemplars)


def guesses(rng: Random, people: int = PEOPLE, videos: int = K, alike: float = 0.0) -> Choices:
    """Return guesses, a share of which repeats the favorite label of the participant."""
    favorite = rng.integers(K, size=(people, 1))
    free = rng.integers(K, size=(people, videos))
    return np.where(rng.random((people, videos)) < alike, favorite, free)


def eliminations(rng: Random, people: int = PEOPLE) -> Choices:
    """Return guesses in which everybody gives each label once."""
    return rng.permuted(np.tile(np.arange(K), (people, 1)), axis=1)


def answers(rng: Random, people: int = PEOPLE, exemplars: int = 1, ability: float = 0.0) -> Choices:
    """Return answers by the shares of Table III; abilities shift the odds of a right answer between participants."""
    shares = TABLE / TABLE.sum(axis=0)
    shift = ability * rng.standard_normal((people, 1))
    columns = []
    for emotion in np.repeat(np.arange(K), exemplars):
        odds = shares[emotion, emotion] / (1 - shares[emotion, emotion]) * np.exp(shift[:, 0])
        right = rng.random(people) < odds / (1 + odds)
        wrong = np.where(np.arange(K) == emotion, 0, shares[:, emotion])
        columns.append(np.where(right, emotion, rng.choice(K, people, p=wrong / wrong.sum())))
    return np.array(columns).T


def errors(rng: Random, rates: list[float], favorites: float = 0.0) -> Choices:
    """Return answers with even errors; in a share of them each participant prefers one label."""
    columns, favorite = [], rng.integers(K, size=PEOPLE)
    for emotion, rate in enumerate(rates):
        wrong = (emotion + rng.integers(1, K, PEOPLE)) % K
        liked = (rng.random(PEOPLE) < favorites) & (favorite != emotion)
        columns.append(np.where(rng.random(PEOPLE) < rate, emotion, np.where(liked, favorite, wrong)))
    return np.array(columns).T


def margins_only(rng: Random) -> Choices:
    """Return a confusion matrix whose errors prefer fear, whatever the video: quasi-independence."""
    weights, matrix = np.array([1, 1, 1, 4, 1, 1.0]), np.zeros((K, K), dtype=np.int64)
    for emotion in range(K):
        shares = np.where(np.arange(K) == emotion, 0, weights)
        matrix[:, emotion] = rng.multinomial(22, shares / shares.sum())
    return matrix


def binomial(choices: Choices, exemplars: int = 1) -> float:
    """Return the share of emotions whose test against chance rejects at 5 %."""
    found = showings(choices, exemplars)
    uses = found.by_emotion() if exemplars > 1 else None
    return float(np.mean([test.p_binomial <= 0.05 for test in recognize(found.counts(), uses=uses)]))


def familywise(choices: Choices) -> float:
    """Return whether any emotion is above chance after Holm's correction."""
    return float(any(test.above_chance for test in recognize(showings(choices).counts())))


def goodness(rng: Random, exemplars: int) -> float:
    """Return whether the exact test of one emotion rejects when participants guess."""
    found = showings(guesses(rng, 45, exemplars, 0.4 * (exemplars > 1)), exemplars)
    return float(goodness_of_fit(found.counts()[:, 0], uses=found.by_emotion()[0]).p_exact <= 0.05)


def rates_covered(rng: Random, exemplars: int, ability: float) -> float:
    """Return the share of emotions whose interval covers the rate; that of abilities is found by a large study."""
    found = showings(answers(rng, exemplars=exemplars, ability=ability), exemplars)
    tests = recognize(found.counts(), uses=found.by_emotion())
    return float(
        np.mean([test.ci_low <= rate <= test.ci_high for test, rate in zip(tests, truth(ability)[0], strict=True)])
    )


_truths: dict[float, tuple[NDArray[np.float64], NDArray[np.float64], float]] = {}


def truth(ability: float) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return rates, unbiased hit rates and information of a study of 400,000 participants."""
    if ability not in _truths:
        counts = showings(answers(np.random.default_rng(0), 400_000, ability=ability)).counts()
        _truths[ability] = np.diag(counts) / counts.sum(axis=0), unbiased_hit_rates(counts), mutual_information(counts)
    return _truths[ability]


def bootstrap_covered(rng: Random, what: str, ability: float) -> float:
    """Return the share of bootstrap intervals that cover the value of a very large study."""
    found = showings(answers(rng, ability=ability))
    samples = resampled_counts(found, int(rng.integers(1_000_000)))
    _, hu, bits = truth(ability)
    if what == "hu":
        ends = unbiased_hit_intervals(found, samples)
        return float(np.mean((ends[:, 0] <= hu) & (hu <= ends[:, 1])))
    known = information(found.counts(), samples)
    return float(known.ci_low <= bits <= known.ci_high)


def accuracy_covered(rng: Random, ability: float) -> float:
    """Return whether the interval of all answers covers the mean rate of a very large study."""
    choices = answers(rng, ability=ability)
    hits = (choices == np.arange(K)).sum(axis=1)
    found = accuracy(showings(choices).counts(), hits, np.full(len(hits), K))
    return float(found.ci_low <= truth(ability)[0].mean() <= found.ci_high)


def order(rng: Random) -> float:
    """Return whether the test of the order rejects without an effect of it."""
    positions = rng.permuted(np.tile(np.arange(1, K + 1), (PEOPLE, 1)), axis=1)
    return float(order_effect(answers(rng, ability=1.0), positions, seed=int(rng.integers(1_000_000))).p <= 0.05)


def groups(
    rng: Random, sizes: tuple[int, int], ability: tuple[float, float], exemplars: int = 1
) -> tuple[float, float]:
    """Return whether scores differ, and the share of emotions whose rates do, where neither does in the population."""
    parts = [even(rng, size, exemplars, sd) for size, sd in zip(sizes, ability, strict=True)]
    found = showings(np.vstack(parts), exemplars)
    group = ["a"] * sizes[0] + ["b"] * sizes[1]
    seed = int(rng.integers(1_000_000))
    p = np.array([test.p for test in rates_differ(found, group, seed)])
    return float(scores_differ(found, group, seed).p <= 0.05), float(np.mean(p <= 0.05))


def even(rng: Random, people: int, exemplars: int, spread: float) -> Choices:
    """Return answers that are right at one half on average, with rates that vary evenly between participants."""
    rates = 0.5 + spread * (rng.random((people, 1)) - 0.5)
    right = np.repeat(np.arange(K), exemplars)
    hit = rng.random((people, len(right))) < rates
    return np.where(hit, right, (right + rng.integers(1, K, hit.shape)) % K)


def newcombe_covered(rng: Random) -> float:
    """Return whether the interval covers a difference of 10 points."""
    n, rates = (13, 32), (0.6, 0.5)
    hits = rng.binomial(n, rates)
    pair = rate_pair(("a", "b"), (int(hits[0]), int(hits[1])), n)
    return float(pair.ci_low <= 0.1 <= pair.ci_high)


def equivalence(rng: Random) -> float:
    """Return whether equivalence is found at the margin."""
    hits = rng.binomial(100, (0.6, 0.4))  # exactly the margin apart: no equivalence
    return float(bool(rate_pair(("a", "b"), (int(hits[0]), int(hits[1])), (100, 100), margin=0.2).equivalent))


def replication(rng: Random) -> float:
    """Return whether any emotion differs between two studies of the same shares."""
    first, second = (showings(answers(rng)).counts() for _ in range(2))
    p = np.array([video.p for video in compare(first, second).videos])
    return float((holm(p) <= 0.05).any())


def label_use_rejects(rng: Random, rates: list[float], favorites: float) -> float:
    """Return whether the test of preferred labels rejects."""
    return float(label_use(showings(errors(rng, rates, favorites))).p <= 0.05)


UNEQUAL = [0.9, 0.9, 0.9, 0.3, 0.3, 0.3]
ABLE = "participants vary (SD 1 in log odds)"
ALIKE = "guessing, 3 videos an emotion, 40 % of answers a favorite"


def rejects(p: float) -> float:
    """Return whether a test rejects at 5 %."""
    return float(p <= 0.05)


def near(rng: Random) -> float:
    """Return whether the test of near neighbors rejects under quasi-independence."""
    return rejects(near_neighbors(margins_only(rng), EMOTIONS, int(rng.integers(1_000_000))).p)


def near_repeated(rng: Random) -> float:
    """Return whether the test of near neighbors rejects when participants give each answer three times."""
    found = showings(np.repeat(errors(rng, [0.5] * K), 3, axis=1), 3)
    return rejects(near_neighbors(found.counts(), EMOTIONS, int(rng.integers(1_000_000)), found.by_emotion()).p)


def replicated_moods(rng: Random) -> float:
    """Return whether the whole matrices of two studies differ, whose participants each prefer a label."""
    both = [np.stack(showings(guesses(rng, 30, alike=0.8)).by_emotion(), axis=2) for _ in range(2)]
    people = both[0], both[1]
    return rejects(compare(both[0].sum(axis=0), both[1].sum(axis=0), people=people).p_monte_carlo)


def informative(rng: Random) -> float:
    """Return whether the interval of mutual information excludes 0 when everybody guesses."""
    found = showings(guesses(rng, 30))
    return float(information(found.counts(), resampled_counts(found, int(rng.integers(1_000_000)))).ci_low > 0)


SIZES = (
    ("Recognition, exact binomial", "guessing, 45 participants", 1000, lambda r: binomial(guesses(r))),
    ("Recognition, exact permutation", ALIKE, 500, lambda r: binomial(guesses(r, videos=18, alike=0.4), 3)),
    ("H1, Holm over six emotions", "guessing: any emotion above chance", 1000, lambda r: familywise(guesses(r))),
    ("Goodness of fit, exact", "guessing, 45 participants", 1000, lambda r: goodness(r, 1)),
    ("Goodness of fit, permutation", ALIKE, 300, lambda r: goodness(r, 3)),
    ("All hits, exact", "guessing", 1000, lambda r: rejects(total_recognition(guesses(r)).p)),
    ("All hits, exact", "each label given once", 1000, lambda r: rejects(total_recognition(eliminations(r)).p)),
    ("Cochran's Q", "equal rates, participants vary", 1000, lambda r: rejects(videos_differ(even(r, 45, 1, 0.8)).p)),
    ("Preferred labels", "even errors, recognition equal", 1000, lambda r: label_use_rejects(r, [0.5] * K, 0)),
    ("Preferred labels", "even errors, recognition 90 and 30 %", 1000, lambda r: label_use_rejects(r, UNEQUAL, 0)),
    ("Preferred labels", "personal favorites, none of all", 1000, lambda r: label_use_rejects(r, [0.5] * K, 0.4)),
    ("Near neighbors", "errors prefer fear, whatever the video", 400, near),
    ("Order", "no effect, participants and videos vary", 200, order),
    ("Scores, studentized", "13 and 32 participants, alike", 400, lambda r: groups(r, (13, 32), (0.6, 0.6))[0]),
    ("Scores, studentized", "13 that vary more and 32", 400, lambda r: groups(r, (13, 32), (1.0, 0.0))[0]),
    ("Rates of groups, Fisher", "13 and 32 participants", 400, lambda r: groups(r, (13, 32), (0.6, 0.6))[1]),
    ("Rates of groups, permutation", "the same, 3 videos", 60, lambda r: groups(r, (13, 32), (1.0, 1.0), 3)[1]),
    ("Equivalence, two one-sided tests", "rates exactly the margin apart", 2000, equivalence),
    ("Replication, Fisher and Holm", "the same shares twice: any emotion differs", 200, replication),
)
COVERAGES = (
    ("Interval of a rate, Wilson", "45 participants, Table III", 1000, lambda r: rates_covered(r, 1, 0.0)),
    ("Interval of a rate, effective n", f"3 videos an emotion, {ABLE}", 500, lambda r: rates_covered(r, 3, 1.0)),
    ("Interval of accuracy", f"Table III, {ABLE}", 3000, lambda r: accuracy_covered(r, 1.0)),
    ("Interval of a difference, Newcombe", "60 % of 13, 50 % of 32", 2000, newcombe_covered),
    ("Interval of the unbiased hit rate", "Table III", 300, lambda r: bootstrap_covered(r, "hu", 0.0)),
    ("Interval of the unbiased hit rate", f"Table III, {ABLE}", 300, lambda r: bootstrap_covered(r, "hu", 1.0)),
    ("Interval of mutual information", "Table III", 200, lambda r: bootstrap_covered(r, "bits", 0.0)),
)
MORE_SIZES = (
    ("Replication, whole matrix", "guessing, 80 % of answers a favorite: participants shuffled", 200, replicated_moods),
    ("Mutual information above 0", "guessing, 30 participants", 100, informative),
    ("Near neighbors, sign flips", "even errors, each given to 3 videos of an emotion", 1000, near_repeated),
)
CASES = [
    Case(name, situation, nominal, runs, found)
    for nominal, group in ((0.05, SIZES), (0.95, COVERAGES), (0.05, MORE_SIZES))
    for name, situation, runs, found in group
]


def simulated(case: Case, place: int) -> tuple[float, float]:
    """Return the mean over the runs of a case, and its standard error."""
    rng = np.random.default_rng(1000 + place)
    found = np.array([case.found(rng) for _ in range(case.runs)])
    return float(found.mean()), float(found.std(ddof=1) / np.sqrt(case.runs))


def page(found: list[tuple[float, float]]) -> str:
    """Return the page."""
    rows = [
        f"| {case.name} | {case.situation} | {case.nominal:.2f} | {mean:.3f} ± {error:.3f} | {case.runs:,} |"
        for case, (mean, error) in zip(CASES, found, strict=True)
    ]
    return "\n".join(
        (
            "# Validation of the statistics",
            "",
            "How often each test rejects a true null hypothesis at 5 %, and how often each 95 % interval covers the",
            "true value, in simulated studies. Exact tests stay below 5 %, since answers are whole numbers. Written by",
            "`make validate-statistics`; [Statistics](statistics.md) has the formulas.",
            "",
            "| test or interval | situation | nominal | found ± standard error | studies |",
            "|---|---|---|---|---|",
            *rows,
            "",
        )
    )


if __name__ == "__main__":
    results = []
    for number, case in enumerate(CASES):
        results.append(simulated(case, number))
        print(f"{case.name}; {case.situation}: {results[-1][0]:.3f} ({case.nominal:.2f})", flush=True)
    (Path(sys.argv[1]) / "validation.md").write_text(page(results), encoding="utf-8")
