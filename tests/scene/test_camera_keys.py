from math import degrees, pi, radians

import pytest

from emovid.errors import SourceError
from emovid.scene.stage import Rectangle
from emovid.scene.video import CameraKeys, Video, aim_of, view_faults

GRITSBOTS, ROBOTARIUM = Rectangle(width=1.2, height=0.8), Rectangle(width=4.3, height=3.6)


def video(**keys: float) -> Video:
    return Video(view="perspective", camera=CameraKeys(**keys))


def faults(stage: Rectangle, tallest: float = 0.03, **keys: float) -> list[tuple[str, str]]:
    return list(view_faults(video(**keys), stage, tallest))


@pytest.mark.parametrize("stage", [GRITSBOTS, ROBOTARIUM, Rectangle(width=3.2, height=2.0)])
def test_default_camera_sees_every_stage(stage) -> None:
    assert faults(stage, 0.1) == []
    aim = aim_of(video(), stage, 0.1)
    assert aim.z == 1.7
    assert (
        stage.height / 2 < -aim.y < stage.height / 2 + 1.7
    )  # nearer than the distance that shows the near edge at 45 degrees
    assert radians(45) < aim.tilt <= radians(60) + 1e-9


@pytest.mark.parametrize("keys", [{"tilt": 30.0}, {"field_of_view": 100.0}])
def test_with_a_tilt_or_a_field_of_view_the_camera_sees_the_near_edge_at_45_degrees(keys) -> None:
    assert -aim_of(video(**keys), ROBOTARIUM, 0.1).y == pytest.approx(1.8 + 1.7)


@pytest.mark.parametrize("height", [0.15, 0.5, 1.0, 4.0])
@pytest.mark.parametrize("stage", [GRITSBOTS, ROBOTARIUM, Rectangle(width=0.3, height=2.0)])
def test_default_camera_is_close_to_the_near_edge_and_sees_the_stage(stage, height) -> None:
    distance = -aim_of(video(height=height), stage, 0.03).y
    assert 0 < distance <= stage.height / 2 + height
    before = faults(stage, height=height, distance=stage.height / 2 + height)
    assert before or faults(stage, height=height) == []


def test_a_field_of_view_is_across_the_width() -> None:
    assert aim_of(video(field_of_view=90.0), GRITSBOTS, 0.03).focal == pytest.approx(640)


def test_smallest_field_of_view_in_messages_is_accepted() -> None:
    ((key, message),) = faults(GRITSBOTS, field_of_view=5.0)
    assert key == "video.camera.field_of_view"
    needed = float(message.split("at least ")[1].split(",")[0])
    assert faults(GRITSBOTS, field_of_view=needed) == []
    assert faults(GRITSBOTS, field_of_view=needed - 0.15)


def test_tilt_in_messages_shows_the_stage() -> None:
    ((key, message),) = faults(ROBOTARIUM, tilt=0.0, distance=1.0)
    assert key == "video.camera.tilt"
    about = float(message.split("about ")[1].split(",")[0])
    assert faults(ROBOTARIUM, tilt=about, distance=1.0) == []


def test_a_camera_can_look_straight_down_from_above_the_stage() -> None:
    assert faults(GRITSBOTS, distance=0.0) == []
    assert aim_of(video(distance=0.0), GRITSBOTS, 0.0).tilt == pytest.approx(pi / 2)


def test_a_camera_among_the_robots_is_refused() -> None:
    assert faults(GRITSBOTS, 0.095, height=0.095)[0][0] == "video.camera.height"


def test_camera_with_a_field_of_view_too_wide_for_a_flat_picture_is_refused() -> None:
    ((key, message),) = faults(GRITSBOTS, height=0.05)
    assert key == "video.camera.height"
    assert "at most 150" in message
    assert faults(GRITSBOTS, height=0.05, distance=2.0) == []


def test_overhead_view_does_not_check_the_camera(make_scene) -> None:
    keys = {"video.camera.field_of_view": 2.0}
    assert make_scene("fear", keys).video.view == "overhead"
    with pytest.raises(SourceError, match="2: the stage is not in view"):
        make_scene("fear", keys | {"video.view": "perspective"})


def test_the_corners_of_any_stage_are_in_view_by_default(make_scene) -> None:
    corners = [{"x": 2.0, "y": 1.0}, {"x": 3.0, "y": 1.8}, {"x": 2.94, "y": 1.88}, {"x": 1.95, "y": 1.1}]
    keys = {"stage": {"corners": corners}, "robots": 1, "start": {"place": "stage"}, "video.view": "perspective"}
    scene = make_scene("fear", keys | {"behaviour.separation": None})
    assert degrees(aim_of(scene.video, scene.stage, 0.03).tilt) > 10
