"""`emovid sweep`: many variants of scenes, as videos, trajectories or measurements."""

import json
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from emovid.batch.results import TABLE
from emovid.batch.sweep import Items, shard_of
from emovid.batch.sweep_file import find_sweep, read_sweep
from emovid.cli import completion
from emovid.cli.options import Force, Jobs, Json, Quiet, output_folder
from emovid.cli.terminal import raise_failures, reporter
from emovid.scene.resources import CONFIGS
from emovid.workflows.sweeps import Step, SweepOutcome, SweepRun, check_output, plan_sweep, run_sweep

FOLDER = "sweeps"


def _sweeps(incomplete: str) -> list[str]:
    """Return the matching shipped sweeps, sweep files and plans."""
    shipped = [path.stem for path in sorted((CONFIGS / "sweeps").glob("*.yaml"))]
    return completion.starting(incomplete, shipped) + completion.files(incomplete, ".yaml", ".yml", ".json")


def sweep(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="SWEEP",
            help="Sweep file, plan.json of another run, or name of a shipped sweep.",
            autocompletion=_sweeps,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Folder of the results, created if missing.", show_default=f"{FOLDER}/NAME"
        ),
    ] = None,
    only: Annotated[
        str | None,
        typer.Option(help="Kind of the results: video, trajectory or measure.", show_default="as in the sweep file"),
    ] = None,
    jobs: Jobs = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Dask scheduler, as in tcp://127.0.0.1:8786.", show_default=False),
    ] = None,
    shard: Annotated[
        str | None, typer.Option(metavar="I/N", help="Make one part of the items, as in 3/40.", show_default=False)
    ] = None,
    wait: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS", min=0, help="Time to wait for a worker of the scheduler.", show_default="no limit"
        ),
    ] = None,
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", "-n", help="List the items that would be made or replaced, and why; write nothing."),
    ] = False,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Make every missing or outdated item of a sweep, and a table of the results.

    Videos also get a contact sheet. Files that are up to date get the date of now, for make.

    Examples: emovid sweep sweep.yaml --jobs 2 · emovid sweep sweep.yaml --only measure --shard 3/40
    """
    items = Items(read_sweep(find_sweep(file), only))
    part = shard_of(shard) if shard else (1, 1)
    run = SweepRun(output or Path(FOLDER) / file.stem, part, force, jobs or os.cpu_count() or 1, scheduler, wait)
    check_output(output_folder(run.folder), items)
    if dry_run:
        _show_steps(list(plan_sweep(items, run)), as_json)
        return
    outcome = SweepOutcome(len(items))
    try:
        run_sweep(items, run, partial(reporter, quiet=quiet or as_json, each=False), outcome)
    finally:
        _show_outcome(run.folder, outcome, quiet=quiet, as_json=as_json)
    raise_failures(outcome.made.failures.values(), len(run.numbers(items)))


def _show_steps(steps: Sequence[Step], as_json: bool) -> None:
    """Print a line for each result that would be made, replaced or left, and the number of results for each."""
    counts = Counter(step.action for step in steps)
    if as_json:
        changes = [asdict(step) for step in steps if step.action != "keep"]
        typer.echo(json.dumps({"counts": counts, "results": changes}, indent=2))
        return
    for step in steps:
        if step.action != "keep":
            typer.echo(": ".join(part for part in (step.action, step.name, step.reason) if part))
    typer.echo(
        f"{len(steps)} results: " + ", ".join(f"{count} to {action}" for action, count in sorted(counts.items()))
    )


def _show_outcome(folder: Path, outcome: SweepOutcome, *, quiet: bool, as_json: bool) -> None:
    """Print the number of finished items, if the sweep came as far as to write its table."""
    made = outcome.made
    if outcome.finished is None:
        return
    if as_json:
        failed = {target.name: str(failure) for target, failure in made.failures.items()}
        counts = {"made": len(made.records), "up_to_date": outcome.known + len(made.elsewhere)}
        typer.echo(json.dumps({"folder": str(folder), "items": outcome.items} | counts | {"failed": failed}, indent=2))
    elif not quiet:
        typer.echo(f"{folder / TABLE}: {outcome.finished} of {outcome.items} items", err=True)
