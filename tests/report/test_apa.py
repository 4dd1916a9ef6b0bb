import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.report import apa
from emovid.statistics.circumplex import NearNeighbours, near_neighbours
from emovid.statistics.compare import Compared
from emovid.statistics.dependence import Agreement, VideosDiffer, label_use
from emovid.statistics.goodness import goodness_of_fit
from emovid.statistics.groups import RatesDiffer, ScoresDiffer
from emovid.statistics.pairs import Pair
from emovid.statistics.permutation_tests import Order, TotalRecognition
from emovid.statistics.recognition import recognise

ROW = np.array([20, 7, 5, 5, 4, 4])


@pytest.mark.parametrize(
    ("p", "expected"),
    [
        (0.0004, "p < .001"),
        (0.00099999, "p < .001"),
        (0.001, "p = .001"),
        (0.02, "p = .020"),
        (0.0833, "p = .083"),
        (0.9996, "p > .999"),
        (1.0, "p = 1.000"),
        (float("nan"), "p n/a"),
    ],
)
def test_p(p: float, expected: str) -> None:
    assert apa.p_value(p) == expected


def test_p_says_how_it_was_found() -> None:
    assert apa.p_value(0.012, draws=9999) == "Monte Carlo p = .012 (B = 9,999)"
    assert apa.p_value(0.0001, draws=9999) == "Monte Carlo p < .001 (B = 9,999)"
    assert apa.p_value(0.0833, "exact p") == "exact p = .083"


@pytest.mark.parametrize(
    ("value", "expected"), [(0.5, "0.50"), (-0.5, "−0.50"), (-0.001, "0.00"), (12.345, "12.35"), (np.nan, "n/a")]
)
def test_number(value: float, expected: str) -> None:
    assert apa.number(value + 1e-9 if value > 1 else value) == expected


def test_goodness() -> None:
    assert apa.goodness(goodness_of_fit(ROW)) == "χ²(5, N = 45) = 25.80, p < .001, w = 0.76"
    row = goodness_of_fit(np.array([6, 2, 1, 1, 1, 1]))
    assert apa.goodness_exact(row) == "χ²(5, N = 12) = 10.00, exact p = .083, w = 0.91"
    many = goodness_of_fit(np.array([400, 300, 300, 300, 300, 300]))
    assert apa.goodness_exact(many).endswith("Monte Carlo p < .001 (B = 9,999), w = 0.12")
    assert apa.goodness(goodness_of_fit(ROW * 0)) == "χ²(5, N = 0) = 0.00, p = 1.000, w = n/a"


def test_proportion_and_binomial() -> None:
    (test, *_) = recognise(np.column_stack([ROW, 0 * ROW]))
    rate = apa.proportion(test.hits, test.n, test.ci_low, test.ci_high)
    assert rate == "20/45 (44.4%, 95% CI [30.9, 58.8])"
    assert apa.binomial(test) == f"{rate}, exact binomial p < .001, Holm p < .001"
    assert apa.proportion(0, 0, 0, 1) == "0/0"


def test_within_participants() -> None:
    assert apa.cochrans_q(VideosDiffer(3.3333, 5, 0.6487, 4)) == "Q(5) = 3.33, p = .649"
    assert apa.fleiss_kappa(Agreement(0.2971, 4, 6)) == "Fleiss’ κ = 0.30"
    total = TotalRecognition(16, 24, 4.0, 9.3e-7, "exact")
    assert apa.total_recognition(total) == "16/24 right, 4.00 expected, exact p < .001"
    order = Order(np.array([1]), np.array([2]), -0.0125, 0.4845, "normal", 0, None)
    assert apa.order_effect(order) == "−1.25 points per position, p = .484"
    use = label_use(np.array([[0, 1, 2], [2, 0, 1]]), 3)
    assert apa.label_use(use) == "χ²(2) = 0.00, Monte Carlo p = 1.000 (B = 9,999)"


def test_groups() -> None:
    scores = ScoresDiffer(("no", "yes"), (3, 4), (0.5, 0.25), 0.1143, "exact", 0, None, (), ())
    assert apa.scores_differ(scores) == "no 50.0%, yes 25.0%: permutation test, exact p = .114"


@pytest.mark.parametrize(
    ("method", "draws", "said"),
    [
        ("exact", 0, "Fisher’s exact p = .752"),
        ("Monte Carlo", 9999, "Fisher, Freeman and Halton’s Monte Carlo p = .752 (B = 9,999)"),
        ("chi-squared", 0, "Pearson’s χ² p = .752"),
    ],
)
def test_rates_are_reported_by_the_test_that_was_made(method: str, draws: int, said: str) -> None:
    rates = RatesDiffer(("no", "yes"), (18, 11), (29, 16), 0.7519, 1.0, method, draws, 0 if draws else None, (), ())
    assert apa.rates_differ(rates) == f"no 18/29, yes 11/16: {said}, Holm p = 1.000"


def test_differences() -> None:
    pair = Pair(("a", "b"), -0.0668, -0.3154, 0.2204, 0.2816, 2.591)
    text = "−6.7 points, 95% CI [−31.5, 22.0], equivalent within ±28.2 points, BF01 = 2.59"
    assert apa.difference(pair) == text
    nan = float("nan")
    assert apa.difference(Pair(("a", "b"), 0.5, nan, nan, nan, nan)) == "50.0 points, no interval"


@pytest.mark.parametrize(
    ("bf01", "expected"),
    [(3.214, "= 3.21"), (0.0512, "= 0.051"), (1e-5, "< 0.001"), (5e6, "> 1,000"), (113.07, "= 113.07")],
)
def test_bayes_factor(bf01: float, expected: str) -> None:
    assert apa.bayes_factor(bf01) == f"BF01 {expected}"


def test_a_bayes_factor_that_is_not_known() -> None:
    assert apa.bayes_factor(float("nan")) == "BF01 n/a"


def test_the_circle_and_replications() -> None:
    near = NearNeighbours(125, 62.176, 78.533, 0.0125)
    assert apa.near_neighbours(near) == "mean distance 62.2°, 78.5° expected, exact p = .013"
    none = near_neighbours(np.eye(2, dtype=np.int64), ("fear", "anger"))
    assert apa.near_neighbours(none) == "no confusions of emotions that have a place on it"
    both = Compared((), 40.1667, 30, 0.1017, 0.0896, 9999, 0)
    assert apa.compared(both) == "χ²(30) = 40.17, Monte Carlo p = .090 (B = 9,999)"


@given(st.floats(0, 1))
def test_any_p_reads_as_itself(p: float) -> None:
    text = apa.p_value(p)
    relation, digits = text.split()[1:]
    bound = float(digits)
    assert {"<": p < bound, ">": p > bound, "=": abs(p - bound) <= 5e-4 + 1e-12}[relation]
