"""`emovid figures`: the paper's figures and tables, from simulated runs and an analyzed study."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli import completion
from emovid.cli.options import Force, Json, Quiet, Seed, Set, View, output_folder, settings, whole
from emovid.cli.terminal import listing
from emovid.errors import InputError
from emovid.figures.catalogue import CATALOGUE
from emovid.workflows.figures import ALL, OF_ANY_SCENE, make_figures, plan_figures
from emovid.workflows.gallery import GALLERY
from emovid.workflows.outputs import STDOUT
from emovid.workflows.snapshots import CONTACT, FRAMES, MOST, Moments


def _names(incomplete: str) -> list[str]:
    """Return the matching names of figures, and the matching sources of `frames` and `contact-sheet`."""
    return (
        completion.starting(incomplete, (ALL, *OF_ANY_SCENE, GALLERY, *CATALOGUE))
        + completion.runs(incomplete)
        + completion.files(incomplete, *completion.VIDEOS)
    )


Times = Annotated[
    str | None,
    typer.Option("--times", help="Times of frames or a contact sheet in seconds, as in 0,2,8.", show_default=False),
]
Count = Annotated[
    int | None,
    typer.Option(
        "--count",
        metavar="INTEGER",
        help="Number of times, evenly from start to end.",
        show_default=False,
        parser=whole("--count", 1, MOST),
    ),
]


def figures(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            help="Names from --list; all; gallery; frames and a scene; contact-sheet and a scene or video.",
            show_default=False,
            autocompletion=_names,
        ),
    ] = None,
    listed: Annotated[bool, typer.Option("--list", "-l", help="List the figures.")] = False,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="The folder for figures, created if missing; - prints one as text."),
    ] = Path("figures"),
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--format", help="pdf, png, svg, eps; tables: tex, md. Can be repeated.", show_default="pdf, png; tex, md"
        ),
    ] = None,
    style: Annotated[
        str | None,
        typer.Option("--style", help="Width: one-column or two-column.", show_default="each figure's own"),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option("--study", help="Results of emovid study analyze.", show_default="the reference study"),
    ] = None,
    times: Times = None,
    count: Count = None,
    pairs: Set = None,
    view: View = None,
    seed: Seed = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Make the paper's figures and tables, ready for print.

    Examples: emovid figures all gallery · emovid figures shapes --format svg · emovid figures contact-sheet anger.mp4
    · emovid figures frames my.yaml --times 0,2,8
    """
    if listed:
        _list(as_json=as_json)
        return
    names, formats = names or [], formats or []
    given = {"--times": times is not None, "--count": count is not None, "--set": bool(pairs), "--view": bool(view)}
    _check_options(names, formats, [option for option, is_given in given.items() if is_given])
    overrides = settings(pairs, seed, {"view": view})
    folder = output if output == STDOUT else output_folder(output)
    plan = plan_figures(names, formats, style, study, Moments(times, count), overrides, folder)
    with listing(plan.steps, quiet=quiet or as_json) as done:
        make_figures(plan, done, force=force)
    if as_json:
        written = {name: [str(target) for target in group] for name, group in plan.targets.items()}
        typer.echo(json.dumps({"figures": written, "left_out": plan.left_out}, indent=2))
    elif not quiet:
        for name, why in plan.left_out.items():
            typer.echo(f"{name}: left out: {why}", err=True)


def _check_options(names: Sequence[str], formats: Sequence[str], given: Sequence[str]) -> None:
    """Check that the given options fit the figures, and each other."""
    if given and not set(names) & set(OF_ANY_SCENE):
        raise InputError(f"{given[0]} goes with {' or '.join(OF_ANY_SCENE)}, and a scene")
    if {"--times", "--count"} <= set(given):
        raise InputError("--times and --count: expected one of them")
    if formats and set(names) == {GALLERY}:
        raise InputError(f"{GALLERY}: cannot be written as {' or '.join(formats)}; it is {GALLERY}.html")


def _list(*, as_json: bool) -> None:
    """Print the figures of the catalog, and those of any scene."""
    if as_json:
        rows = [
            {
                "name": entry.name,
                "paper": entry.paper or None,
                "caption": entry.caption,
                "formats": entry.formats,
                "width_in": entry.width,
                "emotions": entry.emotions,
                "tables": entry.tables,
            }
            for entry in CATALOGUE.values()
        ]
        typer.echo(json.dumps(rows, indent=2))
        return
    for entry in CATALOGUE.values():
        typer.echo(f"{entry.name:<27}{entry.paper:<11}{entry.caption}")
    typer.echo(f"{FRAMES + ' SCENE':<27}{'':<11}Snapshots of any scene or finished run, at any --times")
    typer.echo(f"{CONTACT + ' SOURCE':<27}{'':<11}Frames of any video, scene or finished run, with their times")
    typer.echo(f"{GALLERY:<27}{'':<11}All of these, the six videos and their scenes on one page, gallery.html")
