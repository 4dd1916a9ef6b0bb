"""Memory use of long videos and large swarms: frames are streamed, not kept."""

import subprocess
import sys
from pathlib import Path

PEAK = """
import resource, sys
from emovid.cli.main import main
assert main(sys.argv[1:]) == 0
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def _happiness(seconds: int) -> tuple[str, ...]:
    return ("happiness", "--fps", "10", "--set", f"duration={seconds}")


SIZES = {
    "15 robots, 10 s": _happiness(10),
    "15 robots, ten minutes": _happiness(600),
    "15 robots, one hour": _happiness(3600),
    "10 000 robots, 2 s": (
        *("anger", "--fps", "5", "--set", "duration=2", "--set", "robots=10000"),
        *("--set", "stage.width=30", "--set", "stage.height=20", "--set", "behaviour.density.sigma=2"),
    ),
}


def peak(arguments: tuple[str, ...], folder: Path) -> int:
    """Return the peak memory of the command alone, without its ffmpeg [MB]."""
    render = ["render", *arguments, "--size", "320x180", "--quiet", "-o", str(folder)]
    done = subprocess.run([sys.executable, "-c", PEAK, *render], stdout=subprocess.PIPE, text=True, check=True)
    return int(done.stdout.splitlines()[-1]) // (1024 if sys.platform == "linux" else 1024**2)
