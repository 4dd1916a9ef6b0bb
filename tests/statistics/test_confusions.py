from math import factorial, prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from emovid.figures.circumplex import POSITIONS
from emovid.responses.responses import EMOTIONS
from emovid.statistics.circumplex import ANGLES, AROUSAL, VALENCE, distances
from emovid.statistics.confusions import mutual_information, near_neighbors, percent, quasi_independence
from tests.helpers.known import TABLE_III


def test_angles_follow_the_order_of_the_paper() -> None:
    assert sorted(ANGLES, key=lambda emotion: ANGLES[emotion]) == list(EMOTIONS)


def test_figure_and_test_use_the_same_angles() -> None:
    for emotion, angle in ANGLES.items():
        place = POSITIONS[emotion]
        assert np.degrees(np.arctan2(place.arousal, place.valence)) % 360 == pytest.approx(angle)


def test_distance_is_the_smaller_angle() -> None:
    between = distances(EMOTIONS)
    assert between[0, 5] == pytest.approx(360 - 199.7)
    assert between[3, 4] == 22
    assert (between == between.T).all()
    assert (np.diagonal(between) == 0).all()
    assert between.max() <= 180


def test_poles_match_the_paper() -> None:
    # Its footnote on valence, after Frijda 1986; arousal is the upper half of Russell's circle.
    assert [emotion for emotion, positive in VALENCE.items() if positive] == ["happiness", "surprise"]
    assert [emotion for emotion, high in AROUSAL.items() if not high] == ["sadness"]


def test_percent_of_an_empty_column_is_undefined() -> None:
    shares = percent(np.array([[3, 0], [1, 0]]))
    assert shares[:, 0].tolist() == [75, 25]
    assert np.isnan(shares[:, 1]).all()


def test_confusions_of_the_paper_are_near_neighbors() -> None:
    test = near_neighbors(TABLE_III, EMOTIONS)
    assert test.confusions == 270 - 145
    assert test.mean_distance == pytest.approx(62.279, abs=5e-4)
    assert test.expected == pytest.approx(68.317, abs=5e-4)  # both margins of the errors held
    assert test.p == pytest.approx(0.00025, abs=0.0006)
    assert (test.method, test.draws, test.seed) == ("Monte Carlo", 3999, 0)


def tables(rows: list[int], columns: list[int]) -> list[np.ndarray]:
    """Return every table of errors with these margins, by enumeration."""
    k = len(rows)
    free = [(i, j) for i in range(k) for j in range(k) if i != j]
    found = []

    def fill(place: int, table: np.ndarray, rows_left: np.ndarray, columns_left: np.ndarray) -> None:
        if place == len(free):
            if not rows_left.any() and not columns_left.any():
                found.append(table.copy())
            return
        i, j = free[place]
        for cell in range(min(rows_left[i], columns_left[j]) + 1):
            table[i, j] = cell
            rows_left[i] -= cell
            columns_left[j] -= cell
            fill(place + 1, table, rows_left, columns_left)
            rows_left[i] += cell
            columns_left[j] += cell
        table[i, j] = 0

    fill(0, np.zeros((k, k), dtype=np.int64), np.array(rows), np.array(columns))
    return found


def test_near_neighbors_agrees_with_every_table_of_the_same_margins() -> None:
    errors = np.array([[0, 2, 0, 1], [3, 0, 1, 0], [0, 1, 0, 3], [0, 0, 2, 0]])
    every = tables(errors.sum(axis=1).tolist(), errors.sum(axis=0).tolist())
    weights = np.array([1 / prod(factorial(cell) for cell in table.ravel().tolist()) for table in every])
    between = distances(EMOTIONS[:4])
    sums = np.array([(between * table).sum() for table in every])
    expected = weights[sums <= (between * errors).sum() + 1e-9].sum() / weights.sum()
    assert len(every) > 100
    assert 0.001 < expected < 0.5
    p = np.mean([near_neighbors(errors + 9 * np.eye(4, dtype=np.int64), EMOTIONS[:4], seed).p for seed in range(4)])
    assert p == pytest.approx(expected, abs=4 * np.sqrt(expected / 4 / 4000))


def test_many_errors_use_the_normal_approximation() -> None:
    rng = np.random.default_rng(3)
    few = rng.integers(5, 15, (6, 6))
    many = near_neighbors(few * 10, EMOTIONS)
    assert (many.method, many.draws, many.seed) == ("normal", 0, None)
    z = norm.ppf(many.p) / np.sqrt(10)
    assert near_neighbors(few, EMOTIONS).p == pytest.approx(norm.cdf(z), abs=0.03)


@pytest.mark.parametrize("k", [2, 3])
def test_near_neighbors_cannot_be_tested_with_two_or_three_labels(k: int) -> None:
    test = near_neighbors(TABLE_III[:k, :k], EMOTIONS[:k])
    assert test.confusions > 0
    assert test.mean_distance == pytest.approx(test.expected)
    assert np.isnan(test.p)


def test_near_neighbors_without_errors_is_undefined() -> None:
    test = near_neighbors(np.diag([3, 4, 5]), EMOTIONS[:3])
    assert test.confusions == 0
    assert np.isnan([test.mean_distance, test.p]).all()


def test_labels_without_a_circumplex_position_are_excluded() -> None:
    counts = np.array([[4, 9, 1], [9, 4, 9], [2, 9, 4], [7, 7, 7]])
    test = near_neighbors(counts, ("fear", "awe", "anger", "none"))
    assert (test.confusions, test.mean_distance) == (3, 17)
    assert np.isnan(test.p)


