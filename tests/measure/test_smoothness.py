from math import inf, isnan, log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.measure.kinematics import log_dimensionless_jerk, smoothness, sparc
from emovid.measure.window import Window
from tests.helpers.driven import driven, standing


def minimum_jerk(samples: int) -> np.ndarray:
    """Return the speed of T. Flash and N. Hogan's minimum-jerk movement, one meter in one second."""
    t = (np.arange(samples) + 0.5) / samples
    return 30 * t**2 * (1 - t) ** 2


def submovements(count: int, samples: int) -> np.ndarray:
    return np.concatenate([minimum_jerk(samples // count)] * count)


def test_sparc_of_a_gaussian_speed_profile_is_the_published_value() -> None:
    # The example in the authors' own code: exp(-5 t^2) from -1 to 1 s at 100 Hz.
    assert sparc(np.exp(-5 * np.arange(-1, 1, 0.01) ** 2), 100.0) == pytest.approx(-1.41403, abs=5e-6)


def test_jerk_of_the_minimum_jerk_movement_matches_its_closed_form() -> None:
    # The integral of v''^2 is 720 and the peak speed is 15 / 8.
    assert log_dimensionless_jerk(minimum_jerk(4000)) == pytest.approx(-log(720 / (15 / 8) ** 2), abs=0.01)


@given(scale=st.floats(1e-4, 1e4))
def test_smoothness_does_not_depend_on_size(scale) -> None:
    speed = submovements(3, 90)
    assert sparc(scale * speed, 30.0) == pytest.approx(sparc(speed, 30.0))
    assert log_dimensionless_jerk(scale * speed) == pytest.approx(log_dimensionless_jerk(speed))


def test_more_submovements_are_less_smooth() -> None:
    for measure in (lambda speed: sparc(speed, 30.0), log_dimensionless_jerk):
        values = [measure(submovements(count, 120)) for count in (1, 2, 4, 8)]
        assert values == sorted(values, reverse=True)
        assert values[0] > values[-1] + 1


@pytest.mark.parametrize("seconds", [2, 4, 8, 15])
def test_sparc_of_constant_speed_does_not_depend_on_the_window(seconds) -> None:
    assert sparc(np.ones(30 * seconds), 30.0) == pytest.approx(-2.42, abs=0.02)


def test_constant_speed_has_no_jerk_on_lines_and_circles(make_scene) -> None:
    scene = make_scene("fear", {"robots": 2})
    run = driven(scene, np.zeros((2, 3)), [[[0.1, 0], [0.1, 2]]] * 40, 0.1)
    assert smoothness(Window(run, 0.0, 4.0))["log_dimensionless_jerk"] == inf


def test_smoothness_is_the_median_over_moving_robots(make_scene) -> None:
    rng = np.random.default_rng(1)
    commands = np.stack([rng.uniform(0.05, 0.2, (40, 4)), np.zeros((40, 4))], axis=-1)
    commands[:, 3] = 0
    found = smoothness(Window(driven(make_scene("fear", {"robots": 4}), np.zeros((4, 3)), commands, 0.1), 0.0, 4.0))
    alone = [
        smoothness(Window(driven(make_scene("fear", {"robots": 1}), np.zeros((1, 3)), commands[:, [i]], 0.1), 0.0, 4.0))
        for i in range(3)
    ]
    for name in ("sparc", "log_dimensionless_jerk"):
        assert found[name] == pytest.approx(sorted(each[name] for each in alone)[1])


def test_smoothness_is_undefined_without_motion_or_duration(make_scene) -> None:
    still = standing(make_scene("fear", {"robots": 2}), [[0, 0], [0.2, 0]])
    moving = driven(make_scene("fear", {"robots": 1}), np.zeros((1, 3)), [[[0.1, 0]]] * 10, 0.1)
    for run, end in ((still, 1.0), (moving, 0.05)):
        assert all(isnan(value) for value in smoothness(Window(run, 0.0, end)).values())
