from itertools import permutations, product
from math import comb

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import beta, binomtest, norm, t

from emovid.responses.responses import EMOTIONS
from emovid.statistics.circumplex import ANGLES, AROUSAL, VALENCE
from emovid.statistics.proportions import holm, wilson
from emovid.statistics.recognition import (
    accuracy,
    collapse,
    proportion_index,
    recognize,
    unbiased_chance,
    unbiased_hit_rates,
    verdict,
)
from emovid.statistics.resampling import resampled_counts, unbiased_hit_intervals
from emovid.statistics.showings import Showings
from tests.helpers.known import TABLE_III

MATRIX = st.lists(st.lists(st.integers(0, 9), min_size=4, max_size=4), min_size=4, max_size=5).map(np.array)


def test_majority_verdicts_match_the_paper() -> None:
    found = recognize(TABLE_III)
    relative = {"fear", "disgust"}
    assert [r.verdict for r in found] == [
        "relative majority" if emotion in relative else "absolute majority" for emotion in EMOTIONS
    ]
    assert [round(100 * r.rate, 2) for r in found] == [64.44, 57.78, 55.56, 40.0, 40.0, 64.44]
    assert all(r.above_chance for r in found)


def test_golden_numbers() -> None:
    (test, *_) = recognize(np.array([[20, 0], [7, 0], [5, 0], [5, 0], [4, 0], [4, 0]]))
    assert (test.hits, test.n, test.chance) == (20, 45, pytest.approx(1 / 6))
    assert test.p_binomial == pytest.approx(1.18e-5, rel=0.005)
    assert (test.ci_low, test.ci_high) == pytest.approx((0.309, 0.588), abs=5e-4)


def test_binomial_tail_by_hand() -> None:
    (test, *_) = recognize(np.array([[3, 0], [1, 0], [1, 0]]))
    tail = sum(comb(5, h) * 2 ** (5 - h) for h in (3, 4, 5)) / 3**5
    assert test.p_binomial == pytest.approx(tail)


def test_holm_by_hand() -> None:
    assert holm(np.array([0.01, 0.04, 0.03, 0.005])) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    left_out = holm(np.array([0.01, 1.0, 0.03]), np.array([True, False, True]))
    assert left_out == pytest.approx([0.02, 1.0, 0.03])


def test_above_chance_uses_alpha_after_holm() -> None:
    # 4 of 8 against 1 / 4 has p = 0.114; 5 of 8 has p = 0.027, twice that after Holm.
    counts = np.array([[5, 2], [1, 4], [1, 1], [1, 1]])
    first, second = recognize(counts)
    assert first.p_binomial < 0.05 < first.p_holm
    assert not first.above_chance
    assert recognize(counts, alpha=0.06)[0].above_chance
    assert second.p_holm == pytest.approx(second.p_binomial)


def test_video_without_answers() -> None:
    seen, unseen = recognize(np.array([[4, 0], [1, 0]]))
    assert (unseen.hits, unseen.n) == (0, 0)
    assert np.isnan([unseen.p_binomial, unseen.p_holm, unseen.p_verdict]).all()
    assert (unseen.ci_low, unseen.ci_high, unseen.verdict, unseen.above_chance) == (0, 1, "neither", False)
    assert np.isnan([unseen.rate, unseen.hu, unseen.pi]).all()
    assert seen.p_holm == seen.p_binomial


@pytest.mark.parametrize(
    ("column", "expected"),
    [
        ([3, 1, 1], "absolute majority"),
        ([3, 3, 0], "neither"),
        ([2, 1, 1], "relative majority"),
        ([2, 2, 1], "neither"),
        ([1, 3, 0], "neither"),
        ([0, 0, 0], "neither"),
    ],
)
def test_verdicts_by_hand(column: list[int], expected: str) -> None:
    assert verdict(np.array(column), 0) == expected


def test_wagner_example_of_unbiased_hit_rates() -> None:
    # The example of stats.stackexchange 156774 has the signaled emotion in rows.
    counts = np.array([[4, 1, 0, 1], [0, 3, 2, 1], [0, 0, 6, 0], [2, 0, 0, 4]]).T
    assert unbiased_hit_rates(counts) == pytest.approx([0.444, 0.375, 0.750, 0.444], abs=5e-4)


def test_unused_label_has_no_unbiased_rate() -> None:
    rates = unbiased_hit_rates(np.array([[0, 0], [3, 4]]))
    assert np.isnan(rates[0])
    assert rates[1] == pytest.approx(4**2 / (7 * 4))


def intervals_of(choices: np.ndarray, k: int, seed: int = 0) -> np.ndarray:
    """Return the intervals of answers to one video of each emotion."""
    videos = choices.shape[1]
    names = tuple(f"v{j}" for j in range(videos))
    showings = Showings(choices, np.full_like(choices, -1), np.arange(videos), names, k, videos)
    return unbiased_hit_intervals(showings, resampled_counts(showings, seed))


