"""Claims, mutants and the liveliness of anger on 50 seeds.

Prints the least margin of each claim, the seeds on which a mutant survives, and how nearly anger returns to a former
state within 10 minutes on each platform. With an argument, that many processes at once; by default one a core.
"""

import os
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from emovid.measure.claims import judge
from emovid.measure.convergence import recurrence
from emovid.measure.window import Window
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate
from tests.helpers.mutants import MUTANTS, broken_claims, metrics, uses_seed

SEEDS = range(50)
LONG = 600.0  # s
ALIKE = 0.01  # m
SCENES = tuple((emotion, {}) for emotion in EMOTIONS) + tuple((mutant.emotion, mutant.keys) for mutant in MUTANTS)


def measured(work: tuple[int, int]) -> dict[str, float]:
    """Return the numbers of a scene or mutant with a seed."""
    scene, seed = work
    return metrics(*SCENES[scene], seed)


def least_recurrence(work: tuple[str, int]) -> float:
    """Return the recurrence [m] of anger on a platform with a seed over a long run."""
    place, seed = work
    keys = [Setting("seed", seed, "--seed"), Setting("duration", LONG, "--duration")]
    return recurrence(Window(simulate(load_scene(f"{place}anger", keys)), 0.0, LONG))


def on_all_seeds(found: Iterator[dict[str, float]]) -> list[list[dict[str, float]]]:
    """Return the numbers by scene and seed; a scene without random start has one run for all seeds."""
    return [[next(found) for _ in SEEDS] if uses_seed(*scene) else len(SEEDS) * [next(found)] for scene in SCENES]


def shown_claims(runs: list[list[dict[str, float]]]) -> int:
    """Print the least margin of each claim and return the number of seeds on which one fails."""
    verdicts = [judge(dict(zip(EMOTIONS, (run[i] for run in runs), strict=False))) for i in range(len(SEEDS))]
    worst = [min(SEEDS, key=lambda seed, i=i: verdicts[seed][i].margin) for i in range(len(verdicts[0]))]
    print(f"margin  seed  claim (least margin of {len(SEEDS)} seeds; the claim holds from 1 on)")
    for i, seed in sorted(enumerate(worst), key=lambda at: verdicts[at[1]][at[0]].margin):
        print(f"{min(verdicts[seed][i].margin, 999):6.2f}  {seed:4d}  {verdicts[seed][i].claim}")
    failed = sum(not all(verdict.holds for verdict in found) for found in verdicts)
    print(f"seeds on which a claim fails: {failed} of {len(SEEDS)}\n")
    return failed


def shown_mutants(runs: list[list[dict[str, float]]]) -> int:
    """Print how many claims reject each mutant at least and return the number of runs in which none does."""
    print("rejecting claims (least of the seeds)  survives  mutant")
    survivors = 0
    for mutant, found in zip(MUTANTS, runs[len(EMOTIONS) :], strict=True):
        counts = [
            len(broken_claims(mutant, dict(zip(EMOTIONS, (run[i] for run in runs), strict=False)), found[i]))
            for i in range(len(SEEDS))
        ]
        survivors += counts.count(0)
        print(f"{min(counts):37d}  {counts.count(0):8d}  {mutant}")
    print(f"runs in which a mutant survives: {survivors} of {len(SEEDS) * len(MUTANTS)}\n")
    return survivors


def shown_recurrence(found: Iterable[float]) -> int:
    """Print the least recurrence of anger on each platform and return the number of runs below a centimeter."""
    alike, values = 0, list(found)
    print(f"anger for {LONG:g} s on {len(SEEDS)} seeds: nearest return to a state 3 to 8 control periods before")
    for i, place in enumerate(("simulation", *PLATFORMS)):
        part = values[i * len(SEEDS) : (i + 1) * len(SEEDS)]
        below = sum(value < ALIKE for value in part)
        alike += below
        print(f"{place:<17} {1000 * min(part):6.1f} mm; runs below {1000 * ALIKE:g} mm: {below}")
    return alike


def main() -> None:
    """Print the tables and fail if a claim fails, a mutant survives or anger repeats itself on any seed."""
    processes = int(sys.argv[1]) if len(sys.argv) > 1 else os.cpu_count()
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        work = [(i, s) for i, scene in enumerate(SCENES) for s in (SEEDS if uses_seed(*scene) else SEEDS[:1])]
        runs = on_all_seeds(pool.map(measured, work, chunksize=5))
        failed = shown_claims(runs) + shown_mutants(runs)
        places = ("", *(f"{place}/" for place in PLATFORMS))
        failed += shown_recurrence(pool.map(least_recurrence, product(places, SEEDS)))
    raise SystemExit(bool(failed))


if __name__ == "__main__":
    main()
