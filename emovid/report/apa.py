"""Results as strings in the style of the APA (Publication Manual, 7th edition, 2020).

Probabilities have three decimals and no leading zero, other statistics two; degrees of freedom come before N.
"""

from functools import singledispatch
from math import isnan

from emovid.statistics.compare import Compared
from emovid.statistics.confusions import NearNeighbors
from emovid.statistics.goodness import Goodness
from emovid.statistics.groups import Pair, RatesDiffer, ScoresDiffer
from emovid.statistics.participants import Agreement, LabelUse, Order, TotalRecognition, VideosDiffer
from emovid.statistics.recognition import Accuracy, AgainstChance
from emovid.statistics.resampling import Information

_MINUS = "\N{MINUS SIGN}"
_CHI2 = "\N{GREEK SMALL LETTER CHI}\N{SUPERSCRIPT TWO}"
_KAPPA = "\N{GREEK SMALL LETTER KAPPA}"
_UNKNOWN = "n/a"
_RATE_TESTS = {
    "exact": "Fisher\u2019s exact",
    "Monte Carlo": "Fisher, Freeman and Halton\u2019s",
    "permutation": "permutation of participants,",
}


@singledispatch
def sentence(test: object) -> str:
    """Return the string that reports a test.

    Raises:
        TypeError: for anything that is not a test.
    """
    raise TypeError(f"{type(test).__name__} is not a test")


def has_sentence(kind: type) -> bool:
    """Return whether `sentence` knows this type of results."""
    return sentence.dispatch(kind) is not sentence.dispatch(object)


def p_value(p: float, name: str = "p", draws: int = 0) -> str:
    """Return "p = .020", "exact p < .001" with another name, or "Monte Carlo p = .012 (B = 9,999)" with draws."""
    if isnan(p):
        return f"{name} {_UNKNOWN}"
    digits = f"{p:.3f}" if p >= 1 else f"{p:.3f}".removeprefix("0")
    relation = "< .001" if p < 0.001 else "> .999" if digits == "1.000" and p < 1 else f"= {digits}"
    return f"Monte Carlo {name} {relation} (B = {draws:,})" if draws else f"{name} {relation}"


def number(value: float, decimals: int = 2) -> str:
    """Return a number that may exceed 1: with its leading zero, and a minus sign, not a hyphen."""
    if isnan(value):
        return _UNKNOWN
    text = f"{value:.{decimals}f}"
    return text.replace("-", _MINUS) if float(text) else text.removeprefix("-")


def proportion(hits: int, n: int, low: float, high: float) -> str:
    """Return "20/45 (44.4%, 95% CI [30.9, 58.8])", the interval given as shares."""
    if not n:
        return "0/0"
    return f"{hits}/{n} ({100 * hits / n:.1f}%, 95% CI [{100 * low:.1f}, {100 * high:.1f}])"


@sentence.register
def goodness(test: Goodness) -> str:
    """Return Pearson's goodness of fit, or the permutation statistic of participants who gave several answers."""
    return _goodness(test, p_value(test.p))


def goodness_exact(test: Goodness) -> str:
    """Return the exact or Monte Carlo p of the same statistic."""
    return _goodness(test, exact_p(test))


def _goodness(test: Goodness, p: str) -> str:
    if test.participants is None:
        return f"{_CHI2}({test.dof}, N = {test.n}) = {number(test.statistic)}, {p}, w = {number(test.cohens_w)}"
    if isnan(test.statistic):
        return f"no test: {test.n} answers of {test.participants} participants"
    answers = f"{test.participants} participants, {test.n} answers"
    return f"T({test.dof}; {answers}) = {number(test.statistic)}, {p}"


def exact_p(test: Goodness) -> str:
    """Return the exact or Monte Carlo p alone."""
    return p_value(test.p_exact, draws=test.draws) if test.draws else p_value(test.p_exact, "exact p")


@sentence.register
def binomial(test: AgainstChance) -> str:
    """Return the rate and the one-sided exact test against chance, as it is and after Holm."""
    rate = proportion(test.hits, test.n, test.ci_low, test.ci_high)
    return f"{rate}, one-sided {test.method} {p_value(test.p_binomial)}, {p_value(test.p_holm, 'Holm p')}"


@sentence.register
def overall(test: Accuracy) -> str:
    """Return the rate of all answers together."""
    if isnan(test.ci_low):
        return f"{test.hits}/{test.n} ({100 * test.rate:.1f}%)" if test.n else "0/0"
    return proportion(test.hits, test.n, test.ci_low, test.ci_high)


@sentence.register
def information(test: Information) -> str:
    """Return the mutual information in bits."""
    interval = "" if isnan(test.ci_low) else f", 95% CI [{number(test.ci_low)}, {number(test.ci_high)}]"
    unbiased = "" if isnan(test.corrected) else f" ({number(test.corrected)} less the bias of small samples)"
    return f"{number(test.bits)} of {number(test.most)} bits{unbiased}{interval}"


