from functools import cache
from math import nan
from pathlib import Path

import pytest

from emovid.measure.claims import CLAIMS, NOT_APPLIED, Claim, Quantity, exceptions, judge
from emovid.scene.emotions import EMOTIONS
from tests.helpers.mutants import MUTANTS, Mutant, broken_claims, metrics, uses_seed

SEEDS = (0, 1, 7, 21, 42)  # all of 0..49: make bench


@cache
def numbers(emotion: str, seed: int) -> dict[str, float]:
    return metrics(emotion, {}, seed)


def shipped(seed: int = 1) -> dict[str, dict[str, float]]:
    return {name: numbers(name, seed if name in ("fear", "disgust", "anger") else 1) for name in EMOTIONS}


def test_only_coverage_scenes_use_their_seed() -> None:
    assert [name for name in EMOTIONS if uses_seed(name, {})] == ["fear", "disgust", "anger"]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_shipped_scenes_fulfill_the_claims_on_any_seed(seed: int) -> None:
    verdicts = judge(shipped(seed))
    assert [verdict.claim for verdict in verdicts if not verdict.holds] == []
    assert len(verdicts) == len(CLAIMS)


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.text)
def test_each_claim_can_fail(claim) -> None:
    # A claim must be falsifiable: the larger side is made small, the smaller side large.
    measured = {name: dict(values) for name, values in shipped().items()}
    for side, factor in ((claim.more, 0.01), (claim.less, 100.0)):
        if isinstance(side, Quantity):
            for emotion in side.emotions:
                measured[emotion][side.name] = factor * measured[emotion][side.name] + (0.5 if factor > 1 else 0)
    verdict = next(verdict for verdict in judge(measured) if verdict.claim == claim.text)
    assert not verdict.holds
    assert verdict.margin < 1


def test_verdict_uses_the_worst_emotion() -> None:
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


def test_swapped_emotions_break_many_claims() -> None:
    found = shipped()
    swapped = {**found, "anger": found["sadness"], "sadness": found["anger"]}
    assert sum(not verdict.holds for verdict in judge(swapped)) > 10


@cache
def all_broken() -> dict[str, set[str]]:
    """Return the claims that each mutant breaks while the other scenes are as shipped."""
    return {str(mutant): broken_claims(mutant, shipped()) for mutant in MUTANTS}


def broken_by(mutant: Mutant) -> set[str]:
    return all_broken()[str(mutant)]


@pytest.mark.parametrize("mutant", MUTANTS, ids=str)
def test_scene_that_contradicts_the_paper_breaks_a_claim(mutant) -> None:
    assert broken_by(mutant)


def test_each_claim_rejects_a_mutant_or_compares_two_emotions() -> None:
    rejecting = set().union(*map(broken_by, MUTANTS))
    assert {claim.text for claim in CLAIMS} - rejecting <= {
        "anger arrives: at 6 s its cost is within a quarter of the converged one"
    }


def test_the_documentation_lists_reasons_and_which_mutants_each_claim_rejects() -> None:
    page = (Path(__file__).parents[2] / "docs" / "claims.md").read_text(encoding="utf-8")
    for number, claim in enumerate(CLAIMS, 1):
        rejected = [f"m{i}" for i, mutant in enumerate(MUTANTS, 1) if claim.text in broken_by(mutant)]
        row = f"| {number} | {claim.text} | {claim.source} | {claim.reason} | {', '.join(rejected) or 'none'} |"
        assert row in page
    for number, mutant in enumerate(MUTANTS, 1):
        rejecting = [str(i) for i, claim in enumerate(CLAIMS, 1) if claim.text in broken_by(mutant)]
        assert f"| m{number} | {mutant} | {mutant.words} | {', '.join(rejecting)} |" in page


def test_claims_on_peaks_exclude_anger_only_for_robots_with_motors() -> None:
    measured = {name: dict(values) for name, values in shipped().items()}
    measured["anger"] |= {
        "speed_peak": measured["fear"]["speed_peak"],
        "sparc": 0.0,
    }  # limited, but not as slow as sadness
    cut = {verdict.claim: verdict for verdict in judge(measured, motors=True)}
    free = {verdict.claim: verdict for verdict in judge(measured)}
    spared = exceptions(motors=True)
    assert {claim for claim, verdict in free.items() if not verdict.holds} == set(spared)
    assert all(verdict.holds for verdict in cut.values())
    for claim in spared:
        assert claim not in cut or not any(value.startswith("anger.") for value in cut[claim].values)
    assert set(free) - set(cut) == {
        "anger has the highest peak speed",
        "anger is the least smooth of all, by its speed profile (spectral arc length)",
    }
    assert exceptions(motors=False) == {}


def test_excluding_anger_keeps_the_bound() -> None:
    claim = Claim("", "", Quantity("speed_peak", ("anger", "fear")), 0.1, peaks=True)
    assert claim.without_anger() == Claim("", "", Quantity("speed_peak", ("fear",)), 0.1, peaks=True)


def test_every_claim_has_a_source_and_a_reason() -> None:
    assert all(claim.source and claim.reason for claim in CLAIMS)
    assert len({claim.text for claim in CLAIMS}) == len(CLAIMS)
    assert any("triangles" in claim for claim in NOT_APPLIED)
