"""`emovid render`: scenes, or finished runs, to videos."""

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli import completion
from emovid.cli.failures import raise_failures
from emovid.cli.options import (
    Emotion,
    Force,
    Jobs,
    Json,
    Platform,
    Quiet,
    Seed,
    Set,
    View,
    is_run,
    on_platform,
    one_source,
    output_file,
    settings,
)
from emovid.errors import InputError

if TYPE_CHECKING:
    from emovid.batch.job import Job
    from emovid.scene.load import Setting
    from emovid.scene.video import FormatName

FOLDER = "videos"
_NAMED = 3  # keys that a video differs in from the one that it replaces
_OTHER_VIDEOS = (".mov", ".mkv", ".avi", ".m4v", ".png", ".apng", ".webp")

Output = Annotated[
    Path | None,
    typer.Option(
        "--output", "-o", help="A folder, made if missing, or a file in .mp4, .webm or .gif.", show_default=FOLDER
    ),
]


def render(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENE]",
            help="A scene (.yaml), a finished run (.npz), or an emotion.",
            show_default=False,
            autocompletion=completion.runs,
        ),
    ] = None,
    emotion: Emotion = None,
    every: Annotated[
        bool, typer.Option("--all", "-a", help="All six emotions, and a random order to show them in.")
    ] = False,
    output: Output = None,
    assignments: Set = None,
    platform: Platform = None,
    seed: Seed = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Pixels, as in 1920x1080.", show_default=False)
    ] = None,
    fps: Annotated[int | None, typer.Option(help="Frames per second; the motion stays.", show_default=False)] = None,
    format: Annotated[
        str | None,
        typer.Option(
            help="mp4, webm, gif, or png-sequence: a folder of pictures.",
            show_default="as -o ends, or mp4",
            autocompletion=completion.words("mp4", "webm", "gif", "png-sequence"),
        ),
    ] = None,
    theme: Annotated[
        str | None,
        typer.Option(help="light or dark.", show_default=False, autocompletion=completion.words("light", "dark")),
    ] = None,
    view: View = None,
    overlays: Annotated[
        list[str] | None,
        typer.Option(
            "--overlay",
            help="Also show density, cells, targets or clock.",
            show_default=False,
            autocompletion=completion.words("density", "cells", "targets", "clock"),
        ),
    ] = None,
    jobs: Jobs = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Render scenes as videos; videos that are up to date are kept.

    Examples: emovid render --emotion anger · emovid render --all --jobs 2 · emovid render my.yaml --set robot.l=0.002
    """
    from emovid.batch.cache import find_current, make_missing, workers
    from emovid.batch.order import write_presentation_order
    from emovid.cli.progress import reporter
    from emovid.scene.emotions import EMOTIONS
    from emovid.scene.load import Setting

    look = {"size": size, "fps": fps, "format": format, "theme": theme, "view": view}
    chosen = settings(assignments, seed, look)
    if not any(setting.key == "video.format" for setting in chosen):
        chosen += settings([], look={"format": _format_of(output)})
    overrides = [
        *chosen,
        *(Setting(f"video.overlays.{overlay}", True, f"--overlay {overlay}") for overlay in overlays or ()),
    ]
    if every:
        if source or emotion:
            raise InputError("--all means the six emotions: no scene goes with it")
        work = [_job(on_platform(name, platform), output, overrides) for name in EMOTIONS]
        if len({job.target for job in work}) < len(work):
            raise InputError(f"-o {output}: is one file; expected a folder for six videos")
    else:
        work = [_job(on_platform(one_source(source, emotion), platform), output, overrides)]
    for line in [] if quiet or as_json else _replaced([job for job in work if job.target != output]):
        typer.echo(line, err=True)
    with reporter(len(work), quiet=quiet or as_json) as report:
        known = {} if force else find_current(work, report)
        missing = [job for job in work if job.target not in known]
        with workers(min(jobs or os.cpu_count() or 1, len(missing)), report.advanced) as pool:
            made = make_missing(missing, report, pool)
    if as_json:
        records = known | made.records
        videos = {str(job.target): records[job.target].to_json() for job in work if job.target in records}
        failed = {str(target): str(failure) for target, failure in made.failures.items()}
        typer.echo(json.dumps({"videos": videos, "failed": failed}, indent=2))
    raise_failures(made.failures.values(), len(work), "videos")
    if every:
        names = {name: job.target.name for name, job in zip(EMOTIONS, work, strict=True)}
        write_presentation_order(work[0].target.parent, names, seed or 0)


def _job(source: str, output: Path | None, overrides: "Sequence[Setting]") -> "Job":
    """Return the job for a scene or a run. All that can be wrong with it is found here, before anything is written."""
    from emovid.batch.job import Job
    from emovid.scene.load import find_scene, load_scene, shipped_names
    from emovid.swarm.files import load_trajectory
    from emovid.swarm.simulate import check_start

    run = load_trajectory(Path(source), overrides) if is_run(source) else None
    scene = run.scene if run else load_scene(source, overrides)
    if run is None:
        check_start(scene)
    name = Path(source) if run else find_scene(source)
    if output is None and source in shipped_names():  # those of a platform beside the study's, not in their place
        output = Path(FOLDER) / Path(source).parent
    return Job(scene, _target(output, name.stem, scene.video.format), run)


def _replaced(work: "Sequence[Job]") -> "Iterator[str]":
    """Yield a line for each video of other settings that another is about to replace, as their names are the same."""
    from emovid.batch.manifest import read_manifest
    from emovid.scene.difference import differences_of

    manifests = {folder: read_manifest(folder) for folder in {job.target.parent for job in work}}
    for job in work:
        known = manifests[job.target.parent].get(job.target.name)
        if known and known.scene and job.target.exists():
            keys = [row.key for row in differences_of(known.scene, job.scene.resolved())]
            others = f" and {len(keys) - _NAMED} more" if len(keys) > _NAMED else ""
            if keys:
                yield f"{job.target}: replaces one with another {', '.join(keys[:_NAMED])}{others}"


def _format_of(output: Path | None) -> "FormatName | None":
    """Return the format whose files end as the output does."""
    from emovid.video.encoder import FORMATS

    suffixes = {made.suffix: name for name, made in FORMATS.items() if made.suffix}
    return suffixes.get(output.suffix.lower()) if output and not output.is_dir() else None


def _target(output: Path | None, stem: str, format: "FormatName") -> Path:
    """Return the file, or the folder of pictures, that `-o` means for a scene."""
    from emovid.video.encoder import FORMATS, check_sequence

    suffix = FORMATS[format].suffix
    others = {made.suffix for made in FORMATS.values()} - {"", suffix}
    target = output_file(output, stem + suffix, FOLDER, (suffix,) if suffix else (), (*sorted(others), *_OTHER_VIDEOS))
    if not suffix:
        check_sequence(target)
    return target