@sentence.register
def cochrans_q(test: VideosDiffer) -> str:
    """Return Cochran's Q, with how many participants it rests on."""
    rests = f"{test.informative} of {test.total} participants have complete answers with both hits and misses"
    if isnan(test.p):
        return f"no test: {rests}"
    return f"Q({test.dof}, n = {test.informative}) = {number(test.statistic)}, {p_value(test.p)}"


@sentence.register
def fleiss_kappa(test: Agreement) -> str:
    """Return Fleiss' kappa."""
    return f"Fleiss\u2019 {_KAPPA} = {number(test.kappa)}, n = {test.participants}"


@sentence.register
def label_use(test: LabelUse) -> str:
    """Return the test of preferred labels among errors."""
    if isnan(test.p):
        return f"no test: {test.participants} participants with errors, {len(test.totals)} labels"
    return f"{_CHI2}({test.dof}, n = {test.participants}) = {number(test.statistic)}, {p_value(test.p)}"


@sentence.register
def total_recognition(test: TotalRecognition) -> str:
    """Return all hits against those of shuffled answers."""
    if isnan(test.p):
        return f"{test.hits}/{test.n} right, no test: shuffling changes nothing"
    name = "one-sided exact p" if test.method == "exact" else "one-sided p"
    return f"{test.hits}/{test.n} right, {number(test.expected)} expected, {p_value(test.p, name)}"


@sentence.register
def order_effect(test: Order) -> str:
    """Return the change of the hit rate per position, in percentage points."""
    if isnan(test.p):
        return "no test: all participants had one order, or all or none of the answers hit"
    return f"{number(100 * test.slope)} points per position, {p_value(test.p, draws=test.draws)}"


@sentence.register
def scores_differ(test: ScoresDiffer) -> str:
    """Return the groups' mean scores in percent and the permutation test."""
    means = ", ".join(f"{name} {100 * mean:.1f}%" for name, mean in zip(test.levels, test.means, strict=True))
    p = p_value(test.p, draws=test.draws) if test.draws else p_value(test.p, "exact p")
    if isnan(test.p):
        return f"{means}: no test, since no shuffle of participants changes anything"
    kind = "studentized permutation test" if test.studentized else "permutation test"
    return f"{means}: {kind}, {p}, {p_value(test.p_holm, 'Holm p')}"


@sentence.register
def rates_differ(test: RatesDiffer) -> str:
    """Return the groups' hits on an emotion and the test of the difference, as it is and after Holm."""
    hits = ", ".join(f"{name} {h}/{m}" for name, h, m in zip(test.levels, test.hits, test.n, strict=True))
    return f"{hits}: {_RATE_TESTS[test.method]} {p_value(test.p, draws=test.draws)}, {p_value(test.p_holm, 'Holm p')}"


@sentence.register
def difference(pair: Pair) -> str:
    """Return a difference in percentage points with its interval, test of equivalence and Bayes factor."""
    low, high, points = (number(100 * value, 1) for value in (pair.ci_low, pair.ci_high, pair.difference))
    if isnan(pair.bound):
        return f"{points} points, no interval"
    return f"{points} points, 95% CI [{low}, {high}], {equivalence(pair)}, {bayes_factor(pair.bf01)}"


def equivalence(pair: Pair) -> str:
    """Return whether a pair is equivalent within the margin set beforehand; without one, what is not ruled out."""
    if pair.equivalent is None:
        return f"compatible with differences up to {number(100 * pair.bound, 1)} points (90% CI)"
    shown = "equivalent" if pair.equivalent else "equivalence not shown"
    return f"{shown} within \N{PLUS-MINUS SIGN}{number(100 * pair.margin, 1)} points"


def bayes_factor(value: float, name: str = "BF01") -> str:
    """Return "BF01 = 3.21", or a bound beyond 1,000 either way."""
    if isnan(value):
        return f"{name} {_UNKNOWN}"
    if value > 1000:
        return f"{name} > 1,000"
    return f"{name} < 0.001" if value < 0.001 else f"{name} = {value:.{2 + (value < 0.1)}f}"


@sentence.register
def near_neighbors(test: NearNeighbors) -> str:
    """Return the mean distance of confusions on the circle."""
    if not test.confusions:
        return "no confusions of emotions that have a place on it"
    distance, expected = number(test.mean_distance, 1), number(test.expected, 1)
    said = f"mean distance {distance}\N{DEGREE SIGN}, {expected}\N{DEGREE SIGN} expected"
    if isnan(test.p):
        return f"{said}, cannot be tested: the margins fix the distance"
    how = ", errors of a participant taken together" if test.method == "sign flips" else ""
    return f"{said}, {p_value(test.p, 'one-sided p')}" + _draws(test.draws) + how


def _draws(draws: int) -> str:
    return f" (B = {draws:,})" if draws else ""


@sentence.register
def compared(test: Compared) -> str:
    """Return the whole-matrix test of a replication."""
    how = "participants shuffled over the studies"
    if test.shuffled == "answers":
        how = "answers shuffled over the studies, as if all were independent, since participants are not known"
    return f"{_CHI2}({test.dof}) = {number(test.statistic)}, {p_value(test.p_monte_carlo, draws=test.draws)}, {how}"
