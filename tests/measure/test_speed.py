import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.measure.kinematics import quantile, speed
from emovid.measure.window import Window
from tests.helpers.driven import driven


@pytest.fixture(scope="module")
def two(make_scene):
    """Two robots for 4 s: one accelerates forward, one drives backward at constant speed."""
    commands = np.array([[[0.1, 0], [-0.2, 5]], [[0.2, 0], [-0.2, 5]], [[0.3, 1], [-0.2, 5]], [[0.4, 0], [-0.2, 5]]])
    return driven(make_scene("fear", {"robots": 2}), np.zeros((2, 3)), commands, 1.0)


def of(run, start: float, end: float) -> dict[str, float]:
    return speed(Window(run, start, end))


def test_speed_is_averaged_over_robots_and_time(two) -> None:
    found = of(two, 0, 4)
    assert found["speed_mean"] == pytest.approx((0.1 + 0.2 + 0.3 + 0.4 + 4 * 0.2) / 8)
    assert found["speed_peak"] == 0.4
    assert found["distance_travelled"] == pytest.approx((1.0 + 0.8) / 2)
    assert found["speed_mean_diagonals"] == pytest.approx(found["speed_mean"] / np.hypot(1.2, 0.8))


def test_window_may_start_and_end_within_a_period(two) -> None:
    found = of(two, 0.5, 1.25)
    assert found["distance_travelled"] == pytest.approx((0.5 * 0.1 + 0.25 * 0.2 + 0.75 * 0.2) / 2)
    assert found["speed_mean"] == pytest.approx(found["distance_travelled"] / 0.75)
    assert found["speed_peak"] == 0.2  # times after the window do not count


def test_percentile_of_speed_is_weighted_by_time(two) -> None:
    assert of(two, 0, 3.1)["speed_p95"] == 0.3  # 0.4 m/s for 0.1 s of 6.2 s is less than 5 %
    assert of(two, 0, 3.9)["speed_p95"] == 0.4  # 0.9 s of 7.8 s is more


@given(st.lists(st.tuples(st.floats(0, 1), st.integers(1, 5)), min_size=1, max_size=30), st.floats(0.01, 1))
def test_weighted_quantile_equals_the_quantile_of_repeated_values(pairs, share) -> None:
    values, counts = (np.array(column) for column in zip(*pairs, strict=True))
    repeated = np.sort(np.repeat(values, counts))
    expected = repeated[int(np.ceil(share * len(repeated) - 1e-9)) - 1]
    assert quantile(values, counts.astype(float), share) == expected
