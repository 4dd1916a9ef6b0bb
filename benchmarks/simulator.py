"""Measure the cost of a control period in the simulator for the shipped scenes of 15 robots, on one core.

1. The law alone, and all of a period: law, command, clearance from the stage and other bodies, motion. The law's time
   is that at the poses of a run, which a swarm goes through on its way from scattered to settled.
2. Many seeds at once: a sweep of measurements in one process and in two.

Processor time, the median of rounds.

Usage: python benchmarks/simulator.py [ITEMS]
"""

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # as the command has it

from processes import Cost, cost

from emovid.scene.behaviour import Coverage, Gaussian
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene
from emovid.swarm.laws import coverage_velocity
from emovid.swarm.simulate import simulate

ROUNDS = 9
COVERAGE, CONTOUR = 5000, 20_000  # limits [1/s]; of coverage, for a Gaussian density
ITEMS = 1000


def seconds(work: Callable[[], object]) -> float:
    """Return the processor time of a call [s]."""
    times = []
    for _ in range(ROUNDS):
        started = time.process_time()
        work()
        times.append(time.process_time() - started)
    return median(times)


def row(emotion: str) -> str:
    """Return the cost of the scene of an emotion."""
    scene = load_scene(emotion)
    run, law = simulate(scene), scene.behaviour
    periods = len(run.commands)
    whole, alone, limit, density = periods / seconds(lambda: simulate(scene)), "", f"{CONTOUR} periods", ""
    if isinstance(law, Coverage):
        points = list(run.poses[:-1, :, :2])
        laws = seconds(lambda: [coverage_velocity(law, scene.stage, p) for p in points])
        alone, limit, density = f"{periods / laws:.0f}", "", type(law.density).__name__.lower()
        limit = f"{COVERAGE} laws" if isinstance(law.density, Gaussian) else ""
    return f"{emotion:<11}{density or 'contour':<10}{alone:>10}{whole:>12.0f}   {limit}"


def sweep(folder: Path, jobs: int, items: int) -> Cost:
    """Return the cost of a sweep of measurements over seeds."""
    file = folder / "sweep.yaml"
    file.write_text(f"only: measure\nscenes: [fear, disgust, anger, happiness]\nseeds: {items // 4}\n")
    command = [sys.executable, "-m", "emovid", "sweep", str(file), "-o", f"jobs-{jobs}", "--jobs", str(jobs), "--quiet"]
    return cost(command, folder)


def main() -> None:
    """Print both tables."""
    items = int(sys.argv[1]) if len(sys.argv) > 1 else ITEMS
    print(f"{'a second:':<21}{'laws':>10}{'periods':>12}   at least")
    for emotion in EMOTIONS:
        print(row(emotion), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        one, two = (sweep(Path(folder), jobs, items) for jobs in (1, 2))
    print(f"\na sweep that measures {items} runs of 15 s: wall time, processor time for each run")
    for jobs, used in ((1, one), (2, two)):
        print(f"--jobs {jobs}{used.wall:>8.0f} s{1000 * used.cpu / items:>8.0f} ms")
    print(f"runs a second of wall time, two processes against one: {one.wall / two.wall:.2f}")


if __name__ == "__main__":
    main()
