import json
import math

import numpy as np
import pandas as pd
import pytest
from known import TABLE_III
from scipy.stats import binomtest, chisquare

from emovid.study.analyze import analyze, analyze_counts
from emovid.study.responses import EMOTIONS, Responses


def responses(counts: np.ndarray, positions: bool = False) -> Responses:
    """Return participants whose answers add up to the counts, in two groups."""
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
def results() -> dict:
    return analyze(responses(TABLE_III))


def test_the_matrix_is_that_of_the_paper(results) -> None:
    assert results["counts"] == TABLE_III.tolist()
    assert results["percent"][0] == pytest.approx([64.44, 17.78, 8.89, 4.44, 4.44, 13.33], abs=0.005)
    assert (results["n_participants"], results["n_responses"], results["n_videos"]) == (45, 270, 6)
    assert results["emotions"] == list(EMOTIONS)


def test_goodness_of_fit_is_scipy_s(results) -> None:
    for j, name in enumerate(EMOTIONS):
        expected = chisquare(TABLE_III[:, j])
        fit = results["goodness_of_fit"][name]
        assert (fit["statistic"], fit["p"]) == pytest.approx((expected.statistic, expected.pvalue))
        assert {"n", "statistic", "dof", "p", "p_exact", "cohens_w"} <= set(fit)


def test_recognition_is_scipy_s(results) -> None:
    for j, name in enumerate(EMOTIONS):
        found = results["recognition"][name]
        test = binomtest(int(TABLE_III[j, j]), 45, 1 / 6, alternative="greater")
        assert found["p_binomial"] == pytest.approx(test.pvalue)
        assert found["p_binomial"] <= found["p_holm"] <= 6 * found["p_binomial"] + 1e-15
        assert found["hu_low"] <= found["hu"] <= found["hu_high"]
    assert results["recognition"]["fear"]["verdict"] == "relative majority"


def test_groups_add_up_to_the_whole(results) -> None:
    levels = results["groups"]["hand"]
    assert {level: block["n_participants"] for level, block in levels.items()} == {"left": 30, "right": 15}
    assert sum(np.array(block["counts"]) for block in levels.values()).tolist() == TABLE_III.tolist()
    assert results["group_differences"]["hand"]["scores"]["levels"] == ["left", "right"]
    assert list(results["group_differences"]["hand"]["videos"]) == list(EMOTIONS)


def test_everything_is_json_without_nan(results) -> None:
    text = json.dumps(results, allow_nan=False)
    assert json.loads(text) == results


def test_every_test_has_its_sentence(results) -> None:
    assert results["goodness_of_fit"]["fear"]["apa"] == "χ²(5, N = 45) = 27.67, p < .001, w = 0.78"
    assert results["recognition"]["fear"]["apa"].startswith("18/45 (40.0%, 95% CI [27.0, 54.5])")
    assert "expected" in results["near_neighbours"]["apa"]


def test_the_seed_decides(results) -> None:
    assert analyze(responses(TABLE_III)) == results
    assert analyze(responses(TABLE_III), seed=1)["recognition"]["fear"]["hu_low"] != math.inf


def test_the_order_is_looked_at_where_it_is_known(results) -> None:
    assert results["dependence"]["order"] is None
    known = analyze(responses(TABLE_III, positions=True))
    assert sum(known["dependence"]["order"]["n"]) == 270


def test_a_matrix_alone_gives_what_it_can(results) -> None:
    alone = analyze_counts(TABLE_III, EMOTIONS, EMOTIONS)
    assert alone["goodness_of_fit"] == results["goodness_of_fit"]
    assert alone["n_participants"] is None
    assert alone["groups"] == {}


def test_a_wrong_label_that_everyone_gives_is_warned_of() -> None:
    counts = np.full((6, 6), 5)
    counts[:, 0] = [1, 1, 1, 1, 1, 25]
    said = analyze_counts(counts, EMOTIONS, EMOTIONS)["warnings"]
    assert "happiness: the answers are not uniform, but not because it was recognised: most said sadness" in said


def test_few_answers_are_warned_of() -> None:
    said = analyze(responses(np.eye(6, dtype=int) * 4))["warnings"]
    assert "fear: 0.7 answers a cell are expected, under 5: use the exact p" in said
    assert "hand: fewer than 5 participants in left, right; read their tests as hints" in said


def test_a_group_of_one_is_no_error() -> None:
    study = responses(TABLE_III)
    ages = ["old"] + ["young"] * 44
    lonely = Responses(EMOTIONS, EMOTIONS, study.answers, study.participants.assign(age=ages))
    assert analyze(lonely, by=["age"])["groups"]["age"]["old"]["n_participants"] == 1


def test_an_emotion_without_answers_is_no_error() -> None:
    counts = TABLE_III.copy()
    counts[:, 2] = 0
    found = analyze_counts(counts, EMOTIONS, EMOTIONS)
    assert found["recognition"]["anger"]["rate"] is None
    assert found["percent"][0][2] is None
