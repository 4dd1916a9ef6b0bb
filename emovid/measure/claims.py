"""Claims of the paper about its behaviors, as inequalities between measured numbers: the manipulation check.

All cells of Table I that the paper applies, all cells of Table II, the captions of Figs. 3 to 8, and what Secs. II and
III say. Numbers are of the whole video, unless the paper names a time. Factors and bounds are ours, with reasons.
docs/claims.md names those that were chosen with the margins of the shipped scenes in view.
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
    """A number of some emotions: one of `claim_metrics`.

    Attributes:
        name: of the number.
        emotions: that have it.
        negated: whether minus the number is compared, for negative measures.
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
        text: the claim in words.
        source: section, table or figure of the paper.
        more, less: a number of some emotions, or a bound in its unit.
        factor: 1 against a bound.
        peaks: whether it depends on the peaks of anger's speed, which the motors of a robot cut.
        reason: for the factor or bound.
    """

    text: str
    source: str
    more: Quantity | float
    less: Quantity | float
    factor: float = 1.0
    peaks: bool = False
    reason: str = ""

    def without_anger(self) -> "Claim | None":
        """Return the claim without anger's numbers; None if nothing is left."""
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
    """The result of a claim for measured numbers.

    Attributes:
        claim: in words.
        source: section, table or figure of the paper.
        relation: the inequality, with the values that decide it.
        values: all values compared, by `emotion.name`.
        margin: smallest larger value over its required value; the claim holds from 1 on.
        holds: whether it holds; a missing value (NaN) makes it fail.
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
        reason="twice as fast is a clear difference at a glance",
    ),
    Claim(
        "sadness is very slow: no other emotion has such a slow fastest robot",
        "Table II: very slow",
        Quantity("speed_peak", tuple(name for name in EMOTIONS if name != "sadness")),
        _only("speed_peak", "sadness"),
        3.0,
        reason="'very slow' compared with 'slow' is a further step of the same size or more",
    ),
    Claim(
        "the slow emotions cover less than a twelfth of the stage's diagonal in a second",
        "Table II: slow",
        1 / 12,
        Quantity("speed_mean_diagonals", SLOW),
        reason="at this speed a robot takes most of a video to cross the stage",
    ),
    Claim(
        "anger has the highest peak speed",
        "Sec. II: higher peak velocities for anger",
        _only("speed_peak", "anger"),
        Quantity("speed_peak", tuple(name for name in EMOTIONS if name != "anger")),
        1.5,
        peaks=True,
        reason="a difference of half is visible without a direct comparison",
    ),
    Claim(
        "in any second of its video anger is faster than fear, disgust and sadness in any of theirs",
        "Table II: fast, slow",
        _only("slowest_second", "anger"),
        Quantity("fastest_second", SLOW),
        1.0,
        reason="'faster' without a margin: the claim compares extremes",
    ),
    Claim(
        "happiness and surprise travel many times as far in 4 s as sadness in 8 s",
        "Sec. III-B, Figs. 3 to 5",
        _only("distance_travelled_to_snapshot", "happiness", "surprise"),
        _only("distance_travelled_to_snapshot", "sadness"),
        5.0,
        reason="'significant' against 'very little'",
    ),
    Claim(
        "anger moves largest: farther up to its last snapshot than any other emotion up to its own",
        "Table I: large movement",
        _only("distance_travelled_to_snapshot", "anger"),
        Quantity("distance_travelled_to_snapshot", tuple(name for name in EMOTIONS if name != "anger")),
        1.0,
        reason="'largest' without a margin",
    ),
    Claim(
        "fear and sadness move little: less than half as far as happiness and surprise in the same time",
        "Table I: small movement",
        Quantity("distance_travelled", ("happiness", "surprise")),
        Quantity("distance_travelled", ("sadness", "fear")),
        2.0,
        reason="twice as far is a clear difference",
    ),
    # Angularity and smoothness
    Claim(
        "fear, disgust and anger turn more per meter than the others",
        "Table II: angular; Figs. 6 to 8; Table I: negative valence, angular trace",
        Quantity("turning_per_metre", ANGULAR),
        Quantity("turning_per_metre", SMOOTH),
        4.0,
        reason="the turning of a rippled ring is curvature, not angularity: far more is needed",
    ),
    Claim(
        "fear, disgust and anger have sharp corners along more than a third of their traces",
        "Table II: angular; Figs. 6 to 8",
        Quantity("sharp_corner_share", ANGULAR),
        1 / 3,
        reason="corners on a third of the trace are at most three body widths apart",
    ),
    Claim(
        "happiness, surprise and sadness have hardly any sharp corner",
        "Table II: smooth; Table I: positive valence, rounded trace",
        0.02,
        Quantity("sharp_corner_share", SMOOTH),
        reason="less than one corner in fifty body widths of trace",
    ),
    Claim(
        "happiness, surprise and sadness bend smoothly: no turn tighter than a circle with a radius of a body width",
        "Table II: smooth; Figs. 3 to 5",
        2 / 3,
        Quantity("largest_turn", SMOOTH),
        reason="such a circle turns by 2/3 rad in the step of two thirds of a body that is measured",
    ),
    Claim(
        "happiness, surprise and sadness never reverse",
        "Table II: smooth",
        0.001,
        Quantity("reverse_share", SMOOTH),
        reason="a robot that reverses stops first; a thousandth leaves room for rounding",
    ),
    Claim(
        "happiness, surprise and sadness have a large look-ahead distance l",
        "Sec. III-B: large l",
        Quantity("look_ahead_steps", SMOOTH),
        2.0,
        reason="a look-ahead point within two visible steps of the robot is not far",
    ),
    Claim(
        "fear, disgust and anger have a small look-ahead distance l",
        "Sec. III-B: small l",
        0.5,
        Quantity("look_ahead_periods", ANGULAR),
        reason="the fast robots pass such a point well within a control period, and have to turn back",
    ),
    Claim(
        "surprise has a look-ahead distance like that of happiness",
        "Sec. III-B: analogous parameters",
        _only("look_ahead_steps", "surprise"),
        _only("look_ahead_steps", "happiness"),
        0.5,
        reason="'analogous': not below half",
    ),
    Claim(
        "anger is the most angular of all: it has the most cusps in a second",
        "Sec. III-B, Fig. 8",
        _only("cusps_per_second", "anger"),
        Quantity("cusps_per_second", tuple(name for name in EMOTIONS if name != "anger")),
        2.0,
        reason="'specially' angular: twice as many",
    ),
    Claim(
        "anger is the most angular of all along its trace, too: it turns most per meter in steps of 2/3 of a body",
        "Sec. III-B, Fig. 8",
        _only("coarse_turning", "anger"),
        Quantity("coarse_turning", tuple(name for name in EMOTIONS if name != "anger")),
        1.2,
        reason="in finer steps the short legs of fear and disgust count as much; a small margin on the whole motion",
    ),
    Claim(
        "anger is the least smooth of all, by its speed profile (spectral arc length)",
        "Sec. III-B, Fig. 8",
        Quantity("sparc", ("anger",), negated=True),
        Quantity("sparc", tuple(name for name in EMOTIONS if name != "anger"), negated=True),
        1.1,
        peaks=True,
        reason="'least' with a small margin",
    ),
    Claim(
        "anger overshoots its targets in more than a fifth of its periods",
        "Fig. 8: overshoots",
        _only("overshoot_share", "anger"),
        0.2,
        reason="each robot overshoots several times a second",
    ),
    Claim(
        "anger is lively to the end: its slowest second has more than half of its mean speed",
        "Sec. III-A: a heated environment, a riot",
        _only("liveliness", "anger"),
        0.5,
        reason="a second below half of it would look calm",
    ),
    Claim(
        "anger never repeats itself: no two states a few periods apart are equal within a centimeter",
        "Fig. 16a: robots react to each other's movement",
        _only("recurrence", "anger"),
        0.01,
        reason="within a centimeter, a third of a body, an observer sees the same configuration again",
    ),
    Claim(
        "surprise is controlled like happiness: its mean speed is more than half of happiness's",
        "Sec. III-B: analogous parameters",
        _only("speed_mean", "surprise"),
        _only("speed_mean", "happiness"),
        0.5,
        reason="'analogous': within a factor of two",
    ),
    Claim(
        "surprise is controlled like happiness: its mean speed is less than twice happiness's",
        "Sec. III-B: analogous parameters",
        _only("speed_mean", "happiness"),
        _only("speed_mean", "surprise"),
        0.5,
        reason="'analogous': within a factor of two",
    ),
    # Shape and size
    Claim(
        "happiness, surprise and sadness are rounder than a square",
        "Table I: roundness",
        Quantity("hull_circularity", SMOOTH),
        pi / 4,
        reason="pi / 4 is the circularity of a square",
    ),
    Claim(
        "happiness has six ripples",
        "Appendix A: f = 6",
        _only("ripple_share", "happiness"),
        0.8,
        reason="four fifths of the radius's variation have this number of ripples",
    ),
    Claim(
        "happiness is rippled: its radii vary by more than a twentieth",
        "Table I: curvilinearity; Fig. 3: small ripples",
        _only("radius_spread", "happiness"),
        0.05,
        reason="a ripple of half a body from crest to trough, the least that is visible at a glance",
    ),
    Claim(
        "happiness's ripples are small: its radii vary by less than an eighth",
        "Fig. 3: small ripples",
        1 / 8,
        _only("radius_spread", "happiness"),
        reason="crests a third higher than troughs: still a circle with ripples, not a star",
    ),
    Claim(
        "surprise and sadness are plain circles",
        "Table II: expanding circle, small circle",
        0.01,
        _only("radius_spread", "surprise", "sadness"),
        reason="a hundredth of the radius is a few millimeters, less than a visible step",
    ),
    Claim(
        "happiness is big: its swarm encloses more than a fifth of the stage",
        "Table I: big",
        _only("hull_area_share_mean", "happiness"),
        0.2,
        reason="a circle of two thirds of the largest possible radius on this stage has a quarter",
    ),
    Claim(
        "sadness is small: its swarm encloses less than a fifteenth of the stage",
        "Table I: small",
        1 / 15,
        _only("hull_area_share_mean", "sadness"),
        reason="a third of what counts as big",
    ),
    Claim(
        "surprise is very big: at its last snapshot the largest of the round shapes",
        "Table I: very big",
        _only("hull_area_share_end_to_snapshot", "surprise"),
        _only("hull_area_share_end_to_snapshot", "happiness", "sadness"),
        1.2,
        reason="'very big' compared with 'big': a tenth more in radius",
    ),
    Claim(
        "surprise grows: its radius more than doubles in 4 s",
        "Table II, Fig. 4: expanding circle",
        _only("size_gain", "surprise"),
        2.0,
        reason="twice as large is a clear growth",
    ),
    Claim(
        "sadness has gone more than a tenth of its circle in 8 s",
        "Fig. 5: approximately an eighth",
        _only("circumference_share", "sadness"),
        0.1,
        reason="'approximately an eighth': nearer to an eighth than a twelfth is",
    ),
    Claim(
        "sadness has gone less than 0.15 of its circle in 8 s",
        "Fig. 5: approximately an eighth",
        0.15,
        _only("circumference_share", "sadness"),
        reason="'approximately an eighth': nearer to an eighth than a sixth is",
    ),
    # Starts and crowding
    Claim(
        "fear, disgust and anger start at random positions",
        "Sec. III-A: at random positions within the domain",
        Quantity("start_irregularity", ("fear", "disgust", "anger")),
        0.02,
        reason="neighbors' distances that are equal within a fiftieth are a pattern",
    ),
    Claim(
        "fear and anger start over the domain: the swarm covers more than an eighth of the stage",
        "Sec. III-A: within the domain",
        Quantity("hull_area_share_start", ("fear", "anger")),
        1 / 8,
        reason="a swarm that covers less is in a part of the domain",
    ),
    Claim(
        "fear differs from disgust at once: its swarm starts larger",
        "Sec. III-A: within the domain, from the center",
        _only("radius_of_gyration_start", "fear"),
        _only("radius_of_gyration_start", "disgust"),
        4 / 3,
        reason="a third larger in radius is almost twice as large in area",
    ),
    Claim(
        "fear scatters: the distance of nearest neighbors grows by more than a third",
        "Sec. III-A, Fig. 6",
        _only("neighbour_gain", "fear"),
        4 / 3,
        reason="random positions over the whole stage have two thirds of the largest possible distance",
    ),
    Claim(
        "fear spreads evenly: at 15 s its cost is within a quarter of the converged one",
        "Table II: uniform coverage; Fig. 6",
        1.25,
        _only("cost_ratio_to_snapshot", "fear"),
        reason="a quarter more cost is a tenth more distance",
    ),
    Claim(
        "disgust arrives: at 12 s nine tenths of the decrease to the converged cost are done",
        "Table II: coverage on boundaries; Fig. 7",
        _only("cost_progress_to_snapshot", "disgust"),
        0.9,
        reason="the rest is too little to see",
    ),
    Claim(
        "disgust ends near the boundary: nearer on average than a seventh of the stage's smaller side",
        "Sec. III-A, Fig. 7",
        1 / 7,
        _only("boundary_share", "disgust"),
        reason="half of the mean distance of points all over the stage",
    ),
    Claim(
        "disgust ends nearer to the boundary than fear",
        "Table II: coverage on boundaries, uniform coverage",
        _only("distance_to_boundary_end_to_snapshot", "fear"),
        _only("distance_to_boundary_end_to_snapshot", "disgust"),
        1.5,
        reason="a difference of half is visible without a direct comparison",
    ),
    Claim(
        "disgust ends on all four sides: no gap along the boundary is nine quarters of the even one",
        "Fig. 16b: spread along the boundary",
        9 / 4,
        _only("boundary_gap", "disgust"),
        reason="every side is longer than that, on the testbeds too: none can be empty",
    ),
    Claim(
        "disgust moves from the center outwards: its distance from the center more than doubles",
        "Sec. III-A: from the center towards the exterior",
        _only("centre_gain", "disgust"),
        2.0,
        reason="twice as far is a clear motion outwards",
    ),
    Claim(
        "disgust turns away faster than fear spreads",
        "ours: Sec. III-A describes animosity, so it must not equal fear with another end",
        _only("speed_mean", "disgust"),
        _only("speed_mean", "fear"),
        1.5,
        reason="a difference of half is visible without a direct comparison",
    ),
    Claim(
        "anger crowds around the center: it ends nearer to it than fear and disgust",
        "Table II: coverage on center; Sec. III-A",
        _only("distance_to_centre_end_to_snapshot", "fear", "disgust"),
        _only("distance_to_centre_end_to_snapshot", "anger"),
        2.0,
        reason="half as far is a clear difference",
    ),
    Claim(
        "anger crowds: its robots end nearer to each other than two thirds of their distance at the start",
        "Fig. 8: concentrate; Fig. 16a: in each other's vicinity",
        2 / 3,
        _only("neighbour_gain", "anger"),
        reason="a third nearer is a clear crowding",
    ),
    Claim(
        "anger arrives: at 6 s its cost is within a quarter of the converged one",
        "Table II: coverage on center",
        1.25,
        _only("cost_ratio_to_snapshot", "anger"),
        reason="a quarter more cost is a tenth more distance",
    ),
)

# Cells of Table I that the paper does not apply to its behaviors: no failure of a scene.
NOT_APPLIED = {
    "fear has the shape of downward pointing triangles": "Table I",
    "sadness has an angular shape and an angular trace, as of negative valence": "Table I; Sec. IV-B prefers smooth",
    "fear, disgust and anger have an angular shape, as of negative valence": "Table I; Sec. IV-A gives them densities",
}


# Sec. V: on the robots, anger differs most, since actuator limits and safety rule out the very high peak velocities of
# its simulation, yet it keeps its characteristic features. So for robots with motors, claims about peaks leave out
# anger; other claims do not. Spectral arc length is one of these: it is that of a speed profile.
EXCEPTION = "anger's peaks of speed are cut by the motors: Sec. V"


def claims_on(*, motors: bool) -> tuple[Claim, ...]:
    """Return the claims for scenes; for robots with motors, with the paper's exception."""
    if not motors:
        return CLAIMS
    return tuple(kept for claim in CLAIMS if (kept := claim.without_anger() if claim.peaks else claim))


def exceptions(*, motors: bool) -> dict[str, str]:
    """Return the claims without anger for robots with motors, with the source of the exception."""
    return {claim.text: EXCEPTION for claim in CLAIMS if claim.peaks} if motors else {}


def judge(measured: Measured, *, motors: bool = False) -> list[Verdict]:
    """Return the verdicts on all claims.

    Args:
        measured: the `claim_metrics` of each of the six emotions.
        motors: whether the robots have actuator limits.

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
