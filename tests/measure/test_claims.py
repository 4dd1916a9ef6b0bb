from functools import cache
from math import nan

import pytest

from emovid.measure.claims import CLAIMS, NOT_APPLIED, Claim, Quantity, excepted, judge
from emovid.measure.describe import claim_metrics
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate

MARGIN = 1.05
SEEDS = (0, 1, 7, 21, 42)  # all of 0..49: make bench


def measured_at(seed: int, *settings: tuple[str, object]) -> dict[str, dict[str, float]]:
    keys = [Setting("seed", seed, "test"), *(Setting(key, value, "test") for key, value in settings)]
    return {name: claim_metrics(simulate(load_scene(name, keys))) for name in EMOTIONS}


@cache
def shipped() -> dict[str, dict[str, float]]:
    return measured_at(1)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_shipped_scenes_carry_what_the_paper_claims_on_any_seed(seed: int) -> None:
    verdicts = judge(measured_at(seed))
    assert [verdict.claim for verdict in verdicts if verdict.margin < MARGIN] == []
    assert len(verdicts) == len(CLAIMS)


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.text)
def test_each_claim_can_fail(claim) -> None:
    # A claim that no numbers break is none: the larger side is made small, the smaller side large.
    measured = {name: dict(values) for name, values in shipped().items()}
    for side, factor in ((claim.more, 0.01), (claim.less, 100.0)):
        if isinstance(side, Quantity):
            for emotion in side.emotions:
                measured[emotion][side.name] = factor * measured[emotion][side.name] + (0.5 if factor > 1 else 0)
    verdict = next(verdict for verdict in judge(measured) if verdict.claim == claim.text)
    assert not verdict.holds
    assert verdict.margin < 1


def test_the_worst_emotion_decides() -> None:
    measured = {name: dict(values) for name, values in shipped().items()}
    measured["surprise"]["speed_mean"] = 0.1
    verdict = judge(measured)[0]
    assert not verdict.holds
    assert verdict.relation.startswith("speed_mean of surprise 0.1 >= 2 times speed_mean of disgust")
    assert verdict.values["surprise.speed_mean"] == 0.1
    assert set(verdict.values) == {f"{name}.speed_mean" for name in EMOTIONS}


def test_a_missing_value_fails_its_claim() -> None:
    measured = {name: dict(values) for name, values in shipped().items()}
    measured["happiness"]["speed_mean"] = nan
    assert not judge(measured)[0].holds


def test_swapped_emotions_are_found_out() -> None:
    measured = shipped()
    swapped = {**measured, "anger": measured["sadness"], "sadness": measured["anger"]}
    assert sum(not verdict.holds for verdict in judge(swapped)) > 10


@pytest.mark.parametrize("name", ["fear", "disgust"])
def test_a_large_l_takes_the_angles_away(name: str) -> None:
    measured = {**shipped(), name: claim_metrics(simulate(load_scene(name, [Setting("robot.l", 0.05, "test")])))}
    failed = [verdict.claim for verdict in judge(measured) if not verdict.holds]
    assert "fear, disgust and anger turn more per metre than the others" in failed
    assert "fear, disgust and anger have sharp corners along more than a third of their traces" in failed


def test_of_robots_with_motors_anger_is_left_out_where_its_peaks_decide_and_nowhere_else() -> None:
    measured = {name: dict(values) for name, values in shipped().items()}
    measured["anger"] |= {"speed_peak": 0.0, "sparc": 0.0}
    cut = {verdict.claim: verdict for verdict in judge(measured, motors=True)}
    free = {verdict.claim: verdict for verdict in judge(measured)}
    exceptions = excepted(motors=True)
    assert {claim for claim, verdict in free.items() if not verdict.holds} == set(exceptions)
    assert all(verdict.holds for verdict in cut.values())
    for claim in exceptions:
        assert claim not in cut or not any(value.startswith("anger.") for value in cut[claim].values)
    assert set(free) - set(cut) == {
        "anger has the highest peak speed",
        "anger is the least smooth of all, by its speed profile (spectral arc length)",
    }
    assert excepted(motors=False) == {}


def test_a_bound_stays_when_anger_is_left_out() -> None:
    claim = Claim("", "", Quantity("speed_peak", ("anger", "fear")), 0.1, peaks=True)
    assert claim.without_anger() == Claim("", "", Quantity("speed_peak", ("fear",)), 0.1, peaks=True)


def test_every_claim_says_where_the_paper_does() -> None:
    assert all(claim.source for claim in CLAIMS)
    assert len({claim.text for claim in CLAIMS}) == len(CLAIMS)
    assert any("triangles" in claim for claim in NOT_APPLIED)
