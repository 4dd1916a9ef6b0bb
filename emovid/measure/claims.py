"""What the paper says of its behaviours, as inequalities between measured numbers: the manipulation check.

Every cell of Table I that the paper applies, every cell of Table II and what the captions of Figs. 3 to 8 say is here.
A claim compares numbers from 0 to each emotion's last snapshot time, unless they are of any second of the whole run.
The factors and bounds are ours; the shipped scenes pass with a margin on each of 50 seeds (`make bench`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isnan, pi

from emovid.scene.emotions import EMOTIONS

Measured = Mapping[str, Mapping[str, float]]  # from emotion to the name of a number to its value

FAST, SLOW = ("happiness", "surprise", "anger"), ("sadness", "fear", "disgust")
SMOOTH, ANGULAR = ("happiness", "surprise", "sadness"), ("fear", "disgust", "anger")


@dataclass(frozen=True)
class Quantity:
    """A number of some emotions: a descriptor, or another that `evidence` names.

    Attributes:
        name: of the number.
        emotions: whose.
        negated: whether minus the number is compared, for measures that are negative.
    """

    name: str
    emotions: tuple[str, ...]
    negated: bool = False

    def of(self, measured: Measured) -> dict[str, float]:
        """Return the values to compare, by emotion."""
        sign = -1.0 if self.negated else 1.0
        return {emotion: sign * measured[emotion][self.name] for emotion in self.emotions}


@dataclass(frozen=True)
class Claim:
    """Each value of `more` is at least `factor` times each of `less`.

    Attributes:
        text: what is claimed.
        source: where the paper says it.
        more, less: a number of some emotions, or a bound in its unit.
        factor: 1 against a bound.
        peaks: whether it lives on the peaks of anger's speed, which the motors of a robot cut.
    """

    text: str
    source: str
    more: Quantity | float
    less: Quantity | float
    factor: float = 1.0
    peaks: bool = False

    def without_anger(self) -> "Claim | None":
        """Return what is left of it without anger's numbers; None if nothing is."""
        sides = []
        for side in (self.more, self.less):
            rest = side
            if isinstance(side, Quantity):
                rest = replace(side, emotions=tuple(name for name in side.emotions if name != "anger"))
                if not rest.emotions:
                    return None
            sides.append(rest)
        return replace(self, more=sides[0], less=sides[1])


@dataclass(frozen=True)
class Verdict:
    """A claim held against measured numbers.

    Attributes:
        claim: what is claimed.
        source: where the paper says it.
        relation: the inequality, with the values that decide it.
        values: all that were compared, by `emotion.name`.
        margin: how many times larger the smallest of the larger values is than it must be; the claim holds from 1 on.
        holds: whether it does; a value that is missing (NaN) makes it fail.
    """

    claim: str
    source: str
    relation: str
    values: dict[str, float]
    margin: float
    holds: bool


def _only(name: str, *emotions: str) -> Quantity:
    return Quantity(name, emotions)


