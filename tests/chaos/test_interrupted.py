"""Signals to the command, its workers and ffmpeg during rendering."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.helpers.trial import family, hidden, left_of

EMOVID = [sys.executable, "-m", "emovid"]
# A test run in the background may ignore SIGINT, and child processes inherit that.
LISTENING = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler);from emovid.cli.main import run; run()"
)


def start(folder: Path, seconds: int, *arguments: str) -> "subprocess.Popen[str]":
    look = ["--size", "640x360", "--fps", "30", "--set", f"duration={seconds}"]
    command = [sys.executable, "-c", LISTENING, "render", *arguments, "-o", str(folder), *look]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)


def wait_for_ffmpeg(process: "subprocess.Popen[str]", count: int = 1) -> dict[int, str]:
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        running = family(process.pid)
        if sum("libx264" in line for line in running.values()) >= count:
            return running
        assert process.poll() is None, process.stderr and process.stderr.read()
        time.sleep(0.01)
    raise AssertionError("no ffmpeg was started")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("arguments", [["--emotion", "anger"], ["--all", "--jobs", "2"]], ids=["one", "all"])
def test_interrupted_render_keeps_old_files_and_leaves_no_others(tmp_path, sent, code, arguments) -> None:
    (tmp_path / "anger.mp4").write_bytes(b"the old one")
    process = start(tmp_path, 60, *arguments)
    wait_for_ffmpeg(process)
    os.killpg(process.pid, sent)  # as a terminal or a job scheduler does
    said = process.communicate(timeout=60)[1].splitlines()
    assert process.returncode == code, said
    assert all(line.startswith("[") for line in said[:-1]), said
    assert said[-1] == f"{'interrupted' if code == 130 else 'terminated'}: run again to make what is missing"
    assert left_of([process.pid]) == []
    assert hidden(tmp_path) == []
    if arguments[0] == "--emotion":
        assert names(tmp_path) == ["anger.mp4"]
    assert (tmp_path / "anger.mp4").read_bytes() == b"the old one"


def test_video_of_a_killed_worker_is_rendered_by_another(tmp_path) -> None:
    process = start(tmp_path, 6, "--all", "--jobs", "2")
    running = wait_for_ffmpeg(process, count=2)
    os.kill(next(pid for pid, line in running.items() if "spawn_main" in line), signal.SIGKILL)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0
    assert "its worker died, attempt 1; another worker tries again" in said
    assert len([name for name in names(tmp_path) if name.endswith(".mp4")]) == 6
    assert hidden(tmp_path) == []
    assert left_of([process.pid]) == []


def test_interrupt_during_imports_gives_no_traceback() -> None:
    loading = (
        "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); from emovid.__main__ import run;"
        "sys.meta_path.insert(0, type('', (), {'find_spec': lambda *_: signal.raise_signal(signal.SIGINT)})()); run()"
    )
    done = subprocess.run([sys.executable, "-c", loading], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "")
