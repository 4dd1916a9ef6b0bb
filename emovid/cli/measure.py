"""`emovid measure`: descriptors of motion, and the paper's claims about them."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from math import isfinite, isnan
from pathlib import Path
from typing import Annotated, Any

import typer
from rich import box
from rich.table import Table

from emovid.cli import completion
from emovid.cli.options import Force, Json, Platform, Quiet, Seed, Set, on_platform, settings
from emovid.cli.terminal import listing, show_table
from emovid.errors import InputError
from emovid.measure.claims import NOT_APPLIED
from emovid.measure.describe import DESCRIPTORS, FAMILIES
from emovid.scene.emotions import EMOTIONS
from emovid.workflows.measuring import Measured, chosen_descriptors, measure_sources, measures_csv
from emovid.workflows.outputs import STDOUT, write_outputs

_WIDEST = 16  # characters of a scene's name in a line of the table's head


def _descriptors(incomplete: str) -> list[str]:
    """Return the matching descriptors, after those that are typed already."""
    before, comma, last = incomplete.rpartition(",")
    return [f"{before}{comma}{name}" for name in completion.starting(last, DESCRIPTORS)]


def measure(
    sources: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENE]...",
            help="Scenes (.yaml), emotions, finished runs (.npz), recorded motion (.track.yaml, .csv).",
            show_default=False,
            autocompletion=completion.runs,
        ),
    ] = None,
    every: Annotated[bool, typer.Option("--all", "-a", help="All six emotions.")] = False,
    gate: Annotated[
        bool, typer.Option("--gate", help="Check the paper's claims about all six; exit with 1 if one fails.")
    ] = False,
    same_rate: Annotated[
        bool, typer.Option("--same-rate", help="Sample the other runs at the times of the recorded motion.")
    ] = False,
    only: Annotated[
        str | None,
        typer.Option(
            help="Descriptors, or beginnings of their names, separated by commas, as in cusps,cost.",
            show_default="all",
            autocompletion=_descriptors,
        ),
    ] = None,
    platform: Platform = None,
    assignments: Set = None,
    seed: Seed = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Also write the descriptors as CSV; - prints only these.", show_default=False
        ),
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Measure how scenes move, and check the paper's claims about them.

    Examples: emovid measure --all --gate · emovid measure my.yaml fear -o measure.csv
    · emovid measure fear.npz --only cusps,cost · emovid measure real.csv anger --same-rate
    """
    every = every or (gate and not sources)
    if every == bool(sources):
        raise InputError("expected scenes to measure, or --all")
    if output not in (None, STDOUT) and (output.suffix.lower() != ".csv" or output.is_dir()):
        raise InputError(f"-o {output}: expected a file ending in .csv")
    if output == STDOUT and as_json:
        raise InputError("-o -: cannot be combined with --json")
    shown = chosen_descriptors(only)
    chosen = [on_platform(source, platform) for source in (EMOTIONS if every else dict.fromkeys(sources or []))]
    with listing(len(chosen), quiet=quiet or as_json) as done:
        found = measure_sources(chosen, settings(assignments, seed), shown, done, gate=gate, same_rate=same_rate)
    if output:  # a name of a scene may be no Unicode
        write_outputs({output: measures_csv(found.scenes).encode(errors="backslashreplace")}, force=force)
    if as_json:
        typer.echo(_json(found))
    elif not quiet and output != STDOUT:
        _show(found)
    if not all(verdict.holds for verdict in found.verdicts):
        raise typer.Exit(1)


def _json(found: Measured) -> str:
    data: dict[str, Any] = {"scenes": found.scenes, "claims": list(map(asdict, found.verdicts))}
    if found.verdicts:
        data["not_applied"] = [{"claim": claim, "source": source} for claim, source in NOT_APPLIED.items()]
        data["without_anger"] = [{"claim": claim, "source": source} for claim, source in found.without_anger.items()]
    return json.dumps(_finite(data), indent=2, allow_nan=False)


def _finite(value: Any) -> Any:
    """Return the value with null for numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return value if not isinstance(value, float) or isfinite(value) else None


def _show(found: Measured) -> None:
    """Print the table of descriptors, what recorded motion lacks, and the claims."""
    table = Table("descriptor", "unit", box=box.SIMPLE, padding=(0, 1, 0, 0))
    for scene in found.scenes:
        table.add_column(scene, justify="right", overflow="fold", min_width=9, max_width=_WIDEST)
    for family in FAMILIES.values():
        for name, unit, *_ in family:
            if all(name in values for values in found.scenes.values()):
                table.add_row(name, unit, *(_number(values[name]) for values in found.scenes.values()))
        table.add_section()
    show_table(table, heads=2)
    for source in found.recorded:
        missing = [name for name, value in found.scenes[source].items() if isnan(value)]
        if missing:
            typer.echo(f"{source}: positions only, without commands and a density; missing: {', '.join(missing)}")
    if found.verdicts:
        _show_verdicts(found)


def _number(value: float) -> str:
    return "" if isnan(value) else "0" if abs(value) < 1e-12 else f"{value:.3g}"


def _show_verdicts(found: Measured) -> None:
    """Print each claim with its source, the deciding numbers and the verdict, and a summary."""
    for verdict in found.verdicts:
        typer.echo(f"{'holds' if verdict.holds else 'FAILS'}  {verdict.claim} ({verdict.source}): {verdict.relation}")
    for claim, source in NOT_APPLIED.items():
        typer.echo(f"not applied by the paper  {claim} ({source})")
    for claim, source in found.without_anger.items():
        typer.echo(f"checked without anger  {claim} ({source})")
    failed = sum(not verdict.holds for verdict in found.verdicts)
    typer.echo(f"{len(found.verdicts) - failed} of {len(found.verdicts)} claims hold")
