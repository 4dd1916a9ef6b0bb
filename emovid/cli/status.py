"""`emovid status` and `emovid verify`: check a folder of results."""

import json
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from emovid.batch import check
from emovid.batch.cache import workers
from emovid.cli.options import Jobs, Json
from emovid.cli.terminal import counting

Folder = Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder that emovid render or emovid sweep wrote.")]


def status(folder: Folder, as_json: Json = False) -> None:
    """List what is missing, stale or corrupt in a folder of results.

    Prints a line for each such result; exit with 1 if there is any.

    Example: emovid status sweeps/lk/
    """
    found = check.status(folder)
    _show(found, as_json)
    if any(result.state not in ("current", "unplanned") for result in found):
        raise typer.Exit(1)


def verify(
    folder: Folder,
    again: Annotated[
        bool, typer.Option("--rebuild", help="Rebuild every result in another folder, and name the stage that differs.")
    ] = False,
    jobs: Jobs = None,
    as_json: Json = False,
) -> None:
    """Recompute the hashes of all files that a folder's manifest records.

    Prints a line for each file that differs; exit with 1 if there is any.

    Examples: emovid verify videos/ · emovid verify sweeps/lk/ --rebuild
    """
    if again:
        with counting(folder.absolute().name, quiet=as_json) as tell, workers(jobs or os.cpu_count() or 1) as pool:
            found = check.verify_again(folder, pool, tell or (lambda *_: None))
    else:
        found = check.verify(folder)
    _show(found, as_json)
    if any(result.state not in ("current", "stale", "unplanned") for result in found):
        raise typer.Exit(1)


def _show(found: Sequence[check.Finding], as_json: bool) -> None:
    """Print a line for each result that is not current, and the number of results in each state."""
    counts = Counter(result.state for result in found)
    if as_json:
        wrong = [asdict(result) for result in found if result.state != "current"]
        typer.echo(json.dumps({"counts": counts, "results": wrong}, indent=2))
        return
    for result in found:
        if result.state != "current":
            typer.echo(": ".join(part for part in (result.state, result.name, result.reason) if part))
    typer.echo(f"{len(found)} results: " + ", ".join(f"{count} {state}" for state, count in sorted(counts.items())))
