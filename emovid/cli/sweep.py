"""`emovid sweep`: many variants of scenes, as videos, trajectories or measurements."""

import json
import os
from pathlib import Path
from typing import Annotated

import typer

from emovid.batch.cache import find_current, make_missing, workers
from emovid.batch.results import TABLE, write_plan, write_summary
from emovid.batch.sweep import items, shard_of
from emovid.batch.sweep_file import find_sweep, read_sweep
from emovid.cli.options import Force, Jobs, Json, Quiet
from emovid.cli.terminal import raise_failures, reporter
from emovid.errors import InputError
from emovid.swarm.simulate import check_start

FOLDER = "sweeps"


def sweep(
    file: Annotated[
        Path,
        typer.Argument(metavar="SWEEP", help="Sweep file, plan.json of another run, or name of a shipped sweep."),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder of the results; made if missing.", show_default=f"{FOLDER}/NAME"),
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
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Make every missing or outdated item of a sweep, and a table of the results.

    Videos also get a contact sheet.

    Examples: emovid sweep sweep.yaml --jobs 2 · emovid sweep sweep.yaml --only measure --shard 3/40
    """
    plan = read_sweep(find_sweep(file), only)
    every = items(plan)
    number, count = shard_of(shard) if shard else (1, 1)
    folder = output or Path(FOLDER) / file.stem
    if folder.exists() and not folder.is_dir():
        raise InputError(f"-o {folder}: is a file; expected a folder")
    work = [item.job(folder, plan.only) for item in every[number - 1 :: count]]
    processes = jobs or os.cpu_count() or 1
    with reporter(len(work), quiet=quiet or as_json, each=False) as report:
        known = {} if force else find_current(work, report)
        missing = [job for job in work if job.target not in known]
        for job in missing:
            check_start(job.scene)
        with workers(min(processes, len(missing)), report.advanced, scheduler if missing else None) as pool:
            write_plan(folder, plan)
            made = make_missing(missing, report, pool)
    done = write_summary(folder, plan, every, processes)
    if as_json:
        failed = {target.name: str(failure) for target, failure in made.failures.items()}
        counts = {"items": len(every), "made": len(made.records), "up_to_date": len(known)}
        typer.echo(json.dumps({"folder": str(folder)} | counts | {"failed": failed}, indent=2))
    elif not quiet:
        typer.echo(f"{folder / TABLE}: {done} of {len(every)} items", err=True)
    raise_failures(made.failures.values(), len(work))
