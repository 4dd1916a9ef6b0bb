"""Mutants of the six scenes: each contradicts a description in the paper, so that the claims must reject it."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from emovid.measure.claim_metrics import claim_metrics
from emovid.measure.claims import judge
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate

LATTICE = [(x, y) for y in (-0.24, 0.0, 0.24) for x in (-0.48, -0.24, 0.0, 0.24, 0.48)]


class Mutant(NamedTuple):
    """A scene with other values of a few keys.

    Attributes:
        emotion: the emotion that the scene no longer expresses.
        keys: with their values.
        words: the words of the paper that they contradict.
    """

    emotion: str
    keys: dict[str, Any]
    words: str

    def __str__(self) -> str:
        return f"{self.emotion}: {', '.join(f'{key}={_short(value)}' for key, value in self.keys.items())}"


def _short(value: Any) -> str:
    if not isinstance(value, dict):
        return "null" if value is None else str(value)
    if value.get("place") == "poses":
        return "a lattice"
    if "region" in value:
        return "{width} m x {height} m".format(**value["region"])
    return str(value.get("kind") or value["place"])


def placed(points: list[tuple[float, float]]) -> dict[str, Any]:
    return {"place": "poses", "poses": [{"x": x, "y": y, "heading": 0.0} for x, y in points]}


def region(width: float, height: float, spacing: float = 0.045) -> dict[str, Any]:
    return {"place": "region", "region": {"width": width, "height": height}, "min_spacing": spacing}


MUTANTS = (
    # Happiness: sinusoid over circle; big; fast, smooth
    *(Mutant("happiness", {"behaviour.f": f}, "f = 6") for f in (1, 3, 5, 9)),
    Mutant("happiness", {"behaviour.R": 0.16}, "big"),
    Mutant("happiness", {"behaviour.A": 0.01}, "curvilinearity: ripples"),
    Mutant("happiness", {"behaviour.A": 0.09}, "small ripples"),
    Mutant("happiness", {"behaviour.angular_rate": 0.3}, "fast"),
    Mutant("happiness", {"robot.K": 1}, "fast: large K"),
    Mutant("happiness", {"robot.l": 0.003}, "smooth: large l"),
    # Surprise: expanding circle; very big; as happiness
    Mutant("surprise", {"behaviour.R_max": 0.24}, "very big"),
    Mutant("surprise", {"behaviour.R_min": 0.25}, "expanding"),
    Mutant("surprise", {"behaviour.expansion_rate": 0.02}, "expanding, very big"),
    Mutant("surprise", {"behaviour.angular_rate": 0.3, "behaviour.R_min": 0.14}, "fast"),
    Mutant("surprise", {"behaviour.return_time": None}, "smooth"),
    Mutant("surprise", {"robot.K": 1}, "fast: large K"),
    Mutant("surprise", {"robot.l": 0.005}, "smooth: large l"),
    # Sadness: small circle; very slow, smooth
    Mutant("sadness", {"behaviour.R": 0.25}, "small"),
    Mutant("sadness", {"behaviour.shape": "circular_sinusoid", "behaviour.A": 0.02, "behaviour.f": 6}, "circle"),
    Mutant("sadness", {"behaviour.angular_rate": 0.4}, "very slow; an eighth of the circumference"),
    Mutant("sadness", {"behaviour.angular_rate": 0.02}, "an eighth of the circumference"),
    Mutant("sadness", {"robot.l": 0.001}, "smooth: large l"),
    Mutant("sadness", {"robot.K": 0.05}, "an eighth of the circumference"),
    # Fear: uniform coverage, from random positions within the domain; slow, angular
    Mutant("fear", {"behaviour.density": {"kind": "gaussian", "sigma": 0.1}}, "uniform coverage"),
    Mutant("fear", {"behaviour.density": {"kind": "boundary", "width": 0.06, "inset": 0.06}}, "uniform coverage"),
    Mutant("fear", {"start": region(0.3, 0.22)}, "within the domain"),
    Mutant("fear", {"start": placed(LATTICE)}, "random positions (seed)"),
    Mutant("fear", {"behaviour.u_max": 0.15}, "slow"),
    Mutant("fear", {"robot.l": 0.04}, "angular: small l"),
    Mutant("fear", {"robot.K": 0.3}, "scatter"),
    # Disgust: coverage on boundaries, from the center; slow, angular
    Mutant("disgust", {"behaviour.density.inset": 0.25}, "boundaries"),
    Mutant("disgust", {"behaviour.density.width": 0.4}, "boundaries"),
    Mutant("disgust", {"start": {"place": "stage", "min_spacing": 0.06}}, "from the center"),
    Mutant("disgust", {"start": placed([(0.4 * x, 0.4 * y) for x, y in LATTICE])}, "random positions (seed)"),
    Mutant("disgust", {"behaviour.u_max": 0.2}, "slow"),
    Mutant("disgust", {"robot.l": 0.04}, "angular: small l"),
    Mutant("disgust", {"robot.K": 1}, "towards the exterior"),
    # Anger: coverage on center, from random positions within the domain; fast, angular
    Mutant("anger", {"behaviour.density.sigma": 0.3}, "coverage on center"),
    Mutant("anger", {"start": region(0.3, 0.22)}, "within the domain"),
    Mutant("anger", {"start": placed(LATTICE)}, "random positions (seed)"),
    Mutant("anger", {"behaviour.kappa": 3}, "overshoots; react to each other"),
    Mutant("anger", {"behaviour.u_max": 0.03}, "fast"),
    Mutant("anger", {"behaviour.u_max": 0.012}, "concentrate around the center"),
    Mutant("anger", {"robot.l": 0.1}, "angular: small l"),
    Mutant("anger", {"robot.K": 2}, "fast: large K"),
)


def metrics(emotion: str, keys: Mapping[str, Any], seed: int) -> dict[str, float]:
    """Return the numbers of claims of a scene with other values of keys; a start on the contour uses no seed."""
    settings = [Setting(key, value, "mutant") for key, value in {**keys, "seed": seed}.items()]
    return claim_metrics(simulate(load_scene(emotion, settings)))


def uses_seed(emotion: str, keys: Mapping[str, Any]) -> bool:
    """Return whether runs of a scene with other values of keys differ between seeds."""
    return load_scene(emotion, [Setting(key, value, "mutant") for key, value in keys.items()]).start.place in (
        "stage",
        "region",
    )


def broken_claims(
    mutant: Mutant, shipped: Mapping[str, Mapping[str, float]], found: Mapping[str, float] | None = None
) -> set[str]:
    """Return the claims that fail with a mutant in place of its scene; the others have the metrics `shipped`.

    `found` are the mutant's metrics; by default those of seed 1.
    """
    found = found or metrics(mutant.emotion, mutant.keys, 1)
    return {verdict.claim for verdict in judge({**shipped, mutant.emotion: found}) if not verdict.holds}
