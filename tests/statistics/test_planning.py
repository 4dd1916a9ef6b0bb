from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom, binomtest, multinomial

from emovid.statistics import planning
from emovid.statistics.goodness import exact_p
from emovid.statistics.planning import (
    MOST_PARTICIPANTS,
    critical_hits,
    goodness_power,
    n_binomial,
    n_goodness,
    plan,
    w_of_rate,
)


def binomial_power(rate: float, n: int, k: int = 6, alpha: float = 0.05) -> float:
    """Return the exact probability that n answers with true hit rate `rate` are significantly above 1 / k."""
    return float(binom.sf(critical_hits(n, k, alpha) - 1, n, rate))


def test_golden_sizes() -> None:
    assert (n_binomial(0.4, alpha=0.05 / 6), n_binomial(0.5, alpha=0.05 / 6)) == (41, 24)
    assert (critical_hits(45), critical_hits(45, alpha=0.05 / 6)) == (13, 15)


def test_power_of_the_goodness_of_fit_is_exact() -> None:
    # Noncentral chi-squared promises 0.80 for 47 participants; enumeration of the exact test gives 0.716.
    assert goodness_power(0.4, 47, alpha=0.05 / 6) == (pytest.approx(0.716, abs=5e-4), 0)
    assert goodness_power(0.4, 55, alpha=0.05 / 6)[0] == pytest.approx(0.804, abs=5e-4)
    assert n_goodness(0.4, alpha=0.05 / 6)[0] == 55


def test_exact_power_agrees_with_every_outcome() -> None:
    power = 0.0
    for counts in product(range(8), repeat=3):
        if sum(counts) == 7 and exact_p(np.array(counts)) <= 0.1:
            power += multinomial.pmf(counts, 7, [0.6, 0.2, 0.2])
    assert goodness_power(0.6, 7, 3, 0.1)[0] == pytest.approx(power)


def test_simulated_power_has_a_standard_error(monkeypatch: pytest.MonkeyPatch) -> None:
    exact, _ = goodness_power(0.35, 60)
    monkeypatch.setattr(planning, "_MOST_EXACT", 0)
    power, error = goodness_power(0.35, 60)
    assert 0 < error < 0.004
    assert power == pytest.approx(exact, abs=4 * error)


@pytest.mark.parametrize(("rate", "k"), [(0.4, 6), (0.9, 2), (0.2, 12)])
def test_effect_size_of_a_rate(rate: float, k: int) -> None:
    shares = np.array([rate] + [(1 - rate) / (k - 1)] * (k - 1))
    assert w_of_rate(rate, k) == pytest.approx(np.sqrt(((shares - 1 / k) ** 2 * k).sum()))


def test_power_stays_above_the_target_from_n_on() -> None:
    n = n_binomial(0.5, alpha=0.05 / 6)
    assert binomial_power(0.5, n - 1, alpha=0.05 / 6) < 0.8
    assert all(binomial_power(0.5, more, alpha=0.05 / 6) >= 0.8 for more in range(n, 4 * n))
    assert binomial_power(0.5, 19, alpha=0.05 / 6) > 0.8  # reached earlier, but not for all larger n


def test_power_by_simulation() -> None:
    hits = np.random.default_rng(1).binomial(30, 0.4, 20_000)
    significant = {h: binomtest(h, 30, 1 / 6, alternative="greater").pvalue <= 0.01 for h in np.unique(hits).tolist()}
    expected = np.mean([significant[h] for h in hits.tolist()])
    assert binomial_power(0.4, 30, alpha=0.01) == pytest.approx(expected, abs=0.015)


def test_plan_for_both_tests() -> None:
    found = plan(0.4)
    assert found.alpha == pytest.approx(0.05 / 6)
    assert found.n == max(found.n_goodness, found.n_binomial)
    assert found.n_binomial == 41
    assert found.critical_hits == critical_hits(41, alpha=0.05 / 6)
    assert found.power_goodness == goodness_power(0.4, found.n_goodness, alpha=0.05 / 6)[0] >= 0.8
    assert goodness_power(0.4, found.n_goodness - 1, alpha=0.05 / 6)[0] < 0.8
    assert found.goodness_error == 0


def test_plan_refuses_a_rate_too_near_to_chance() -> None:
    found = plan(0.168)
    assert (found.n_goodness, found.n_binomial, found.critical_hits, found.n) == (None, None, None, None)
    assert binomial_power(0.168, MOST_PARTICIPANTS, alpha=0.05 / 6) < 0.8


@pytest.mark.parametrize("rate", [1 / 6, 0.1, 1.01, -1])
def test_plan_refuses_a_rate_at_or_below_chance(rate: float) -> None:
    with pytest.raises(ValueError, match="not above the chance"):
        plan(rate)


@pytest.mark.parametrize("wrong", [{"alpha": 0}, {"alpha": 1}, {"power": 1}, {"power": 0}])
def test_invalid_plan_parameters_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        plan(0.5, **wrong)


def test_nothing_is_significant_with_one_answer() -> None:
    assert critical_hits(1) == 2
    assert binomial_power(1, 1) == 0


@given(st.integers(1, 80), st.integers(2, 12), st.sampled_from([0.001, 0.05 / 6, 0.05, 0.2]))
@settings(max_examples=60)
def test_critical_hits_are_the_smallest_significant_number(n: int, k: int, alpha: float) -> None:
    hits = critical_hits(n, k, alpha)
    assert binomtest(hits - 1, n, 1 / k, alternative="greater").pvalue > alpha
    assert hits > n or binomtest(hits, n, 1 / k, alternative="greater").pvalue <= alpha


@given(st.floats(0.2, 0.9), st.integers(2, 60))
@settings(max_examples=40, deadline=None)
def test_smaller_alpha_gives_lower_power(rate: float, n: int) -> None:
    assert binomial_power(rate, n, alpha=0.01) <= binomial_power(rate, n, alpha=0.05)
    assert goodness_power(rate, n, alpha=0.01)[0] <= goodness_power(rate, n, alpha=0.05)[0] + 1e-12
