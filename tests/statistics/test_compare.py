from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2, chi2_contingency, fisher_exact

from emovid.errors import SourceError
from emovid.scene.resources import STUDIES
from emovid.statistics.compare import aligned, compare, homogeneity
from emovid.statistics.goodness import DRAWS
from emovid.statistics.proportions import newcombe
from emovid.workflows.analysis import analyze_exports, compare_studies, write_analysis

A = np.array([[29, 8, 4], [5, 26, 4], [4, 0, 25], [7, 11, 12]])
B = np.array([[14, 6, 8], [6, 10, 2], [4, 3, 9], [2, 5, 5]])
LABELS, PAIR = ("fear", "anger", "none"), ("fear", "anger")


def test_studies_with_other_videos_are_aligned_by_their_labels() -> None:
    first = np.array([[3, 1], [1, 2], [0, 1]]), LABELS, PAIR
    second = np.array([[5], [6], [7]]), ("anger", "none", "fear"), ("anger",)
    original, replication, _, videos = aligned(first, second)
    assert videos == PAIR
    assert original.tolist() == first[0].tolist()
    assert replication.tolist() == [[0, 7], [0, 5], [0, 6]]
    back, forth, _, videos = aligned(second, first)
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
    assert homogeneity(rows[:, :, None], total[:, None])[:, 0] == pytest.approx(expected)


def people(rng: np.random.Generator, n: int, mood: float, exemplars: int = 1, k: int = 3) -> np.ndarray:
    """Return uses (participants, k labels, k emotions) of participants who often repeat one label."""
    favorite = rng.integers(k, size=(n, 1, 1))
    given = np.where(rng.random((n, k, exemplars)) < mood, favorite, rng.integers(k, size=(n, k, exemplars)))
    return (given[:, None] == np.arange(k)[None, :, None, None]).sum(axis=3)


def test_shuffled_participants_are_all_splits_of_them() -> None:
    rng = np.random.default_rng(4)
    both = people(rng, 3, 0.5), people(rng, 4, 0.5)
    a, b = (uses.sum(axis=0) for uses in both)
    found = compare(a, b, people=both)
    cells = np.concatenate(both)
    sums = [cells[list(chosen)].sum(axis=0) for chosen in combinations(range(7), 4)]
    whole = np.array([homogeneity(table[None], a + b).sum() for table in sums])
    assert (found.shuffled, found.draws) == ("participants", DRAWS)
    assert found.p_monte_carlo == pytest.approx((whole >= found.statistic - 1e-9).mean(), abs=0.02)


def test_answers_of_one_mood_are_no_evidence_of_a_difference() -> None:
    rng, by_people, by_answers = np.random.default_rng(0), [], []
    for _ in range(40):
        both = people(rng, 20, 1.0, k=8), people(rng, 20, 1.0, k=8)
        a, b = (uses.sum(axis=0) for uses in both)
        by_people.append(compare(a, b, people=both).p_monte_carlo <= 0.05)
        by_answers.append(compare(a, b).p_monte_carlo <= 0.05)
    assert np.mean(by_people) <= 0.15  # 0.05 +- 0.03
    assert np.mean(by_answers) >= 0.2  # 0.23 is expected


def test_several_answers_are_worth_less() -> None:
    rng = np.random.default_rng(7)
    both = people(rng, 20, 0.9, 4), people(rng, 20, 0.9, 4)
    a, b = (uses.sum(axis=0) for uses in both)
    known, unknown = compare(a, b, people=both).videos[0], compare(a, b).videos[0]
    assert known.p_answers > unknown.p_answers + 0.1
    assert known.rates.ci_high - known.rates.ci_low > 1.3 * (unknown.rates.ci_high - unknown.rates.ci_low)
    assert known.pooled_high - known.pooled_low > 1.3 * (unknown.pooled_high - unknown.pooled_low)
    assert np.isnan(known.replication_bf)


def test_participants_come_from_the_tidy_answers(tmp_path) -> None:
    reference = STUDIES / "santos-egerstedt" / "responses.csv"
    for name in ("original", "replication"):
        write_analysis(analyze_exports([reference]), tmp_path / name)
    _, found = compare_studies(tmp_path / "original", tmp_path / "replication" / "results.json")
    assert (found.shuffled, found.statistic, found.p_monte_carlo) == ("participants", 0, 1)
    _, matrix = compare_studies(tmp_path / "original", tmp_path / "replication" / "confusion_matrix.csv")
    assert (matrix.shuffled, matrix.p_monte_carlo) == ("answers", 1)
    tidy = tmp_path / "original" / "responses_tidy.csv"
    tidy.write_text("".join(tidy.read_text().splitlines(keepends=True)[:-1]))
    with pytest.raises(SourceError, match=r"other answers than those of results\.json"):
        compare_studies(tmp_path / "original", tmp_path / "replication")


@given(MATRIX, MATRIX, st.permutations(range(3)))
@settings(max_examples=12, deadline=None)
def test_order_of_studies_and_labels_does_not_matter(a: np.ndarray, b: np.ndarray, order: list[int]) -> None:
    test, swapped = compare(a, b), compare(b, a)
    assert np.isnan(test.p_monte_carlo) == (test.dof == 0)
    assert np.isnan(test.p_monte_carlo) or 0 < test.p_monte_carlo <= 1
    assert all(np.isnan(video.p) or 0 < video.p <= video.p_holm <= 1 for video in test.videos)
    assert swapped.statistic == pytest.approx(test.statistic)
    renamed = compare(a[np.ix_(order, order)], b[np.ix_(order, order)])
    assert renamed.statistic == pytest.approx(test.statistic)
    assert [video.hits for video in renamed.videos] == [test.videos[j].hits for j in order]
