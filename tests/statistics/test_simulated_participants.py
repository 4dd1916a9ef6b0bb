import numpy as np
import pytest
from scipy.stats import chisquare

from emovid.responses.responses import EMOTIONS
from emovid.statistics.simulated_participants import Responders, rehearse, responders


def table(model: Responders, participants: int = 2000, seed: int = 1):
    return rehearse(model, EMOTIONS, EMOTIONS, participants, seed)


def test_responders_are_as_accurate_as_they_are_told() -> None:
    accuracy = np.array([0.9, 0.7, 0.5, 0.3, 0.2, 0.1])
    answers = table(responders(accuracy, 6))
    rates = (answers["video"] == answers["response"]).groupby(answers["video"]).mean()[list(EMOTIONS)]
    assert rates.to_numpy() == pytest.approx(accuracy, abs=0.04)
    assert len(answers) == 12_000


def test_wrong_answers_follow_the_bias() -> None:
    answers = table(responders(np.zeros(6), 6, bias=np.array([0, 0, 0, 3, 1, 0.0])))
    wrong = answers[answers["video"] == "happiness"]["response"].value_counts()
    assert set(wrong.index) == {"fear", "disgust"}
    assert wrong["fear"] / wrong.sum() == pytest.approx(0.75, abs=0.04)


def test_where_no_wrong_label_has_weight_all_are_alike() -> None:
    model = responders(np.array([0.0, 0.4]), 3, bias=np.array([0, 1.0, 0]))
    assert model.probabilities.T.tolist() == [[0, 1, 0], [pytest.approx(0.3), 0.4, pytest.approx(0.3)]]
    none = responders(np.zeros(3), 3, bias=np.zeros(3))
    assert none.probabilities.tolist() == [[0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]]


def test_who_eliminates_never_gives_a_label_twice() -> None:
    answers = table(responders(np.full(6, 0.3), 6, elimination=1.0), participants=200)
    assert (answers.groupby("participant")["response"].nunique() == 6).all()


@pytest.mark.parametrize("rate", [0.2, 0.4, 0.8])
def test_who_eliminates_is_as_accurate_as_told(rate: float) -> None:
    # Without raised probabilities, labels that are gone would make 0.37 of 0.4.
    answers = table(responders(np.full(6, rate), 6, elimination=1.0), participants=4000)
    assert (answers["video"] == answers["response"]).mean() == pytest.approx(rate, abs=0.012)


def test_elimination_goes_on_when_no_likely_label_is_left() -> None:
    answers = table(responders(np.ones(6), 6, bias=np.array([1, 0, 0, 0, 0, 0.0]), elimination=1.0), participants=50)
    assert (answers["video"] == answers["response"]).all()


def test_dropouts_leave_early_and_for_good() -> None:
    answers = table(responders(np.full(6, 0.5), 6, dropout=0.2))
    last = answers.groupby("participant")["position"].agg(["max", "count"])
    assert (last["max"] == last["count"]).all()
    assert (last["count"] == 6).mean() == pytest.approx(0.8**5, abs=0.03)


def test_every_order_of_videos_is_as_likely() -> None:
    answers = table(responders(np.full(6, 0.5), 6))
    for _, shown in answers.groupby("position"):
        assert chisquare(shown["video"].value_counts()).pvalue > 1e-4


def test_the_seed_decides() -> None:
    model = responders(np.full(6, 0.5), 6, elimination=0.3, dropout=0.1)
    assert table(model, 50, seed=1).equals(table(model, 50, seed=1))
    assert not table(model, 50, seed=1).equals(table(model, 50, seed=2))