CLAIMS = (
    # Speed
    Claim(
        "happiness, surprise and anger are fast, the others slow",
        "Table II; Table I: anger fast, sadness and fear slow",
        Quantity("speed_mean", FAST),
        Quantity("speed_mean", SLOW),
        2.0,
    ),
    Claim(
        "sadness is very slow", "Table II", _only("speed_mean", "fear", "disgust"), _only("speed_mean", "sadness"), 2.0
    ),
    Claim(
        "the slow ones cover less than a twelfth of the stage's diagonal in a second",
        "Table II",
        1 / 12,
        Quantity("speed_mean_diagonals", SLOW),
    ),
    Claim(
        "anger has the highest peak speed",
        "Sec. III, Table I: higher peak velocities with anger",
        _only("speed_peak", "anger"),
        Quantity("speed_peak", tuple(name for name in EMOTIONS if name != "anger")),
        1.5,
        peaks=True,
    ),
    Claim(
        "in any second of its video anger is faster than fear, disgust and sadness in any of theirs",
        "Table II",
        _only("slowest_second", "anger"),
        Quantity("fastest_second", SLOW),
        1.5,
    ),
    Claim(
        "happiness and surprise go many times as far in 4 s as sadness in 8 s",
        "Sec. IV-B, Figs. 3 to 5",
        _only("distance_travelled", "happiness", "surprise"),
        _only("distance_travelled", "sadness"),
        5.0,
    ),
    Claim(
        "anger moves largest: it goes farther in its 6 s than any other up to its last snapshot",
        "Table I: large movement",
        _only("distance_travelled", "anger"),
        Quantity("distance_travelled", tuple(name for name in EMOTIONS if name != "anger")),
        1.5,
    ),
    Claim(
        "fear and sadness move little: not four fifths as far as happiness and surprise, in twice the time or more",
        "Table I: small movement",
        Quantity("distance_travelled", ("happiness", "surprise")),
        Quantity("distance_travelled", ("sadness", "fear")),
        1.25,
    ),
    # Angularity and smoothness
    Claim(
        "fear, disgust and anger turn more per metre than the others",
        "Table II; Figs. 6 to 8; Table I: negative valence, angular trace",
        Quantity("turning_per_metre", ANGULAR),
        Quantity("turning_per_metre", SMOOTH),
        4.0,
    ),
    Claim(
        "fear, disgust and anger have sharp corners along more than a third of their traces",
        "Table II; Figs. 6 to 8",
        Quantity("sharp_corner_share", ANGULAR),
        1 / 3,
    ),
    Claim(
        "happiness, surprise and sadness have hardly any sharp corner",
        "Table II; Table I: positive valence, rounded trace",
        0.02,
        Quantity("sharp_corner_share", SMOOTH),
    ),
    Claim(
        "anger is the most angular of all: it has the most cusps in a second",
        "Sec. IV-B, Fig. 8",
        _only("cusps_per_second", "anger"),
        Quantity("cusps_per_second", tuple(name for name in EMOTIONS if name != "anger")),
        4.0,
    ),
    Claim(
        "anger is the least smooth of all, by its speed profile (spectral arc length)",
        "Sec. IV-B, Fig. 8",
        Quantity("sparc", ("anger",), negated=True),
        Quantity("sparc", tuple(name for name in EMOTIONS if name != "anger"), negated=True),
        1.1,
        peaks=True,
    ),
    Claim(
        "happiness, surprise and sadness are smoother than the others (spectral arc length)",
        "Table II; Table I: happiness smooth",
        Quantity("sparc", ANGULAR, negated=True),
        Quantity("sparc", SMOOTH, negated=True),
        1.1,
        peaks=True,
    ),
    Claim(
        "anger overshoots the places it heads for in more than a fifth of its periods",
        "Fig. 8",
        _only("overshoot_share", "anger"),
        0.2,
    ),
    Claim(
        "surprise is controlled like happiness: its mean speed is more than half of happiness's",
        "Sec. IV-B: analogous parameters",
        _only("speed_mean", "surprise"),
        _only("speed_mean", "happiness"),
        0.5,
    ),
    Claim(
        "surprise is controlled like happiness: its mean speed is less than twice happiness's",
        "Sec. IV-B: analogous parameters",
        _only("speed_mean", "happiness"),
        _only("speed_mean", "surprise"),
        0.5,
    ),
    # Shape and size
    Claim(
        "happiness, surprise and sadness are rounder than a square",
        "Table I: roundness",
        Quantity("hull_circularity", SMOOTH),
        pi / 4,
    ),
    Claim(
        "happiness is rippled: its radii vary by more than a twentieth",
        "Table I: curvilinearity; Fig. 3: small ripples",
        _only("radius_spread", "happiness"),
        0.05,
    ),
    Claim(
        "happiness's ripples are small: its radii vary by less than an eighth",
        "Fig. 3: small ripples",
        1 / 8,
        _only("radius_spread", "happiness"),
    ),
    Claim(
        "surprise and sadness are plain circles",
        "Table II: expanding circle, small circle",
        0.01,
        _only("radius_spread", "surprise", "sadness"),
    ),
    Claim(
        "happiness is big: more than a fifth of the stage lies within it",
        "Table I: big",
        _only("hull_area_share_mean", "happiness"),
        0.2,
    ),
    Claim(
        "sadness is small: less than a fifteenth of the stage lies within it",
        "Table I: small",
        1 / 15,
        _only("hull_area_share_mean", "sadness"),
    ),
    Claim(
        "surprise is very big: at its last snapshot the largest of the round shapes",
        "Table I: very big",
        _only("hull_area_share_end", "surprise"),
        _only("hull_area_share_end", "happiness", "sadness"),
        1.2,
    ),
    Claim(
        "surprise grows: its radius more than doubles in 4 s",
        "Table II, Fig. 4: expanding circle",
        _only("size_gain", "surprise"),
        2.0,
    ),
    Claim(
        "sadness has gone more than a tenth of its circle in 8 s",
        "Fig. 5: approximately an eighth",
        _only("circumference_share", "sadness"),
        0.1,
    ),
    Claim(
        "sadness has gone less than 0.15 of its circle in 8 s",
        "Fig. 5: approximately an eighth",
        0.15,
        _only("circumference_share", "sadness"),
    ),
    # Crowding
    Claim(
        "fear scatters: the distance of nearest neighbours grows by more than half",
        "Sec. IV-A, Fig. 6",
        _only("neighbour_gain", "fear"),
        1.5,
    ),
    Claim(
        "fear spreads evenly: at 15 s its cost is within a quarter of the converged one",
        "Table II: uniform coverage; Fig. 6",
        1.25,
        _only("cost_ratio", "fear"),
    ),
    Claim(
        "disgust arrives: at 12 s nine tenths of the way down to the converged cost are done",
        "Table II: coverage on boundaries; Fig. 7",
        _only("cost_progress", "disgust"),
        0.9,
    ),
    Claim(
        "disgust ends near the boundary: nearer on average than a seventh of the stage's smaller side",
        "Sec. IV-A, Fig. 7",
        1 / 7,
        _only("boundary_share", "disgust"),
    ),
    Claim(
        "disgust ends nearer to the boundary than fear",
        "Table II",
        _only("distance_to_boundary_end", "fear"),
        _only("distance_to_boundary_end", "disgust"),
        1.5,
    ),
    Claim(
        "disgust goes from the centre outwards: its distance from the centre more than doubles",
        "Sec. IV-A",
        _only("centre_gain", "disgust"),
        2.0,
    ),
    Claim(
        "disgust turns away faster than fear spreads",
        "ours: Sec. IV-A gives it animosity, and it must not be fear with another end",
        _only("speed_mean", "disgust"),
        _only("speed_mean", "fear"),
        1.5,
    ),
    Claim(
        "anger crowds around the centre: it ends nearer to it than fear and disgust",
        "Table II: coverage on center; Sec. IV-A",
        _only("distance_to_centre_end", "fear", "disgust"),
        _only("distance_to_centre_end", "anger"),
        1.5,
    ),
    Claim(
        "anger arrives: at 6 s its cost is within a quarter of the converged one",
        "Table II: coverage on center",
        1.25,
        _only("cost_ratio", "anger"),
    ),
)

