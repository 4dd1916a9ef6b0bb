"""Check distances of bodies and walls and the motor limits in the Robotarium scenes on 50 seeds.

Scenes that start on their contour use no seed: one run stands for all. With an argument, that many processes at once;
by default one a core.
"""

import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from typing import NamedTuple

from emovid.platforms.feasibility import TESTBEDS, check_platform
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate

SEEDS = range(50)
_SHOWN = ("between bodies", "from bodies to walls", "time with commands bent by the barrier", "time without a solution")


class Run(NamedTuple):
    """Result of one run: the failed checks, the values to show, and the time of a step [ms]."""

    failed: list[str]
    values: list[float]
    step: float


def run(work: tuple[str, str, int]) -> Run:
    """Run a scene with a seed and return the result."""
    platform, emotion, seed = work
    scene = load_scene(f"{platform}/{emotion}", [Setting("seed", seed, "--seed")])
    started = time.perf_counter()
    trajectory = simulate(scene)
    step = 1000 * (time.perf_counter() - started) / len(trajectory.commands)
    checks = {check.name: check for check in check_platform(trajectory, TESTBEDS[platform])}
    failed = [name for name, check in checks.items() if not check.holds]
    return Run(failed, [float(checks[name].value or 0) for name in _SHOWN], step)


def main() -> None:
    """Print the table and fail if a check fails on any seed."""
    processes = int(sys.argv[1]) if len(sys.argv) > 1 else os.cpu_count()
    print("worst over all seeds       seeds    bodies    walls    bent  no solution  a step   checks failed")
    failures = 0
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        for platform, emotion in product(PLATFORMS, EMOTIONS):
            drawn = load_scene(f"{platform}/{emotion}").start.place != "contour"
            seeds = SEEDS if drawn else SEEDS[:1]
            runs = list(pool.map(run, [(platform, emotion, seed) for seed in seeds]))
            bodies, walls, bent, unsolved = zip(*(each.values for each in runs), strict=True)
            failed = sorted({name for each in runs for name in each.failed})
            failures += len(failed)
            step = sorted(each.step for each in runs)[len(runs) // 2]
            print(
                f"{platform + '/' + emotion:<27}{len(seeds):5}{1000 * min(bodies):7.1f} mm{1000 * min(walls):6.0f} mm"
                f"{max(bent):8.2%}{max(unsolved):13.2%}{step:5.2f} ms   {', '.join(failed) or 'none'}",
                flush=True,
            )
    raise SystemExit(bool(failures))


if __name__ == "__main__":
    main()
