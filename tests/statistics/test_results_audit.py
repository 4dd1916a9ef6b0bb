"""Data of a statistical audit with known values: from R 4.2, full enumeration, or construction."""

from pathlib import Path

import numpy as np
import pytest

from emovid.report import apa
from emovid.report.page import report_html
from emovid.responses.read import read_responses
from emovid.responses.results_files import read_matrix
from emovid.statistics.analyze import analyze
from emovid.statistics.compare import compare
from emovid.statistics.results import StudyResults

AUDIT = Path(__file__).parent / "audit"


def analyzed(name: str, key: str | None = None, labels: list[str] | None = None, by: list[str] | None = None):
    source, codes = AUDIT / f"{name}.csv", AUDIT / key if key else None
    found = read_responses([source], codes, AUDIT / "map.yaml", labels, by or [])
    return analyze(found, by or [])


@pytest.fixture(scope="module")
def exemplars() -> StudyResults:
    labels = ["happiness", "anger", "sadness"]
    return analyzed("hu_two_exemplars", "hu_two_exemplars_key.csv", labels, ["group"])


def test_every_table_counts_all_answers_to_several_videos(exemplars) -> None:
    for test in exemplars.recognition.values():
        assert (test.hits, test.n, test.participants) == (20, 40, 20)
        assert test.hu == pytest.approx(0.25)
        assert 0 < test.hu_low < 0.25 < test.hu_high < 1
    total = exemplars.dependence.total_recognition
    assert (total.hits, total.n) == (60, 120)
    for level in ("g1", "g2"):
        assert exemplars.groups["group"][level].recognition["happiness"].hits == 10
    differ = exemplars.group_differences["group"].videos["happiness"]
    assert (differ.hits, differ.n) == ((10, 10), (20, 20))
    assert exemplars.group_differences["group"].scores.means == (0.5, 0.5)


def test_each_video_has_its_own_results(exemplars) -> None:
    hits = {
        code: (video.emotion, video.recognition.hits, video.recognition.n) for code, video in exemplars.videos.items()
    }
    assert hits["a0"] == ("happiness", 20, 20)
    assert hits["b0"] == ("happiness", 0, 20)
    page = report_html(exemplars, None)
    assert "Video by video" in page
    assert "permutation test that keeps each participant" in page


def test_errors_count_as_independent_only_where_participants_are_not_taken_together() -> None:
    words = "counted as independent: repeated confusions"
    reference = read_responses([Path(__file__).parents[2] / "studies" / "santos-egerstedt" / "responses.csv"])
    for found, method in ((analyzed("repeated", "key.csv"), "sign flips"), (analyze(reference), "Monte Carlo")):
        assert found.near_neighbours.method == method
        assert (words in report_html(found, None)) == (method == "Monte Carlo")


def test_overall_test_uses_all_311_answers() -> None:
    found = analyzed("repeated", "key.csv")
    assert found.dependence.total_recognition.n == found.accuracy.n == found.n_responses == 311
    assert sum(found.dependence.order.n) == 311
    assert len(found.videos) == 12
    assert sum(video.recognition.n for video in found.videos.values()) == 311


def test_unequal_recognition_is_not_a_label_preference() -> None:
    # By construction: errors are uniform; 0.9 and 0.3 are recognized. The former test had chi-squared 69.58, p < .001.
    use = analyzed("no_preference_unequal_recognition").dependence.label_use
    assert use.p > 0.05
    assert use.bias == pytest.approx(np.ones(6), abs=0.5)
    assert use.totals[:3].min() >= 2 * use.totals[3:].max()


def test_difference_of_zero_is_not_reported_as_a_finding() -> None:
    (a, _, _), (b, _, _) = (read_matrix(AUDIT / f"compare_{name}.csv") for name in "ab")
    happiness = compare(a, b).videos[0]
    assert happiness.rates.difference == 0
    assert (happiness.p, happiness.p_holm) == (1, 1)
    assert happiness.p_answers_holm < 0.001  # its errors differ, which is a different test


@pytest.mark.parametrize(
    ("name", "labels"), [("two_labels", ["happiness", "sadness"]), ("three", ["happiness", "sadness", "anger"])]
)
def test_near_neighbors_is_undefined_for_two_or_three_labels(name, labels) -> None:
    near = analyzed(name, labels=labels).near_neighbours
    assert np.isnan(near.p)
    assert apa.sentence(near).endswith("cannot be tested: the margins fix the distance")


def test_one_participant_gives_no_test_of_videos() -> None:
    q = analyzed("unequal").dependence.cochran_q
    assert (q.informative, q.total) == (1, 40)
    assert np.isnan(q.p)


def test_interval_of_twenty_right_answers_does_not_collapse() -> None:
    found = analyzed("perfect")
    for test in found.recognition.values():
        assert (test.hu, test.hu_high) == (1, 1)
        assert test.ci_low == pytest.approx(0.839, abs=5e-4)
        assert test.hu_low < test.ci_low
    assert np.isnan(found.information.ci_low)
