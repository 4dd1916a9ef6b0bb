from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom, chi2

from emovid.statistics import participants
from emovid.statistics.goodness import DRAWS
from emovid.statistics.participants import (
    agreement,
    hit_distribution,
    label_use,
    order_effect,
    total_recognition,
    videos_differ,
)
from emovid.statistics.recognition import unbiased_hit_rates
from emovid.statistics.showings import Showings

# Four people whose answers have the known unbiased hit rates and accuracy below, found by search.
FOUR = np.array([[0, 1, 2, 3, 5, 4], [0, 2, 2, 4, 1, 5], [0, 1, 3, 3, 0, 5], [1, 1, 2, 3, 4, 5]])
CHOICES = st.integers(1, 5).flatmap(
    lambda people: st.lists(st.lists(st.integers(-1, 4), min_size=4, max_size=4), min_size=people, max_size=people).map(
        np.array
    )
)


def counts_of(choices: np.ndarray, k: int) -> np.ndarray:
    return np.array([[(choices[:, j] == i).sum() for j in range(choices.shape[1])] for i in range(k)])


def enumerated_tail(choices: np.ndarray) -> float:
    """Enumerate all permutations of the answers of all participants together."""
    sets = []
    for row in choices:
        videos = np.flatnonzero(row >= 0)
        sets.append([(np.array(order) == videos).sum() for order in permutations(row[videos])] if len(videos) else [0])
    totals = np.array([sum(hits) for hits in product(*sets)])
    return float((totals >= (choices == np.arange(choices.shape[1])).sum()).mean())


def test_example_of_four_participants_has_its_known_counts() -> None:
    expected = [0.5625, 0.45, 0.5625, 0.5625, 0.0833, 0.5625]
    assert unbiased_hit_rates(counts_of(FOUR, 6)) == pytest.approx(expected, abs=5e-5)
    assert (np.arange(6) == FOUR).mean() == pytest.approx(0.667, abs=5e-4)


def test_golden_numbers() -> None:
    kappa, q, total = agreement(FOUR, 6), videos_differ(FOUR), total_recognition(FOUR)
    assert (kappa.kappa, kappa.participants, kappa.videos) == (pytest.approx(0.297, abs=5e-4), 4, 6)
    assert (q.statistic, q.dof, q.p) == (pytest.approx(3.33, abs=5e-3), 5, pytest.approx(0.649, abs=5e-4))
    assert (total.hits, total.n, total.method) == (16, 24, "exact")
    assert total.p == pytest.approx(9.3e-7, rel=0.01)
    assert total.p > binom.sf(15, 24, 1 / 6)


def test_kappa_by_hand() -> None:
    # Videos: (2, 0), (1, 1), (0, 2): agreement (1 + 0 + 1) / 3, by chance 1 / 2.
    assert agreement(np.array([[0, 0, 1], [0, 1, 1]]), 2).kappa == pytest.approx((2 / 3 - 1 / 2) / (1 / 2))


def test_q_by_hand() -> None:
    # Hits 3, 1, 0 over videos and 1, 2, 1 over people: (c - 1)(c sum col^2 - N^2) / (c N - sum row^2).
    choices = np.array([[0, 0, 0], [0, 1, 0], [0, 0, 1]])
    test = videos_differ(choices)
    assert test.statistic == pytest.approx(2 * (3 * 10 - 16) / (3 * 4 - 6))
    assert test.dof == 2


def test_kappa_and_q_use_only_complete_participants() -> None:
    more = np.vstack([FOUR, [[0, 1, 2, 3, 4, -1]]])
    assert agreement(more, 6) == agreement(FOUR, 6)
    assert replace(videos_differ(more), total=4) == videos_differ(FOUR)


def test_label_without_a_video_does_not_change_kappa_and_q() -> None:
    offered = np.column_stack([FOUR, np.full(4, -1)])
    assert agreement(offered, 7) == agreement(FOUR, 6)
    assert videos_differ(offered) == videos_differ(FOUR)


def test_one_video_alone_has_no_agreement_and_no_difference() -> None:
    choices = np.array([[0, -1], [1, -1], [0, -1]])
    assert np.isnan(agreement(choices, 2).kappa)
    assert np.isnan(videos_differ(choices).p)
    assert (videos_differ(choices).dof, videos_differ(choices).participants) == (0, 3)


@pytest.mark.parametrize("choices", [np.empty((0, 3)), np.array([[0, 1, 2]]), np.array([[1, 1, 1], [1, 1, 1]])])
def test_kappa_is_undefined_for_degenerate_data(choices: np.ndarray) -> None:
    assert np.isnan(agreement(choices.astype(np.int64), 3).kappa)


@pytest.mark.parametrize("choices", [np.empty((0, 3)), np.array([[0, 1, 2], [1, 2, 0]])])
def test_cochran_q_is_undefined_without_informative_participants(choices: np.ndarray) -> None:
    test = videos_differ(choices.astype(np.int64))
    assert np.isnan([test.statistic, test.p]).all()
    assert test.informative == 0


