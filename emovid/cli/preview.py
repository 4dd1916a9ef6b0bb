"""`emovid preview`: a scene at a glance, and again whenever its file is saved."""

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from emovid.cli import completion
from emovid.cli.options import (
    Emotion,
    Platform,
    Quiet,
    Seed,
    Set,
    Source,
    on_platform,
    one_source,
    output_file,
    settings,
)
from emovid.errors import EmovidError, InputError, nearest

if TYPE_CHECKING:
    from emovid.scene.load import Setting
    from emovid.swarm.trajectory import Trajectory

FOLDER = "previews"
_SHEET = "png"
_FORMATS = ("gif", "webm", "mp4", _SHEET)
_WIDTH = 320  # of the loop, and of each picture of a contact sheet [pixels]
_FPS = 10
_ROWS, _COLUMNS = 2, 3  # of a contact sheet
_PAUSE = 0.1  # seconds between two looks at the file


def preview(
    source: Source = None,
    emotion: Emotion = None,
    platform: Platform = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A file in one of the formats, or a folder.", show_default=FOLDER),
    ] = None,
    format: Annotated[
        str | None,
        typer.Option(
            help="gif, webm, mp4; or png: a contact sheet.",
            show_default="as -o ends, or gif",
            autocompletion=completion.words(*_FORMATS),
        ),
    ] = None,
    assignments: Set = None,
    seed: Seed = None,
    watch: Annotated[
        bool, typer.Option("--watch", "-w", help="Make it again whenever the scene is saved, until Ctrl-C.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Show a scene at a glance: a small loop or a contact sheet, within seconds.

    Examples: emovid preview my.yaml --watch · emovid preview --emotion anger --format png -o anger.png
    """
    from emovid.scene.load import find_scene

    chosen = on_platform(one_source(source, emotion), platform)
    file, overrides = find_scene(chosen), settings(assignments, seed)
    target = _target(output, file.stem, format)

    make = partial(_make, chosen, overrides, target, quiet=quiet)
    if watch:
        _make_when_saved(make, file, quiet=quiet)
    make()


def _target(output: Path | None, stem: str, format: str | None) -> Path:
    if format is not None and format not in _FORMATS:
        raise InputError(f"--format {format}: expected one of {', '.join(_FORMATS)}{nearest(format, _FORMATS)}")
    suffixes = [f".{name}" for name in _FORMATS if format in (None, name)]
    others = (*(f".{name}" for name in _FORMATS), ".mov", ".avi", ".mkv", ".jpg", ".pdf")
    return output_file(output, f"{stem}{suffixes[0]}", FOLDER, suffixes, others)


def _make(source: str, overrides: "list[Setting]", target: Path, *, quiet: bool) -> None:
    """Make the preview and say where it is."""
    from emovid.atomic_io import make_folder
    from emovid.cli.progress import counting
    from emovid.scene.load import load_scene
    from emovid.swarm.simulate import check_start, simulate
    from emovid.video.render import reduced, render_video

    started = time.perf_counter()
    scene = load_scene(source, overrides)
    check_start(scene)
    make_folder(target.parent)
    with counting(target.name, quiet=quiet) as on_period:
        run = simulate(scene, on_period)
    format: Any = target.suffix.lower().removeprefix(".")
    if format == _SHEET:
        _write_sheet(reduced(run, _WIDTH, _FPS), target)
    else:
        render_video(reduced(run, _WIDTH, _FPS, format), target)
    if not quiet:
        typer.echo(f"{target}: {scene.duration:g} s, made in {time.perf_counter() - started:.1f} s", err=True)


def _write_sheet(run: "Trajectory", target: Path) -> None:
    """Write pictures of a run at even distances in time, from its start to its end."""
    import numpy as np

    from emovid.figures.contact import contact_figure
    from emovid.figures.style import save
    from emovid.video.painter import Painter

    times, painter = np.linspace(0, run.t[-1], _ROWS * _COLUMNS), Painter(run)
    pictures = np.stack([painter.frame(t)[..., :3].copy() for t in times])
    grid = pictures.reshape(_ROWS, _COLUMNS, *pictures.shape[1:])
    save(contact_figure(grid, captions=[f"{t:.3g} s" for t in times]), target)


def _make_when_saved(make: Callable[[], None], file: Path, *, quiet: bool) -> NoReturn:
    """Call `make` now, and again whenever the file changes, for ever; what is wrong in it becomes a line.

    The file is looked at rather than subscribed to: editors that save by renaming, network folders and all systems
    behave alike, and a look takes microseconds.
    """
    if not quiet:
        typer.echo(f"watching {file}: Ctrl-C ends it", err=True)
    made: tuple[int, ...] = ()
    while True:
        now = _state(file)
        if now and now != made:
            made = now
            try:
                make()
            except EmovidError as error:
                print(error, file=sys.stderr, flush=True)
        time.sleep(_PAUSE)


def _state(file: Path) -> tuple[int, ...]:
    """Return what changes when a file is saved; nothing while an editor replaces it."""
    try:
        found = file.stat()
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino
