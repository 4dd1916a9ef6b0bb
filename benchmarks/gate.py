"""Claims and mutants on each of 50 seeds: the least margin of each claim, and the seeds on which a mutant survives."""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from emovid.measure.claim_metrics import claim_metrics
from emovid.measure.claims import Verdict, judge
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate
from tests.helpers.mutants import MUTANTS, broken_claims

SEEDS = range(50)


def results(seed: int) -> tuple[list[Verdict], list[int]]:
    """Return the verdicts on the shipped scenes with another seed, and for each mutant how many claims it breaks."""
    keys = [Setting("seed", seed, "--seed")]
    measured = {name: claim_metrics(simulate(load_scene(name, keys))) for name in EMOTIONS}
    return judge(measured), [len(broken_claims(mutant, measured, seed)) for mutant in MUTANTS]


def main() -> None:
    """Print both tables and fail if a claim fails or a mutant survives on any seed."""
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool:
        verdicts, broken = zip(*pool.map(results, SEEDS), strict=True)
    worst = [min(SEEDS, key=lambda seed, i=i: verdicts[seed][i].margin) for i in range(len(verdicts[0]))]
    print(f"margin  seed  claim (least margin of {len(SEEDS)} seeds; the claim holds from 1 on)")
    for i, seed in sorted(enumerate(worst), key=lambda at: verdicts[at[1]][at[0]].margin):
        print(f"{verdicts[seed][i].margin:6.2f}  {seed:4d}  {verdicts[seed][i].claim}")
    failed = [seed for seed in SEEDS if not all(verdict.holds for verdict in verdicts[seed])]
    print(f"seeds on which a claim fails: {len(failed)} of {len(SEEDS)}")
    print("least broken  survives  mutant")
    survivors = 0
    for i, mutant in enumerate(MUTANTS):
        counts = [broken[seed][i] for seed in SEEDS]
        survivors += counts.count(0)
        print(f"{min(counts):12d}  {counts.count(0):8d}  {mutant}")
    print(f"runs in which a mutant survives: {survivors} of {len(SEEDS) * len(MUTANTS)}")
    raise SystemExit(bool(failed or survivors))


if __name__ == "__main__":
    main()
