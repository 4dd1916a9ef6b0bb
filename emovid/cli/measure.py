"""`emovid measure`: descriptors of motion, and the paper's claims held against them."""

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from emovid.cli import completion
from emovid.cli.options import Json, Platform, Quiet, Seed, Set, on_platform, settings
from emovid.errors import InputError, nearest
from emovid.measure.describe import DESCRIPTORS

if TYPE_CHECKING:
    from emovid.measure.claims import Verdict
    from emovid.scene.load import Setting
    from emovid.scene.model import Scene
    from emovid.swarm.trajectory import Trajectory

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
            help="Scenes (.yaml), finished runs (.npz), or emotions.",
            show_default=False,
            autocompletion=completion.runs,
        ),
    ] = None,
    every: Annotated[bool, typer.Option("--all", "-a", help="All six emotions.")] = False,
    gate: Annotated[
        bool, typer.Option("--gate", help="Hold the paper's claims against all six; exit with 1 where one fails.")
    ] = False,
    only: Annotated[
        str | None,
        typer.Option(
            help="Descriptors, or how names begin, with commas between, as in cusps,cost.",
            show_default="all",
            autocompletion=_descriptors,
        ),
    ] = None,
    platform: Platform = None,
    assignments: Set = None,
    seed: Seed = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Also write the descriptors as CSV.", show_default=False)
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Measure how scenes move, and check the paper's claims about them.

    Examples: emovid measure --all --gate · emovid measure my.yaml fear -o measure.csv
    · emovid measure fear.npz --only cusps,cost
    """
    from emovid.cli.terminal import listing
    from emovid.measure.claim_metrics import claim_metrics
    from emovid.measure.claims import exceptions, judge
    from emovid.scene.emotions import EMOTIONS

    every = every or (gate and not sources)
    if every == bool(sources):
        raise InputError("expected scenes to measure, or --all")
    if output and (output.suffix.lower() != ".csv" or output.is_dir()):
        raise InputError(f"-o {output}: expected a file ending in .csv")
    shown = _chosen(only)
    named = list(EMOTIONS) if every else list(dict.fromkeys(sources or []))
    chosen = [on_platform(source, platform) for source in named]
    runs = [_run_of(source, settings(assignments, seed)) for source in chosen]
    emotions = [run.scene.emotion for run in runs]
    if gate and sorted(map(str, emotions)) != sorted(EMOTIONS):
        raise InputError(f"--gate: expected one scene of each emotion; given {', '.join(map(str, emotions))}")
    measured = {}
    with listing(len(chosen), quiet=quiet or as_json) as done:
        for source, run in zip(chosen, runs, strict=True):
            measured[source] = claim_metrics(run.trajectory())
            done(source)
    of_emotion = dict(zip(map(str, emotions), measured.values(), strict=True))
    motors = all(run.scene.robot.limits for run in runs)
    verdicts = judge({name: of_emotion[name] for name in EMOTIONS}, motors=motors) if gate else []
    without_anger = exceptions(motors=motors)
    scenes = {source: {name: values[name] for name in shown} for source, values in measured.items()}
    if output:
        _write_csv(scenes, output)
    if as_json:
        _print_json(scenes, verdicts, without_anger)
    elif not quiet:
        _show(scenes)
        _show_verdicts(verdicts, without_anger)
    if not all(verdict.holds for verdict in verdicts):
        raise typer.Exit(1)


def _chosen(only: str | None) -> list[str]:
    """Return the descriptors that are meant by names and beginnings of names with commas between, in their order."""
    if only is None:
        return list(DESCRIPTORS)
    words = [word.strip() for word in only.split(",")]
    for word in words:
        if not word or not any(name.startswith(word) for name in DESCRIPTORS):
            expected = f"expected descriptors, or how names begin, as in cusps,cost{nearest(word, DESCRIPTORS)}"
            raise InputError(f"--only {only}: {expected}")
    return [name for name in DESCRIPTORS if name in words or name.startswith(tuple(set(words) - DESCRIPTORS.keys()))]


class _Run(NamedTuple):
    scene: "Scene"
    trajectory: "Callable[[], Trajectory]"


def _run_of(source: str, overrides: "Sequence[Setting]") -> _Run:
    """Return a scene and its run, which is made when it is asked for; all that can be wrong with it is found here."""
    from emovid.scene.load import load_scene
    from emovid.swarm.files import is_run, load_trajectory
    from emovid.swarm.simulate import check_start, simulate

    if is_run(source):
        trajectory = load_trajectory(Path(source), overrides)
        return _Run(trajectory.scene, lambda: trajectory)
    scene = load_scene(source, overrides)
    check_start(scene)
    return _Run(scene, lambda: simulate(scene))


def _write_csv(scenes: Mapping[str, Mapping[str, float]], target: Path) -> None:
    """Write one row for each scene and descriptor; a value that does not exist is an empty cell."""
    from emovid.atomic_io import make_folder, writing

    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(("scene", "descriptor", "value", "unit"))
    for scene, values in scenes.items():
        for name, value in values.items():
            rows.writerow((scene, name, "" if isnan(value) else value, DESCRIPTORS[name].unit))
    make_folder(target.parent)
    with writing(target) as file:
        file.write(text.getvalue().encode(errors="backslashreplace"))  # as JSON has a name that is no Unicode


def _print_json(
    scenes: Mapping[str, Mapping[str, float]], verdicts: "Sequence[Verdict]", without_anger: Mapping[str, str]
) -> None:
    from dataclasses import asdict

    from emovid.measure.claims import NOT_APPLIED

    found: dict[str, Any] = {"scenes": scenes, "claims": list(map(asdict, verdicts))}
    if verdicts:
        found["not_applied"] = [{"claim": claim, "source": source} for claim, source in NOT_APPLIED.items()]
        found["without_anger"] = [{"claim": claim, "source": source} for claim, source in without_anger.items()]
    typer.echo(json.dumps(_finite(found), indent=2, allow_nan=False))


def _finite(value: Any) -> Any:
    """Return the value with null for numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return value if not isinstance(value, float) or isfinite(value) else None


