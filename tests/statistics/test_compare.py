import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2, chi2_contingency, fisher_exact

from emovid.statistics.compare import aligned, compare, homogeneity
from emovid.statistics.goodness import DRAWS
from emovid.statistics.proportions import newcombe

A = np.array([[29, 8, 4], [5, 26, 4], [4, 0, 25], [7, 11, 12]])
B = np.array([[14, 6, 8], [6, 10, 2], [4, 3, 9], [2, 5, 5]])
LABELS, PAIR = ("fear", "anger", "none"), ("fear", "anger")


def test_studies_with_other_videos_are_aligned_by_their_labels() -> None:
    first = np.array([[3, 1], [1, 2], [0, 1]]), LABELS, PAIR
    second = np.array([[5], [6], [7]]), ("anger", "none", "fear"), ("anger",)
    original, replication, videos = aligned(first, second)
    assert videos == PAIR
    assert original.tolist() == first[0].tolist()
    assert replication.tolist() == [[0, 7], [0, 5], [0, 6]]
    back, forth, videos = aligned(second, first)
    assert (videos, back.tolist()) == (("anger", "fear"), [[5, 0], [7, 0], [6, 0]])
    assert forth.tolist() == [[2, 1], [1, 3], [1, 0]]
    found = compare(original, replication)
    assert found.videos[0].n == (4, 0)
    with pytest.raises(ValueError, match="differ"):
        aligned(first, (second[0], ("anger", "none", "sadness"), ("anger",)))


MATRIX = st.lists(st.integers(0, 8), min_size=9, max_size=9).map(lambda cells: np.array(cells).reshape(3, 3))


def test_each_video_compares_the_two_studies() -> None:
    test = compare(A, B)
    for j, video in enumerate(test.videos):
        expected = chi2_contingency(np.array([A[:, j], B[:, j]]), correction=False)
        assert video.statistic == pytest.approx(expected.statistic)
        assert video.dof == expected.dof
        assert video.p_answers == pytest.approx(expected.pvalue, abs=0.03)
        hits, n = video.hits, video.n
        rates = fisher_exact([[hits[0], n[0] - hits[0]], [hits[1], n[1] - hits[1]]])
        assert video.p == pytest.approx(rates.pvalue)


def test_overall_statistic_is_the_sum_over_videos() -> None:
    test = compare(A, B)
    assert test.statistic == pytest.approx(sum(video.statistic for video in test.videos))
    assert test.dof == 9
    assert test.p == pytest.approx(chi2.sf(test.statistic, 9))
    assert test.p_monte_carlo == pytest.approx(test.p, abs=0.03)


def test_differences_are_replication_minus_original() -> None:
    first = compare(A, B).videos[0]
    assert (first.hits, first.n) == ((29, 14), (45, 26))
    assert first.rates.difference == pytest.approx(14 / 26 - 29 / 45)
    assert (first.rates.ci_low, first.rates.ci_high) == newcombe((14, 29), (26, 45))


def test_comparison_of_two_labels_agrees_with_fisher() -> None:
    a, b = np.array([[8, 1], [2, 9]]), np.array([[3, 3], [7, 5]])
    for j, video in enumerate(compare(a, b, seed=5).videos):
        assert video.p == pytest.approx(fisher_exact([a[:, j], b[:, j]]).pvalue, abs=0.02)


def test_holm_correction_and_seed_of_a_comparison() -> None:
    test = compare(A, B, seed=9)
    smallest = min(video.p for video in test.videos)
    assert min(video.p_holm for video in test.videos) == pytest.approx(min(1, 3 * smallest))
    answers = min(video.p_answers for video in test.videos)
    assert min(video.p_answers_holm for video in test.videos) == pytest.approx(min(1, 3 * answers))
    assert (test.draws, test.seed) == (DRAWS, 9)
    assert compare(A, B, seed=9) == test


def test_comparison_of_a_study_with_itself() -> None:
    test = compare(A, A)
    assert (test.statistic, test.p, test.p_monte_carlo) == (0, 1, 1)
    assert all(video.rates.difference == 0 and video.rates.ci_low < 0 < video.rates.ci_high for video in test.videos)


def test_comparison_of_very_different_studies() -> None:
    test = compare(A, np.roll(A, 1, axis=0))
    assert test.p < 1e-6
    assert test.p_monte_carlo == 1 / (DRAWS + 1)


def test_comparison_without_answers_to_one_video() -> None:
    missing = B.copy()
    missing[:, 1] = 0
    test = compare(A, missing)
    video = test.videos[1]
    assert (video.statistic, video.dof) == (0, 0)
    assert np.isnan([video.p, video.p_holm, video.p_answers, video.rates.difference, video.replication_bf]).all()
    assert test.dof == 6
    assert np.isnan([compare(A * 0, B * 0).p, compare(A * 0, B * 0).p_monte_carlo]).all()


def test_studies_with_different_labels_are_refused() -> None:
    with pytest.raises(ValueError, match="cannot be compared"):
        compare(A, B[:3])


def test_homogeneity_of_many_tables() -> None:
    total, rows = np.array([6, 5, 4]), np.array([[3, 2, 2], [6, 1, 0], [0, 3, 4]])
    expected = [chi2_contingency(np.array([row, total - row])).statistic for row in rows]
    assert homogeneity(rows, total) == pytest.approx(expected)


@given(MATRIX, MATRIX, st.permutations(range(3)))
@settings(max_examples=12)
def test_order_of_studies_and_labels_does_not_matter(a: np.ndarray, b: np.ndarray, order: list[int]) -> None:
    test, swapped = compare(a, b), compare(b, a)
    assert np.isnan(test.p_monte_carlo) == (test.dof == 0)
    assert np.isnan(test.p_monte_carlo) or 0 < test.p_monte_carlo <= 1
    assert all(np.isnan(video.p) or 0 < video.p <= video.p_holm <= 1 for video in test.videos)
    assert swapped.statistic == pytest.approx(test.statistic)
    renamed = compare(a[np.ix_(order, order)], b[np.ix_(order, order)])
    assert renamed.statistic == pytest.approx(test.statistic)
    assert [video.hits for video in renamed.videos] == [test.videos[j].hits for j in order]
