import re
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from emovid import load_scene, render_video, simulate
from emovid.atomic_io import file_digest
from emovid.swarm.files import load_trajectory, save_trajectory
from emovid.video.encoder import video_arguments
from emovid.video.ffmpeg import count_frames
from emovid.video.painter import Painter
from emovid.video.render import frames, frames_checksum
from tests.helpers.mp4 import decode, stream_line

SMALL = {"video.size": "160x120", "video.fps": 10, "duration": 2}


def test_frame_k_shows_the_run_at_time_k_over_fps(make_scene) -> None:
    run = simulate(make_scene("anger", SMALL))
    painter = Painter(run)
    for k, frame in enumerate(frames(run)):
        assert np.array_equal(frame, painter.frame(k / 10))
    assert k == 19


def test_a_window_and_another_speed_show_the_same_run(make_scene) -> None:
    keys = {"video.begin": 0.4, "video.end": 1.6, "video.speed": 2}
    run = simulate(make_scene("anger", SMALL | keys))
    painter = Painter(run)
    for k, frame in enumerate(frames(run)):
        assert np.array_equal(frame, painter.frame(0.4 + 2 * k / 10))
    assert k == 5  # 1.2 s of the run in 0.6 s
    assert run.digest() == simulate(make_scene("anger", SMALL)).digest()


def test_two_renders_give_identical_bytes(make_scene, tmp_path) -> None:
    for name in ("a", "b"):
        render_video(simulate(make_scene("anger", SMALL)), tmp_path / f"{name}.mp4")
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_a_saved_run_renders_to_the_same_bytes_as_its_scene(make_scene, tmp_path) -> None:
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
def test_fractional_frame_counts_are_rounded_to_at_least_one(make_scene, tmp_path, keys) -> None:
    scene = make_scene("fear", SMALL | keys)
    render_video(simulate(scene), tmp_path / "x.mp4")
    assert len(decode(tmp_path / "x.mp4", 160, 120)) == scene.frames == max(1, round(keys["duration"] * 10))


def test_ffmpeg_arguments_contain_size_and_rate(make_scene) -> None:
    arguments = video_arguments(make_scene("fear", {"video.size": "1920x1080", "video.fps": 60}).video)
    pairs = dict(pairwise(arguments))
    assert (pairs["-s"], pairs["-r"], pairs["-g"], pairs["-threads"]) == ("1920x1080", "60", "60", "1")


def test_three_public_functions_render_a_scene(tmp_path) -> None:
    scene = load_scene("sadness").model_copy(update={"duration": 0.5})
    render_video(simulate(scene), tmp_path / "x.mp4")
    assert (tmp_path / "x.mp4").stat().st_size > 1000


def test_checksum_covers_the_drawn_frames(make_scene, tmp_path) -> None:
    def checksum(**keys: object) -> str:
        return render_video(simulate(make_scene("anger", SMALL | keys)), tmp_path / "x")

    plain = checksum()
    assert plain == checksum(**{"video.format": "gif"}) == frames_checksum(simulate(make_scene("anger", SMALL)))
    later = {"video.colours.trails": ["#1684ea", "#e15319", "#005432", "#c25d96", "#3d00e5"]}
    others = [checksum(**keys) for keys in ({"seed": 2}, {"video.overlays.clock": True}, {"duration": 1.9}, later)]
    assert len({plain, *others}) == 5


# --- formats ---------------------------------------------------------------------------------------------------------

FILES = ("mp4", "webm", "gif")


def rendered(make_scene, target, format: str, **keys: object):
    run = simulate(make_scene("anger", SMALL | {"video.format": format} | keys))
    render_video(run, target)
    return run


@pytest.mark.parametrize("format", FILES)
def test_every_format_shows_every_frame_at_its_time(make_scene, tmp_path, format) -> None:
    run = rendered(make_scene, tmp_path / "x", format)
    assert count_frames(tmp_path / "x") == 20
    shown = decode(tmp_path / "x", 160, 120).astype(int)
    wanted = np.stack([frame[..., :3].astype(int) for frame in frames(run)])
    error = np.abs(shown[:, None] - wanted).mean(axis=(2, 3, 4))
    assert (error.argmin(axis=1) == range(20)).all()
    assert error.diagonal().max() < 2.5
    assert " 10 fps" in stream_line(tmp_path / "x")


@pytest.mark.parametrize("format", [*FILES, "png-sequence"])
def test_every_format_renders_to_identical_bytes_twice(make_scene, tmp_path, format) -> None:
    for name in ("a", "b"):
        rendered(make_scene, tmp_path / name, format)
    assert file_digest(tmp_path / "a") == file_digest(tmp_path / "b")


def test_image_sequence_holds_the_exact_frames(make_scene, tmp_path) -> None:
    run = rendered(make_scene, tmp_path / "x", "png-sequence")
    for k, frame in enumerate(frames(run)):
        assert np.array_equal(np.asarray(Image.open(tmp_path / "x" / f"{k:05d}.png")), frame[..., :3]), k
    assert len(list((tmp_path / "x").iterdir())) == k + 1 == 20


def test_webm_has_all_color_tags_and_no_identifying_metadata(make_scene, tmp_path) -> None:
    rendered(make_scene, tmp_path / "x", "webm")
    assert "yuv420p(tv, bt709, progressive)" in stream_line(tmp_path / "x")
    data = (tmp_path / "x").read_bytes()
    assert not [word for word in (b"anger", b"emovid", b"2026", b"v1.") if word in data.lower()]
    assert b"Lavf" in data
    assert not re.search(rb"Lav[fc][0-9]", data)  # without their versions


def test_gif_keeps_the_drawn_colors(make_scene, tmp_path) -> None:
    run = rendered(make_scene, tmp_path / "x", "gif")
    colours = run.scene.video.palette
    with Image.open(tmp_path / "x") as gif:
        assert gif.info["loop"] == 0
        shown = np.asarray(gif.convert("RGB"))
    for place, colour in (((2, 2), colours.surround), ((20, 80), colours.stage)):
        assert tuple(shown[place]) == tuple(bytes.fromhex(colour[1:]))