def test_bootstrap_interval_contains_the_estimate_and_is_reproducible() -> None:
    rng = np.random.default_rng(5)
    columns = [rng.permutation(np.repeat(np.arange(6), TABLE_III[:, j])) for j in range(6)]
    choices = np.array(columns).T
    intervals = intervals_of(choices, 6, seed=1)
    rates = unbiased_hit_rates(TABLE_III)
    assert ((intervals[:, 0] < rates) & (rates < intervals[:, 1])).all()
    assert (intervals == intervals_of(choices, 6, seed=1)).all()
    assert (intervals != intervals_of(choices, 6, seed=2)).any()


def test_bootstrap_agrees_with_resampling_people_one_by_one() -> None:
    rng = np.random.default_rng(8)
    choices = np.where(rng.random((30, 3)) < 0.6, np.arange(3), rng.integers(-1, 3, (30, 3)))
    samples = []
    for _ in range(2000):
        again = choices[rng.integers(30, size=30)]
        counts = np.array([[(again[:, j] == i).sum() for j in range(3)] for i in range(3)])
        samples.append([counts[j, j] ** 2 / counts[j].sum() / counts[:, j].sum() for j in range(3)])
    expected = np.percentile(samples, [2.5, 97.5], axis=0).T
    assert intervals_of(choices, 3) == pytest.approx(expected, abs=0.03)


def test_bootstrap_of_undefined_rates() -> None:
    intervals = intervals_of(np.array([[1, 1], [1, -1]]), 2)
    assert np.isnan(intervals[0]).all()
    assert np.isfinite(intervals[1]).all()
    assert np.isnan(intervals_of(np.empty((0, 2), dtype=np.int64), 2)).all()


def test_interval_of_perfect_answers_does_not_collapse() -> None:
    # Twenty of twenty: Wilson's 95 % interval of the rate ends at 0.84, and so does that of the precision of the label.
    intervals = intervals_of(np.tile(np.arange(3), (20, 1)), 3)
    assert intervals == pytest.approx(np.tile([wilson(20, 20)[0] ** 2, 1], (3, 1)))
    assert intervals[0, 0] == pytest.approx(0.704, abs=5e-4)


def test_wagner_chance_level() -> None:
    # The share of the label times that of the video (Wagner 1993): 66 and 45 of 270.
    assert unbiased_chance(TABLE_III)[3] == pytest.approx(59 / 270 * 45 / 270)
    assert unbiased_chance(np.full((6, 6), 4)) == pytest.approx(1 / 36)
    assert recognize(TABLE_III)[3].hu_chance == pytest.approx(unbiased_chance(TABLE_III)[3])


def test_bayes_factor_and_credible_interval_for_the_paper() -> None:
    fear = recognize(TABLE_III)[3]
    assert fear.bf10 == pytest.approx(1304, abs=0.5)
    assert (fear.bayes_low, fear.bayes_high) == pytest.approx(beta.ppf([0.025, 0.975], 1 + 18, 5 + 27))


def test_a_majority_is_tested() -> None:
    found = recognize(TABLE_III)
    assert found[0].p_verdict == pytest.approx(binomtest(29, 45, 0.5, alternative="greater").pvalue)
    # Fear: 18 against 12 for the second most frequent label, disgust.
    assert found[3].p_verdict == pytest.approx(binomtest(18, 30, 0.5, alternative="greater").pvalue)
    assert np.isnan(recognize(np.array([[1, 0], [3, 0], [0, 1]]))[0].p_verdict)


def test_several_answers_test_agrees_with_every_permutation_of_labels() -> None:
    used = [np.array([[2, 0, 0], [1, 1, 0], [0, 1, 1], [1, 0, 1]])]
    (test,) = recognize(used[0].sum(axis=0)[:, None], uses=used)
    every = [list(permutations(row)) for row in used[0].tolist()]
    hits = np.array([sum(row[0] for row in rows) for rows in product(*every)])
    assert test.p_binomial == pytest.approx((hits >= 4).mean())
    assert (test.hits, test.n, test.participants, test.method) == (4, 8, 4, "exact permutation")
    assert np.isnan([test.bf10, test.bayes_low]).all()


def test_one_answer_per_participant_gives_the_binomial_test() -> None:
    answers = [0] * 9 + [1] * 5 + [2] * 4
    used = [np.array([np.bincount([answer], minlength=3) for answer in answers])]
    (test,) = recognize(used[0].sum(axis=0)[:, None], uses=used)
    assert repr(test) == repr(recognize(used[0].sum(axis=0)[:, None])[0])


