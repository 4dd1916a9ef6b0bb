from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom, friedmanchisquare

from emovid.statistics import dependence, permutation_tests
from emovid.statistics.dependence import agreement, label_use, videos_differ
from emovid.statistics.goodness import DRAWS
from emovid.statistics.permutation_tests import hit_distribution, order_effect, total_recognition
from emovid.statistics.recognition import unbiased_hit_rates

# Four people whose answers have all the figures of the notes' four-person set, found by search.
FOUR = np.array([[0, 1, 2, 3, 5, 4], [0, 2, 2, 4, 1, 5], [0, 1, 3, 3, 0, 5], [1, 1, 2, 3, 4, 5]])
CHOICES = st.integers(1, 5).flatmap(
    lambda people: st.lists(st.lists(st.integers(-1, 4), min_size=4, max_size=4), min_size=people, max_size=people).map(
        np.array
    )
)


def counts_of(choices: np.ndarray, k: int) -> np.ndarray:
    return np.array([[(choices[:, j] == i).sum() for j in range(choices.shape[1])] for i in range(k)])


def enumerated_tail(choices: np.ndarray) -> float:
    """Shuffle the given answers of every participant in every way at once."""
    sets = []
    for row in choices:
        videos = np.flatnonzero(row >= 0)
        sets.append([(np.array(order) == videos).sum() for order in permutations(row[videos])] if len(videos) else [0])
    totals = np.array([sum(hits) for hits in product(*sets)])
    return float((totals >= (choices == np.arange(choices.shape[1])).sum()).mean())


def test_the_four_people_are_those_of_the_notes() -> None:
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


def test_missing_answers_leave_kappa_and_q_to_the_complete() -> None:
    more = np.vstack([FOUR, [[0, 1, 2, 3, 4, -1]]])
    assert agreement(more, 6) == agreement(FOUR, 6)
    assert videos_differ(more) == videos_differ(FOUR)


def test_a_label_that_has_no_video_leaves_kappa_and_q_as_they_are() -> None:
    offered = np.column_stack([FOUR, np.full(4, -1)])
    assert agreement(offered, 7) == agreement(FOUR, 6)
    assert videos_differ(offered) == videos_differ(FOUR)


def test_one_video_alone_has_no_agreement_and_no_difference() -> None:
    choices = np.array([[0, -1], [1, -1], [0, -1]])
    assert np.isnan(agreement(choices, 2).kappa)
    assert (videos_differ(choices).p, videos_differ(choices).dof, videos_differ(choices).participants) == (1, 0, 3)


@pytest.mark.parametrize("choices", [np.empty((0, 3)), np.array([[0, 1, 2]]), np.array([[1, 1, 1], [1, 1, 1]])])
def test_no_agreement_to_speak_of(choices: np.ndarray) -> None:
    assert np.isnan(agreement(choices.astype(np.int64), 3).kappa)


@pytest.mark.parametrize("choices", [np.empty((0, 3)), np.array([[0, 1, 2], [1, 2, 0]])])
def test_nobody_tells_the_videos_apart(choices: np.ndarray) -> None:
    test = videos_differ(choices.astype(np.int64))
    assert (test.statistic, test.p) == (0, 1)


def test_hits_of_people_who_give_each_label_once() -> None:
    null = hit_distribution((1,) * 6, 6)
    assert null * 720 == pytest.approx([265, 264, 135, 40, 15, 0, 1])  # rencontres numbers
    mean = np.arange(7) @ null
    assert (mean, np.arange(7) ** 2 @ null - mean**2) == pytest.approx((1, 1))


def test_one_label_throughout_always_hits_once() -> None:
    assert hit_distribution((0, 0, 6, 0, 0, 0), 6) == pytest.approx([0, 1, 0, 0, 0, 0, 0])
    assert total_recognition(np.full((5, 6), 2)).p == pytest.approx(1)


@given(CHOICES.filter(lambda choices: len(choices) <= 3))
@settings(max_examples=60)
def test_total_recognition_is_every_shuffle(choices: np.ndarray) -> None:
    # Label 4 is that of no video; -1 is a missing answer.
    assert total_recognition(choices).p == pytest.approx(enumerated_tail(choices), rel=1e-9)


def test_many_people_use_the_normal_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    choices = rng.integers(-1, 6, (300, 6))
    choices[:20] = np.arange(6) // 2
    exact = total_recognition(choices)
    monkeypatch.setattr(permutation_tests, "MOST_CONVOLVED", 100)
    normal = total_recognition(choices)
    assert (exact.method, normal.method) == ("exact", "normal")
    assert normal.p == pytest.approx(exact.p, abs=0.003)
    assert normal.expected == exact.expected


