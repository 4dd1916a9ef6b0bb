from math import sqrt

import pytest

from emovid.errors import nearest
from emovid.scene.load import Setting, load_robot, load_scene


@pytest.mark.parametrize(
    ("duration", "fps", "frames"),
    [
        (15, 30, 450),
        (15, 24, 360),
        (1.7, 24, 41),  # 40.8
        (0.1, 24, 2),  # 2.4
        (0.29, 100, 29),  # 28.999999999999996 in floating point
        (1.1, 30, 33),  # 33.00000000000001 in floating point: no extra frame
        (0.001, 30, 1),  # at least one
        (86400, 240, 20736000),
    ],
)
def test_frames_are_duration_times_fps(duration, fps, frames):
    keys = {"duration": duration, "video.fps": fps, "control_period": 1}
    scene = load_scene("happiness", [Setting(key, value, key) for key, value in keys.items()])
    assert scene.frames == frames


def test_radius_of_a_gritsbot():
    # Its square: corners' centers at (9, 9) mm and 6 mm around them, 9 sqrt 2 + 6 = 18.73 mm from the origin. Its
    # wheels reach further: 35 / 2 + 3 / 2 = 19 mm out and 5 mm ahead, sqrt(19^2 + 5^2) = sqrt 386 = 19.65 mm.
    assert load_robot("gritsbot").radius == pytest.approx(0.001 * sqrt(386), rel=1e-12)


def test_radius_of_a_single_integrator():
    # A disk of 30 mm: corners' centers at the origin and 15 mm around them.
    assert load_robot("single_integrator").radius == pytest.approx(0.015, rel=1e-12)


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("k", " (did you mean K?)"),
        ("L", " (did you mean l?)"),
        ("Model", " (did you mean model?)"),
        ("modle", " (did you mean model?)"),
        ("limit", " (did you mean limits?)"),
        ("battery", ""),
        ("", ""),
    ],
)
def test_nearest_word(word, hint):
    assert nearest(word, ["model", "l", "K", "limits"]) == hint


def test_nearest_word_without_candidates():
    assert nearest("model", []) == ""
