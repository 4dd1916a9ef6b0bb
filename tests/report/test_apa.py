from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.report import apa
from emovid.statistics.compare import Compared
from emovid.statistics.confusions import NearNeighbors, near_neighbors
from emovid.statistics.goodness import goodness_of_fit
from emovid.statistics.groups import Pair, RatesDiffer, ScoresDiffer
from emovid.statistics.participants import Agreement, LabelUse, Order, TotalRecognition, VideosDiffer
from emovid.statistics.recognition import accuracy, recognize
from emovid.statistics.resampling import Information

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
def test_p_values_are_formatted(p: float, expected: str) -> None:
    assert apa.p_value(p) == expected


def test_p_value_names_its_method() -> None:
    assert apa.p_value(0.012, draws=9999) == "Monte Carlo p = .012 (B = 9,999)"
    assert apa.p_value(0.0001, draws=9999) == "Monte Carlo p < .001 (B = 9,999)"
    assert apa.p_value(0.0833, "exact p") == "exact p = .083"


@pytest.mark.parametrize(
    ("value", "expected"), [(0.5, "0.50"), (-0.5, "−0.50"), (-0.001, "0.00"), (12.345, "12.35"), (np.nan, "n/a")]
)
def test_numbers_are_formatted(value: float, expected: str) -> None:
    assert apa.number(value + 1e-9 if value > 1 else value) == expected


def test_sentences_of_goodness_of_fit() -> None:
    assert apa.goodness(goodness_of_fit(ROW)) == "χ²(5, N = 45) = 25.80, p < .001, w = 0.76"
    row = goodness_of_fit(np.array([6, 2, 1, 1, 1, 1]))
    assert apa.goodness_exact(row) == "χ²(5, N = 12) = 10.00, exact p = .083, w = 0.91"
    many = goodness_of_fit(np.array([400, 300, 300, 300, 300, 300]))
    assert apa.goodness_exact(many).endswith("Monte Carlo p < .001 (B = 9,999), w = 0.12")
    assert apa.goodness(goodness_of_fit(ROW * 0)) == "χ²(5, N = 0) = n/a, p n/a, w = n/a"


def test_sentences_of_proportion_and_binomial() -> None:
    (test, *_) = recognize(np.column_stack([ROW, 0 * ROW]))
    rate = apa.proportion(test.hits, test.n, test.ci_low, test.ci_high)
    assert rate == "20/45 (44.4%, 95% CI [30.9, 58.8])"
    assert apa.binomial(test) == f"{rate}, one-sided exact binomial p < .001, Holm p < .001"
    assert apa.proportion(0, 0, 0, 1) == "0/0"


def test_sentences_of_tests_within_participants() -> None:
    assert apa.cochrans_q(VideosDiffer(3.3333, 5, 0.6487, 4, 4, 5)) == "Q(5, n = 4) = 3.33, p = .649"
    nan = float("nan")
    undefined = apa.cochrans_q(VideosDiffer(5.0, 5, nan, 4, 1, 40))
    assert undefined == "no test: 1 of 40 participants have complete answers with both hits and misses"
    assert apa.fleiss_kappa(Agreement(0.2971, 4, 6)) == "Fleiss’ κ = 0.30, n = 4"
    total = TotalRecognition(16, 24, 4.0, 9.3e-7, "exact")
    assert apa.total_recognition(total) == "16/24 right, 4.00 expected, one-sided exact p < .001"
    order = Order(np.array([1]), np.array([2]), -0.0125, 0.4845, "normal", 0, None)
    assert apa.order_effect(order) == "−1.25 points per position, p = .484"
    none = np.zeros(3)
    use = LabelUse(none, none, none, none, none, 24.9855, 5, 0.00126, 44)
    assert apa.label_use(use) == "χ²(5, n = 44) = 24.99, p = .001"
    unknown = LabelUse(np.zeros(6), none, none, none, none, nan, 0, nan, 1)
    assert apa.label_use(unknown) == "no test: 1 participants with errors, 6 labels"


def test_sentences_of_groups() -> None:
    scores = ScoresDiffer(("no", "yes"), (3, 4), (0.5, 0.25), 0.1143, 0.2286, "exact", True, 0, None, (), ())
    assert (
        apa.scores_differ(scores) == "no 50.0%, yes 25.0%: studentized permutation test, exact p = .114, Holm p = .229"
    )


