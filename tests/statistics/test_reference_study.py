"""One test for each published claim about the study, by scipy and pandas from the reconstructed answers."""

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from scipy.stats import chisquare, fisher_exact

STUDY = Path(__file__).parents[2] / "studies" / "santos-egerstedt"
EMOTIONS = ["happiness", "surprise", "anger", "fear", "disgust", "sadness"]
CLEAR = ["happiness", "surprise", "anger", "sadness"]  # absolute majority; the others are CLOSE
CLOSE = ["fear", "disgust"]
CHANCE = 1 / 6
TABLE_III = [
    [64.44, 17.78, 8.89, 4.44, 4.44, 13.33],
    [11.11, 57.78, 8.89, 2.22, 0.00, 0.00],
    [8.89, 0.00, 55.56, 13.33, 15.56, 4.44],
    [6.67, 13.33, 20.00, 40.00, 35.56, 15.56],
    [6.67, 4.44, 4.44, 26.67, 40.00, 2.22],
    [2.22, 6.67, 2.22, 13.33, 4.44, 64.44],
]
CHI_SQUARED = [75.133, 60.200, 54.067, 27.667, 39.933, 79.133]


@pytest.fixture(scope="module")
def answers() -> pd.DataFrame:
    return pd.read_csv(STUDY / "responses.csv")


@pytest.fixture(scope="module")
def people(answers) -> pd.DataFrame:
    return answers.drop_duplicates("participant")


def table(answers: pd.DataFrame) -> pd.DataFrame:
    counts = pd.crosstab(answers["response"], answers["video"])
    return counts.reindex(index=EMOTIONS, columns=EMOTIONS, fill_value=0)


def p_values(answers: pd.DataFrame) -> pd.Series:
    return pd.Series(chisquare(table(answers)).pvalue, EMOTIONS)


def accuracy(answers: pd.DataFrame) -> pd.Series:
    return (answers["response"] == answers["video"]).groupby(answers["video"]).mean()


def group(answers: pd.DataFrame, column: str, level: str) -> pd.DataFrame:
    return answers[answers[column] == level]


def test_file_has_45_participants_with_six_videos_each(answers) -> None:
    assert list(answers) == ["participant", "video", "response", "gender", "robotics_background", "age"]
    assert len(answers) == 270
    assert answers.groupby("participant")["video"].apply(sorted).tolist() == [sorted(EMOTIONS)] * 45
    assert set(answers["response"]) <= set(EMOTIONS)
    groups = answers.groupby("participant")[["gender", "robotics_background", "age"]].nunique()
    assert (groups == 1).all(axis=None)


def test_percentages_match_table_iii(answers) -> None:
    percent = table(answers) / 45 * 100
    assert percent.round(2).to_numpy().tolist() == TABLE_III


def test_counts_match_the_publication(answers) -> None:
    published = pd.read_csv(STUDY / "counts.csv", index_col="perceived")
    assert published.equals(table(answers).rename_axis(index="perceived", columns=None))


def test_32_are_male_and_13_female(people) -> None:
    assert people["gender"].value_counts().to_dict() == {"male": 32, "female": 13}


def test_29_have_no_robotics_background(people) -> None:
    assert people["robotics_background"].value_counts().to_dict() == {"no": 29, "yes": 16}


def test_age_groups_match_the_publication(people) -> None:
    percent = (people["age"].value_counts(normalize=True) * 100).round(1)
    assert percent.to_dict() == {"18-24": 31.1, "25-34": 60.0, "35-44": 6.7, "45-54": 2.2}


def test_absolute_majority_for_happiness_surprise_anger_and_sadness(answers) -> None:
    assert (accuracy(answers)[CLEAR] > 0.5).all()


def test_relative_majority_of_40_percent_for_fear_and_disgust(answers) -> None:
    counts = table(answers)
    for emotion in CLOSE:
        assert accuracy(answers)[emotion] == pytest.approx(0.4)
        assert counts.index[counts[emotion] == counts[emotion].max()].tolist() == [emotion]


def test_all_emotions_are_recognized_above_chance(answers) -> None:
    assert (accuracy(answers) > CHANCE).all()


def test_chi_squared_of_each_video(answers) -> None:
    result = chisquare(table(answers))
    assert result.statistic == pytest.approx(CHI_SQUARED, abs=5e-4)
    assert (result.pvalue < 0.0001).all()


def test_confusions_are_mostly_with_circumplex_neighbors(answers) -> None:
    wrong = answers[answers["response"] != answers["video"]]
    steps = (wrong["response"].map(EMOTIONS.index) - wrong["video"].map(EMOTIONS.index)) % 6
    assert steps.isin([1, 5]).mean() > 0.5  # 0.4 if wrong answers were uniform


@pytest.mark.parametrize("background", ["yes", "no"])
def test_either_background_has_a_majority_for_four_emotions_with_p_below_001(answers, background) -> None:
    part = group(answers, "robotics_background", background)
    assert (accuracy(part)[CLEAR] > 0.5).all()
    assert (p_values(part)[CLEAR] < 0.01).all()


def test_fear_and_disgust_without_a_background_have_higher_accuracy_and_p_below_001(answers) -> None:
    without, having = (group(answers, "robotics_background", level) for level in ("no", "yes"))
    assert (accuracy(without)[CLOSE] > accuracy(having)[CLOSE]).all()
    assert (p_values(without)[CLOSE] < 0.01).all()


def test_fear_and_disgust_with_a_background_have_slightly_higher_p_and_are_above_chance(answers) -> None:
    part = group(answers, "robotics_background", "yes")
    p = p_values(part)
    assert 0.01 <= p["fear"] < 0.05 <= p["disgust"] < 0.1
    assert (accuracy(part)[CLOSE] > CHANCE).all()


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_no_substantial_difference_by_background(answers, emotion) -> None:
    part = answers[answers["video"] == emotion]
    hits = pd.crosstab(part["robotics_background"], part["response"] == emotion)
    assert hits.to_numpy().sum() == 45
    assert fisher_exact(hits).pvalue > 0.05
    assert (hits[True] / hits.sum(axis=1)).diff().abs().max() < 0.1


def test_female_accuracy_is_higher_for_every_emotion(answers) -> None:
    assert (accuracy(group(answers, "gender", "female")) > accuracy(group(answers, "gender", "male"))).all()


def test_female_accuracy_exceeds_half_in_five_of_six_and_is_4615_percent_for_fear(answers) -> None:
    female = accuracy(group(answers, "gender", "female"))
    assert female.index[female <= 0.5].tolist() == ["fear"]
    assert round(100 * female["fear"], 2) == 46.15


def test_female_answers_differ_from_chance_at_p_below_001(answers) -> None:
    assert (p_values(group(answers, "gender", "female")) < 0.01).all()


def test_male_answers_differ_from_chance_at_p_below_005_but_not_all_at_001(answers) -> None:
    male = group(answers, "gender", "male")
    assert (accuracy(male) > CHANCE).all()
    assert (p_values(male) < 0.05).all()
    assert (p_values(male) >= 0.01).any()


def test_script_reproduces_the_file_exactly(tmp_path) -> None:
    made = tmp_path / "responses.csv"
    subprocess.run([sys.executable, "-W", "error", STUDY / "reconstruct.py", made], check=True)
    assert made.read_bytes() == (STUDY / "responses.csv").read_bytes()
