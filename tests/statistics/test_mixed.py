from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.special import expit
from statsmodels.genmod.cov_struct import Exchangeable
from statsmodels.genmod.families import Binomial
from statsmodels.genmod.generalized_estimating_equations import GEE

from emovid.cli.main import main
from emovid.responses.read import read_responses
from emovid.statistics.mixed import MixedModel, mixed_model, model_of

LME4 = [(0.19985, 0.23891), (0.51417, 0.26763), (-0.54426, 0.23011)]  # of `crossed`
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


def crossed(rng: np.random.Generator) -> tuple[np.ndarray, list[str], list[str], dict[str, list[str]]]:
    """Return answers of 40 participants to 24 videos, every tenth missing: hands differ, and so do speeds of videos."""
    videos, people = rng.normal(0, 0.6, 24), rng.normal(0, 0.7, 40)
    person, video = (index.ravel() for index in np.indices((40, 24)))
    kept = rng.random(960) >= 0.1
    right, slow = person % 2 == 1, video // 2 % 2 == 1
    hits = rng.random(960) < expit(0.4 + 0.5 * right - 0.8 * slow + videos[video] + people[person])
    columns = {"hand": np.where(right, "right", "left"), "speed": np.where(slow, "slow", "fast")}
    names = [f"p{i:02d}" for i in person[kept]], [f"v{i:02d}" for i in video[kept]]
    return hits[kept], *names, {name: column[kept].tolist() for name, column in columns.items()}


def test_groups_and_conditions_are_those_of_lme4() -> None:
    # R 4.2, lme4: glmer(hit ~ hand + speed + (1 | participant) + (1 | video), family = binomial).
    found = mixed_model(*crossed(np.random.default_rng(11)))
    assert [effect.name for effect in found.effects] == ["(intercept)", "hand: right", "speed: slow"]
    estimates = [(effect.estimate, effect.error) for effect in found.effects]
    assert np.array(estimates) == pytest.approx(np.array(LME4), abs=1e-3)
    assert (found.participant_sd, found.video_sd) == (pytest.approx(0.7023, abs=1e-3), pytest.approx(0.4286, abs=1e-3))
    assert found.deviance == pytest.approx(1115.91075, abs=1e-4)


def test_equations_of_statsmodels_say_the_same_of_the_population() -> None:
    # Without an effect of videos both hold; a mean over participants pulls log odds towards 0 by sqrt(1 + 0.346 sd^2).
    rng = np.random.default_rng(3)
    people = np.repeat(np.arange(150), 8)
    group = people % 2
    hits = rng.random(1200) < expit(-0.2 + 0.9 * group + rng.normal(0, 1, 150)[people])
    names = people.astype(str).tolist()
    found = mixed_model(
        hits, names, np.tile(np.arange(8), 150).astype(str).tolist(), {"group": group.astype(str).tolist()}
    )
    design = np.column_stack([np.ones(1200), group])
    equations = GEE(hits.astype(float), design, people, family=Binomial(), cov_struct=Exchangeable()).fit(
        cov_type="bias_reduced"
    )
    shrunk = found.effects[1].estimate / np.sqrt(1 + 0.346 * (found.participant_sd**2 + found.video_sd**2))
    assert shrunk == pytest.approx(equations.params[1], abs=0.03)
    assert found.effects[1].p == pytest.approx(equations.pvalues[1], abs=1e-3)


def test_a_level_without_misses_has_no_estimate() -> None:
    hits = np.array([True] * 40 + [True, False] * 20)
    people, videos = [f"p{i // 4}" for i in range(80)], [f"v{i % 4}" for i in range(80)]
    found = mixed_model(hits, people, videos, {"hand": ["left"] * 40 + ["right"] * 40})
    assert np.isnan([effect.error for effect in found.effects]).all()


def test_conditions_come_from_the_key(tmp_path, capsys) -> None:
    hits, people, videos, columns = crossed(np.random.default_rng(11))
    given = [
        f"{p},{v},{'fear' if hit else 'anger'},{hand}"
        for hit, p, v, hand in zip(hits, people, videos, columns["hand"], strict=True)
    ]
    export, key = tmp_path / "export.csv", tmp_path / "stimuli.csv"
    export.write_text("participant,video,response,hand\n" + "\n".join(given))
    speeds = dict(zip(videos, columns["speed"], strict=True))
    key.write_text(
        "video_code,true_emotion,speed\n" + "\n".join(f"{v},fear,{speed}" for v, speed in sorted(speeds.items()))
    )
    assert main(["study", "model", str(export), "--key", str(key), "--by", "hand", "--factor", "speed"]) == 0
    assert f"speed: slow: \N{MINUS SIGN}{-LME4[2][0]:.2f} (SE {LME4[2][1]:.2f})" in capsys.readouterr().out
    for arguments, message in (
        (["--key", str(key), "--factor", "sped"], "no column 'sped' (did you mean speed?)"),
        (["--factor", "speed"], "--factor speed: expected --key"),
        ([], "expected --by with a group of participants, or --factor"),
    ):
        assert main(["study", "model", str(export), *arguments]) == 2
        assert message in capsys.readouterr().err


def test_columns_of_which_one_follows_from_the_others_are_refused() -> None:
    hits, people, videos, columns = crossed(np.random.default_rng(1))
    with pytest.raises(ValueError, match="hand, side: one follows from the others"):
        mixed_model(hits, people, videos, {"hand": columns["hand"], "side": [f"{hand}y" for hand in columns["hand"]]})


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
