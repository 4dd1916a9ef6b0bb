import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from emovid.atomic_io import owner
from emovid.errors import EmovidError, InputError, RenderError
from emovid.video import ffmpeg
from emovid.video.encoder import encoder_arguments, write_pictures, write_video
from emovid.video.ffmpeg import count_frames
from emovid.video.pixel_formats import Yuv420
from tests.helpers.mp4 import decode
from tests.helpers.owners import DEAD, PARENT
from tests.helpers.reference import all_changed

SIZE = (96, 64)


def pictures(count: int) -> list[np.ndarray]:
    """Return frames, each in a single gray of its own."""
    return [np.full((SIZE[1], SIZE[0], 4), [20 + 8 * k] * 3 + [255], np.uint8) for k in range(count)]


def planes(frames: list[np.ndarray]) -> list[np.ndarray]:
    """Return the same frames as YUV planes, the input of the video encoder."""
    height, width = frames[0].shape[:2]
    return [Yuv420(width, height).convert(frame, all_changed(frame)) for frame in frames]


def write(target: Path, count: int = 12, told: int | None = None, **keys: object) -> None:
    write_video(planes(pictures(count)), told or count, encoder_arguments(*SIZE, 10), target, **keys)  # type: ignore[arg-type]


@pytest.fixture
def use_ffmpeg(monkeypatch, tmp_path):
    """Replace ffmpeg by a shell script."""

    def use(script: str) -> None:
        fake = tmp_path / "ffmpeg"
        fake.write_text(f"#!/bin/sh\nreal='{ffmpeg.executable()}'\n{script}\n")
        fake.chmod(fake.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setattr(ffmpeg, "executable", lambda: str(fake))

    return use


def left(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name != "ffmpeg")


def test_frames_are_decoded_in_order(tmp_path) -> None:
    write(tmp_path / "x.mp4")
    frames = decode(tmp_path / "x.mp4", *SIZE)
    assert frames.shape == (12, 64, 96, 3)
    assert frames.mean(axis=(1, 2, 3)) == pytest.approx([20 + 8 * k for k in range(12)], abs=2)


def test_count_frames_is_zero_for_invalid_or_missing_files(tmp_path) -> None:
    write(tmp_path / "x.mp4", count=7)
    assert count_frames(tmp_path / "x.mp4") == 7
    (tmp_path / "bad.mp4").write_bytes(b"no video")
    assert count_frames(tmp_path / "bad.mp4") == 0
    assert count_frames(tmp_path / "none.mp4") == 0


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("cat > /dev/null; exit 0", "wrote 0 of 12 frames"),
        ("head -c 20000 > /dev/null; echo 'disk on fire' >&2; exit 3", "exit status 3: disk on fire"),
        ("exit 1", "exit status 1: no message"),
        ('head -c 40000 | "$real" "$@"; cat > /dev/null', "wrote 4 of 12 frames"),
        ("cat > /dev/null; kill -XFSZ $$", f"exit status -{int(signal.SIGXFSZ)}: file too large: raise the limit"),
        ("cat > /dev/null; kill -KILL $$", "exit status -9: killed$"),
    ],
    ids=["no file", "dies midway", "dies at once", "frames lost", "too large", "killed"],
)
def test_failing_ffmpeg_keeps_the_existing_file(tmp_path, use_ffmpeg, script, message) -> None:
    target = tmp_path / "x.mp4"
    target.write_bytes(b"the old one")
    use_ffmpeg(script)
    with pytest.raises(RenderError, match=message) as failure:
        write(target)
    assert str(failure.value).startswith(f"{target}: ")
    assert target.read_bytes() == b"the old one"
    assert left(tmp_path) == ["x.mp4"]


@pytest.mark.parametrize("count", [0, 100])  # ffmpeg reads nothing, and the frames exceed the buffer of the pipe
def test_an_ffmpeg_that_hangs_is_killed(tmp_path, use_ffmpeg, monkeypatch, count) -> None:
    monkeypatch.setattr(ffmpeg, "IDLE_TIMEOUT", 0.3)
    use_ffmpeg("exec sleep 1000 < /dev/null" if count == 0 else "exec sleep 1000")
    with pytest.raises(RenderError, match="hangs: it did nothing for"):
        write_video(count * [Yuv420(*SIZE).planes], count, encoder_arguments(*SIZE, 10), tmp_path / "x.mp4")
    assert left(tmp_path) == []


