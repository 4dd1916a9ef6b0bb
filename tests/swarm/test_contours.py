import numpy as np
import pytest

from emovid.scene.behaviour import Circle, CircularSinusoid, Contour, ExpandingCircle
from emovid.swarm.laws import followed_points, radius, start_angles, start_headings

HAPPY = CircularSinusoid(law="contour", shape="circular_sinusoid", R=0.3, A=0.05, f=6, angular_rate=1.0)
SURPRISED = ExpandingCircle(
    law="contour", shape="expanding_circle", R_min=0.1, R_max=0.4, expansion_rate=0.1, angular_rate=1.0
)
SAD = Circle(law="contour", shape="circle", R=0.12, angular_rate=-0.1)


def test_robots_start_evenly_around_the_center() -> None:
    assert start_angles(4) == pytest.approx([np.pi / 2, np.pi, 3 * np.pi / 2, 2 * np.pi])


def test_circular_sinusoid_by_hand() -> None:
    # sin(6 * 15 deg) = 1 and sin(6 * 45 deg) = -1: a crest and a trough.
    assert radius(HAPPY, np.radians([15.0, 45.0, 0.0]), 7.0) == pytest.approx([0.35, 0.25, 0.3])


@pytest.mark.parametrize(("t", "r"), [(0, 0.1), (1, 0.2), (2.9, 0.39), (3.0, 0.1), (4.5, 0.25)])
def test_expanding_circle_grows_and_restarts(t: float, r: float) -> None:
    assert radius(SURPRISED, np.zeros(1), t) == pytest.approx([r])


def test_points_move_at_the_angular_rate() -> None:
    points = followed_points(SAD, np.array([0.0, np.pi / 2]), 5.0)
    assert points == pytest.approx(0.12 * np.array([[np.cos(-0.5), np.sin(-0.5)], [-np.sin(-0.5), np.cos(-0.5)]]))


@pytest.mark.parametrize("contour", [HAPPY, SURPRISED, SAD], ids=lambda contour: contour.shape)
def test_headings_are_tangent_to_the_paths_of_the_followed_points(contour: Contour) -> None:
    theta_0 = start_angles(15)
    step = 1e-6
    moved = followed_points(contour, theta_0, step) - followed_points(contour, theta_0, 0.0)
    heading = start_headings(contour, theta_0)
    assert np.cos(heading - np.arctan2(moved[:, 1], moved[:, 0])) == pytest.approx(np.ones(15), abs=1e-9)


def test_contour_at_rest_has_headings() -> None:
    still = SAD.model_copy(update={"angular_rate": 0.0})
    assert start_headings(still, np.zeros(1)) == pytest.approx([np.pi / 2])


def test_contour_center_can_be_anywhere() -> None:
    moved = SAD.model_copy(update={"centre": SAD.centre.model_copy(update={"x": 0.2, "y": -0.1})})
    shift = followed_points(moved, start_angles(3), 1.0) - followed_points(SAD, start_angles(3), 1.0)
    assert shift == pytest.approx(np.tile([0.2, -0.1], (3, 1)))