def test_label_use_is_friedmans_for_ranks() -> None:
    rng = np.random.default_rng(4)
    uses = np.array([rng.permutation([1, 2, 3]) for _ in range(9)])
    choices = np.array([np.repeat(np.arange(3), use) for use in uses])
    test = label_use(choices, 3)
    expected = friedmanchisquare(*uses.T)
    assert test.statistic == pytest.approx(expected.statistic)
    assert test.p == pytest.approx(expected.pvalue, abs=0.1)
    assert test.totals.tolist() == uses.sum(axis=0).tolist()


def test_label_use_is_every_shuffle() -> None:
    choices = np.array([[0, 0, 1], [0, 0, 0], [0, 1, 2]])
    uses = [[2, 1, 0], [3, 0, 0], [1, 1, 1]]
    totals = [np.sum(rows, axis=0) for rows in product(*[list(permutations(use)) for use in uses])]
    expected = np.mean([(total**2).sum() >= 6**2 + 2**2 + 1 for total in totals])
    test = label_use(choices, 3)
    assert test.p == pytest.approx(expected, abs=0.015)
    assert test.never == pytest.approx([0, 1 / 3, 2 / 3])
    assert test.repeated == pytest.approx([2 / 3, 0, 0])
    assert (test.draws, test.seed) == (DRAWS, 0)


def test_each_label_once_is_no_preference() -> None:
    test = label_use(np.array([[0, 1, 2], [2, 0, 1]]), 3)
    assert (test.statistic, test.p) == (0, 1)


def test_label_use_of_many_people(monkeypatch: pytest.MonkeyPatch) -> None:
    choices = np.random.default_rng(3).integers(0, 6, (200, 6))
    shuffled = label_use(choices, 6)
    monkeypatch.setattr(dependence, "MOST_SHUFFLED", 100)
    large = label_use(choices, 6)
    assert (large.method, large.draws, large.seed) == ("chi-squared", 0, None)
    assert large.p == pytest.approx(shuffled.p, abs=0.03)


def tiring(people: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return answers that are right up to the third position and wrong after it."""
    rng = np.random.default_rng(seed)
    positions = np.array([rng.permutation(6) + 1 for _ in range(people)])
    return np.where(positions <= 3, np.arange(6), (np.arange(6) + 1) % 6), positions


def test_order_effect_is_seen() -> None:
    choices, positions = tiring(20, 1)
    test = order_effect(choices, positions)
    assert test.hits.tolist() == [20, 20, 20, 0, 0, 0]
    assert test.n.tolist() == [20] * 6
    # Least squares of (1, 1, 1, 0, 0, 0) on 1 to 6, but for the rates of the videos.
    assert test.slope == pytest.approx(-4.5 / 17.5, abs=0.03)
    assert test.p == 1 / (DRAWS + 1)


def test_order_effect_is_every_shuffle() -> None:
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
    monkeypatch.setattr(permutation_tests, "MOST_SHUFFLED", 100)
    large = order_effect(choices, positions)
    assert (large.method, large.slope) == ("normal", shuffled.slope)
    assert large.p == pytest.approx(shuffled.p, abs=0.02)


def test_one_order_for_all_tells_nothing() -> None:
    test = order_effect(FOUR, np.tile(np.arange(1, 7), (4, 1)))
    assert np.isnan([test.p, test.slope]).all()
    assert test.n.tolist() == [4] * 6


def test_unknown_positions() -> None:
    test = order_effect(FOUR, np.full((4, 6), -1))
    assert test.n.size == 0
    assert np.isnan(test.p)


def test_nobody() -> None:
    nobody = np.empty((0, 6), dtype=np.int64)
    assert total_recognition(nobody).p == 1
    assert label_use(nobody, 6).p == 1
    assert order_effect(nobody, nobody).n.size == 0


@given(CHOICES, st.randoms())
@settings(max_examples=40)
def test_people_may_be_reordered(choices: np.ndarray, random) -> None:
    rows = choices.tolist()
    random.shuffle(rows)
    test = total_recognition(choices)
    assert 0 <= test.p <= 1
    assert total_recognition(np.array(rows)).p == pytest.approx(test.p)
    assert videos_differ(np.array(rows)) == videos_differ(choices)
