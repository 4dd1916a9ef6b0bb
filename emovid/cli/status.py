"""`emovid status` and `emovid verify`: what is wrong in a folder of results."""

import json
import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli.options import Jobs, Json
from emovid.errors import EmovidError

if TYPE_CHECKING:
    from emovid.batch.check import Found

Folder = Annotated[Path, typer.Argument(metavar="FOLDER", help="That emovid render or emovid sweep has written to.")]


def status(folder: Folder, as_json: Json = False) -> None:
    """List what is missing, stale or corrupt in a folder of results.

    Prints a line for each such result; exit with 1 if there is any.

    Example: emovid status sweeps/lk/
    """
    from emovid.batch.check import status as find

    found = find(folder)
    _show(found, as_json)
    if any(result.state != "current" for result in found):
        raise typer.Exit(1)


def verify(
    folder: Folder,
    again: Annotated[
        bool, typer.Option("--rebuild", help="Make all again, apart, and name the stage that differs.")
    ] = False,
    jobs: Jobs = None,
    as_json: Json = False,
) -> None:
    """Recompute the hashes of all files that a folder's manifest records.

    Prints a line for each file that differs; exit with 1 if there is any.

    Examples: emovid verify videos/ · emovid verify sweeps/lk/ --rebuild
    """
    from emovid.batch.check import rebuild, rebuildable
    from emovid.batch.check import verify as find
    from emovid.batch.make import workers
    from emovid.batch.run import run
    from emovid.cli.progress import counting

    found = {result.name: result for result in find(folder)}
    if again:
        work = rebuildable(folder)
        processes = min(jobs or os.cpu_count() or 1, max(len(work), 1))
        with counting(folder.resolve().name, quiet=as_json) as tell, workers(processes) as pool:
            for done, (what, outcome) in enumerate(run(rebuild, work, pool), start=1):
                if isinstance(outcome, EmovidError):
                    raise outcome
                if found.get(what.name, outcome).state == "current":
                    found[what.name] = outcome
                if tell:
                    tell(done, len(work))
    _show(list(found.values()), as_json)
    if any(result.state not in ("current", "stale") for result in found.values()):
        raise typer.Exit(1)


def _show(found: "Sequence[Found]", as_json: bool) -> None:
    """Print a line for each result that is not as it should be, and how many are in each state."""
    counts = Counter(result.state for result in found)
    if as_json:
        wrong = [result._asdict() for result in found if result.state != "current"]
        typer.echo(json.dumps({"counts": counts, "results": wrong}, indent=2))
        return
    for result in found:
        if result.state != "current":
            typer.echo(": ".join(part for part in (result.state, result.name, result.reason) if part))
    typer.echo(f"{len(found)} results: " + ", ".join(f"{count} {state}" for state, count in sorted(counts.items())))
