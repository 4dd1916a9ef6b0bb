from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from emovid.errors import InputError, RenderError
from emovid.video import ffmpeg
from emovid.video.encoder import encoder_arguments, write_video
from emovid.video.frame_reader import frame_times, read_frames, read_last_frame
from emovid.video.pixel_formats import Yuv420
from tests.helpers.reference import all_changed

WIDTH, HEIGHT, FRAMES, FPS = 160, 96, 12, 10
GREYS = np.linspace(20, 235, FRAMES).round().astype(np.uint8)


@pytest.fixture(scope="module", params=["mp4", "webm", "gif"])
def video(request, tmp_path_factory) -> Path:
    """Make a video in which each frame has a different gray."""
    target = tmp_path_factory.mktemp("still") / f"greys.{request.param}"
    if request.param == "gif":
        pages = [Image.new("L", (WIDTH, HEIGHT), int(grey)) for grey in GREYS]
        pages[0].save(target, save_all=True, append_images=pages[1:], duration=1000 // FPS)
        return target
    convert = Yuv420(WIDTH, HEIGHT).convert
    pictures = (np.full((HEIGHT, WIDTH, 4), grey, np.uint8) for grey in GREYS)
    planes = (convert(picture, all_changed(picture)) for picture in pictures)
    write_video(planes, FRAMES, encoder_arguments(WIDTH, HEIGHT, FPS, request.param), target)
    return target


def greys(video: Path, times: list[float], size: tuple[int, int] = (40, 24)) -> list[int]:
    film = frame_times(video)
    shown = read_frames(video, film.frames_at(np.array(times)).tolist(), *size)
    assert shown.shape == (len(times), size[1], size[0], 3)
    return shown[:, size[1] // 2, size[0] // 2, 0].tolist()


def test_frame_times_and_size_are_read_from_the_video(video) -> None:
    film = frame_times(video)
    assert film.times == pytest.approx(np.arange(FRAMES) / FPS)
    assert film.end == pytest.approx(FRAMES / FPS)
    assert (film.width, film.height) == (WIDTH, HEIGHT)


def test_each_time_gives_the_frame_shown_at_that_time(video) -> None:
    times = [0.0, 0.1, 0.19, 0.55, 0.3, 0.3, 1.1, 1.2]
    assert greys(video, times) == pytest.approx([int(GREYS[k]) for k in (0, 1, 1, 5, 3, 3, 11, 11)], abs=3)


def test_read_last_frame_equals_read_frames(video) -> None:
    ours = read_frames(video, [FRAMES - 1], 40, 24)[0]
    assert np.abs(read_last_frame(video, FRAMES, FPS, 40, 24).astype(int) - ours).max() <= 1


def test_missing_last_frame_is_reported_with_a_remedy(video, tmp_path) -> None:
    with pytest.raises(RenderError, match=r"greys\.\w+: its last frame cannot be read: make it again with --force"):
        read_last_frame(video, 10 * FRAMES, FPS, 40, 24)
    with pytest.raises(RenderError, match="its last frame cannot be read"):
        read_last_frame(tmp_path, FRAMES, FPS, 40, 24)  # a folder without pictures


def test_ffmpeg_that_cannot_be_started_is_named(video, monkeypatch) -> None:
    monkeypatch.setattr(ffmpeg, "executable", lambda: "/nowhere/ffmpeg")
    with pytest.raises(RenderError, match="ffmpeg cannot be started: /nowhere/ffmpeg: no such file"):
        frame_times(video)


def test_frames_of_another_shape_are_padded_with_white(video) -> None:
    (tall,) = read_frames(video, [0], 40, 48)
    assert (tall[0] == 255).all()
    assert tall[24, 20] == pytest.approx(GREYS[0], abs=3)


@pytest.mark.parametrize("fps", [7, 30, 49, 103, 240])
def test_duration_of_a_three_second_video_is_three_seconds(fps, tmp_path) -> None:
    frame = Yuv420(64, 64).planes
    write_video([frame] * 3 * fps, 3 * fps, encoder_arguments(64, 64, fps), tmp_path / "x.mp4")
    assert frame_times(tmp_path / "x.mp4").end == 3.0


def test_frames_of_unequal_duration_are_supported(tmp_path) -> None:
    pages = [Image.new("L", (64, 64), grey) for grey in (40, 120, 200)]
    pages[0].save(tmp_path / "x.gif", save_all=True, append_images=pages[1:], duration=[100, 700, 200])
    assert frame_times(tmp_path / "x.gif").times == pytest.approx([0, 0.1, 0.8])
    assert greys(tmp_path / "x.gif", [0.05, 0.2, 0.7, 0.9], (64, 64)) == [40, 120, 120, 200]


@pytest.mark.parametrize("name", ["a:b.mp4", "-y", "100 %.mp4", "concat:x.mp4"])
def test_special_characters_in_file_names_are_accepted(name, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.new("L", (64, 64), 90).save(tmp_path / name, "gif")
    assert greys(Path(name), [0.0], (64, 64)) == [90]
    assert (read_last_frame(Path(name), 1, 10, 64, 64) == 90).all()


@pytest.mark.parametrize("data", [b"", b"no video", bytes(5000)])
def test_a_file_that_is_not_a_video_is_refused(data, tmp_path) -> None:
    (tmp_path / "x.mp4").write_bytes(data)
    with pytest.raises(InputError, match=r"x\.mp4: cannot be read as a video"):
        frame_times(tmp_path / "x.mp4")


def test_video_that_disappears_is_reported(tmp_path) -> None:
    with pytest.raises(RenderError, match=r"x\.mp4: its frames cannot be read"):
        read_frames(tmp_path / "x.mp4", [0], 40, 24)
