from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import beta, binomtest, dirichlet_multinomial, norm, t
from scipy.stats import fisher_exact as scipy_fisher
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import confint_proportions_2indep, proportion_confint

from emovid.statistics.proportions import (
    binomial_tail,
    effective_n,
    fisher_exact,
    holm,
    newcombe,
    replication_bf,
    uniform_bf10,
    wilson,
)

P = st.lists(st.floats(0, 1), min_size=1, max_size=20).map(np.array)
TWO = st.tuples(st.integers(1, 40), st.integers(1, 40)).flatmap(
    lambda n: st.tuples(st.just(n), st.tuples(st.integers(0, n[0]), st.integers(0, n[1])))
)


@given(P)
@settings(max_examples=40)
def test_holm_agrees_with_statsmodels(p: np.ndarray) -> None:
    with patch("gc.collect"):  # statsmodels collects garbage in each call, which takes a fifth of a second here
        assert holm(p) == pytest.approx(multipletests(p, method="holm")[1])


def test_holm_leaves_out_what_is_undefined() -> None:
    assert holm(np.array([0.01, np.nan, 0.03])) == pytest.approx([0.02, np.nan, 0.03], nan_ok=True)
    assert len(holm(np.array([]))) == 0
    assert np.isnan(holm(np.array([np.nan]))).all()


@given(TWO)
@settings(max_examples=40)
def test_intervals_agree_with_statsmodels(two) -> None:
    n, hits = two
    expected = proportion_confint(hits[0], n[0], method="wilson")
    assert wilson(hits[0], n[0]) == pytest.approx(expected, abs=1e-12)
    low, high = confint_proportions_2indep(hits[0], n[0], hits[1], n[1], method="newcomb", compare="diff")
    assert newcombe(hits, n) == pytest.approx((low, high), abs=1e-12)


@given(TWO)
@settings(max_examples=40)
def test_fisher_agrees_with_scipy(two) -> None:
    n, hits = two
    p = fisher_exact(hits, n)
    if sum(hits) in (0, sum(n)):
        assert np.isnan(p)
    else:
        assert p == pytest.approx(scipy_fisher([hits, np.subtract(n, hits)]).pvalue)


@pytest.mark.parametrize(("hits", "n", "chance"), [(0, 5, 0.2), (5, 5, 0.2), (18, 45, 1 / 6), (3, 10, 0.5)])
def test_binomial_agrees_with_scipy(hits: int, n: int, chance: float) -> None:
    assert binomial_tail(hits, n, chance) == pytest.approx(binomtest(hits, n, chance, alternative="greater").pvalue)


def test_binomial_tail_interpolates_between_whole_hits() -> None:
    assert binomial_tail(5, 10, 0.3) > binomial_tail(5.5, 10, 0.3) > binomial_tail(6, 10, 0.3)


def test_effective_n_by_hand() -> None:
    ones = np.ones(20, dtype=np.int64)
    hits = np.repeat([1, 0], [12, 8])
    assert effective_n(hits, ones) == 20  # one answer each
    # Answers that agree are worth one, less one for the rate, and less for an interval by t instead of z.
    assert effective_n(3 * hits, 3 * ones) == pytest.approx(19 * (norm.ppf(0.975) / t.ppf(0.975, 19)) ** 2)
    assert effective_n(3 * ones, 3 * ones) == 20  # nobody misses: at most one each
    assert effective_n(ones, 2 * ones) == 40  # more even than chance: never more than there are
    assert effective_n(np.array([2, 0]), np.array([3, 0])) == 1


def test_effective_n_agrees_with_the_variance_of_the_rate() -> None:
    # Beta-binomial hits: of m answers with correlation rho, m / (1 + (m - 1) rho) count.
    rng, m, rho = np.random.default_rng(1), 4, 0.3
    a, b = 0.5 * (1 / rho - 1), 0.5 * (1 / rho - 1)
    found = [effective_n(rng.binomial(m, rng.beta(a, b, 200)), np.full(200, m)) for _ in range(200)]
    few = (norm.ppf(0.975) / t.ppf(0.975, 199)) ** 2
    assert np.mean(found) == pytest.approx(few * 200 * m / (1 + (m - 1) * rho), rel=0.02)


def test_replication_bayes_factor_by_integration() -> None:
    prior = beta(1 + 18, 1 + 27)
    marginal = quad(lambda p: prior.pdf(p) * p**9 * (1 - p) ** 11, 0, 1)[0]
    assert replication_bf((18, 45), (9, 20), 1 / 6) == pytest.approx(marginal / ((1 / 6) ** 9 * (5 / 6) ** 11))
    assert replication_bf((18, 45), (3, 20), 1 / 6) < 1


def test_bayes_factor_of_equal_shares_agrees_with_the_dirichlet_multinomial() -> None:
    counts = np.array([7, 2, 4, 0])
    equal = dirichlet_multinomial.pmf(counts, np.full(4, 1e9), 13)
    assert uniform_bf10(counts) == pytest.approx(dirichlet_multinomial.pmf(counts, np.ones(4), 13) / equal, rel=1e-5)
    assert uniform_bf10(np.zeros(6, dtype=np.int64)) == pytest.approx(1)