def _show(scenes: Mapping[str, Mapping[str, float]]) -> None:
    from rich import box
    from rich.table import Table

    from emovid.cli.terminal import show_table
    from emovid.measure.describe import FAMILIES

    table = Table("descriptor", "unit", box=box.SIMPLE, padding=(0, 1, 0, 0))
    for scene in scenes:
        table.add_column(scene, justify="right", overflow="fold", min_width=9, max_width=_WIDEST)
    for family in FAMILIES.values():
        for name, unit, *_ in family:
            if all(name in values for values in scenes.values()):
                table.add_row(name, unit, *(_number(values[name]) for values in scenes.values()))
        table.add_section()
    show_table(table, heads=2)


def _number(value: float) -> str:
    return "" if isnan(value) else "0" if abs(value) < 1e-12 else f"{value:.3g}"


def _show_verdicts(verdicts: "Sequence[Verdict]", without_anger: Mapping[str, str]) -> None:
    """Print each claim with its source, the numbers that decide it and the verdict, and a line that sums up."""
    from emovid.measure.claims import NOT_APPLIED

    if not verdicts:
        return
    for verdict in verdicts:
        typer.echo(f"{'holds' if verdict.holds else 'FAILS'}  {verdict.claim} ({verdict.source}): {verdict.relation}")
    for claim, source in NOT_APPLIED.items():
        typer.echo(f"not applied by the paper  {claim} ({source})")
    for claim, source in without_anger.items():
        typer.echo(f"not held against anger  {claim} ({source})")
    failed = sum(not verdict.holds for verdict in verdicts)
    typer.echo(f"{len(verdicts) - failed} of {len(verdicts)} claims hold")
