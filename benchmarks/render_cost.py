"""Measure the cost of rendering: processor time of whole processes and their children, alternating in one run.

1. `emovid render --emotion anger` against ffmpeg alone, which is handed its very frames, in RGBA, and encodes them with
   the same arguments. What making and handing over those frames costs is not counted.
2. From 15 to 10 000 robots, on a stage that grows with them: simulation, rendering, memory, and how they grow.

Usage: python benchmarks/render_cost.py [ROUNDS]
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from math import log, sqrt
from pathlib import Path
from statistics import median

from processes import ENVIRONMENT, Cost, cost

from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video import ffmpeg
from emovid.video.encoder import video_arguments
from emovid.video.render import frames, frames_checksum, render_video

VIDEOS = (("1280x720", 30), ("1920x1080", 60))
ROBOTS = (15, 150, 1500, 10_000)
RATIO, MEMORY = 1.0, 300.0  # limits: of the ratio, of the largest process [MB]
CONVERSION = "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+bitexact,format=yuv420p,"


def seconds_of(who: int) -> float:
    """Return the processor time of `RUSAGE_SELF`, or of the children that have ended [s]."""
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def emovid_render(size: str, fps: int, folder: Path) -> Cost:
    """Return the cost of a command, including its child processes."""
    command = [sys.executable, "-m", "emovid", "render", "--emotion", "anger", "--size", size, "--fps", str(fps)]
    return cost([*command, "--quiet", "--force", "-o", "ours.mp4"], folder)


def ffmpeg_alone(run: Trajectory, folder: Path) -> float:
    """Return the processor time of ffmpeg, fed with the frames of a run [s]."""
    arguments = video_arguments(run.scene.video)
    arguments[arguments.index("yuv420p")] = "rgba"
    filters = arguments.index("-vf") + 1
    arguments[filters] = CONVERSION + arguments[filters]
    return cost([ffmpeg.executable(), *arguments, "alone.mp4"], folder, (frame.data for frame in frames(run))).cpu


def compare(size: str, fps: int, rounds: int, folder: Path) -> str:
    """Return a row of the first table: medians of rounds; the two alternate in who starts first."""
    run = simulate(load_scene("anger", [Setting("video.size", size, ""), Setting("video.fps", fps, "")]))
    pairs, memory = [], 0.0
    for k in range(rounds):
        alone = ffmpeg_alone(run, folder) if k % 2 else 0.0
        ours = emovid_render(size, fps, folder)
        pairs.append((ours.cpu, alone or ffmpeg_alone(run, folder)))
        memory = max(memory, ours.memory)
    ratios = sorted(ours / alone for ours, alone in pairs)
    ours, alone = (median(column) for column in zip(*pairs, strict=True))
    spread = f"{median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f})"
    times = f"{ours:>10.2f} s{alone:>13.2f} s"
    return f"{f'{size}, {fps} fps':<20}{times}   {spread:<22}{RATIO:.1f}{memory:>8.0f} MB"


def shares(folder: Path) -> str:
    """Return the processor time of each part of rendering anger, measured alone, median of three [s]."""
    scene = load_scene("anger")
    run = simulate(scene)
    modules = "import emovid.cli.main, emovid.batch.cache"
    parts = {
        "start": lambda: cost([sys.executable, "-c", modules]).cpu,
        "simulation": lambda: seconds_here(lambda: simulate(scene)),
        "drawing": lambda: seconds_here(lambda: frames_checksum(run)),
    }
    found = {name: median(part() for _ in range(3)) for name, part in parts.items()}
    before = seconds_of(resource.RUSAGE_CHILDREN)
    video = seconds_here(lambda: render_video(run, folder / "parts.mp4"))
    found |= {"conversion and pipe": video - found["drawing"]}
    found |= {"ffmpeg": seconds_of(resource.RUSAGE_CHILDREN) - before}
    return ", ".join(f"{name} {used:.2f} s" for name, used in found.items())


def seconds_here(work: Callable[[], object]) -> float:
    """Return the processor time that some work takes in this process [s]."""
    before = seconds_of(resource.RUSAGE_SELF)
    work()
    return seconds_of(resource.RUSAGE_SELF) - before


def swarm(robots: int) -> None:
    """Print the cost of a swarm as JSON; runs in its own process, so that its memory can be measured."""
    wide = sqrt(robots / 15)
    keys = {"robots": robots, "stage.width": 1.2 * wide, "stage.height": 0.8 * wide, "duration": 2.0}
    keys |= {"start": {"place": "stage", "min_spacing": 0.06}}
    scene = load_scene("fear", [Setting(key, value, "") for key, value in keys.items()])
    simulate(scene)  # a first time, which imports what large swarms need
    started = time.process_time()
    run = simulate(scene)
    simulated = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        render_video(run, Path(folder) / "x.mp4")
    rendered = time.process_time() - simulated + seconds_of(resource.RUSAGE_CHILDREN)
    peak = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    cost = {"period": (simulated - started) / len(run.commands), "frame": rendered / scene.frames}
    print(json.dumps({**cost, "memory": peak / 1024}))


def swarm_costs() -> list[dict[str, float]]:
    """Return the cost for each number of robots: seconds per control period and per frame, and memory [MB]."""
    costs = []
    for robots in ROBOTS:
        command = [sys.executable, __file__, "--swarm", str(robots)]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=ENVIRONMENT)
        costs.append(json.loads(done.stdout))
    return costs


def main() -> None:
    """Print both tables with the limits."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    print(f"{'anger, 15 s':<20}{'emovid render':>12}{'ffmpeg alone':>14}   {'ratio':<22}limit{'memory':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for size, fps in VIDEOS:
            print(compare(size, fps, rounds, Path(folder)), flush=True)
        print(f"of the first: {shares(Path(folder))}", flush=True)
    costs = swarm_costs()
    print(f"\n{'robots':>6}{'a period':>13}{'a frame':>13}{'memory':>11}   limit")
    for robots, found in zip(ROBOTS, costs, strict=True):
        times = f"{1000 * found['period']:>10.2f} ms{1000 * found['frame']:>10.2f} ms"
        print(f"{robots:>6}{times}{found['memory']:>8.0f} MB   {MEMORY:.0f} MB")
    for what, key in (("simulation", "period"), ("rendering", "frame")):
        steps = zip(pairwise(ROBOTS), pairwise(costs), strict=True)
        exponents = (log(b[key] / a[key]) / log(m / n) for (n, m), (a, b) in steps)
        print(f"{what}: exponents of growth between them {', '.join(f'{e:.2f}' for e in exponents)}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--swarm"]:
        swarm(int(sys.argv[2]))
    else:
        main()
