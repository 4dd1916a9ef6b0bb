"""Frames are streamed: memory does not grow with the length of a video."""

import subprocess
import sys

PEAK = """
import resource, sys
from emovid.cli.main import main
assert main(sys.argv[1:]) == 0
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def peak(target, seconds: int) -> float:
    """Return the peak memory [MB] of rendering this many seconds of four robots, at one megabyte per frame."""
    scene = ["--set", f"duration={seconds}", "--set", "robots=4", "--set", "control_period=0.1"]
    command = ["render", "sadness", *scene, "--size", "640x360", "--fps", "4", "-o", str(target), "-q"]
    done = subprocess.run([sys.executable, "-c", PEAK, *command], capture_output=True, text=True, check=True)
    return int(done.stdout) / (1024 if sys.platform == "linux" else 1024**2)


def test_memory_does_not_grow_with_the_number_of_frames(tmp_path) -> None:
    short, long = (peak(tmp_path / f"{seconds}.mp4", seconds) for seconds in (10, 120))
    frames = 440 * 640 * 360 * 4 / 1e6  # MB of additional frames in the long video
    assert frames > 400
    assert long - short < 20
