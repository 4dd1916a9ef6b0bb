import json
import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest, chisquare

from emovid.figures.study import figure_data, study_figures
from emovid.report.results_json import as_json
from emovid.responses.responses import EMOTIONS, Responses
from emovid.statistics.analyze import analyze, analyze_counts
from emovid.statistics.results import StudyResults
from tests.helpers.known import TABLE_III


def responses(counts: np.ndarray, positions: bool = False) -> Responses:
    """Return participants in two groups whose answers add up to the counts."""
    people = int(counts.sum(axis=0).max())
    rows = []
    for j, video in enumerate(EMOTIONS):
        answers = np.repeat(np.arange(6), counts[:, j])
        for i, answer in enumerate(answers):
            rows.append((f"p{i}", f"v{j}", video, EMOTIONS[answer], (i + j) % 6 + 1 if positions else pd.NA))
    answers = pd.DataFrame(rows, columns=["participant", "video", "signalled", "perceived", "position"])
    answers["position"] = answers["position"].astype("Int64")
    names = [f"p{i}" for i in range(people)]
    groups = pd.DataFrame({"hand": ["left" if i % 3 else "right" for i in range(people)]}, index=names)
    return Responses(EMOTIONS, EMOTIONS, answers, groups)


@pytest.fixture(scope="module")
def results() -> StudyResults:
    return analyze(responses(TABLE_III))


def test_matrix_matches_the_paper(results) -> None:
    assert results.counts.tolist() == TABLE_III.tolist()
    assert results.percent[0] == pytest.approx([64.44, 17.78, 8.89, 4.44, 4.44, 13.33], abs=0.005)
    assert (results.n_participants, results.n_responses, results.n_videos) == (45, 270, 6)
    assert results.emotions == EMOTIONS


def test_goodness_of_fit_agrees_with_scipy(results) -> None:
    for j, name in enumerate(EMOTIONS):
        expected = chisquare(TABLE_III[:, j])
        fit = results.goodness_of_fit[name]
        assert (fit.statistic, fit.p) == pytest.approx((expected.statistic, expected.pvalue))
        assert {"n", "statistic", "dof", "p", "p_exact", "cohens_w"} <= set(vars(fit))


def test_recognition_agrees_with_scipy(results) -> None:
    for j, name in enumerate(EMOTIONS):
        found = results.recognition[name]
        test = binomtest(int(TABLE_III[j, j]), 45, 1 / 6, alternative="greater")
        assert found.p_binomial == pytest.approx(test.pvalue)
        assert found.p_binomial <= found.p_holm <= 6 * found.p_binomial + 1e-15
        assert found.hu_low <= found.hu <= found.hu_high
    assert results.recognition["fear"].verdict == "relative majority"


def test_groups_add_up_to_the_total(results) -> None:
    levels = results.groups["hand"]
    assert {level: block.n_participants for level, block in levels.items()} == {"left": 30, "right": 15}
    assert sum(block.counts for block in levels.values()).tolist() == TABLE_III.tolist()
    assert results.group_differences["hand"].scores.levels == ("left", "right")
    assert list(results.group_differences["hand"].videos) == list(EMOTIONS)


def test_results_are_json_without_nan(results) -> None:
    found = as_json(results)
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_every_test_has_an_apa_sentence(results) -> None:
    found = as_json(results)
    assert found["goodness_of_fit"]["fear"]["apa"] == "χ²(5, N = 45) = 27.67, p < .001, w = 0.78"
    assert found["recognition"]["fear"]["apa"].startswith("18/45 (40.0%, 95% CI [27.0, 54.5])")
    assert "expected" in found["near_neighbours"]["apa"]


def test_results_depend_on_the_seed(results) -> None:
    assert as_json(analyze(responses(TABLE_III))) == as_json(results)
    assert analyze(responses(TABLE_III), seed=1).recognition["fear"] != results.recognition["fear"]


def test_order_effect_is_tested_only_with_known_positions(results) -> None:
    assert results.dependence.order is None
    known = analyze(responses(TABLE_III, positions=True))
    assert sum(known.dependence.order.n) == 270


def test_matrix_without_answers_gives_the_possible_tests(results) -> None:
    alone = analyze_counts(TABLE_III, EMOTIONS, EMOTIONS)
    assert alone.goodness_of_fit == results.goodness_of_fit
    assert alone.n_participants is None
    assert alone.groups == {}


def test_warning_if_a_wrong_label_is_the_majority() -> None:
    counts = np.full((6, 6), 5)
    counts[:, 0] = [1, 1, 1, 1, 1, 25]
    said = analyze_counts(counts, EMOTIONS, EMOTIONS).warnings
    assert "happiness: the answers are not uniform, but not because it was recognized: most said sadness" in said


def test_no_warning_if_the_right_label_is_the_majority() -> None:
    counts = np.full((6, 6), 5)
    counts[:, 0] = [5, 5, 5, 0, 0, 0]
    said = analyze_counts(counts, EMOTIONS, EMOTIONS).warnings
    assert "happiness: the answers are not uniform, yet it is not above chance" in said
    counts[:, 0] = [0, 0, 0, 5, 5, 5]
    said = analyze_counts(counts, EMOTIONS, EMOTIONS).warnings
    text = "happiness: the answers are not uniform, but not because it was recognized: most said fear and disgust and"
    assert any(line.startswith(text) for line in said)


