import subprocess

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from emovid.swarm.simulate import simulate
from emovid.video import ffmpeg
from emovid.video.canvas import Change
from emovid.video.painter import Painter
from emovid.video.pixel_formats import Yuv420
from tests.helpers.reference import all_changed, exact_planes, whole_frame

SIZES = st.tuples(st.integers(1, 9), st.integers(1, 9)).map(lambda half: (2 * half[0], 2 * half[1]))
PICTURES = SIZES.flatmap(lambda size: arrays.arrays(np.uint8, (*size, 4)))


def planes(converted: np.ndarray, height: int, width: int) -> list[np.ndarray]:
    """Return Y, U and V as pictures."""
    y, u, v = np.split(converted, [height * width, height * width * 5 // 4])
    return [y.reshape(height, width), u.reshape(height // 2, width // 2), v.reshape(height // 2, width // 2)]


def convert(picture: np.ndarray) -> np.ndarray:
    height, width = picture.shape[:2]
    return Yuv420(width, height).convert(picture, all_changed(picture))


@pytest.mark.parametrize(
    ("rgb", "expected"),  # ITU-R BT.709-6, 75 % and 100 % bars as in Rec. ITU-R BT.801
    [((255, 255, 255), (235, 128, 128)), ((0, 0, 0), (16, 128, 128)), ((255, 0, 0), (63, 102, 240)),
     ((0, 255, 0), (173, 42, 26)), ((0, 0, 255), (32, 240, 118)), ((255, 255, 0), (219, 16, 138)),
     ((0, 255, 255), (188, 154, 16)), ((255, 0, 255), (78, 214, 230))],
)  # fmt: skip
def test_pure_colors_match_the_standard(rgb, expected) -> None:
    picture = np.full((4, 6, 4), (*rgb, 255), np.uint8)
    assert [set(plane.ravel().tolist()) for plane in planes(convert(picture), 4, 6)] == [{value} for value in expected]


@pytest.mark.parametrize("level", range(256))
def test_grays_have_neutral_chroma(level) -> None:
    y, u, v = planes(convert(np.full((2, 2, 4), level, np.uint8)), 2, 2)
    assert (u.item(), v.item()) == (128, 128)
    assert y[0, 0] == int(16.5 + 219 * level / 255)


@given(PICTURES)
def test_levels_are_the_rounded_values_of_the_standard(picture) -> None:
    height, width = picture.shape[:2]
    for found, exact in zip(planes(convert(picture), height, width), exact_planes(picture), strict=True):
        assert np.abs(found - exact).max() < 0.51


@given(PICTURES)
def test_conversion_equals_exact_integer_arithmetic(picture) -> None:
    assert np.array_equal(convert(picture), whole_frame(picture))


@given(PICTURES, st.data())
def test_partial_conversion_equals_full_conversion(first, data) -> None:
    height, width = first.shape[:2]
    follower = Yuv420(width, height)
    assert np.array_equal(follower.convert(first, all_changed(first)), whole_frame(first))
    second = first.copy()
    for _ in range(data.draw(st.integers(0, 3))):
        top, bottom = sorted((data.draw(st.integers(0, height)), data.draw(st.integers(0, height))))
        left, right = sorted((data.draw(st.integers(0, width)), data.draw(st.integers(0, width))))
        second[top:bottom, left:right] = data.draw(st.integers(0, 255))
    where = np.flatnonzero((first != second).any(axis=2))
    change = Change(where, all_changed(second).pixels[where])
    assert np.array_equal(follower.convert(second, change), whole_frame(second))


def test_large_pictures_are_converted_in_parts() -> None:
    picture = np.random.default_rng(1).integers(0, 256, (512, 514, 4), np.uint8)
    assert np.array_equal(convert(picture), whole_frame(picture))


@pytest.mark.parametrize("keys", [{}, {"video.theme": "dark", "video.overlays.cells": True}])
def test_ffmpeg_finds_the_same_levels(make_scene, keys) -> None:
    frame = Painter(simulate(make_scene("anger", {"duration": 3} | keys))).frame(2.9)
    height, width = frame.shape[:2]
    conversion = "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+bitexact,format=yuv420p"
    source = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{width}x{height}", "-i", "-"]
    command = [ffmpeg.executable(), "-v", "error", *source, "-vf", conversion, "-f", "rawvideo", "-"]
    theirs = subprocess.run(command, input=frame.tobytes(), capture_output=True, check=True).stdout
    pairs = zip(
        planes(convert(frame), height, width), planes(np.frombuffer(theirs, np.uint8), height, width), strict=True
    )
    difference = [np.abs(a.astype(int) - b) for a, b in pairs]
    assert difference[0].max() <= 1
    blocks = frame.reshape(height // 2, 2, width // 2, 2, 4)
    one = (blocks == blocks[:, :1, :, :1]).all(axis=(1, 3, 4))
    even = one.copy()  # without color changes inside the rows that ffmpeg averages
    for rows in range(1, 4):
        same = one[rows:] & one[:-rows] & (blocks[rows:, 0, :, 0] == blocks[:-rows, 0, :, 0]).all(axis=2)
        even[rows:] &= same
        even[:-rows] &= same
    assert even.mean() > 0.8
    assert max(plane[even].max() for plane in difference[1:]) <= 2
    assert max(plane.mean() for plane in difference[1:]) < 0.1
