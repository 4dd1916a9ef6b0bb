from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.special import expit

from emovid.responses.read import read_responses
from emovid.statistics.mixed import MixedModel, mixed_model, model_of

REFERENCE = Path(__file__).parents[2] / "studies" / "santos-egerstedt" / "responses.csv"


@pytest.fixture(scope="module")
def reference() -> MixedModel:
    return model_of(read_responses([REFERENCE]), ["gender"])


def test_reference_study_agrees_with_lme4(reference) -> None:
    # R 4.2, lme4: glmer(hit ~ gender + (1 | participant) + (1 | video), family = binomial).
    intercept, gender = reference.effects
    assert (gender.name, gender.estimate, gender.error) == (
        "gender: male",
        pytest.approx(-0.4709, abs=2e-4),
        pytest.approx(0.3001, abs=5e-4),
    )
    assert gender.p == pytest.approx(0.1166, abs=5e-4)
    assert (intercept.estimate, intercept.error) == (pytest.approx(0.4923, abs=2e-4), pytest.approx(0.2836, abs=5e-4))
    assert reference.participant_sd == pytest.approx(0.3185, abs=5e-4)
    assert reference.video_sd == pytest.approx(0.3033, abs=5e-4)
    assert reference.deviance == pytest.approx(368.09039, abs=1e-4)
    assert (reference.answers, reference.participants, reference.videos) == (270, 45, 6)
    assert reference.converged


def test_two_groups_agree_with_lme4() -> None:
    found = model_of(read_responses([REFERENCE]), ["gender", "robotics_background"])
    estimates = [(effect.estimate, effect.error) for effect in found.effects]
    expected = [(0.4950, 0.2961), (-0.4703, 0.3007), (-0.0087, 0.2809)]
    assert np.array(estimates) == pytest.approx(np.array(expected), abs=1e-3)


def test_without_random_effects_the_estimate_is_the_log_odds_ratio() -> None:
    # Each participant answers one video, and rates within a group are equal: no variation for random effects.
    hits = np.array([True] * 30 + [False] * 10 + [True] * 10 + [False] * 30)
    people = [f"p{i}" for i in range(80)]
    found = mixed_model(hits, people, ["v"] * 80, {"hand": ["left"] * 40 + ["right"] * 40})
    assert found.effects[1].estimate == pytest.approx(np.log((10 / 30) / (30 / 10)), abs=0.02)
    assert found.video_sd == pytest.approx(0, abs=1e-3)


def test_a_known_effect_is_covered() -> None:
    rng = np.random.default_rng(4)
    people, videos = np.repeat(np.arange(60), 8), np.tile(np.arange(8), 60)
    group = np.where(people % 2, "b", "a")
    odds = 0.3 + 0.8 * (group == "b") + rng.normal(0, 0.7, 60)[people] + rng.normal(0, 0.5, 8)[videos]
    hits = rng.random(480) < expit(odds)
    found = mixed_model(hits, people.astype(str).tolist(), videos.astype(str).tolist(), {"group": group.tolist()})
    effect = found.effects[1]
    assert np.log(effect.ci_low) < 0.8 < np.log(effect.ci_high)
    assert 0.3 < found.participant_sd < 1.2


def test_invalid_models_are_refused() -> None:
    with pytest.raises(ValueError, match="all answers are right or all are wrong"):
        mixed_model(np.ones(4, dtype=bool), list("aabb"), list("vwvw"), {})
    with pytest.raises(ValueError, match="gender: one level, f; a model compares two or more"):
        mixed_model(np.array([True, False]), list("ab"), list("vv"), {"gender": ["f", "f"]})


def test_participants_without_a_group_value_are_excluded() -> None:
    found = read_responses([REFERENCE])
    silent = found.participants.assign(gender=["", *found.participants["gender"][1:]])
    without = type(found)(found.signalled, found.labels, found.answers, pd.DataFrame(silent))
    assert model_of(without, ["gender"]).participants == 44
