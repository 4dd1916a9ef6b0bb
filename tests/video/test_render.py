from itertools import pairwise

import numpy as np
import pytest
from mp4 import decode

from emovid import load_scene, render_video, simulate
from emovid.swarm.files import load_trajectory, save_trajectory
from emovid.video.draw import Painter
from emovid.video.render import frames, video_arguments

SMALL = {"video.size": "160x120", "video.fps": 10, "duration": 2}


def test_frame_k_shows_the_time_k_over_fps(make_scene) -> None:
    run = simulate(make_scene("anger", SMALL))
    painter = Painter(run)
    for k, frame in enumerate(frames(run)):
        assert np.array_equal(frame, painter.frame(k / 10))
    assert k == 19


def test_two_renders_are_equal_to_the_byte(make_scene, tmp_path) -> None:
    for name in ("a", "b"):
        render_video(simulate(make_scene("anger", SMALL)), tmp_path / f"{name}.mp4")
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_a_saved_run_renders_to_the_same_bytes(make_scene, tmp_path) -> None:
    run = simulate(make_scene("disgust", SMALL))
    save_trajectory(run, tmp_path / "run.npz")
    render_video(run, tmp_path / "a.mp4")
    render_video(load_trajectory(tmp_path / "run.npz"), tmp_path / "b.mp4")
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_the_motion_is_the_same_at_any_frame_rate(make_scene, tmp_path) -> None:
    slow, fast = (make_scene("happiness", SMALL | {"video.fps": fps}) for fps in (5, 10))
    for name, scene in (("slow", slow), ("fast", fast)):
        render_video(simulate(scene), tmp_path / f"{name}.mp4")
    every = decode(tmp_path / "fast.mp4", 160, 120).astype(int)
    half = decode(tmp_path / "slow.mp4", 160, 120).astype(int)
    assert len(every) == 2 * len(half)
    assert np.abs(every[::2] - half).mean() < 1.5


@pytest.mark.parametrize("keys", [{"duration": 0.05}, {"duration": 1.03}, {"duration": 0.999}])
def test_lengths_that_are_no_whole_number_of_frames(make_scene, tmp_path, keys) -> None:
    scene = make_scene("fear", SMALL | keys)
    render_video(simulate(scene), tmp_path / "x.mp4")
    assert len(decode(tmp_path / "x.mp4", 160, 120)) == scene.frames == max(1, round(keys["duration"] * 10))


def test_the_arguments_name_size_and_rate(make_scene) -> None:
    arguments = video_arguments(make_scene("fear", {"video.size": "1920x1080", "video.fps": 60}).video)
    pairs = dict(pairwise(arguments))
    assert (pairs["-s"], pairs["-r"], pairs["-g"], pairs["-threads"]) == ("1920x1080", "60", "60", "1")


def test_the_public_api_is_three_words(tmp_path) -> None:
    scene = load_scene("sadness").model_copy(update={"duration": 0.5})
    render_video(simulate(scene), tmp_path / "x.mp4")
    assert (tmp_path / "x.mp4").stat().st_size > 1000
