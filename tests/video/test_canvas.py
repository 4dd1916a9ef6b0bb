import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.path import Path

from emovid.scene.emotions import EMOTIONS
from emovid.swarm.simulate import simulate
from emovid.video.canvas import Canvas, Layer, rgba
from emovid.video.painter import Painter

WIDTH, HEIGHT = 120, 80
PLACE = st.tuples(st.floats(-30, WIDTH + 30), st.floats(-30, HEIGHT + 30))
LINE = st.lists(PLACE, min_size=2, max_size=20).map(np.array)


def stamp(canvas: Canvas, places: list[tuple[float, float]], size: float) -> None:
    turns = np.repeat(np.diag([size, size, 1.0])[None], len(places), axis=0)
    canvas.stamp([Layer(Path.unit_circle(), rgba(["#ff0000"]))], turns, np.array(places))


def test_new_canvas_reports_the_full_frame_as_changed_once() -> None:
    canvas = Canvas(WIDTH, HEIGHT, "#102030")
    assert canvas.changed().where.tolist() == list(range(WIDTH * HEIGHT))
    assert canvas.changed().where.tolist() == []
    assert (canvas.pixels == [0x10, 0x20, 0x30, 0xFF]).all()


@given(st.lists(PLACE, min_size=1, max_size=5), st.lists(LINE, min_size=1, max_size=4), st.floats(0.1, 15))
def test_changes_are_the_differences_from_the_last_picture(places, lines, width) -> None:
    canvas = Canvas(WIDTH, HEIGHT, "#ffffff")
    canvas.changed()
    for draw in (
        lambda: canvas.lines(lines, rgba(["#000000"]), width),
        lambda: stamp(canvas, places, width),
        canvas.restore,
    ):
        before = canvas.pixels.copy()
        draw()
        changed = canvas.changed()
        assert changed.where.tolist() == np.flatnonzero((canvas.pixels != before).any(axis=2)).tolist()
        assert np.array_equal(changed.pixels.view(np.uint8).reshape(-1, 4), canvas.pixels.reshape(-1, 4)[changed.where])


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


LOOKS = {
    "plain": {},
    "trails that go": {"video.trails.seconds": 0.7},
    "trails that fade": {"video.trails.seconds": 0.7, "video.trails.fade": True, "video.trails.robots": None},
    "overlays": {f"video.overlays.{name}": True for name in ("cells", "targets", "clock")},
}


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("emotion", EMOTIONS)
def test_changes_between_frames_make_one_of_the_other(make_scene, emotion, look) -> None:
    painter = Painter(simulate(make_scene(emotion, {"duration": 3.5, "video.size": "640x360"} | LOOKS[look])))
    followed = np.zeros(640 * 360, np.uint32)
    for t in (0.0, 1 / 30, 0.5, 0.9, 1.1, 1.1, 3.4, 2.0, 0.1):
        frame, changed = painter.frame(t), painter.changed()
        followed[changed.where] = changed.pixels
        assert np.array_equal(followed.view(np.uint8), frame.reshape(-1)), t
