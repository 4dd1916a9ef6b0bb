"""Equal trajectories give identical bytes under every setting of the processor."""

import os
import subprocess
import sys

import numpy as np
import pytest

from emovid.swarm.files import save_trajectory
from emovid.swarm.simulate import simulate
from emovid.video import render
from emovid.video.encoder import video_arguments
from emovid.video.render import frames_checksum, render_video

KEYS = {"video.size": "320x240", "video.fps": 10, "duration": 1.5}


@pytest.fixture(scope="module")
def run(make_scene):
    return simulate(make_scene("disgust", KEYS))


@pytest.mark.parametrize(
    ("before", "after"),
    [(["-cpuflags", "0"], ""), ([], ":asm=0"), (["-cpuflags", "0"], ":asm=0")],
    ids=["no SIMD in ffmpeg", "no SIMD in x264", "neither"],
)
def test_video_is_identical_without_vector_instructions(run, tmp_path, monkeypatch, before, after) -> None:
    checksum = render_video(run, tmp_path / "a.mp4")
    arguments = video_arguments(run.scene.video)
    arguments[arguments.index("-x264-params") + 1] += after
    monkeypatch.setattr(render, "video_arguments", lambda *_: [*before, *arguments])
    assert render_video(run, tmp_path / "b.mp4") == checksum
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


DRAW = """
import sys
from pathlib import Path
import numpy as np
from emovid.swarm.files import load_trajectory
from emovid.video.render import frames_checksum
print(np.show_config(mode="dicts")["SIMD Extensions"].get("found", []))
print(frames_checksum(load_trajectory(Path(sys.argv[1]))))
"""


def test_frames_are_identical_without_numpy_vector_instructions(run, tmp_path) -> None:
    found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    assert found, "this processor has none beyond the baseline"
    save_trajectory(run, tmp_path / "run.npz")
    env = {**os.environ, "NPY_DISABLE_CPU_FEATURES": " ".join(found)}
    command = [sys.executable, "-c", DRAW, str(tmp_path / "run.npz")]
    said = subprocess.run(command, env=env, capture_output=True, text=True, check=True).stdout.splitlines()
    assert said == ["[]", frames_checksum(run)]


def test_checksum_covers_all_frames(run, make_scene, tmp_path) -> None:
    assert frames_checksum(run) == render_video(run, tmp_path / "a.mp4")
    other = simulate(make_scene("disgust", KEYS | {"video.colours.stage": "#fafaf6"}))
    assert other.digest() == run.digest()
    assert frames_checksum(other) != frames_checksum(run)
