from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emovid.figures.circumplex import POSITIONS
from emovid.responses.responses import EMOTIONS
from emovid.statistics.circumplex import ANGLES, distances, near_neighbours
from tests.helpers.known import TABLE_III


def test_emotions_go_round_in_the_order_of_the_paper() -> None:
    assert sorted(ANGLES, key=lambda emotion: ANGLES[emotion]) == list(EMOTIONS)


def test_the_figure_shows_the_angles_that_are_tested() -> None:
    for emotion, angle in ANGLES.items():
        place = POSITIONS[emotion]
        assert np.degrees(np.arctan2(place.arousal, place.valence)) % 360 == pytest.approx(angle)


def test_distance_goes_the_short_way_round() -> None:
    between = distances(EMOTIONS)
    assert between[0, 5] == pytest.approx(360 - 199.7)
    assert between[3, 4] == 22
    assert (between == between.T).all()
    assert (np.diagonal(between) == 0).all()
    assert between.max() <= 180


def test_confusions_of_the_paper_are_near() -> None:
    test = near_neighbours(TABLE_III, EMOTIONS)
    assert test.confusions == 270 - 145
    assert test.p == pytest.approx(9 / 720)
    assert test.mean_distance < test.expected


def test_against_arcs_measured_one_by_one() -> None:
    angles = np.radians(list(ANGLES.values()))

    def mean_arc(order) -> float:
        arcs = [
            np.degrees(np.arccos(np.cos(angles[order[i]] - angles[order[j]])))
            for i in range(6)
            for j in range(6)
            for _ in range(TABLE_III[i, j])
            if i != j
        ]
        return float(np.mean(arcs))

    arcs = np.array([mean_arc(order) for order in permutations(range(6))])
    test = near_neighbours(TABLE_III, EMOTIONS)
    assert test.mean_distance == pytest.approx(arcs[0])
    assert test.expected == pytest.approx(arcs.mean())
    assert test.p == pytest.approx((arcs <= arcs[0] + 1e-6).mean())


def test_only_nearest_neighbours_and_only_farthest() -> None:
    between = distances(EMOTIONS) + np.diag(np.full(6, np.nan))
    near, far = np.zeros((6, 6), dtype=np.int64), np.zeros((6, 6), dtype=np.int64)
    near[np.nanargmin(between, axis=0), np.arange(6)] = 5
    far[np.nanargmax(between, axis=0), np.arange(6)] = 5
    assert near_neighbours(near, EMOTIONS).p < 0.05
    assert near_neighbours(far, EMOTIONS).p > 0.95


def test_nobody_was_confused() -> None:
    test = near_neighbours(np.diag([3, 4, 5]), EMOTIONS[:3])
    assert (test.confusions, test.p) == (0, 1)
    assert np.isnan(test.mean_distance)


def test_labels_without_a_place_are_left_out() -> None:
    counts = np.array([[4, 9, 1], [9, 4, 9], [2, 9, 4], [7, 7, 7]])
    test = near_neighbours(counts, ("fear", "awe", "anger", "none"))
    assert (test.confusions, test.mean_distance, test.p) == (3, 17, 1)


def test_fewer_videos_than_labels() -> None:
    test = near_neighbours(TABLE_III[:, :2], EMOTIONS)
    assert test.confusions == 90 - 29 - 26
    assert test.mean_distance == pytest.approx((distances(EMOTIONS)[:, :2] * TABLE_III[:, :2]).sum() / test.confusions)


@given(st.lists(st.integers(0, 9), min_size=16, max_size=16), st.integers(1, 5))
@settings(max_examples=30)
def test_more_answers_of_the_same_kind_change_nothing(cells: list[int], times: int) -> None:
    counts = np.array(cells).reshape(4, 4)
    one, many = near_neighbours(counts, EMOTIONS[:4]), near_neighbours(times * counts, EMOTIONS[:4])
    assert 1 / 24 <= one.p <= 1
    assert many.p == one.p