# Cells of Table I that the paper does not apply to its behaviours: no failure of a scene.
NOT_APPLIED = {
    "fear has the shape of downward pointing triangles": "Table I",
    "sadness has an angular shape and an angular trace, as of negative valence": "Table I; Sec. IV-B prefers smooth",
    "fear, disgust and anger have an angular shape, as of negative valence": "Table I; Sec. IV-A gives them densities",
}


# Sec. V: on the robots, the largest difference is in anger, since actuator limits and safety rule out the very high
# peak velocities of its simulation, yet it keeps its characteristic features. So for robots with motors anger is left
# out of the claims that live on peaks, and of nothing else. One is of spectral arc length: that of a speed profile.
EXCEPTION = "anger's peaks of speed are cut by the motors: Sec. V"


def claims_on(*, motors: bool) -> tuple[Claim, ...]:
    """Return the claims that are held against scenes; for robots with motors, with the paper's exception."""
    if not motors:
        return CLAIMS
    return tuple(kept for claim in CLAIMS if (kept := claim.without_anger() if claim.peaks else claim))


def excepted(*, motors: bool) -> dict[str, str]:
    """Return the claims that robots with motors need not fulfil for anger, with the source of the exception."""
    return {claim.text: EXCEPTION for claim in CLAIMS if claim.peaks} if motors else {}


def judge(measured: Measured, *, motors: bool = False) -> list[Verdict]:
    """Return the verdicts on all claims.

    Args:
        measured: the `evidence` of each of the six emotions.
        motors: whether the robots have actuator limits, for which the paper makes an exception.

    Raises:
        KeyError: if an emotion is missing.
    """
    return [_verdict(claim, measured) for claim in claims_on(motors=motors)]


def _verdict(claim: Claim, measured: Measured) -> Verdict:
    values: dict[str, float] = {}
    sides = []
    for side, extreme in ((claim.more, min), (claim.less, max)):
        if isinstance(side, Quantity):
            found = side.of(measured)
            values |= {f"{emotion}.{side.name}": measured[emotion][side.name] for emotion in side.emotions}
            decisive = extreme(found, key=lambda emotion: found[emotion])
            number = next(filter(isnan, found.values()), found[decisive])
            sides.append((number, f"{'-' if side.negated else ''}{side.name} of {decisive} {number:.3g}"))
        else:
            sides.append((side, f"{side:.3g}"))
    (more, more_text), (less, less_text) = sides
    needed = claim.factor * less
    by = f"{claim.factor:g} times " if claim.factor != 1 else ""
    margin = more / needed if needed > 0 else float("inf") if more >= needed else 0.0
    return Verdict(claim.text, claim.source, f"{more_text} >= {by}{less_text}", values, margin, margin >= 1)
