"""Results as strings in the style of the APA (Publication Manual, 7th edition, 2020).

Probabilities have three decimals and no leading zero, other statistics two; degrees of freedom come before N.
"""

from math import isnan

from emovid.statistics.circumplex import NearNeighbours
from emovid.statistics.compare import Compared
from emovid.statistics.dependence import Agreement, LabelUse, VideosDiffer
from emovid.statistics.goodness import Goodness
from emovid.statistics.groups import RatesDiffer, ScoresDiffer
from emovid.statistics.pairs import Pair
from emovid.statistics.permutation_tests import Order, TotalRecognition
from emovid.statistics.recognition import AgainstChance

_MINUS = "\N{MINUS SIGN}"
_CHI2 = "\N{GREEK SMALL LETTER CHI}\N{SUPERSCRIPT TWO}"
_KAPPA = "\N{GREEK SMALL LETTER KAPPA}"
_UNKNOWN = "n/a"
_RATE_TESTS = {
    "exact": "Fisher\u2019s exact",
    "Monte Carlo": "Fisher, Freeman and Halton\u2019s",
    "chi-squared": f"Pearson\u2019s {_CHI2}",
}


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


def goodness(test: Goodness) -> str:
    """Return Pearson's goodness of fit."""
    return f"{_chi_squared(test.statistic, test.dof, test.n)}, {p_value(test.p)}, w = {number(test.cohens_w)}"


def goodness_exact(test: Goodness) -> str:
    """Return the exact or Monte Carlo p of the same statistic."""
    p = p_value(test.p_exact, draws=test.draws) if test.draws else p_value(test.p_exact, "exact p")
    return f"{_chi_squared(test.statistic, test.dof, test.n)}, {p}, w = {number(test.cohens_w)}"


def _chi_squared(statistic: float, dof: int, n: int) -> str:
    return f"{_CHI2}({dof}, N = {n}) = {number(statistic)}"


def binomial(test: AgainstChance) -> str:
    """Return the rate and the one-sided exact binomial test against chance, as it is and after Holm."""
    rate = proportion(test.hits, test.n, test.ci_low, test.ci_high)
    return f"{rate}, exact binomial {p_value(test.p_binomial)}, {p_value(test.p_holm, 'Holm p')}"


def cochrans_q(test: VideosDiffer) -> str:
    """Return Cochran's Q."""
    return f"Q({test.dof}) = {number(test.statistic)}, {p_value(test.p)}"


def fleiss_kappa(test: Agreement) -> str:
    """Return Fleiss' kappa."""
    return f"Fleiss\u2019 {_KAPPA} = {number(test.kappa)}"


def label_use(test: LabelUse) -> str:
    """Return the test of preferred labels."""
    return f"{_CHI2}({test.dof}) = {number(test.statistic)}, {p_value(test.p, draws=test.draws)}"


def total_recognition(test: TotalRecognition) -> str:
    """Return all hits against those of shuffled answers."""
    name = "exact p" if test.method == "exact" else "p"
    return f"{test.hits}/{test.n} right, {number(test.expected)} expected, {p_value(test.p, name)}"


def order_effect(test: Order) -> str:
    """Return the change of the hit rate per position, in percentage points."""
    return f"{number(100 * test.slope)} points per position, {p_value(test.p, draws=test.draws)}"


def scores_differ(test: ScoresDiffer) -> str:
    """Return the groups' mean scores in percent and the permutation test."""
    means = ", ".join(f"{name} {100 * mean:.1f}%" for name, mean in zip(test.levels, test.means, strict=True))
    p = p_value(test.p, draws=test.draws) if test.draws else p_value(test.p, "exact p")
    return f"{means}: permutation test, {p}"


def rates_differ(test: RatesDiffer) -> str:
    """Return the groups' hits on a video and the test of the difference, as it is and after Holm."""
    hits = ", ".join(f"{name} {h}/{m}" for name, h, m in zip(test.levels, test.hits, test.n, strict=True))
    return f"{hits}: {_RATE_TESTS[test.method]} {p_value(test.p, draws=test.draws)}, {p_value(test.p_holm, 'Holm p')}"


def difference(pair: Pair) -> str:
    """Return a difference in percentage points with its interval, bound of equivalence and Bayes factor."""
    low, high, points = (number(100 * value, 1) for value in (pair.ci_low, pair.ci_high, pair.difference))
    if isnan(pair.bound):
        return f"{points} points, no interval"
    bound = f"equivalent within \N{PLUS-MINUS SIGN}{number(100 * pair.bound, 1)} points"
    return f"{points} points, 95% CI [{low}, {high}], {bound}, {bayes_factor(pair.bf01)}"


def bayes_factor(bf01: float) -> str:
    """Return "BF01 = 3.21", or a bound beyond 1,000 either way."""
    if isnan(bf01):
        return f"BF01 {_UNKNOWN}"
    return "BF01 > 1,000" if bf01 > 1000 else "BF01 < 0.001" if bf01 < 0.001 else f"BF01 = {bf01:.{2 + (bf01 < 0.1)}f}"


def near_neighbours(test: NearNeighbours) -> str:
    """Return the mean distance of confusions on the circle."""
    if not test.confusions:
        return "no confusions of emotions that have a place on it"
    distance, expected = number(test.mean_distance, 1), number(test.expected, 1)
    return f"mean distance {distance}\N{DEGREE SIGN}, {expected}\N{DEGREE SIGN} expected, {p_value(test.p, 'exact p')}"


def compared(test: Compared) -> str:
    """Return the whole-matrix test of a replication."""
    return f"{_CHI2}({test.dof}) = {number(test.statistic)}, {p_value(test.p_monte_carlo, draws=test.draws)}"
