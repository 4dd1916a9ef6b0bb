"""`emovid render`, `preview` and `simulate`: scenes to videos, previews and trajectories."""

import json
import sys
import time
import webbrowser
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from emovid.batch import manifest
from emovid.cli import completion
from emovid.cli.options import (
    Duration,
    Emotion,
    Force,
    Jobs,
    Json,
    Platform,
    Quiet,
    Seed,
    Set,
    Source,
    View,
    on_platform,
    one_source,
    output_file,
    settings,
    warn_of,
    whole,
)
from emovid.cli.terminal import counting, raise_failures, reporter
from emovid.errors import EmovidError, InputError, nearest
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, find_scene, load_scene
from emovid.swarm.files import SUFFIXES, write_trajectory
from emovid.swarm.simulate import check_start
from emovid.swarm.simulate import simulate as simulate_scene
from emovid.video.encoder import FORMATS, check_sequence
from emovid.workflows import rendering
from emovid.workflows.outputs import STDOUT, write_output
from emovid.workflows.preview import SHEET, make_when_saved, write_preview

_PREVIEWS = ".gif", ".webm", ".mp4", SHEET
_PREVIEW_FORMATS = tuple(suffix.removeprefix(".") for suffix in _PREVIEWS)

Sources = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[SCENE]...",
        help="Scenes (.yaml), finished runs (.npz), or emotions.",
        show_default=False,
        autocompletion=completion.runs,
    ),
]
AllSix = Annotated[bool, typer.Option("--all", "-a", help="All six emotions, and a random order to show them in.")]
VideoOutput = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="A folder, created if missing, or a file in .mp4, .webm or .gif.",
        show_default=str(rendering.FOLDER),
    ),
]
Size = Annotated[str | None, typer.Option(metavar="WxH", help="Pixels, as in 1920x1080.", show_default=False)]
Fps = Annotated[
    int | None,
    typer.Option(
        metavar="INTEGER",
        help="Frames per second; the motion does not change.",
        show_default=False,
        parser=whole("--fps", 1),
    ),
]
Format = Annotated[
    str | None,
    typer.Option(
        help="mp4, webm, gif, or png-sequence: a folder of pictures.",
        show_default="as -o ends, or mp4",
        autocompletion=completion.words(*FORMATS),
    ),
]
Speed = Annotated[
    str | None,
    typer.Option(
        "--speed", metavar="NUMBER", help="Playback speed; 2 shows a run in half its time.", show_default=False
    ),
]
Begin = Annotated[
    str | None,
    typer.Option("--from", metavar="SECONDS", help="Time of the run at which the video begins.", show_default=False),
]
End = Annotated[
    str | None,
    typer.Option("--to", metavar="SECONDS", help="Time of the run at which the video ends.", show_default=False),
]
Theme = Annotated[
    str | None,
    typer.Option(help="light or dark.", show_default=False, autocompletion=completion.words("light", "dark")),
]
Overlay = Annotated[
    list[str] | None,
    typer.Option(
        "--overlay",
        help="Also show density, cells, targets or clock.",
        show_default=False,
        autocompletion=completion.words("density", "cells", "targets", "clock"),
    ),
]


