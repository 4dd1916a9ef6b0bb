import numpy as np
import pytest

from emovid.scene.model import Stage
from emovid.video.camera import Camera


def test_the_stage_fills_the_frame_but_for_a_margin() -> None:
    # Height decides: 720 pixels less 2 x 3.5 %, over 0.8 m.
    camera = Camera.framing(Stage(width=1.2, height=0.8), 1280, 720)
    assert camera.scale == pytest.approx((720 - 50.4) / 0.8)
    assert camera.pixels(np.array([0.0, 0.4]))[1] == pytest.approx(720 - 25.2)


def test_a_wide_stage_is_bound_by_the_width() -> None:
    camera = Camera.framing(Stage(width=4.0, height=0.5), 640, 480)
    assert camera.pixels(np.array([-2.0, 0.0])) == pytest.approx([0.035 * 480, 240])


def test_the_origin_is_the_middle_and_y_points_up() -> None:
    camera = Camera.framing(Stage(width=1.2, height=0.8), 200, 100)
    middle, above = camera.pixels(np.array([[0.0, 0.0], [0.0, 0.1]]))
    assert middle == pytest.approx([100, 50])
    assert above[1] > middle[1]
