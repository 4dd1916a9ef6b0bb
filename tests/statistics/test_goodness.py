import math
from itertools import permutations, product
from math import factorial, prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chisquare

from emovid.statistics.goodness import (
    DRAWS,
    MOST_PARTITIONS,
    exact_p,
    goodness_of_fit,
    monte_carlo_p,
    partitions,
)
from tests.helpers.known import TABLE_III

COUNTS = st.lists(st.integers(0, 12), min_size=2, max_size=7).map(np.array)


def enumerated_p(counts: np.ndarray) -> float:
    """Sum the multinomial probabilities of every composition whose chi-squared is at least that of `counts`."""
    n, k = int(counts.sum()), len(counts)
    p = 0.0
    for cells in product(range(n + 1), repeat=k - 1):
        if sum(cells) <= n:
            full = (*cells, n - sum(cells))
            if chisquare(full).statistic >= chisquare(counts).statistic * (1 - 1e-9):
                p += factorial(n) / prod(map(factorial, full)) / k**n
    return p


def test_chi_squared_of_table_iii() -> None:
    tests = [goodness_of_fit(column) for column in TABLE_III.T]
    assert [t.statistic for t in tests] == pytest.approx([75.133, 60.200, 54.067, 27.667, 39.933, 79.133], abs=5e-4)
    assert all(t.dof == 5 and t.n == 45 and t.expected == 7.5 for t in tests)
    assert all(t.p < 1e-4 and t.p_exact < 1e-4 for t in tests)


@pytest.mark.parametrize(
    ("counts", "statistic", "p", "p_exact"),
    [
        ([20, 7, 5, 5, 4, 4], 25.80, 0.000097, 0.00014),
        ([6, 2, 1, 1, 1, 1], 10, 0.0752, 0.0833),
        ([3, 1, 0, 0, 0, 0], 11, 0.0514, 0.0972),
    ],
)
def test_golden_numbers(counts: list[int], statistic: float, p: float, p_exact: float) -> None:
    test = goodness_of_fit(np.array(counts))
    assert test.statistic == pytest.approx(statistic)
    assert test.p == pytest.approx(p, rel=0.01)
    assert test.p_exact == pytest.approx(p_exact, rel=0.03)
    assert (test.method, test.draws, test.seed) == ("exact", 0, None)


def test_effect_size() -> None:
    assert goodness_of_fit(np.array([20, 7, 5, 5, 4, 4])).cohens_w == pytest.approx(0.757, abs=5e-4)


def test_four_answers_by_hand() -> None:
    # Of 6^4 sequences, 6 give [4], and 30 * 4 give [3, 1].
    assert exact_p(np.array([3, 1, 0, 0, 0, 0])) == pytest.approx((6 + 120) / 6**4, rel=1e-12)


@pytest.mark.parametrize("counts", [[3, 1], [0, 5, 2], [2, 2, 2, 1], [4, 0, 1, 3], [3, 1, 1, 0, 1], [2, 0, 2, 0, 1, 0]])
def test_exact_p_agrees_with_the_sum_over_compositions(counts: list[int]) -> None:
    assert exact_p(np.array(counts)) == pytest.approx(enumerated_p(np.array(counts)), rel=1e-10)


@pytest.mark.parametrize("k", range(2, 13))
def test_exact_p_for_any_number_of_labels(k: int) -> None:
    # All participants give one label: k of k^n outcomes.
    assert exact_p(np.array([9] + [0] * (k - 1))) == pytest.approx(k / k**9, rel=1e-9)
    assert exact_p(np.ones(k, dtype=np.int64)) == pytest.approx(1)


@pytest.mark.parametrize(("n", "k", "count"), [(0, 6, 1), (5, 5, 7), (10, 3, 14), (45, 6, 5942), (100, 6, 189509)])
def test_number_of_partitions(n: int, k: int, count: int) -> None:
    assert partitions(n, k) == count


def test_number_of_partitions_is_capped() -> None:
    assert partitions(10**12, 2) == partitions(2 * MOST_PARTITIONS, 2) == MOST_PARTITIONS + 1
    assert partitions(2 * MOST_PARTITIONS - 1, 2) == MOST_PARTITIONS
    assert partitions(10**6, 1) == 1


