"""Signals, to the command, to its workers and to ffmpeg, while videos are being made."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

EMOVID = [sys.executable, "-m", "emovid"]
# Who starts the tests in the background may have made SIGINT ignored, and processes inherit that.
LISTENING = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler);from emovid.cli.main import run; run()"
)
LONG = ["--size", "640x360", "--fps", "30"]


def start(folder: Path, *arguments: str) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", LISTENING, "render", *arguments, "-o", str(folder), *LONG]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)


def family(pid: int) -> dict[int, str]:
    """Return the command lines of the descendants of a process, from /proc."""
    parents, lines = {}, {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                lines[int(entry.name)] = (entry / "cmdline").read_text().replace("\0", " ")
            except (OSError, IndexError):
                continue  # it has ended meanwhile
    found: dict[int, str] = {}
    todo = [pid]
    while todo:
        mother = todo.pop()
        children = [child for child, parent in parents.items() if parent == mother]
        found |= {child: lines[child] for child in children}
        todo += children
    return found


def wait_for_ffmpeg(process: "subprocess.Popen[str]", count: int = 1) -> dict[int, str]:
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        running = family(process.pid)
        if sum("libx264" in line for line in running.values()) >= count:
            return running
        assert process.poll() is None, process.stderr and process.stderr.read()
        time.sleep(0.01)
    raise AssertionError("no ffmpeg was started")


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_for_end(pids: Iterator[int] | list[int]) -> None:
    deadline = time.monotonic() + 30
    alive = list(pids)
    while alive and time.monotonic() < deadline:
        alive = [pid for pid in alive if is_alive(pid)]
        time.sleep(0.02)
    assert not alive


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("arguments", [["--emotion", "anger"], ["--all", "--jobs", "2"]], ids=["one", "all"])
def test_an_interrupted_render_leaves_old_files_and_nothing_else(tmp_path, sent, code, arguments) -> None:
    (tmp_path / "anger.mp4").write_bytes(b"the old one")
    process = start(tmp_path, *arguments)
    running = wait_for_ffmpeg(process)
    os.killpg(process.pid, sent)  # as a terminal or a job scheduler does
    said = process.communicate(timeout=60)[1].splitlines()
    assert process.returncode == code
    assert all(line.startswith("[") for line in said[: -1 if code == 130 else None]), said
    if code == 130:
        assert said[-1] == "interrupted: run again to make what is missing"
    wait_for_end(list(running))
    assert [name for name in names(tmp_path) if name.endswith(".part")] == []
    if arguments[0] == "--emotion":
        assert names(tmp_path) == ["anger.mp4"]
    assert (tmp_path / "anger.mp4").read_bytes() == b"the old one"


def test_a_killed_command_leaves_no_process_and_the_next_run_completes(tmp_path) -> None:
    process = start(tmp_path, "--all", "--jobs", "2")
    running = wait_for_ffmpeg(process, count=2)
    process.kill()
    process.communicate()
    wait_for_end(list(running))
    finished = [name for name in names(tmp_path) if name.endswith(".mp4")]
    assert len(finished) < 6
    again = subprocess.run([*EMOVID, "render", "--all", "--jobs", "2", "-o", str(tmp_path), *LONG], check=False)
    assert again.returncode == 0
    assert len([name for name in names(tmp_path) if name.endswith(".mp4")]) == 6
    assert [name for name in names(tmp_path) if name.endswith(".part")] == []


def test_a_killed_ffmpeg_is_a_failure_that_says_so(tmp_path) -> None:
    process = start(tmp_path, "--all", "--jobs", "2")
    running = wait_for_ffmpeg(process)
    os.kill(next(pid for pid, line in running.items() if "libx264" in line), signal.SIGKILL)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 1
    assert "ffmpeg failed with exit status -9" in said.splitlines()[-1]
    wait_for_end(list(running))
    again = subprocess.run([*EMOVID, "render", "--all", "--jobs", "2", "-o", str(tmp_path), *LONG], check=False)
    assert again.returncode == 0
    assert [name for name in names(tmp_path) if name.endswith(".part")] == []


def test_a_killed_worker_loses_its_video_and_another_makes_it(tmp_path) -> None:
    process = start(tmp_path, "--all", "--jobs", "2")
    running = wait_for_ffmpeg(process)
    os.kill(next(pid for pid, line in running.items() if "spawn_main" in line), signal.SIGKILL)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0
    assert "its worker died, attempt 1; another takes over" in said
    assert len([name for name in names(tmp_path) if name.endswith(".mp4")]) == 6
    assert [name for name in names(tmp_path) if name.endswith(".part")] == []