def test_label_without_a_video_is_named_and_not_counted_as_missing() -> None:
    study = responses(TABLE_III)
    labels = (*EMOTIONS, "neutral")
    offered = analyze(Responses(labels, labels, study.answers, study.participants))
    assert "neutral: no answers to a video of it" in offered.warnings
    assert not [line for line in offered.warnings if "missing" in line or line.startswith("neutral: 0.0")]
    without = analyze(study).dependence
    assert offered.dependence.fleiss_kappa == without.fleiss_kappa
    assert offered.dependence.cochran_q == without.cochran_q


def test_excluded_participants_are_reported() -> None:
    study = responses(TABLE_III)
    dropped = Responses(EMOTIONS, EMOTIONS, study.answers, study.participants, dropped={"preview": 2, "bot": 1})
    assert "participants left out: 2 preview, 1 bot" in analyze(dropped).warnings


def test_a_missing_answer_is_counted() -> None:
    study = responses(TABLE_III)
    some = analyze(Responses(EMOTIONS, EMOTIONS, study.answers[:-2], study.participants))
    assert "2 of 270 answers are missing" in some.warnings


def test_all_answers_to_several_videos_of_one_emotion_count_in_every_table() -> None:
    # All participants are right about the first videos of anger and fear, at positions 1 and 2, and wrong otherwise.
    rows = [
        (f"p{i}", f"{emotion}{take}", emotion, emotion if take == 0 else "sadness", 2 * take + 1 + (i + j) % 2)
        for i in range(8)
        for j, emotion in enumerate(("anger", "fear"))
        for take in (0, 1)
    ]
    answers = pd.DataFrame(rows, columns=["participant", "video", "signalled", "perceived", "position"])
    people = pd.DataFrame({"hand": ["left", "right"] * 4}, index=[f"p{i}" for i in range(8)])
    found = analyze(Responses(EMOTIONS, EMOTIONS, answers.astype({"position": "Int64"}), people))
    dependence = found.dependence
    assert (dependence.order.hits.tolist(), dependence.order.n.tolist()) == ([8, 8, 0, 0], [8, 8, 8, 8])
    assert (dependence.total_recognition.hits, dependence.total_recognition.n) == (16, 32)
    assert (found.recognition["anger"].hits, found.recognition["anger"].n) == (8, 16)
    assert (found.groups["hand"]["left"].recognition["anger"].hits, found.groups["hand"]["left"].n_responses) == (4, 16)
    assert found.group_differences["hand"].scores.means == (0.5, 0.5)
    assert found.group_differences["hand"].videos["anger"].n == (8, 8)
    assert {code: (video.recognition.hits, video.recognition.n) for code, video in found.videos.items()} == {
        "anger0": (8, 8), "anger1": (0, 8), "fear0": (8, 8), "fear1": (0, 8)
    }  # fmt: skip
    assert any("participants answered several videos of one emotion" in note for note in found.notes)


def test_groups_with_very_many_levels_are_compared_only_on_request() -> None:
    study = responses(TABLE_III)
    aged = study.participants.assign(
        age=[str(20 + i % 13) for i in range(45)], hand=["", *"abcdefghijkl" * 3, *"abcdefgh"]
    )
    study = Responses(EMOTIONS, EMOTIONS, study.answers, aged)
    found = analyze(study)
    assert list(found.groups) == list(found.group_differences) == ["hand"]
    assert "age: 13 levels, too many for a group; --by age compares them all the same" in found.notes
    asked = analyze(study, by=["age"])
    assert list(asked.groups) == ["age"]
    assert not [line for line in (*asked.warnings, *asked.notes) if "too many" in line]


def test_figure_names_of_groups_are_valid_on_all_file_systems() -> None:
    study = responses(TABLE_III)
    question = "Geschlecht (m/w/d): " + "wie Sie es nennen? " * 20
    groups = {question: "hand", f"{question}!": "hand", "Hand": "hand", "hand": "hand", "a_b": "hand"}
    people = pd.DataFrame({name: study.participants[column] for name, column in groups.items()})
    names = list(study_figures(figure_data(analyze(Responses(EMOTIONS, EMOTIONS, study.answers, people)))))
    long = "accuracy-Geschlecht-m-w-d-wie-Sie-es-nennen-wie-Sie-es-nenne"
    assert names[3:] == [long, f"{long}-2", "accuracy-Hand", "accuracy-hand-2", "accuracy-a-b"]


def test_few_answers_give_warnings() -> None:
    said = analyze(responses(np.eye(6, dtype=int) * 4)).warnings
    assert "all emotions: 0.7 answers a cell are expected, under 5: use the exact p" in said
    assert "hand: fewer than 5 participants in left, right; interpret their tests with caution" in said


def test_group_of_one_participant_is_accepted() -> None:
    study = responses(TABLE_III)
    ages = ["old"] + ["young"] * 44
    lonely = Responses(EMOTIONS, EMOTIONS, study.answers, study.participants.assign(age=ages))
    assert analyze(lonely, by=["age"]).groups["age"]["old"].n_participants == 1


def test_emotion_without_answers_is_accepted() -> None:
    counts = TABLE_III.copy()
    counts[:, 2] = 0
    found = analyze_counts(counts, EMOTIONS, EMOTIONS)
    assert as_json(found)["recognition"]["anger"]["rate"] is None
    assert as_json(found)["percent"][0][2] is None
    assert math.isnan(found.recognition["anger"].p_binomial)
