from itertools import product
from math import comb

import numpy as np
import pytest
from scipy.stats import binom, norm
from statsmodels.stats.power import TTestIndPower

from emovid.statistics.designs import Design, participants_for, sequential, simulated_power
from emovid.statistics.planning import critical_hits


def test_power_of_one_emotion_without_variation_is_exact_binomial() -> None:
    power, error = simulated_power(Design("h1", 0.4, emotions=1, participant_sd=0), 30, studies=4000)
    expected = binom.sf(critical_hits(30) - 1, 30, 0.4)
    assert power == pytest.approx(expected, abs=4 * error)


def test_power_for_all_emotions_is_lower_than_for_one() -> None:
    one, six = (simulated_power(Design("h1", 0.4, emotions=emotions), 30)[0] for emotions in (1, 6))
    assert six < one


def test_guessing_is_rarely_found_above_chance() -> None:
    # Equal answers of a participant to several videos of one emotion are not independent evidence.
    design = Design("h1", 1 / 6 + 1e-9, emotions=1, exemplars=4, participant_sd=0.0)
    assert simulated_power(design, 40, studies=4000)[0] < 0.05 + 4 * np.sqrt(0.05 * 0.95 / 4000)


def test_power_of_a_group_difference_agrees_with_the_t_test() -> None:
    # Scores of six independent answers: variance p (1 - p) / 6.
    power, error = simulated_power(Design("difference", 0.5, participant_sd=0, difference=0.1), 80, studies=4000)
    spread = np.sqrt((0.25 + 0.24) / 2 / 6)
    expected = TTestIndPower().power(0.1 / spread, 40, 0.05)
    assert power == pytest.approx(expected, abs=4 * error + 0.005)


def test_equivalence_power_agrees_with_two_one_sided_tests() -> None:
    power, error = simulated_power(Design("equivalence", 0.5, participant_sd=0, margin=0.1), 200, studies=4000)
    z = 0.1 / np.sqrt(0.25 / 6 * 2 / 100)
    assert power == pytest.approx(2 * norm.cdf(z - norm.ppf(0.95)) - 1, abs=4 * error + 0.01)


def test_more_variation_needs_more_participants() -> None:
    few, many = (participants_for(Design("difference", 0.6, participant_sd=sd)) for sd in (0.2, 1.5))
    assert few.participants < many.participants
    assert 0.8 - 3 * few.error < few.power < 0.9
    assert few.error < 0.01


def test_plan_beyond_the_largest_sample_has_no_result() -> None:
    found = participants_for(Design("equivalence", 0.5, margin=0.005))
    assert found.participants is None


@pytest.mark.parametrize(
    "wrong", [{"rate": 0.1}, {"rate": 1}, {"alpha": 0}, {"share": 1}, {"goal": "difference", "difference": 0.9}]
)
def test_invalid_designs_are_refused(wrong) -> None:
    with pytest.raises(ValueError, match=r"between|leaves"):
        participants_for(Design(**({"goal": "h1", "rate": 0.5} | wrong)))


def test_alpha_spending_agrees_with_every_sequence_of_hits() -> None:
    found = sequential("alpha", [2, 4, 6], 0.7, k=3, alpha=0.2)
    crossed = 0.0
    for steps in product(range(3), repeat=3):
        hits = np.cumsum(steps)
        if (hits >= found.above).any():
            crossed += np.prod([comb(2, step) * (1 / 3) ** step * (2 / 3) ** (2 - step) for step in steps])
    assert found.false_alarms == pytest.approx(crossed)
    assert found.false_alarms <= 0.2
    assert found.chance_stop == (-1, -1, -1)


@pytest.mark.parametrize("rule", ["alpha", "bayes"])
def test_error_rates_agree_with_simulated_studies(rule) -> None:
    found = sequential(rule, [15, 30, 45, 60], 0.4)
    assert found.simulated_false_alarms == pytest.approx(found.false_alarms, abs=0.006)
    assert found.simulated_power == pytest.approx(found.power, abs=0.015)
    assert found.expected[1] < 60


def test_single_look_equals_the_binomial_test() -> None:
    found = sequential("alpha", [45], 0.4)
    assert found.above == (critical_hits(45),)
    assert found.power == pytest.approx(binom.sf(critical_hits(45) - 1, 45, 0.4))


def test_bayes_factors_stop_for_and_against_the_effect() -> None:
    found = sequential("bayes", [20, 40], 0.5)
    # At 20 participants: BF of 3 hits and of 9, uniform above chance, by integration.
    rates = np.linspace(1 / 6, 1, 200_001)
    for hits, stops in ((found.above[0], 10), (found.above[0] - 1, 0)):
        factor = np.trapezoid(binom.pmf(hits, 20, rates), rates) / (5 / 6) / binom.pmf(hits, 20, 1 / 6)
        assert (factor >= 10) == bool(stops)
    for hits, stops in ((found.chance_stop[0], True), (found.chance_stop[0] + 1, False)):
        factor = np.trapezoid(binom.pmf(hits, 20, rates), rates) / (5 / 6) / binom.pmf(hits, 20, 1 / 6)
        assert (factor <= 0.1) == stops


@pytest.mark.parametrize(("looks", "rate"), [([], 0.5), ([20, 10], 0.5), ([0, 10], 0.5), ([10], 0.1)])
def test_invalid_looks_are_refused(looks, rate) -> None:
    with pytest.raises(ValueError, match="expected a rate above chance"):
        sequential("alpha", looks, rate)