def test_missing_ffmpeg_is_reported_with_its_path(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(ffmpeg, "executable", lambda: "/nowhere/ffmpeg")
    with pytest.raises(RenderError, match=r"x\.mp4: ffmpeg cannot be started: /nowhere/ffmpeg: no such file"):
        write(tmp_path / "x.mp4")


def test_without_ffmpeg_the_message_explains_how_to_install_it(monkeypatch) -> None:
    def none() -> str:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(ffmpeg.imageio_ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(RenderError, match="no ffmpeg found: reinstall imageio-ffmpeg, or set IMAGEIO_FFMPEG_EXE"):
        ffmpeg.executable.__wrapped__()  # clears the cached path


def test_ffmpeg_that_cannot_run_is_reported(tmp_path, monkeypatch, use_ffmpeg) -> None:
    monkeypatch.setattr(ffmpeg, "RUN_TIMEOUT", 0.1)
    use_ffmpeg("exec sleep 1000")
    with pytest.raises(RenderError, match=r"ffmpeg does not answer within 0\.1 s: /"):
        count_frames(tmp_path / "x.mp4")
    monkeypatch.setattr(ffmpeg, "executable", lambda: "/nowhere/ffmpeg")
    with pytest.raises(RenderError, match=r"^ffmpeg cannot be started: /nowhere/ffmpeg: no such file"):
        count_frames(tmp_path / "x.mp4")


def test_a_larger_rate_factor_makes_a_smaller_file(tmp_path) -> None:
    noise = np.random.default_rng(0).integers(16, 235, (5, Yuv420(*SIZE).planes.size), np.uint8)
    for crf in (None, 16, 40):
        write_video(list(noise), 5, encoder_arguments(*SIZE, 10, crf=crf), tmp_path / f"{crf}.mp4")
    size = {path.stem: path.stat().st_size for path in tmp_path.iterdir()}
    assert size["None"] == size["16"] > 2 * size["40"]


def test_interrupted_encoding_leaves_no_file(tmp_path) -> None:
    def interrupt(frames: int) -> None:
        if frames == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write(tmp_path / "x.mp4", on_frame=interrupt)
    assert left(tmp_path) == []


def test_a_full_disk_is_reported(tmp_path) -> None:
    # A limit on file sizes stops ffmpeg as a full disk would, without root permissions.
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000));"
        "sys.path.insert(0, sys.argv[1]); from tests.video import test_encoder; import pathlib, emovid.errors\n"
        "try: test_encoder.write(pathlib.Path(sys.argv[2]), 200)\n"
        "except emovid.errors.RenderError as error: print(error); sys.exit(7)"
    )
    target = tmp_path / "x.mp4"
    done = subprocess.run(
        [sys.executable, "-c", code, str(Path(__file__).parents[2]), str(target)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 7, done.stderr
    assert "ffmpeg failed with exit status" in done.stdout
    assert left(tmp_path) == []


def test_a_folder_that_vanishes_is_reported(tmp_path) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()

    def vanish(frames: int) -> None:
        if frames == 3:
            for path in folder.iterdir():
                path.unlink()
            folder.rmdir()

    with pytest.raises(EmovidError, match=r"x\.mp4"):
        write(folder / "x.mp4", on_frame=vanish)


def test_leftovers_of_a_killed_process_are_removed(tmp_path) -> None:
    code = (
        "import os, pathlib, signal, sys; sys.path.insert(0, sys.argv[1]); from tests.video import test_encoder\n"
        "test_encoder.write(pathlib.Path(sys.argv[2]), on_frame=lambda k: os.kill(os.getpid(), signal.SIGKILL))"
    )
    target = tmp_path / "x.mp4"
    done = subprocess.run([sys.executable, "-c", code, str(Path(__file__).parents[2]), str(target)], check=False)
    assert done.returncode == -signal.SIGKILL
    deadline = time.monotonic() + 20
    while not (stale := left(tmp_path)) and time.monotonic() < deadline:
        time.sleep(0.05)  # the orphaned ffmpeg exits when its input ends
    assert len(stale) == 1
    assert stale[0].endswith(".part")
    write(target)
    assert left(tmp_path) == ["x.mp4"]


def test_leftovers_of_a_zombie_process_are_removed(tmp_path) -> None:
    # In a container without an init process, a killed worker remains a zombie: its number exists, but it does not run.
    with subprocess.Popen([sys.executable, "-c", ""]) as ended:
        deadline = time.monotonic() + 20
        while Path(f"/proc/{ended.pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z":
            assert time.monotonic() < deadline
            time.sleep(0.01)
        (tmp_path / f".x.mp4.{owner(ended.pid)}.part").write_bytes(b"")
        write(tmp_path / "x.mp4")
        assert left(tmp_path) == ["x.mp4"]


def test_glob_characters_in_file_names_are_literal(tmp_path) -> None:
    target = tmp_path / "[a]*.mp4"
    bystander = tmp_path / f".a.mp4.{DEAD}.part"
    bystander.write_bytes(b"")
    write(target)
    assert left(tmp_path) == sorted([bystander.name, target.name])


@pytest.mark.parametrize("name", ["2026-11-23T16:10/x.mp4", "concat:x.mp4", "pipe:1.mp4", "-y.mp4", "100 %d.mp4"])
def test_special_characters_in_paths_are_accepted(name, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    target = Path(name)
    target.parent.mkdir(exist_ok=True)
    write(target)
    assert count_frames(target) == 12
    assert left(tmp_path / target.parent) == [target.name]


def test_partial_files_of_a_live_process_are_kept(tmp_path) -> None:
    own = tmp_path / f".x.mp4.{PARENT}.part"
    own.write_bytes(b"")
    write(tmp_path / "x.mp4")
    assert left(tmp_path) == [own.name, "x.mp4"]


@pytest.mark.parametrize(
    ("before", "after"),
    [(["-cpuflags", "0"], []), (["-cpuflags", "sse2"], []), ([], ["asm=0"]), ([], ["asm=sse2"])],
    ids=["no SIMD in ffmpeg", "SSE2 in ffmpeg", "no SIMD in x264", "SSE2 in x264"],
)
def test_bytes_do_not_depend_on_the_processor(tmp_path, before, after) -> None:
    rng = np.random.default_rng(0)
    noise = [np.full((128, 160, 4), 255, np.uint8) for _ in range(15)]
    for k, frame in enumerate(noise):
        frame[20:90, 10 + 4 * k : 70 + 4 * k, :3] = rng.integers(0, 255, (70, 60, 3), np.uint8)
    arguments = encoder_arguments(160, 128, 10)
    noise = planes(noise)
    write_video(noise, 15, arguments, tmp_path / "a.mp4")
    other = [*before, *arguments]
    place = other.index("-x264-params") + 1
    other[place] = ":".join([other[place], *after])
    write_video(noise, 15, other, tmp_path / "b.mp4")
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


@pytest.mark.parametrize("width_of_vectors", ["0", "0x3F"], ids=["no SIMD", "SSE4"])
def test_bytes_of_a_webm_do_not_depend_on_the_processor(tmp_path, monkeypatch, width_of_vectors) -> None:
    arguments = encoder_arguments(*SIZE, 10, "webm")
    write_video(planes(pictures(12)), 12, arguments, tmp_path / "a.webm")
    monkeypatch.setenv("VPX_SIMD_CAPS", width_of_vectors)
    write_video(planes(pictures(12)), 12, ["-cpuflags", "0", *arguments], tmp_path / "b.webm")
    assert (tmp_path / "a.webm").read_bytes() == (tmp_path / "b.webm").read_bytes()


# --- sequences of pictures -------------------------------------------------------------------------------------------


def write_sequence(target: Path, count: int = 12, **keys: object) -> None:
    write_pictures(pictures(count), count, encoder_arguments(*SIZE, 10, "png-sequence"), target, **keys)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["x%d", "10:30"])
def test_png_sequence_holds_the_exact_frames(name, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_sequence(Path(name))
    assert left(tmp_path) == [name]
    assert left(tmp_path / name) == [f"{k:05d}.png" for k in range(12)]
    for k, frame in enumerate(pictures(12)):
        assert np.array_equal(np.asarray(Image.open(tmp_path / name / f"{k:05d}.png")), frame[..., :3])


def test_sequence_replaces_a_longer_sequence_completely(tmp_path) -> None:
    write_sequence(tmp_path / "x", 12)
    write_sequence(tmp_path / "x", 3)
    assert left(tmp_path) == ["x"]
    assert left(tmp_path / "x") == ["00000.png", "00001.png", "00002.png"]


def test_interrupted_sequence_keeps_the_old_one(tmp_path) -> None:
    def interrupt(frames: int) -> None:
        if frames == 5:
            raise KeyboardInterrupt

    write_sequence(tmp_path / "x", 3)
    with pytest.raises(KeyboardInterrupt):
        write_sequence(tmp_path / "x", on_frame=interrupt)
    assert left(tmp_path) == ["x"]
    assert len(left(tmp_path / "x")) == 3


def test_incomplete_sequences_are_reported_with_their_frame_count(tmp_path, use_ffmpeg) -> None:
    use_ffmpeg('head -c 100000 | "$real" "$@"; cat > /dev/null')
    with pytest.raises(RenderError, match=r"x: ffmpeg wrote 4 of 12 frames$"):
        write_sequence(tmp_path / "x")
    assert left(tmp_path) == []


@pytest.mark.parametrize(("name", "message"), [("x", "is a file"), ("x/notes.txt", "holds notes.txt")])
def test_sequence_does_not_replace_other_files(tmp_path, name, message) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("mine")
    with pytest.raises(InputError, match=message):
        write_sequence(tmp_path / "x")
    assert (tmp_path / name).read_text() == "mine"
    assert left(tmp_path) == ["x"]


def test_leftover_sequences_of_a_killed_process_are_removed(tmp_path) -> None:
    stale = tmp_path / f".x.{DEAD}.part"
    stale.mkdir()
    (stale / "00000.png").write_bytes(b"")
    write_sequence(tmp_path / "x", 2)
    assert left(tmp_path) == ["x"]