def test_hit_distribution_if_each_label_is_given_once() -> None:
    null = hit_distribution(((1, 1),) * 6, 6)
    assert null * 720 == pytest.approx([265, 264, 135, 40, 15, 0, 1])  # rencontres numbers
    mean = np.arange(7) @ null
    assert (mean, np.arange(7) ** 2 @ null - mean**2) == pytest.approx((1, 1))


def test_constant_answers_always_give_one_hit() -> None:
    assert hit_distribution(((0, 1), (0, 1), (6, 1), (0, 1), (0, 1), (0, 1)), 6) == pytest.approx([0, 1, 0, 0, 0, 0, 0])
    assert np.isnan(total_recognition(np.full((5, 6), 2)).p)  # every shuffle has as many hits: no test


def is_fixed(choices: np.ndarray) -> bool:
    """Return whether no participant has an order of the answers with another number of hits."""
    shown = [np.flatnonzero(row >= 0) for row in choices]
    return all(
        len({sum(row[i] == j for i, j in zip(order, places, strict=True)) for order in permutations(places)}) < 2
        for row, places in zip(choices, shown, strict=True)
    )


@given(CHOICES.filter(lambda choices: len(choices) <= 3))
@settings(max_examples=60)
def test_total_recognition_agrees_with_every_shuffle(choices: np.ndarray) -> None:
    # Label 4 is that of no video; -1 is a missing answer.
    test = total_recognition(choices)
    if is_fixed(choices):
        assert np.isnan(test.p)
    else:
        assert test.p == pytest.approx(enumerated_tail(choices), rel=1e-9)


def test_many_people_use_the_normal_approximation(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    choices = rng.integers(-1, 6, (300, 6))
    choices[:20] = np.arange(6) // 2
    exact = total_recognition(choices)
    monkeypatch.setattr(participants, "MOST_CONVOLVED", 100)
    normal = total_recognition(choices)
    assert (exact.method, normal.method) == ("exact", "normal")
    assert normal.p == pytest.approx(exact.p, abs=0.003)
    assert normal.expected == exact.expected


def shown(choices: np.ndarray, k: int) -> Showings:
    """Return answers to one video of each emotion."""
    videos = choices.shape[1]
    names = tuple(f"v{j}" for j in range(videos))
    return Showings(choices, np.full_like(choices, -1), np.arange(videos), names, k, videos)


def guesses(people: int, rates: list[float], seed: int, weights: np.ndarray | None = None) -> np.ndarray:
    """Return choices whose wrong answers are distributed over the other labels by weight."""
    rng, k = np.random.default_rng(seed), len(rates)
    weights = np.ones(k) if weights is None else weights
    columns = []
    for j, rate in enumerate(rates):
        others = np.where(np.arange(k) == j, 0, weights)
        wrong = rng.choice(k, people, p=others / others.sum())
        columns.append(np.where(rng.random(people) < rate, j, wrong))
    return np.array(columns).T


def test_label_use_agrees_with_the_score_test_of_errors() -> None:
    choices = guesses(40, [0.5, 0.4, 0.6, 0.3], 4)
    test = label_use(shown(choices, 4))
    # By hand: the use of each label by each participant beyond an even share of their errors; three labels suffice.
    beyond = np.array([
        np.sum([np.eye(4)[row[j]] - (np.arange(4) != j) / 3 for j in range(4) if row[j] != j] or [np.zeros(4)], axis=0)
        for row in choices
    ])  # fmt: skip
    kept = beyond[(choices != np.arange(4)).any(axis=1)][:, :3]
    total = kept.sum(axis=0)
    assert test.statistic == pytest.approx(total @ np.linalg.inv(kept.T @ kept) @ total)
    assert (test.dof, test.participants) == (3, len(kept))
    assert test.p == pytest.approx(chi2.sf(test.statistic, 3))


def test_favorites_of_single_participants_are_no_preference_of_all() -> None:
    own = np.array([[label] * 4 for label in range(4)] * 5)  # each label is the favorite of five
    assert label_use(shown(own, 4)).p == pytest.approx(1)
    assert label_use(shown(np.vstack([own, [[3] * 4] * 20]), 4)).p < 0.01


def test_preferred_label_is_detected_with_its_bias() -> None:
    test = label_use(shown(guesses(300, [0.5] * 5, 1, np.array([4, 1, 1, 1, 1.0])), 5))
    assert test.p < 1e-6
    assert test.bias[0] / test.bias[1:].mean() == pytest.approx(4, rel=0.25)
    assert test.bias.mean() == pytest.approx(1)
    assert test.errors[0] == test.errors.max()


def test_unequal_recognition_does_not_give_a_label_preference() -> None:
    # 0.05 +- 3 standard errors of 400 tests; the videos are recognized at 90 and 30 %.
    rates = [0.9, 0.9, 0.9, 0.3, 0.3, 0.3]
    rejected = np.mean([label_use(shown(guesses(60, rates, seed), 6)).p < 0.05 for seed in range(400)])
    assert rejected < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 400)


