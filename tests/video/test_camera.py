import numpy as np
import pytest

from emovid.scene.stage import Polygon, Rectangle
from emovid.video.cameras import OverheadCamera


def test_stage_fills_the_frame_except_for_a_margin() -> None:
    # Height decides: 720 pixels less 2 x 3.5 %, over 0.8 m.
    camera = OverheadCamera.framing(Rectangle(width=1.2, height=0.8), 1280, 720)
    assert camera.scale == pytest.approx((720 - 50.4) / 0.8)
    assert camera.pixels(np.array([0.0, 0.4]))[1] == pytest.approx(720 - 25.2)


def test_wide_stage_is_limited_by_the_frame_width() -> None:
    camera = OverheadCamera.framing(Rectangle(width=4.0, height=0.5), 640, 480)
    assert camera.pixels(np.array([-2.0, 0.0])) == pytest.approx([0.035 * 480, 240])


def test_origin_is_at_the_frame_center_and_y_points_up() -> None:
    camera = OverheadCamera.framing(Rectangle(width=1.2, height=0.8), 200, 100)
    middle, above = camera.pixels(np.array([[0.0, 0.0], [0.0, 0.1]]))
    assert middle == pytest.approx([100, 50])
    assert above[1] > middle[1]


def test_off_origin_stage_is_centered_by_its_bounding_box() -> None:
    # From (2, 1) to (3, 3): its height decides, and its box's middle is the frame's.
    triangle = Polygon(corners=[{"x": 2, "y": 1}, {"x": 3, "y": 1}, {"x": 2.5, "y": 3}])
    camera = OverheadCamera.framing(triangle, 640, 480)
    assert camera.scale == pytest.approx(0.93 * 480 / 2)
    assert camera.pixels(np.array([2.5, 2.0])) == pytest.approx([320, 240])
    assert camera.pixels(np.array([2.5, 3.0])) == pytest.approx([320, 480 - 0.035 * 480])


def test_world_coordinates_invert_pixel_coordinates() -> None:
    camera = OverheadCamera(640, 480, 321.5, (0.3, -0.2))
    places = np.array([[0.0, 0.0], [-0.4, 0.7], [1.1, 0.2]])
    assert camera.metres(camera.pixels(places)) == pytest.approx(places)
