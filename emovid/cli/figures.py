"""`emovid figures`: the paper's figures and tables, from simulated runs and an analysed study."""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli.figure_sources import frames_of, measures_of, study_results
from emovid.cli.options import Json, Quiet, Seed, settings
from emovid.errors import EmovidError, InputError, nearest

if TYPE_CHECKING:
    from emovid.figures.catalogue import Entry
    from emovid.figures.material import Material
    from emovid.scene.load import Setting

FOLDER = Path("figures")
EVERY, FRAMES = "all", "frames"
_DEFAULT_FORMATS = ("pdf", "png", "tex", "md")


def figures(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME", help="Names from --list; all; or frames and a scene or run.", show_default=False
        ),
    ] = None,
    listed: Annotated[bool, typer.Option("--list", "-l", help="Say which figures there are.")] = False,
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder for figures, made if missing.")] = FOLDER,
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--format", help="pdf, png, svg; for tables tex, md too. Can be repeated.", show_default="pdf, png; tex, md"
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
    times: Annotated[
        str | None, typer.Option("--times", help="Of frames, in seconds, as in 0,2,8.", show_default=False)
    ] = None,
    seed: Seed = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Make the paper's figures and tables, ready for print.

    Examples: emovid figures all · emovid figures shapes --format svg · emovid figures frames my.yaml --times 0,2,8
    """
    from emovid.cli.progress import listing
    from emovid.figures.catalogue import CATALOGUE, MEASURES, STUDY, WIDTHS
    from emovid.figures.material import Material
    from emovid.whole_files import writing

    if listed:
        _list(CATALOGUE, as_json=as_json)
        return
    if style is not None and style not in WIDTHS:
        raise InputError(f"--style {style}: expected {' or '.join(WIDTHS)}{nearest(style, WIDTHS)}")
    _check_formats(formats or [])
    overrides, every = settings(None, seed), EVERY in (names or [])
    asked = _in_formats(_asked(names or [], times, overrides, CATALOGUE), formats, strict=not every)
    tables = {STUDY: lambda _: study_results(study), MEASURES: measures_of}
    material = Material(overrides, tables)
    faults = _faults(asked, material)
    if faults and not every:
        raise InputError(": ".join(next(iter(faults.items()))))
    work = {entry: suffixes for entry, suffixes in asked.items() if entry.name not in faults}
    targets = {entry.name: [output / f"{entry.name}.{suffix}" for suffix in work[entry]] for entry in work}
    _make_room(output, [target for group in targets.values() for target in group])
    with listing(len(work), quiet=quiet or as_json) as done:
        for entry, suffixes in work.items():
            made = entry.files(material, suffixes, WIDTHS[style] if style else None)
            for target, data in zip(targets[entry.name], made, strict=True):
                with writing(target) as file:
                    file.write(data)
            done(f"{output / entry.name}: {', '.join(suffixes)}")
    if as_json:
        written = {name: [str(target) for target in group] for name, group in targets.items()}
        typer.echo(json.dumps({"figures": written, "left_out": faults}, indent=2))
    elif not quiet:
        for name, why in faults.items():
            typer.echo(f"{name}: left out: {why}", err=True)


def _list(catalogue: "Mapping[str, Entry]", *, as_json: bool) -> None:
    """Print what there is."""
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
            for entry in catalogue.values()
        ]
        typer.echo(json.dumps(rows, indent=2))
        return
    for entry in catalogue.values():
        typer.echo(f"{entry.name:<27}{entry.paper:<11}{entry.caption}")
    typer.echo(f"{FRAMES + ' SCENE':<27}{'':<11}Snapshots of any scene or finished run, at any --times")


def _asked(
    names: list[str], times: str | None, overrides: "Sequence[Setting]", catalogue: "Mapping[str, Entry]"
) -> "list[Entry]":
    """Return the figures that are meant."""
    if not names:
        raise InputError(f"expected names of figures, {EVERY}, or --list to see them")
    if FRAMES in names:
        return [frames_of([name for name in names if name != FRAMES], times, overrides)]
    if times is not None:
        raise InputError(f"--times goes with {FRAMES} and a scene")
    for name in names:
        if name not in catalogue and name != EVERY:
            close = nearest(name, [*catalogue, EVERY, FRAMES])
            raise InputError(f"{name}: no such figure{close}; --list shows them")
    return list(catalogue.values()) if EVERY in names else [catalogue[name] for name in dict.fromkeys(names)]


def _check_formats(formats: Sequence[str]) -> None:
    from emovid.figures.catalogue import TEXTS
    from emovid.figures.style import FORMATS

    known = (*FORMATS, *TEXTS)
    for format in formats:
        if format not in known:
            raise InputError(f"--format {format}: expected one of {', '.join(known)}{nearest(format, known)}")


def _in_formats(entries: "Sequence[Entry]", formats: Sequence[str] | None, *, strict: bool) -> "dict[Entry, list[str]]":
    """Return the figures with the formats to write them in: those asked for that a figure has, if it has any.

    Raises:
        InputError: in strict mode, for a figure that has none.
    """
    chosen = {
        entry: [format for format in dict.fromkeys(formats or _DEFAULT_FORMATS) if format in entry.formats]
        for entry in entries
    }
    for entry, suffixes in chosen.items():
        if strict and not suffixes:
            asked = " or ".join(formats or ())
            raise InputError(f"{entry.name}: cannot be written as {asked}; expected one of {', '.join(entry.formats)}")
    return {entry: suffixes for entry, suffixes in chosen.items() if suffixes}


def _faults(asked: "Iterable[Entry]", material: "Material") -> dict[str, str]:
    """Return which figures the study has too little for, and why.

    Scenes that cannot start and studies that cannot be read raise their errors here, before anything is written.
    """
    from emovid.swarm.simulate import check_start

    for emotion in dict.fromkeys(emotion for entry in asked for emotion in entry.emotions):
        check_start(material.scene(emotion))
    faults = {}
    for entry in asked:
        for table in entry.tables:
            material.table(table)
            try:
                entry.parts(material)
            except InputError as error:
                faults[entry.name] = str(error)
    return faults


def _make_room(folder: Path, targets: Sequence[Path]) -> None:
    """Make the folder and see that the figures can be written into it."""
    from emovid.whole_files import make_folder

    if folder.exists() and not folder.is_dir():
        raise InputError(f"-o {folder}: is a file; expected a folder")
    try:
        make_folder(folder)
    except EmovidError as error:
        raise InputError(f"-o {error}") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"-o {folder}: cannot be written to")
    for target in targets:
        if target.is_dir():
            raise InputError(f"{target}: is a folder; expected a file that can be replaced")