def test_frequencies_of_labels() -> None:
    test = label_use(shown(np.array([[0, 0, 1], [0, 0, 0], [0, 1, 2]]), 3))
    assert test.totals.tolist() == [6, 2, 1]
    assert test.never == pytest.approx([0, 1 / 3, 2 / 3])
    assert test.repeated == pytest.approx([2 / 3, 0, 0])


def test_label_preference_is_undefined_for_two_labels() -> None:
    assert np.isnan(label_use(shown(np.array([[0, 0], [1, 1], [0, 1], [1, 0]] * 5), 2)).p)


def test_none_is_excluded_from_label_use() -> None:
    choices = guesses(50, [0.5] * 4, 7)
    choices[::3, 0] = 4  # none
    test = label_use(shown(choices, 5), np.array([True] * 4 + [False]))
    rest = choices.copy()
    rest[::3, 0] = -1
    assert test.statistic == pytest.approx(label_use(shown(rest, 4)).statistic)
    assert np.isnan(test.bias[4])


def tiring(people: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return answers that are right up to the third position and wrong afterward."""
    rng = np.random.default_rng(seed)
    positions = np.array([rng.permutation(6) + 1 for _ in range(people)])
    return np.where(positions <= 3, np.arange(6), (np.arange(6) + 1) % 6), positions


def test_order_effect_is_detected() -> None:
    choices, positions = tiring(20, 1)
    test = order_effect(choices, positions)
    assert test.hits.tolist() == [20, 20, 20, 0, 0, 0]
    assert test.n.tolist() == [20] * 6
    # Least squares of (1, 1, 1, 0, 0, 0) on 1 to 6, adjusted for the rates of the videos.
    assert test.slope == pytest.approx(-4.5 / 17.5, abs=0.03)
    assert test.p == 1 / (DRAWS + 1)


def test_order_effect_agrees_with_every_shuffle() -> None:
    choices = np.array([[0, 1, 0], [0, 2, -1], [1, 1, 2]])
    positions = np.array([[1, 2, 3], [3, 1, 2], [3, 1, 2]])
    known = choices >= 0
    hit = (choices == np.arange(3)) & known
    beyond = hit - hit.sum(axis=0) / known.sum(axis=0)
    rows = [(beyond[i][known[i]], positions[i][known[i]]) for i in range(3)]

    def statistic(orders) -> float:
        return abs(sum(y @ (np.array(x) - np.mean(x)) for (y, _), x in zip(rows, orders, strict=True)))

    every = np.array([statistic(orders) for orders in product(*[list(permutations(x)) for _, x in rows])])
    expected = (every >= statistic([x for _, x in rows]) - 1e-9).mean()
    assert order_effect(choices, positions).p == pytest.approx(expected, abs=0.02)


def test_order_effect_of_many_people(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(12)
    positions = np.array([rng.permutation(6) + 1 for _ in range(150)])
    choices = np.where(rng.random((150, 6)) < 0.5, np.arange(6), rng.integers(-1, 6, (150, 6)))
    shuffled = order_effect(choices, positions)
    monkeypatch.setattr(participants, "MOST_SHUFFLED", 100)
    large = order_effect(choices, positions)
    assert (large.method, large.slope) == ("normal", shuffled.slope)
    assert large.p == pytest.approx(shuffled.p, abs=0.02)


def test_order_effect_is_undefined_if_all_share_one_order() -> None:
    test = order_effect(FOUR, np.tile(np.arange(1, 7), (4, 1)))
    assert np.isnan([test.p, test.slope]).all()
    assert test.n.tolist() == [4] * 6


def test_order_effect_is_undefined_without_positions() -> None:
    test = order_effect(FOUR, np.full((4, 6), -1))
    assert test.n.size == 0
    assert np.isnan(test.p)


def test_results_without_participants_are_undefined() -> None:
    nobody = np.empty((0, 6), dtype=np.int64)
    assert np.isnan(total_recognition(nobody).p)
    assert np.isnan(label_use(shown(nobody, 6)).p)
    assert order_effect(nobody, nobody).n.size == 0


@given(CHOICES, st.randoms())
@settings(max_examples=40)
def test_results_do_not_depend_on_participant_order(choices: np.ndarray, random) -> None:
    rows = choices.tolist()
    random.shuffle(rows)
    test = total_recognition(choices)
    assert np.isnan(test.p) == is_fixed(choices)
    assert np.isnan(test.p) or 0 <= test.p <= 1
    assert total_recognition(np.array(rows)).p == pytest.approx(test.p, nan_ok=True)
    assert repr(videos_differ(np.array(rows))) == repr(videos_differ(choices))
