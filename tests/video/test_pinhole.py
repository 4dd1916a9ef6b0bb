import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from emovid.scene.stage import Rectangle
from emovid.scene.video import Aim, CameraKeys, Video
from emovid.video.cameras import PinholeCamera
from tests.helpers.pinholes import FLOOR, PINHOLES, matrix

ROBOTARIUM = Rectangle(width=4.3, height=3.6)


def framing(
    stage: Rectangle = ROBOTARIUM, tallest: float = 0.1, size: str = "1280x720", **keys: float
) -> PinholeCamera:
    return PinholeCamera.framing(stage, Video(size=size, view="perspective", camera=CameraKeys(**keys)), tallest)


def test_known_points_of_a_camera_that_looks_down_at_45_degrees() -> None:
    # One meter up and one meter back: the origin is in the middle, sqrt(2) m away.
    camera = PinholeCamera(400, 300, Aim(0.0, -1.0, 1.0, np.pi / 4, 100.0), (0.0, 0.0), (0.0, 0.0))
    assert camera.pixels(np.array([0.0, 0.0])) == pytest.approx([200, 150])
    assert camera.pixels(np.array([0.5, 0.0])) == pytest.approx([200 + 50 / np.sqrt(2), 150])
    assert camera.pixels(np.array([0.0, 1.0])) == pytest.approx([200, 150 + 100 / 3])  # (2, -1): up 1, away 3
    assert camera.project(np.array([0.0, 0.0, 1.0])) == pytest.approx([200, 250])  # level with the camera
    assert camera.horizon == pytest.approx(250)
    assert camera.scale == pytest.approx(100 / np.sqrt(2))


@given(PINHOLES, st.tuples(st.floats(-3, 3), st.floats(-1, 3), st.floats(0, 0.4)).map(np.array))
def test_projection_agrees_with_a_homogeneous_matrix(camera, point) -> None:
    x, y, w = matrix(camera) @ [*point, 1.0]
    assume(w > 0.05)
    assert camera.project(point) == pytest.approx([x / w, camera.height - y / w], rel=1e-9, abs=1e-6)


@given(PINHOLES, st.lists(FLOOR, min_size=1, max_size=5).map(np.array))
def test_floor_coordinates_invert_pixel_coordinates(camera, places) -> None:
    assert camera.metres(camera.pixels(places)) == pytest.approx(places, abs=1e-7)


@given(PINHOLES, st.floats(0, 2 * np.pi), st.lists(FLOOR, min_size=2, max_size=4).map(np.array))
def test_parallel_lines_meet_in_one_vanishing_point(camera, angle, places) -> None:
    way = np.array([np.cos(angle), np.sin(angle)])
    assume(way[1] > 0.05)  # away from the camera
    cos, sin = np.cos(camera.aim.tilt), np.sin(camera.aim.tilt)
    expected = camera.aim.focal * np.array([way[0] / (way[1] * cos), sin / cos]) + [640, 360]
    assert camera.pixels(places + 1e9 * way) == pytest.approx(
        np.broadcast_to(expected, places.shape), rel=1e-5, abs=1e-2
    )
    assert expected[1] == pytest.approx(camera.horizon)  # as those of all lines of the floor


@given(PINHOLES, FLOOR, FLOOR)
def test_straight_lines_stay_straight(camera, one, other) -> None:
    first, last = camera.pixels(np.array([one, other]))
    between = camera.pixels(one + np.linspace(0, 1, 9)[:, None] * (other - one)) - first
    across = between[:, 0] * (last - first)[1] - between[:, 1] * (last - first)[0]
    assert np.abs(across).max() <= 1e-6 * max(1.0, float(np.sum((last - first) ** 2)))


@given(PINHOLES, FLOOR)
def test_projected_turns_match_the_derivative_of_pixels(camera, place) -> None:
    step = 1e-5
    moves = np.array([[step, 0], [0, step]])
    slope = (camera.pixels(place + moves) - camera.pixels(place - moves)).T / (2 * step)
    turn = camera.disc_maps(place[None], 3.0)[0]
    assert turn[:2, :2] == pytest.approx(3.0 * slope / camera.scale, rel=1e-4, abs=1e-6)
    assert turn[2].tolist() == [0, 0, 1]


def test_the_robotarium_camera_is_170_cm_up_and_sees_the_whole_arena() -> None:
    camera = framing()
    assert (camera.aim.x, camera.aim.z) == (0.0, 1.7)
    seen = camera.project(np.array([[x, y, up] for x, y in ROBOTARIUM.outline for up in (0.0, 0.1)]))
    assert [seen[:, 0].min(), 1280 - seen[:, 0].max()] == pytest.approx([0.035 * 720] * 2)
    assert seen[:, 1].min() + seen[:, 1].max() == pytest.approx(720)  # as much free above as below
    assert np.ptp(seen[:, 1]) > 2 / 3 * 720  # most of the height, too


def area(camera: PinholeCamera, stage: Rectangle) -> float:
    x, y = camera.pixels(np.array(stage.outline)).T
    return float(abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2 / (camera.width * camera.height))


@pytest.mark.parametrize("stage", [ROBOTARIUM, Rectangle(width=1.2, height=0.8)])
def test_default_distance_shows_the_stage_nearly_as_large_as_any_other(stage) -> None:
    near_edge = stage.height / 2
    others = [area(framing(stage, distance=distance), stage) for distance in np.linspace(near_edge, 4 * near_edge, 25)]
    assert area(framing(stage), stage) > 0.99 * max(others)  # the tilt has a limit, too
    assert area(framing(stage), stage) > 0.4


@pytest.mark.parametrize("size", ["1280x720", "720x1280", "640x640"])
@pytest.mark.parametrize("stage", [ROBOTARIUM, Rectangle(width=1.2, height=0.8), Rectangle(width=0.3, height=2.0)])
def test_every_stage_fills_every_frame_except_for_a_margin(stage, size) -> None:
    camera = framing(stage, 0.03, size)
    margin = 0.035 * min(camera.width, camera.height)
    points = np.array([[x, y, up] for x, y in stage.outline for up in (0.0, 0.03)])
    low, high = camera.project(points).min(axis=0), camera.project(points).max(axis=0)
    free = np.concatenate([low, [camera.width, camera.height] - high])
    assert free.min() == pytest.approx(margin)


def test_camera_keys_set_the_camera() -> None:
    camera = framing(height=2.0, distance=5.0, tilt=20.0, field_of_view=90.0)
    assert camera.aim == pytest.approx((0.0, -5.0, 2.0, np.radians(20), 640.0))


def test_nearest_corner_has_the_most_pixels_per_meter() -> None:
    camera = framing()
    steps = 1e-4 * np.stack([np.cos(np.arange(0, 7, 0.1)), np.sin(np.arange(0, 7, 0.1))], axis=-1)
    for corner in ROBOTARIUM.outline:
        moved = camera.pixels(corner + steps) - camera.pixels(np.array(corner))
        assert np.hypot(*moved.T).max() / 1e-4 < 1.001 * camera.max_scale
    moved = camera.pixels(np.array([-2.15, -1.8]) + steps) - camera.pixels(np.array([-2.15, -1.8]))
    assert np.hypot(*moved.T).max() / 1e-4 == pytest.approx(camera.max_scale, rel=0.01)


def test_a_camera_that_looks_straight_down_sees_no_horizon() -> None:
    assert framing(distance=0.0).horizon == np.inf
