"""The long run of the chaos suite (`make chaos`): every fault at many random times, and a table of violations."""

import argparse
import random
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from tests.helpers.data_loss import LOSSES
from tests.helpers.faults import SIGNALS, VICTIMS, at_random, damaged, lasting
from tests.helpers.memory import SIZES, peak
from tests.helpers.sweeps import DaskTrials, Made, five_hundred
from tests.helpers.trial import NAMES, Fault, reference_run, try_fault

_MARK = "<!-- written by make chaos -->"
_DAMAGED, _LOSSES = 10, 75

Row = tuple[str, list[str]]  # a fault, and the violations it caused


def main() -> int:
    """Try all faults, print a line per trial, and write the tables if a file is given; return 1 for any violation."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--moments", type=int, default=200, help="random moments of signals")
    options.add_argument("--seed", type=int, default=20210321)
    options.add_argument("--table", type=Path, help="a file whose tables are replaced")
    given = options.parse_args()
    rng = random.Random(given.seed)  # noqa: S311 - a trial can be repeated
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, violations in _trials(folder, given.moments, rng):
            print(f"[{len(rows) + 1}] {name}: {'; '.join(violations) or 'ok'}", flush=True)
            rows.append((name, violations))
        made, violations = five_hundred(folder)
        rows.append(("a Dask worker lost from a sweep of 500 videos", violations))
        sizes = {name: peak(arguments, folder) for name, arguments in SIZES.items()}
    tables = "\n".join([_faults(rows, given.seed), _sweeps(made), _memory(sizes)])
    print(tables)
    if given.table:
        head, mark, _ = given.table.read_text().partition(_MARK)
        given.table.write_text(f"{head}{mark}\n\n{tables}")
    return int(any(violations for _, violations in rows))


def _trials(folder: Path, moments: int, rng: random.Random) -> Iterator[Row]:
    reference = folder / "reference"
    seconds = reference_run(reference)
    dask = DaskTrials(folder)
    for i in range(moments):
        number, victim = SIGNALS[i % 3], [*VICTIMS, "a Dask worker"][i // 3 % 4]
        if victim == "a Dask worker":
            yield f"{number.name} to a Dask worker", dask.violations(number, rng)
        else:
            yield _tried(at_random(rng, number, victim), reference, seconds)
    for i in range(_LOSSES):
        name = list(LOSSES)[i % len(LOSSES)]
        yield name, LOSSES[name](rng)
    for fault in lasting():
        yield _tried(fault, reference, seconds)
    for i in range(_DAMAGED):
        yield _tried(damaged(rng, "manifest.json" if i % 2 else rng.choice(NAMES)), reference, seconds)


def _tried(fault: Fault, reference: Path, seconds: float) -> Row:
    return fault.name, try_fault(fault, reference, seconds)


def _faults(rows: list[Row], seed: int) -> str:
    cells = []
    for name in dict.fromkeys(name for name, _ in rows):
        found = [len(violations) for other, violations in rows if other == name]
        cells.append((name, len(found), sum(found)))
    total = sum(len(violations) for _, violations in rows)
    cells.append((f"**all** (seed {seed})", f"**{len(rows)}**", f"**{total}**"))
    return _table("| fault | trials | violations |\n|---|---:|---:|", cells)


def _sweeps(made: list[Made]) -> str:
    cells = [(one.how, one.videos, f"`{one.table[:16]}`", f"`{one.files[:16]}`") for one in made]
    return _table(
        "| sweep of 500 | videos | SHA-256 of `results.csv` | of all files and their names |\n|---|---:|---|---|", cells
    )


def _memory(sizes: dict[str, int]) -> str:
    return _table(
        "| video of 320x180 | peak memory |\n|---|---:|", [(name, f"{size} MB") for name, size in sizes.items()]
    )


def _table(head: str, rows: Iterable[tuple[object, ...]]) -> str:
    return "\n".join([head, *("| " + " | ".join(map(str, cells)) + " |" for cells in rows)]) + "\n"


if __name__ == "__main__":
    sys.exit(main())
