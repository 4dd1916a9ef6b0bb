import numpy as np
import pytest
from scipy.stats import chisquare

from emovid.responses.responses import EMOTIONS
from emovid.statistics.simulated_participants import Responders, rehearse, responders


def table(model: Responders, participants: int = 2000, seed: int = 1):
    return rehearse(model, EMOTIONS, EMOTIONS, participants, seed)


def test_responders_have_the_requested_accuracy() -> None:
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


def test_wrong_labels_are_equally_likely_without_bias_weights() -> None:
    model = responders(np.array([0.0, 0.4]), 3, bias=np.array([0, 1.0, 0]))
    assert model.probabilities.T.tolist() == [[0, 1, 0], [pytest.approx(0.3), 0.4, pytest.approx(0.3)]]
    none = responders(np.zeros(3), 3, bias=np.zeros(3))
    assert none.probabilities.tolist() == [[0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]]


def test_eliminating_participants_never_repeat_a_label() -> None:
    answers = table(responders(np.full(6, 0.3), 6, elimination=1.0), participants=200)
    assert (answers.groupby("participant")["response"].nunique() == 6).all()


@pytest.mark.parametrize("rate", [0.2, 0.4, 0.8])
def test_eliminating_participants_have_the_requested_accuracy(rate: float) -> None:
    # Without adjusted probabilities, used labels would reduce 0.4 to 0.37.
    answers = table(responders(np.full(6, rate), 6, elimination=1.0), participants=4000)
    assert (answers["video"] == answers["response"]).mean() == pytest.approx(rate, abs=0.012)


def test_elimination_continues_without_likely_labels() -> None:
    answers = table(responders(np.ones(6), 6, bias=np.array([1, 0, 0, 0, 0, 0.0]), elimination=1.0), participants=50)
    assert (answers["video"] == answers["response"]).all()


def test_dropouts_give_no_later_answers() -> None:
    answers = table(responders(np.full(6, 0.5), 6, dropout=0.2))
    last = answers.groupby("participant")["position"].agg(["max", "count"])
    assert (last["max"] == last["count"]).all()
    assert (last["count"] == 6).mean() == pytest.approx(0.8**5, abs=0.03)


def test_all_video_orders_are_equally_likely() -> None:
    answers = table(responders(np.full(6, 0.5), 6))
    for _, shown in answers.groupby("position"):
        assert chisquare(shown["video"].value_counts()).pvalue > 1e-4


def test_answers_depend_on_the_seed() -> None:
    model = responders(np.full(6, 0.5), 6, elimination=0.3, dropout=0.1)
    assert table(model, 50, seed=1).equals(table(model, 50, seed=1))
    assert not table(model, 50, seed=1).equals(table(model, 50, seed=2))