@pytest.mark.parametrize(
    ("method", "draws", "said"),
    [
        ("exact", 0, "Fisher’s exact p = .752"),
        ("Monte Carlo", 9999, "Fisher, Freeman and Halton’s Monte Carlo p = .752 (B = 9,999)"),
        ("permutation", 0, "permutation of participants, p = .752"),
    ],
)
def test_rates_are_reported_with_the_test_used(method: str, draws: int, said: str) -> None:
    rates = RatesDiffer(("no", "yes"), (18, 11), (29, 16), 0.7519, 1.0, method, draws, 0 if draws else None, (), ())
    assert apa.rates_differ(rates) == f"no 18/29, yes 11/16: {said}, Holm p = 1.000"


def test_sentences_of_differences() -> None:
    nan = float("nan")
    numbers = -0.0668, -0.3154, 0.2204, 0.2816
    text = "−6.7 points, 95% CI [−31.5, 22.0], "
    without = Pair(("a", "b"), *numbers, nan, None, 2.591)
    assert apa.difference(without) == text + "compatible with differences up to 28.2 points (90% CI), BF01 = 2.59"
    shown = Pair(("a", "b"), *numbers, 0.3, True, 2.591)
    assert apa.difference(shown) == text + "equivalent within ±30.0 points, BF01 = 2.59"
    not_shown = Pair(("a", "b"), *numbers, 0.2, False, 2.591)
    assert apa.difference(not_shown) == text + "equivalence not shown within ±20.0 points, BF01 = 2.59"
    assert apa.difference(Pair(("a", "b"), 0.5, nan, nan, nan, nan, None, nan)) == "50.0 points, no interval"


def test_sentence_of_all_answers_together() -> None:
    matrix = np.diag([10, 10]) + np.array([[0, 5], [5, 0]])
    assert apa.sentence(accuracy(matrix)) == "20/30 (66.7%)"
    known = accuracy(matrix, np.array([2] * 10 + [0] * 5), np.full(15, 2))
    assert apa.sentence(known) == "20/30 (66.7%, 95% CI [38.7, 86.3])"
    assert apa.sentence(accuracy(0 * matrix)) == "0/0"
    nan = float("nan")
    said = "0.75 of 2.58 bits (0.69 less the bias of small samples), 95% CI [0.53, 0.84]"
    assert apa.information(Information(0.7492, 0.69, 0.53, 0.84, 2.585, 2000, 0)) == said
    assert apa.information(Information(0.7492, nan, nan, nan, 2.585, 0, None)) == "0.75 of 2.58 bits"


def test_only_tests_have_a_sentence() -> None:
    assert apa.has_sentence(Pair)
    assert not apa.has_sentence(str)
    with pytest.raises(TypeError, match="str is not a test"):
        apa.sentence("x")


@pytest.mark.parametrize(
    ("bf01", "expected"),
    [(3.214, "= 3.21"), (0.0512, "= 0.051"), (1e-5, "< 0.001"), (5e6, "> 1,000"), (113.07, "= 113.07")],
)
def test_sentences_of_bayes_factors(bf01: float, expected: str) -> None:
    assert apa.bayes_factor(bf01) == f"BF01 {expected}"


def test_unknown_bayes_factor() -> None:
    assert apa.bayes_factor(float("nan")) == "BF01 n/a"


def test_near_neighbors_and_replications() -> None:
    near = NearNeighbors(125, 62.279, 68.317, 0.0125, "Monte Carlo", 3999, 0)
    said = "mean distance 62.3°, 68.3° expected, one-sided p = .013 (B = 3,999)"
    assert apa.near_neighbors(near) == said
    assert apa.near_neighbors(replace(near, method="sign flips")) == f"{said}, errors of a participant taken together"
    none = near_neighbors(np.eye(2, dtype=np.int64), ("fear", "anger"))
    assert apa.near_neighbors(none) == "no confusions of emotions that have a place on it"
    fixed = near_neighbors(np.ones((2, 2), dtype=np.int64), ("fear", "anger"))
    assert apa.near_neighbors(fixed).endswith("cannot be tested: the margins fix the distance")
    both = Compared((), 40.1667, 30, 0.1017, 0.0896, "participants", 9999, 0)
    assert (
        apa.compared(both) == "χ²(30) = 40.17, Monte Carlo p = .090 (B = 9,999), participants shuffled over the studies"
    )
    assert "as if all were independent" in apa.compared(replace(both, shuffled="answers"))


@given(st.floats(0, 1))
def test_rounded_p_values_are_consistent_with_their_relation(p: float) -> None:
    text = apa.p_value(p)
    relation, digits = text.split()[1:]
    bound = float(digits)
    assert {"<": p < bound, ">": p > bound, "=": abs(p - bound) <= 5e-4 + 1e-12}[relation]
