"""External videos as stimuli: acceptance and encoding."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from emovid.errors import RenderError, SourceError
from emovid.kit.external_videos import check_video, grain, reencode
from emovid.kit.study import Look
from emovid.video import ffmpeg

LOOK = Look(size="160x90", fps=10, duration=1.0)


@pytest.fixture
def video(fresh, tmp_path, monkeypatch) -> Path:
    """Put a video in the working folder."""
    monkeypatch.chdir(tmp_path)
    source = next((fresh / "public" / "videos").iterdir())
    return Path(shutil.copy(source, "recorded.mp4"))


def changed(video: Path, *options: str | bytes, before: tuple[str, ...] = ()) -> Path:
    """Return the video re-encoded as by another program."""
    target = Path("changed.mp4")
    subprocess.run(
        [ffmpeg.executable(), "-v", "error", *before, "-i", video.absolute(), *options, "-y", target], check=True
    )
    return target


def luma(video: Path) -> np.ndarray:
    command = [ffmpeg.executable(), "-v", "error", "-i", video, "-f", "rawvideo", "-pix_fmt", "gray", "-"]
    data = subprocess.run(command, capture_output=True, check=True).stdout
    return np.frombuffer(data, np.uint8).reshape(-1, 90, 160).astype(int)


def test_external_video_may_have_any_name_and_title(video) -> None:
    check_video(video, LOOK)
    check_video(video.rename("10:30.mp4"), LOOK)  # there is no protocol called 10
    check_video(changed(Path("10:30.mp4"), "-c", "copy", "-metadata", b"title=\xe9t\xe9"), LOOK)  # Latin-1


@pytest.mark.parametrize(
    ("before", "options", "message"),
    [
        (("-display_rotation", "90"), ("-c", "copy"), "has 90x160, 10 fps, 10 frames; expected 160x90, 10 fps"),
        ((), ("-vf", "setsar=4/3"), "has pixels of 4:3; expected square pixels"),
        ((), ("-r", "5"), r"has 160x90, 5 fps, \d frames; expected 160x90, 10 fps, 10 frames"),
        ((), ("-frames:v", "9"), "has 160x90, 10 fps, 9 frames; expected"),
    ],
    ids=["recorded upright", "pixels", "rate", "length"],
)
def test_video_that_differs_visibly_from_the_others_is_refused(video, before, options, message) -> None:
    with pytest.raises(SourceError, match=message):
        check_video(changed(video, *options, before=before), LOOK)


def test_a_file_that_is_not_a_video_is_refused(tmp_path) -> None:
    sound = tmp_path / "sound.wav"
    subprocess.run([ffmpeg.executable(), "-v", "error", "-f", "lavfi", "-i", "sine=duration=1", str(sound)], check=True)
    for path in (sound, Path(__file__)):
        with pytest.raises(SourceError, match="cannot be decoded as a video"):
            check_video(path, LOOK)
    with pytest.raises(SourceError, match="no such file"):
        check_video(tmp_path / "none.mp4", LOOK)


def test_encoding_keeps_the_picture_and_removes_sound_and_title(video) -> None:
    sounding = changed(video, "-f", "lavfi", "-i", "sine=duration=1", "-metadata", "title=fear", "-c:v", "copy")
    reencode(sounding, Path("out.mp4"), LOOK, 5)
    before, after = luma(video), luma(Path("out.mp4"))
    assert before.shape == after.shape == (10, 90, 160)
    assert np.abs(before - after).mean() < 1.5  # of which the lowest bit in half the squares is 0.5
    assert (before != after).any()
    data = Path("out.mp4").read_bytes()
    assert b"fear" in sounding.read_bytes()
    assert b"fear" not in data
    assert b"soun" not in data  # the type of an audio track


def test_video_named_like_a_protocol_is_encoded(video) -> None:
    reencode(video, Path("out.mp4"), LOOK, 5)
    reencode(video.rename("10:30.mp4"), Path("again.mp4"), LOOK, 5)
    assert Path("again.mp4").read_bytes() == Path("out.mp4").read_bytes()


def test_grain_consists_of_squares_and_depends_on_the_seed() -> None:
    found = grain(100, 50, 7)
    assert found.shape == (50, 100)
    assert set(np.unique(found)) == {0, 1}
    corners = found[::16, ::16]
    assert np.array_equal(found, corners.repeat(16, axis=0).repeat(16, axis=1)[:50, :100])
    assert np.array_equal(found, grain(100, 50, 7))
    assert not np.array_equal(found, grain(100, 50, 8))
    assert 0.45 < grain(1280, 720, 7).mean() < 0.55


def test_decoder_that_stops_within_a_frame_is_an_error_and_writes_no_video(video, monkeypatch) -> None:
    failing = Path("failing").absolute()
    failing.write_text("#!/bin/sh\nhead -c 1000 /dev/zero\n")
    failing.chmod(0o755)
    monkeypatch.setattr("emovid.video.ffmpeg.executable", lambda: str(failing))
    with pytest.raises(RenderError, match=r"recorded\.mp4: cannot be decoded to its end"):
        reencode(video, Path("out.mp4"), LOOK, 5)
    assert not Path("out.mp4").exists()
