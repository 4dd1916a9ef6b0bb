import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.path import Path

from emovid.scene.emotions import EMOTIONS
from emovid.swarm.simulate import simulate
from emovid.video.canvas import Canvas, Layer, rgba
from emovid.video.painter import Painter
from tests.helpers.reference import inside

WIDTH, HEIGHT = 120, 80
PLACE = st.tuples(st.floats(-30, WIDTH + 30), st.floats(-30, HEIGHT + 30))
LINE = st.lists(PLACE, min_size=2, max_size=20).map(np.array)


def stamp(canvas: Canvas, places: list[tuple[float, float]], size: float) -> None:
    turns = np.repeat(np.diag([size, size, 1.0])[None], len(places), axis=0)
    canvas.stamp([Layer(Path.unit_circle(), rgba(["#ff0000"]))], turns, np.array(places), size)


def test_new_canvas_reports_the_full_frame_as_changed_once() -> None:
    canvas = Canvas(WIDTH, HEIGHT, "#102030")
    assert canvas.changed() == [(0, HEIGHT, 0, WIDTH)]
    assert canvas.changed() == []
    assert (canvas.pixels == [0x10, 0x20, 0x30, 0xFF]).all()


@given(st.lists(LINE, min_size=1, max_size=4), st.floats(0.1, 12))
def test_nothing_changes_outside_the_boxes_of_lines(lines, width) -> None:
    canvas = Canvas(WIDTH, HEIGHT, "#ffffff")
    canvas.changed()
    canvas.lines(lines, rgba(["#000000"]), width)
    touched = (canvas.pixels != 255).any(axis=2)
    assert not (touched & ~inside(canvas.pixels, canvas.changed())).any()


@given(st.lists(PLACE, min_size=1, max_size=5), st.floats(0.1, 15))
def test_nothing_changes_outside_the_boxes_of_stamps(places, size) -> None:
    canvas = Canvas(WIDTH, HEIGHT, "#ffffff")
    canvas.changed()
    stamp(canvas, places, size)
    touched = (canvas.pixels != 255).any(axis=2)
    assert not (touched & ~inside(canvas.pixels, canvas.changed())).any()


@given(st.lists(PLACE, min_size=1, max_size=5), st.lists(LINE, min_size=1, max_size=3))
def test_restored_background_is_identical(places, lines) -> None:
    canvas = Canvas(WIDTH, HEIGHT, "#ffffff")
    stamp(canvas, places, 9.0)
    canvas.keep()
    before = canvas.pixels.copy()
    canvas.lines(lines, rgba(["#00ff00"]), 3.0)
    stamp(canvas, places[::-1], 4.0)
    canvas.restore()
    assert np.array_equal(canvas.pixels, before)


def test_boxes_of_a_long_line_are_small() -> None:
    canvas = Canvas(1000, 1000, "#ffffff")
    canvas.changed()
    canvas.lines([np.column_stack([np.arange(1000.0), np.arange(1000.0)])], rgba(["#000000"]), 2.0)
    assert inside(canvas.pixels, canvas.changed()).mean() < 0.03


def test_full_frame_drawing_gives_a_single_box() -> None:
    canvas = Canvas(WIDTH, HEIGHT, "#ffffff")
    stamp(canvas, [(x, y) for x in range(0, WIDTH, 5) for y in range(0, HEIGHT, 5)], 6.0)
    assert canvas.changed() == [(0, HEIGHT, 0, WIDTH)]


LOOKS = {
    "plain": {},
    "trails that go": {"video.trails.seconds": 0.7},
    "trails that fade": {"video.trails.seconds": 0.7, "video.trails.fade": True, "video.trails.robots": None},
    "overlays": {f"video.overlays.{name}": True for name in ("cells", "targets", "clock")},
}


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("emotion", EMOTIONS)
def test_boxes_contain_all_changes_between_frames(make_scene, emotion, look) -> None:
    painter = Painter(simulate(make_scene(emotion, {"duration": 3.5, "video.size": "640x360"} | LOOKS[look])))
    assert painter.changed() == [(0, 360, 0, 640)]
    before = painter.frame(0.0).copy()
    painter.changed()
    for t in (1 / 30, 0.5, 0.9, 1.1, 1.1, 3.4, 2.0, 0.1):
        after = painter.frame(t)
        differs = (before != after).any(axis=2)
        assert not (differs & ~inside(after, painter.changed())).any(), t
        before = after.copy()
