"""`emovid figures`: the paper's figures and tables, from simulated runs and an analysed study."""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli import completion
from emovid.cli.options import Json, Quiet, Seed, Set, View, settings
from emovid.errors import EmovidError, InputError, nearest
from emovid.workflows.figure_sources import measures_of, study_results
from emovid.workflows.gallery import GALLERY, gallery, steps
from emovid.workflows.snapshots import CONTACT, FRAMES, MOST, Moments, at_times

if TYPE_CHECKING:
    from emovid.figures.catalogue import Entry
    from emovid.figures.run_cache import Material
    from emovid.scene.load import Setting

FOLDER = Path("figures")
EVERY = "all"
OF_ANY = (FRAMES, CONTACT)  # figures of any scene
_DEFAULT_FORMATS = ("pdf", "png", "tex", "md")


def figures(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            help="Names from --list; all; gallery; frames and a scene; contact-sheet and a scene or video.",
            show_default=False,
            autocompletion=completion.figure_names,
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
        str | None,
        typer.Option("--times", help="Of frames or a contact sheet, in seconds, as in 0,2,8.", show_default=False),
    ] = None,
    count: Annotated[
        int | None,
        typer.Option("--count", help="So many times, evenly from start to end.", min=1, max=MOST, show_default=False),
    ] = None,
    pairs: Set = None,
    view: View = None,
    seed: Seed = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Make the paper's figures and tables, ready for print.

    Examples: emovid figures all gallery · emovid figures shapes --format svg · emovid figures contact-sheet anger.mp4
    · emovid figures frames my.yaml --times 0,2,8
    """
    from emovid.atomic_io import writing
    from emovid.cli.progress import listing
    from emovid.figures.catalogue import CATALOGUE, MEASURES, STUDY, WIDTHS
    from emovid.figures.run_cache import Material

    if listed:
        _list(CATALOGUE, as_json=as_json)
        return
    if style is not None and style not in WIDTHS:
        raise InputError(f"--style {style}: expected {' or '.join(WIDTHS)}{nearest(style, WIDTHS)}")
    _check_formats(formats or [])
    names = names or []
    _check_options(names, formats or [], {"--times": times, "--count": count, "--set": pairs, "--view": view})
    overrides, every, page = settings(pairs, seed, {"view": view}), EVERY in names, GALLERY in names
    entries = _of_any(names, Moments(times, count), overrides) or _asked(names, CATALOGUE)
    asked = _in_formats(entries, formats, strict=not every)
    tables = {STUDY: lambda _: study_results(study), MEASURES: measures_of}
    material = Material(overrides, tables)
    faults = _faults({**asked, **dict.fromkeys(CATALOGUE.values() if page else ())}, material)
    named = [] if every else [entry.name for entry in asked if entry.name in faults]
    if named:
        raise InputError(f"{named[0]}: {faults[named[0]]}")
    work = {entry: suffixes for entry, suffixes in asked.items() if entry.name not in faults}
    shown = [entry for entry in CATALOGUE.values() if page and entry.name not in faults]
    targets = {entry.name: [output / f"{entry.name}.{suffix}" for suffix in work[entry]] for entry in work}
    targets |= {GALLERY: [output / f"{GALLERY}.html"]} if page else {}
    _make_room(output, [target for group in targets.values() for target in group])
    with listing(len(work) + (steps(shown) if page else 0), quiet=quiet or as_json) as done:
        for entry, suffixes in work.items():
            made = entry.files(material, suffixes, WIDTHS[style] if style else None)
            for target, data in zip(targets[entry.name], made, strict=True):
                with writing(target) as file:
                    file.write(data)
            done(f"{output / entry.name}: {', '.join(suffixes)}")
        if page:
            data = gallery(material, shown, lambda part: done(f"{output / GALLERY}: {part}"))
            with writing(targets[GALLERY][0]) as file:
                file.write(data)
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
    typer.echo(f"{CONTACT + ' SOURCE':<27}{'':<11}Frames of any video, scene or finished run, with their times")
    typer.echo(f"{GALLERY:<27}{'':<11}All of these, the six videos and their scenes on one page, gallery.html")


def _check_options(names: list[str], formats: Sequence[str], given: "Mapping[str, object]") -> None:
    """Check that options which need a scene have one, those of figures a figure, and times one definition."""
    for option, value in given.items():
        if value is not None and not set(names) & set(OF_ANY):
            raise InputError(f"{option} goes with {' or '.join(OF_ANY)}, and a scene")
    if given["--times"] is not None and given["--count"] is not None:
        raise InputError("--times and --count: expected one of them")
    if formats and set(names) == {GALLERY}:
        raise InputError(f"{GALLERY}: cannot be written as {' or '.join(formats)}; it is {GALLERY}.html")


def _of_any(names: list[str], moments: Moments, overrides: "Sequence[Setting]") -> "list[Entry]":
    """Return the figure of any scene or video, if one is meant."""
    kinds = [name for name in dict.fromkeys(names) if name in (*OF_ANY, EVERY, GALLERY)]
    if not set(kinds) & set(OF_ANY):
        return []
    if len(kinds) > 1:
        raise InputError(f"{' and '.join(kinds)}: expected one of them at a time")
    return [at_times(kinds[0], [name for name in names if name != kinds[0]], moments, overrides)]


def _asked(names: list[str], catalogue: "Mapping[str, Entry]") -> "list[Entry]":
    """Return the figures that are meant."""
    if not names:
        raise InputError(f"expected names of figures, {EVERY}, {GALLERY}, or --list to see them")
    for name in names:
        if name not in (*catalogue, EVERY, GALLERY):
            close = _of_file(name) or nearest(name, [*catalogue, EVERY, GALLERY, *OF_ANY])
            raise InputError(f"{name}: no such figure{close}; --list shows them")
    chosen = catalogue if EVERY in names else dict.fromkeys(name for name in names if name != GALLERY)
    return [catalogue[name] for name in chosen]


def _of_file(name: str) -> str:
    """Return which figure of any scene or video is meant by the name of a file; nothing for another name."""
    suffix = Path(name).suffix.lower()
    kind = FRAMES if suffix in (".yaml", ".yml", ".npz") else CONTACT if suffix in completion.VIDEOS else ""
    return kind and f" (did you mean {kind} {name}?)"


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
    from emovid.atomic_io import make_folder

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