def test_fewer_videos_than_labels() -> None:
    test = near_neighbors(TABLE_III[:, :2], EMOTIONS)
    assert test.confusions == 90 - 29 - 26
    assert test.mean_distance == pytest.approx((distances(EMOTIONS)[:, :2] * TABLE_III[:, :2]).sum() / test.confusions)


@given(st.lists(st.integers(0, 9), min_size=16, max_size=16))
@settings(max_examples=20, deadline=None)
def test_right_answers_are_ignored(cells: list[int]) -> None:
    counts = np.array(cells).reshape(4, 4)
    more = counts + np.diag([5, 0, 7, 1])
    assert repr(near_neighbors(more, EMOTIONS[:4])) == repr(near_neighbors(counts, EMOTIONS[:4]))
    assert quasi_independence(more).residuals == pytest.approx(quasi_independence(counts).residuals, nan_ok=True)


# R 4.2: glm(n ~ factor(row) + factor(column), poisson) of the 30 wrong answers of Table III, rstandard(m, "pearson").
RESIDUALS = [
    [None, 3.09, 0.14, -2.61, -1.81, 2.21],
    [3.41, None, 1.99, -1.56, -1.87, -1.28],
    [0.90, -2.05, None, -0.06, 1.40, -0.40],
    [-2.19, -0.76, 0.26, None, 1.99, 0.33],
    [-0.07, -0.89, -1.15, 2.80, None, -1.33],
    [-0.69, 0.87, -0.95, 1.31, -0.73, None],
]


def test_residuals_for_the_paper_agree_with_quasi_independence_in_r() -> None:
    expected = np.array(RESIDUALS, dtype=float)
    assert quasi_independence(TABLE_III).residuals == pytest.approx(expected, abs=0.006, nan_ok=True)


def test_quasi_independence_keeps_both_margins_and_has_no_right_answers() -> None:
    errors = quasi_independence(TABLE_III)
    wrong = TABLE_III - np.diag(np.diag(TABLE_III))
    assert errors.expected.sum(axis=0) == pytest.approx(wrong.sum(axis=0))
    assert errors.expected.sum(axis=1) == pytest.approx(wrong.sum(axis=1))
    assert (np.diag(errors.expected) == 0).all()
    odds = errors.expected[0, 2] * errors.expected[1, 3] / (errors.expected[0, 3] * errors.expected[1, 2])
    assert odds == pytest.approx(1)  # rows and columns are independent
    assert errors.bias.mean() == pytest.approx(1)


def test_residuals_of_too_small_tables_are_undefined() -> None:
    assert np.isnan(quasi_independence(np.array([[3, 1], [1, 3]])).residuals).all()
    assert np.isnan(quasi_independence(np.zeros((3, 3), dtype=np.int64)).residuals).all()
    assert np.isnan(quasi_independence(np.diag([3, 3, 3])).bias).all()


def test_information_of_table_iii() -> None:
    assert mutual_information(TABLE_III) == pytest.approx(0.75, abs=0.005)


@pytest.mark.parametrize("k", [2, 6, 8])
def test_information_of_perfect_answers_and_of_guessing(k: int) -> None:
    assert mutual_information(4 * np.eye(k, dtype=int)) == pytest.approx(np.log2(k))
    assert mutual_information(np.full((k, k), 3)) == pytest.approx(0, abs=1e-12)
    assert np.isnan(mutual_information(np.zeros((k, k), dtype=int)))


def repeated(rng: np.random.Generator, people: int) -> list[np.ndarray]:
    """Return the answers to each emotion (participants, labels) of people who give each answer three times."""
    wrong = (np.arange(6) + rng.integers(1, 6, (people, 6))) % 6
    answers = np.where(rng.random((people, 6)) < 0.5, np.arange(6), wrong)
    return list(np.moveaxis(3 * np.eye(6, dtype=np.int64)[answers], 1, 0))


def of_participants(uses: list[np.ndarray], seed: int = 0) -> float:
    return near_neighbors(np.stack([used.sum(axis=0) for used in uses], axis=1), EMOTIONS, seed, uses).p


def test_near_neighbors_holds_its_size_when_participants_repeat_their_errors() -> None:
    rng = np.random.default_rng(5)
    p = np.array([of_participants(repeated(rng, 20), i) for i in range(400)])
    assert 0.02 < (p <= 0.05).mean() < 0.08  # standard error 0.011; about 0.2 where errors count as independent
    assert 0.4 < p.mean() < 0.6


def test_near_neighbors_of_one_participant_do_not_convince() -> None:
    rng = np.random.default_rng(0)
    uses = repeated(rng, 1)
    assert of_participants(uses) > 0.4


def test_near_neighbors_of_many_participants_use_the_normal_approximation() -> None:
    uses = repeated(np.random.default_rng(2), 300)
    many = [np.repeat(used, 5, axis=0) for used in uses]
    counts = np.stack([used.sum(axis=0) for used in many], axis=1)
    found = near_neighbors(counts, EMOTIONS, 0, many)
    assert (found.method, found.draws, found.seed) == ("normal", 0, None)
    assert norm.cdf(norm.ppf(found.p) / np.sqrt(5)) == pytest.approx(of_participants(uses), abs=0.03)