def test_repeated_answers_add_no_evidence() -> None:
    used = np.array([np.bincount([answer], minlength=3) for answer in [0] * 9 + [1] * 5 + [2] * 4])
    (once,) = recognize(used.sum(axis=0)[:, None], uses=[used])
    (twice,) = recognize(2 * used.sum(axis=0)[:, None], uses=[2 * used])
    assert twice.p_binomial == pytest.approx(once.p_binomial)
    worth = 17 * (norm.ppf(0.975) / t.ppf(0.975, 17)) ** 2  # 18, less one for the rate, and less by the t factor
    assert (twice.effective_n, once.effective_n) == (pytest.approx(worth), 18)
    assert (twice.ci_low, twice.ci_high) == pytest.approx(wilson(worth / 2, worth))
    assert twice.p_verdict == pytest.approx(once.p_verdict)
    assert once.p_verdict == pytest.approx(binomtest(9, 14, 0.5, alternative="greater").pvalue)


def test_majority_of_several_answers_changes_signs_of_participants() -> None:
    rng = np.random.default_rng(2)
    used = np.array([np.bincount(rng.choice(3, 4, p=[0.5, 0.3, 0.2]), minlength=3) for _ in range(9)])
    (found,) = recognize(used.sum(axis=0)[:, None], uses=[used])
    column = used.sum(axis=0)
    rivals = used[:, 1:].sum(axis=1) if 2 * column[0] > column.sum() else used[:, 1 + np.argmax(column[1:])]
    lead = used[:, 0] - rivals
    signs = np.array(list(product([-1, 1], repeat=9)))
    assert found.verdict != "neither"
    assert found.p_verdict == pytest.approx((signs @ np.abs(lead) >= lead.sum()).mean())
    assert found.p_verdict >= 2**-9


def test_accuracy_treats_participants_as_units() -> None:
    counts = np.diag([10, 10]) + np.array([[0, 5], [5, 0]])
    known = accuracy(counts, hits=np.array([2] * 10 + [0] * 5), n=np.full(15, 2))
    assert (known.rate, known.participants) == (pytest.approx(2 / 3), 15)
    worth = 14 * (norm.ppf(0.975) / t.ppf(0.975, 14)) ** 2
    assert (known.ci_low, known.ci_high) == pytest.approx(wilson(worth * 2 / 3, worth), abs=1e-9)
    assert np.isnan(accuracy(counts).ci_low)


@pytest.mark.parametrize("k", range(2, 13))
def test_proportion_index(k: int) -> None:
    assert proportion_index(1 / k, k) == pytest.approx(0.5)
    assert proportion_index(0, k) == 0
    assert proportion_index(1, k) == pytest.approx(1)
    assert proportion_index(0.3, 2) == 0.3


def test_valence_of_table_iii() -> None:
    found = collapse(TABLE_III, EMOTIONS, VALENCE)
    assert found.table.tolist() == [[29 + 8 + 5 + 26, 19], [22, 161]]
    assert found.table.sum() == 270
    happiness, anger = found.videos["happiness"], found.videos["anger"]
    assert (happiness.hits, happiness.chance) == (34, pytest.approx(2 / 6))
    assert (anger.hits, anger.chance) == (25 + 9 + 2 + 1, pytest.approx(4 / 6))


def test_arousal_of_table_iii() -> None:
    found = collapse(TABLE_III, EMOTIONS, AROUSAL)
    assert found.table[1].tolist() == [1 + 3 + 1 + 6 + 2, 29]
    assert found.videos["sadness"].hits == 29


def test_none_counts_as_a_miss_and_unknown_labels_have_no_pole() -> None:
    found = collapse(np.array([[2, 1], [1, 2], [3, 3]]), ("happiness", "awe", "none"), VALENCE)
    assert list(found.videos) == ["happiness"]
    assert (found.videos["happiness"].hits, found.videos["happiness"].n) == (2, 6)
    assert found.videos["happiness"].chance == pytest.approx(1 / 3)
    assert found.table.tolist() == [[2, 0], [0, 0]]


def test_poles_are_the_halves_of_the_circle() -> None:
    angle = np.radians([ANGLES[emotion] for emotion in EMOTIONS])
    valence, arousal = np.cos(angle), np.sin(angle)
    assert [VALENCE[emotion] for emotion in EMOTIONS] == (valence > 0).tolist()
    assert [AROUSAL[emotion] for emotion in EMOTIONS] == (arousal > 0).tolist()


@given(MATRIX)
@settings(max_examples=30)
def test_results_are_in_range_for_any_matrix(counts: np.ndarray) -> None:
    for test in recognize(counts):
        assert np.isnan(test.p_binomial) if not test.n else 0 <= test.p_binomial <= test.p_holm <= 1
        assert 0 <= test.ci_low <= test.ci_high <= 1
        assert np.isnan(test.hu) or 0 <= test.hu <= test.rate + 1e-12


@given(st.integers(1, 60), st.data())
@settings(max_examples=25)
def test_more_hits_give_smaller_p(n: int, data) -> None:
    hits = data.draw(st.integers(0, n - 1))
    fewer, more = (recognize(np.array([[h], [n - h], [0]]))[0] for h in (hits, hits + 1))
    assert more.p_binomial < fewer.p_binomial
    assert wilson(hits, n) < wilson(hits + 1, n)