def test_result_without_answers_is_undefined() -> None:
    test = goodness_of_fit(np.zeros(6, dtype=np.int64))
    assert test.n == 0
    assert np.isnan([test.statistic, test.p, test.p_exact, test.cohens_w]).all()


def test_many_answers_use_monte_carlo() -> None:
    counts = np.array([60, 45, 45, 45, 45, 45])
    assert partitions(285, 6) > MOST_PARTITIONS
    test = goodness_of_fit(counts, seed=7)
    assert (test.method, test.draws, test.seed) == ("Monte Carlo", DRAWS, 7)
    assert test.p_exact == pytest.approx(test.p, abs=0.015)
    assert goodness_of_fit(counts, seed=7) == test
    assert goodness_of_fit(np.array([285, 0, 0, 0, 0, 0])).p_exact == 1 / (DRAWS + 1)


def test_monte_carlo_agrees_with_exact() -> None:
    counts = np.array([12, 7, 8, 5, 9, 4])
    assert monte_carlo_p(counts, np.random.default_rng(3)) == pytest.approx(exact_p(counts), abs=0.015)


@given(COUNTS, st.randoms())
def test_results_do_not_depend_on_label_order(counts: np.ndarray, random) -> None:
    shuffled = counts.tolist()
    random.shuffle(shuffled)
    p = exact_p(counts)
    assert 0 < p <= 1
    assert exact_p(np.array(shuffled)) == p


@given(COUNTS)
def test_more_uneven_tables_have_smaller_p(counts: np.ndarray) -> None:
    moved = np.sort(counts)
    moved[0], moved[-1] = 0, moved[-1] + moved[0]
    assert exact_p(moved) <= exact_p(counts)


@given(st.integers(1, 40), st.integers(2, 8))
@settings(max_examples=40)
def test_probabilities_add_up_to_one(n: int, k: int) -> None:
    even = np.bincount(np.arange(n) % k, minlength=k)
    assert exact_p(even) == pytest.approx(1, rel=1e-9)


def uses(answers: list[list[int]], k: int) -> np.ndarray:
    return np.array([np.bincount(row, minlength=k) for row in answers])


def test_several_answers_test_agrees_with_every_permutation_of_labels() -> None:
    used = uses([[0, 0], [0, 1], [2, 0]], 3)
    test = goodness_of_fit(used.sum(axis=0), uses=used)
    orders = [list(permutations(row)) for row in used.tolist()]
    totals = np.array([np.sum(rows, axis=0) for rows in product(*orders)])
    expected = ((totals**2).sum(axis=1) >= (used.sum(axis=0) ** 2).sum()).mean()
    assert test.p_exact == pytest.approx(expected, abs=0.015)
    assert (test.method, test.draws, test.seed) == ("Monte Carlo", DRAWS, 0)


def test_permutation_statistic_of_one_answer_each_is_chi_squared() -> None:
    used = uses([[answer] for answer in [0] * 9 + [1] * 4 + [2] * 2], 3)
    test, pearson = goodness_of_fit(used.sum(axis=0), uses=used), goodness_of_fit(used.sum(axis=0))
    assert test == pearson
    twice = goodness_of_fit(
        2 * used.sum(axis=0), uses=2 * used
    )  # all participants repeat their answer: no new evidence
    assert twice.statistic == pytest.approx(pearson.statistic)
    assert twice.p_exact == pytest.approx(pearson.p_exact, abs=0.01)
    assert twice.cohens_w == pytest.approx(pearson.cohens_w)


def test_example_of_the_r_manual() -> None:
    # help(chisq.test): x <- c(A = 20, B = 15, C = 25); chisq.test(x) gives X-squared = 2.5, df = 2, p-value = 0.2865.
    found = goodness_of_fit(np.array([20, 15, 25]))
    assert (found.statistic, found.dof, round(found.p, 4)) == (2.5, 2, 0.2865)
    # Simulated p-values of the same call estimate this sum over outcomes at least as far from equal shares.
    outcomes = [(a, b, 60 - a - b) for a in range(61) for b in range(61 - a)]
    log_p = [math.lgamma(61) - sum(math.lgamma(c + 1) for c in o) - 60 * math.log(3) for o in outcomes]
    beyond = sum(math.exp(p) for o, p in zip(outcomes, log_p, strict=True) if sum(c * c for c in o) >= 1250)
    assert found.p_exact == pytest.approx(beyond, rel=1e-9)
