from itertools import combinations
from math import comb

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import cauchy, chi2_contingency, fisher_exact, nct, norm, ttest_ind
from scipy.stats import t as student

from emovid.statistics.goodness import DRAWS
from emovid.statistics.groups import (
    MIN_GROUP,
    levels_of,
    mean_pair,
    means_bf01,
    rate_pair,
    rates_differ,
    scores_differ,
)
from emovid.statistics.proportions import newcombe, rates_bf01
from emovid.statistics.showings import Showings

N = st.integers(1, 40)


def answers(scores: list[int], videos: int = 6) -> Showings:
    """Return answers (participants, videos) of which the first `score` of each participant are right."""
    right, k = np.arange(videos), max(videos, 2)
    choices = np.array([np.where(right < score, right, (right + 1) % k) for score in scores])
    return Showings(choices, np.full_like(choices, -1), right, tuple(f"v{j}" for j in range(videos)), k, videos)


def test_levels_of_a_group() -> None:
    assert levels_of(["b", "a", "", None, float("nan"), "b"]) == ("a", "b")


def test_scores_agree_with_all_splits() -> None:
    scores = [6, 5, 5, 4, 3, 2, 1]
    test = scores_differ(answers(scores), ["a", "a", "b", "a", "b", "b", "b"])
    splits = [
        ([scores[i] for i in one], [scores[i] for i in range(7) if i not in one]) for one in combinations(range(7), 3)
    ]
    apart = np.array([abs(ttest_ind(*split, equal_var=False).statistic) for split in splits])
    assert test.p == pytest.approx((apart >= apart[1] - 1e-9).mean())  # (0, 1, 3) is the second split
    assert test.studentized
    assert (test.method, test.draws, test.seed) == ("exact", 0, None)
    assert test.means == pytest.approx((15 / 18, 11 / 24))
    assert test.n == (3, 4)


def test_three_groups_and_missing_answers() -> None:
    choices = answers([6, 6, 5, 1, 0, 1, 3, 2, 3, 4])
    choices.choices[9] = -1
    test = scores_differ(choices, list("aaabbbccca"), seed=3)
    assert test.n == (3, 3, 3)
    assert (test.tiny, MIN_GROUP) == (("a", "b", "c"), 5)
    assert [pair.levels for pair in test.pairs] == [("a", "b"), ("a", "c"), ("b", "c")]
    # Welch's statistic over all 9! / 3!^3 splits, by definition.
    scores = np.array([6, 6, 5, 1, 0, 1, 3, 2, 3]) / 6
    found = []
    for one in combinations(range(9), 3):
        left = [i for i in range(9) if i not in one]
        for two in combinations(left, 3):
            groups = [scores[list(one)], scores[list(two)], scores[[i for i in left if i not in two]]]
            weights = np.array([3 / max(group.var(ddof=1), 1e-12) for group in groups])
            means = np.array([group.mean() for group in groups])
            found.append((weights * (means - weights @ means / weights.sum()) ** 2).sum())
    assert len(found) == 1680
    assert test.p == pytest.approx((np.array(found) >= found[0] * (1 - 1e-9)).mean())
    assert (test.method, test.draws, test.seed) == ("exact", 0, None)


def test_a_group_of_one() -> None:
    test = scores_differ(answers([1, 2, 3, 2, 6]), ["a", "a", "b", "b", "c"])
    # Of the 30 splits, by hand: the spread is largest with 6 alone and {1, 2} against {3, 2}.
    assert test.p == pytest.approx(4 / 30)
    assert (test.method, test.studentized, test.tiny) == ("exact", False, ("a", "b", "c"))
    assert [np.isnan(pair.bound) for pair in test.pairs] == [False, True, True]


def test_many_people_use_monte_carlo() -> None:
    scores = [3, 4, 2, 5, 3, 4, 1, 2] * 5
    group = ["a", "b"] * 20
    test = scores_differ(answers(scores), group, seed=2)
    assert (test.method, test.draws, test.seed, test.tiny) == ("Monte Carlo", DRAWS, 2, ())
    assert scores_differ(answers(scores), group, seed=2) == test
    expected = ttest_ind(scores[::2], scores[1::2], equal_var=False).pvalue
    assert test.p == pytest.approx(expected, abs=0.02)


def test_scores_of_unequal_variance_are_studentized() -> None:
    # 12 and 48 people with equal means; the 12 vary three times as much. Without studentization, over 5 % reject.
    rng = np.random.default_rng(8)
    group = ["a"] * 12 + ["b"] * 48
    p = []
    for seed in range(60):
        few, many = rng.choice([0, 6], 12), rng.choice([2, 3, 4], 48, p=[0.2, 0.6, 0.2])
        p.append(scores_differ(answers([*few, *many]), group, seed).p)
    assert np.mean(np.array(p) < 0.05) <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / 60)


@pytest.mark.parametrize("group", [["a"] * 4, [None] * 4, ["a", "", "a", None]])
def test_one_group_is_not_compared(group: list) -> None:
    choices = answers([1, 2, 3, 4])
    assert np.isnan(scores_differ(choices, group).p)
    assert scores_differ(choices, group).pairs == ()
    assert all(np.isnan(test.p) and test.pairs == () for test in rates_differ(choices, group))


def test_rates_of_two_groups_agree_with_fisher() -> None:
    choices = answers([6, 5, 5, 4, 4, 3, 2, 2, 1, 1, 0, 0])
    group = list("aaaaaabbbbbb")
    tests = rates_differ(choices, group)
    for test, threshold in zip(tests, range(1, 7), strict=True):
        table = [[test.hits[0], 6 - test.hits[0]], [test.hits[1], 6 - test.hits[1]]]
        assert test.p == pytest.approx(fisher_exact(table).pvalue)
        assert test.hits[0] == sum(score >= threshold for score in (6, 5, 5, 4, 4, 3))
        assert (test.method, test.draws, test.seed) == ("exact", 0, None)
    # The third video: 6 of 6 against 0 of 6.
    assert tests[2].p == pytest.approx(2 / comb(12, 6))
    assert tests[2].p_holm == pytest.approx(12 / comb(12, 6))


def test_rates_of_three_groups() -> None:
    choices = answers([1] * 5 + [0] * 9 + [1], videos=2)
    group = list("aaaaabbbbbccccc")
    first, second = rates_differ(choices, group, seed=4)
    # Fisher, Freeman and Halton by hand: tables with six hits in 15 that are at most as likely as (5, 0, 1).
    ways = {
        (a, b, 6 - a - b): comb(5, a) * comb(5, b) * comb(5, 6 - a - b)
        for a in range(6)
        for b in range(6)
        if 0 <= 6 - a - b <= 5
    }
    expected = sum(way for way in ways.values() if way <= ways[5, 0, 1]) / comb(15, 6)
    assert first.p == pytest.approx(expected, abs=0.005)
    assert (first.method, first.draws, first.seed) == ("Monte Carlo", DRAWS, 4)
    assert second.hits == (0, 0, 0)
    assert np.isnan(second.p)
    assert first == rates_differ(choices, group, seed=4)[0]


def test_groups_of_one_participant_with_one_hit() -> None:
    (test,) = rates_differ(answers([1, *[0] * 7], videos=1), list("abcdefgh"))
    assert np.isnan(test.p)  # it had to be one of them: no test


def test_a_group_without_answers_to_a_video() -> None:
    choices = answers([1, 1, 0, 0], videos=2)
    choices.choices[2:, 0] = -1
    first, second = rates_differ(choices, list("aabb"))
    assert first.n == (2, 0)
    assert np.isnan([first.p, first.p_holm]).all()
    assert np.isnan(first.pairs[0].difference)
    assert second.n == (2, 2)


def test_newcombe_example() -> None:
    assert newcombe((56, 48), (70, 80)) == pytest.approx((0.0524, 0.3339), abs=5e-5)


def test_equivalence_bound_is_the_wider_end_of_the_90_percent_interval() -> None:
    pair = rate_pair(("a", "b"), (56, 48), (70, 80))
    low, high = newcombe((56, 48), (70, 80), 0.90)
    assert 0.0524 < low < high < 0.3339
    assert pair.bound == high
    assert rate_pair(("b", "a"), (48, 56), (80, 70)).bound == pytest.approx(high)


def test_rates_bf01_by_hand() -> None:
    # One of one against none of one: B(2, 2) / (B(2, 1) B(1, 2)) = (1 / 6) / (1 / 4).
    assert rates_bf01((1, 0), (1, 1)) == pytest.approx(2 / 3)


def test_rates_bf01_by_integration() -> None:
    def likelihood(h: int, m: int) -> float:
        return quad(lambda p: p**h * (1 - p) ** (m - h), 0, 1)[0]

    expected = likelihood(12, 25) / (likelihood(9, 15) * likelihood(3, 10))
    assert rates_bf01((9, 3), (15, 10)) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(4))