def render(
    sources: Sources = None,
    emotion: Emotion = None,
    every: AllSix = False,
    output: VideoOutput = None,
    assignments: Set = None,
    platform: Platform = None,
    seed: Seed = None,
    duration: Duration = None,
    size: Size = None,
    fps: Fps = None,
    format: Format = None,
    theme: Theme = None,
    view: View = None,
    overlays: Overlay = None,
    speed: Speed = None,
    begin: Begin = None,
    end: End = None,
    jobs: Jobs = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Render scenes as videos; videos that are up to date are kept.

    Examples: emovid render --emotion anger · emovid render --all --jobs 2 · emovid render my.yaml --set robot.l=0.002
    """
    if every and (sources or emotion):
        raise InputError("--all renders the six emotions and takes no scene")
    look = {"size": size, "fps": fps, "format": format, "theme": theme, "view": view}
    look |= {"speed": speed, "from": begin, "to": end}
    overrides = _look(settings(assignments, seed, look, duration), output, overlays or [])
    named = list(EMOTIONS) if every else _named(sources or [], emotion)
    work = rendering.video_jobs([on_platform(name, platform) for name in named], overrides, output, _video_file)
    for job in work:
        warn_of(job.scene, quiet=quiet or as_json)
    files = (manifest.NAME, rendering.ORDER) if every else (manifest.NAME,)
    with reporter(len(work), quiet=quiet or as_json) as report:
        made = rendering.make_all(work, report, jobs, force=force, files=files)
    if as_json:
        videos = {str(job.target): made.records[job.target].to_json() for job in work if job.target in made.records}
        failed = {str(target): str(failure) for target, failure in made.failures.items()}
        typer.echo(json.dumps({"videos": videos, "failed": failed}, indent=2))
    raise_failures(made.failures.values(), len(work), "videos")
    if every:
        rendering.write_presentation_order(work, seed or 0)


def _named(sources: list[str], emotion: str | None) -> list[str]:
    """Return the requested scenes, each once, given as arguments or by `--emotion`."""
    if len(sources) > 1 and emotion is None:
        return list(dict.fromkeys(sources))
    return [one_source(sources[0] if sources else None, emotion)]


def _look(chosen: list[Setting], output: Path | None, overlays: list[str]) -> list[Setting]:
    """Return the settings of a video, with the format that `-o` implies unless one is given, and the overlays."""
    if not any(setting.key == "video.format" for setting in chosen):
        chosen = chosen + settings([], look={"format": rendering.format_of(output)})
    return [*chosen, *(Setting(f"video.overlays.{name}", True, f"--overlay {name}") for name in overlays)]


def _video_file(output: Path, source: rendering.Source) -> Path:
    """Return the file, or the folder of pictures, that `-o` means for a video."""
    suffix = FORMATS[source.scene.video.format].suffix
    target = output_file(output, source.stem + suffix, ".", (suffix,) if suffix else ())
    if not suffix:
        check_sequence(target)
    return target


def preview(
    source: Source = None,
    emotion: Emotion = None,
    platform: Platform = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A file in one of the formats, or a folder.", show_default="previews"),
    ] = None,
    format: Annotated[
        str | None,
        typer.Option(
            help="gif, webm, mp4; or png: a contact sheet.",
            show_default="as -o ends, or gif",
            autocompletion=completion.words(*_PREVIEW_FORMATS),
        ),
    ] = None,
    assignments: Set = None,
    seed: Seed = None,
    duration: Duration = None,
    watch: Annotated[
        bool, typer.Option("--watch", "-w", help="Render again whenever the scene is saved, until Ctrl-C.")
    ] = False,
    shown: Annotated[bool, typer.Option("--open", help="Open the preview in a browser.")] = False,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Show a scene at a glance: a small loop or a contact sheet, within seconds.

    Examples: emovid preview my.yaml --watch · emovid preview --emotion anger --format png -o anger.png
    """
    chosen = on_platform(one_source(source, emotion), platform)
    file, overrides = find_scene(chosen), settings(assignments, seed, duration=duration)
    target = _preview_file(output, file.stem, format)
    own = force

    def make() -> None:
        nonlocal own
        _preview(chosen, overrides, target, force=own, quiet=quiet)
        own = True  # the file is ours now, and is replaced when the scene is saved

    if shown:
        make()
        if not webbrowser.open(target.resolve().as_uri()):
            raise EmovidError(f"no browser found: open {target} yourself")
    if watch:
        if not quiet:
            typer.echo(f"watching {file}: Ctrl-C ends it", err=True)
        make_when_saved(make, file, lambda error: print(error, file=sys.stderr, flush=True))
    if not shown:
        make()


def _preview_file(output: Path | None, stem: str, format: str | None) -> Path:
    if format is not None and format not in _PREVIEW_FORMATS:
        expected = f"expected one of {', '.join(_PREVIEW_FORMATS)}{nearest(format, _PREVIEW_FORMATS)}"
        raise InputError(f"--format {format}: {expected}")
    suffixes = [suffix for suffix in _PREVIEWS if format in (None, suffix.removeprefix("."))]
    return output_file(output, f"{stem}{suffixes[0]}", "previews", suffixes)


def _preview(source: str, overrides: list[Setting], target: Path, *, force: bool, quiet: bool) -> None:
    """Make a preview and print its file."""
    started = time.perf_counter()
    scene = load_scene(source, overrides)
    check_start(scene)
    warn_of(scene, quiet=quiet)
    with counting(target.name, quiet=quiet) as on_period:
        run = simulate_scene(scene, on_period)
    write_preview(run, target, force=force)
    if not quiet:
        typer.echo(f"{target}: {scene.duration:g} s, made in {time.perf_counter() - started:.1f} s", err=True)


def simulate(
    source: Source = None,
    emotion: Emotion = None,
    platform: Platform = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="A file in .npz or .csv, a folder, or - to print the CSV.",
            show_default="SCENE.npz",
        ),
    ] = None,
    assignments: Set = None,
    seed: Seed = None,
    duration: Duration = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Simulate a scene without drawing it.

    Examples: emovid simulate --emotion fear -o fear.npz · emovid simulate my.yaml --seed 3 -o my.csv
    """
    chosen = on_platform(one_source(source, emotion), platform)
    scene = load_scene(chosen, settings(assignments, seed, duration=duration))
    to_stdout = output == STDOUT
    target = STDOUT if to_stdout else output_file(output, f"{find_scene(chosen).stem}.npz", ".", SUFFIXES)
    check_start(scene)
    warn_of(scene, quiet=quiet or as_json)
    if not force:
        rendering.check_trajectory(target, scene)
    with counting(target.name, quiet=quiet or as_json) as on_period:
        trajectory = simulate_scene(scene, on_period)
    suffix = ".csv" if to_stdout else target.suffix
    write_output(target, partial(write_trajectory, trajectory, suffix), force=force or suffix.lower() == ".npz")
    if as_json:
        facts = {"file": str(target), "trajectory_sha256": trajectory.digest(), "samples": len(trajectory.t)}
        typer.echo(json.dumps(facts | {"robots": scene.robots, "seed": scene.seed}, indent=2), err=to_stdout)
    elif not quiet:
        typer.echo(f"{target}: {scene.robots} robots, {len(trajectory.t)} samples in {scene.duration:g} s", err=True)