def test_means_bf01_agrees_with_integration(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.normal(0.3 * seed, 1, 12), rng.normal(0, 1, 17)
    t, dof, size = ttest_ind(a, b).statistic, 27, np.sqrt(12 * 17 / 29)
    under = quad(lambda d: nct.pdf(t, dof, d * size) * cauchy.pdf(d, scale=np.sqrt(0.5)), -6, 6, limit=200)[0]
    assert means_bf01(a, b) == pytest.approx(student.pdf(t, dof) / under, rel=1e-3)


def test_bayes_factors_of_extreme_data_are_finite() -> None:
    assert 0 < rates_bf01((100_000, 0), (100_000, 100_000)) < 1e-200
    a = np.repeat([0.0, 0.01], 50_000)
    assert 0 < means_bf01(a, a + 1) < 1e-200
    assert means_bf01(a, a) > 100


def test_mean_difference_agrees_with_welch() -> None:
    a, b = np.array([0.2, 0.5, 0.9, 0.4]), np.array([0.3, 0.8, 0.7])
    pair, interval = mean_pair(("a", "b"), a, b), ttest_ind(a, b, equal_var=False).confidence_interval(0.95)
    assert (pair.ci_low, pair.ci_high) == pytest.approx((interval.low, interval.high))
    low, high = ttest_ind(a, b, equal_var=False).confidence_interval(0.90)
    assert pair.bound == pytest.approx(max(-low, high))


@pytest.mark.parametrize("b", [[0.5], [1 / 3, 1 / 3, 1 / 3]])
def test_means_without_variance_have_no_interval(b: list[float]) -> None:
    pair = mean_pair(("a", "b"), np.full(3, 2 / 3), np.array(b))
    assert pair.difference == pytest.approx(2 / 3 - b[0])
    assert np.isnan([pair.ci_low, pair.ci_high, pair.bound, pair.bf01]).all()


@given(N, N, st.data())
@settings(max_examples=30)
def test_rate_pair_is_consistent_and_antisymmetric(n: int, m: int, data) -> None:
    hits = data.draw(st.integers(0, n)), data.draw(st.integers(0, m))
    pair, mirrored = rate_pair(("a", "b"), hits, (n, m)), rate_pair(("b", "a"), hits[::-1], (m, n))
    assert -1 - 1e-9 <= pair.ci_low <= pair.difference + 1e-9
    assert pair.difference <= pair.ci_high + 1e-9 <= 1 + 2e-9
    assert abs(pair.difference) <= pair.bound + 1e-9
    assert mirrored.ci_low == pytest.approx(-pair.ci_high)
    assert mirrored.bf01 == pytest.approx(pair.bf01)


def test_more_people_give_a_smaller_equivalence_bound() -> None:
    bounds = [rate_pair(("a", "b"), (n // 2, n // 2), (n, n)).bound for n in (10, 40, 160, 640)]
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[-1] == pytest.approx(norm.ppf(0.95) * np.sqrt(0.5 / 640), rel=0.01)


def test_three_groups_of_very_many_people() -> None:
    rng = np.random.default_rng(0)
    choices = rng.integers(0, 6, (60_000, 6))
    group = rng.choice(["a", "b", "c"], 60_000).tolist()
    choices[:, 0] = np.where((np.array(group) == "a") & (rng.random(60_000) < 0.05), 0, choices[:, 0])
    showings = Showings(choices, np.full_like(choices, -1), np.arange(6), tuple("uvwxyz"), 6, 6)
    tests = rates_differ(showings, group)
    assert {(test.method, test.draws, test.seed) for test in tests} == {("Monte Carlo", DRAWS, 0)}
    p = [test.p for test in tests]
    assert p[0] == 1 / (DRAWS + 1)
    assert p[1:] == pytest.approx(
        [chi2_contingency([test.hits, np.subtract(test.n, test.hits)]).pvalue for test in tests[1:]], abs=0.02
    )


def test_several_answers_to_an_emotion_are_permuted_by_participant() -> None:
    # Equal answers to two videos of one emotion: twice the answers, but no more evidence.
    hits = np.array([1, 1, 1, 1, 0, 0, 1, 0, 0, 0, 0, 0])
    choices = np.column_stack([1 - hits, 1 - hits])
    group = list("aaaaaabbbbbb")
    both = Showings(choices, np.full_like(choices, -1), np.array([0, 0]), ("v0", "v1"), 2, 1)
    (test,) = rates_differ(both, group)
    assert (test.method, test.hits, test.n) == ("permutation", (8, 2), (12, 12))
    splits = np.array([hits[list(one)].sum() for one in combinations(range(12), 6)])
    assert test.p == pytest.approx((abs(splits - 2.5) >= 1.5 - 1e-9).mean())
    few = 5 * (norm.ppf(0.975) / student.ppf(0.975, 5)) ** 2  # one participant less, for the rate, and a t factor
    once = rate_pair(("a", "b"), (4, 1), (6, 6), worth=(few, few))
    assert (test.pairs[0].ci_low, test.pairs[0].ci_high) == pytest.approx((once.ci_low, once.ci_high))
    assert np.isnan(test.pairs[0].bf01)


def test_equivalence_needs_a_margin_set_beforehand() -> None:
    assert rate_pair(("a", "b"), (150, 150), (300, 300)).equivalent is None
    pair = rate_pair(("a", "b"), (150, 150), (300, 300), margin=0.1)
    assert (pair.margin, pair.equivalent) == (0.1, True)
    assert pair.bound < 0.1
    assert rate_pair(("a", "b"), (15, 15), (30, 30), margin=0.1).equivalent is False
    scores = np.array([0.2, 0.5, 0.9, 0.4])
    assert mean_pair(("a", "b"), scores, scores, margin=0.9).equivalent is True
