"""`emovid render`: scenes, or finished runs, to videos."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli.options import Emotion, Force, Json, Quiet, Seed, Set, one_source, output_file, settings
from emovid.errors import InputError

if TYPE_CHECKING:
    from emovid.batch.videos import Job
    from emovid.scene.load import Setting

FOLDER = "videos"
_OTHER_VIDEOS = (".webm", ".gif", ".mov", ".mkv", ".avi", ".m4v", ".png", ".apng", ".webp")

Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="A folder, made if missing, or a file ending in .mp4.", show_default=FOLDER),
]


def render(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENE]", help="A scene (.yaml), a finished run (.npz), or an emotion.", show_default=False
        ),
    ] = None,
    emotion: Emotion = None,
    every: Annotated[
        bool, typer.Option("--all", "-a", help="All six emotions, and a random order to show them in.")
    ] = False,
    output: Output = None,
    assignments: Set = None,
    seed: Seed = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Pixels, as in 1920x1080.", show_default=False)
    ] = None,
    fps: Annotated[int | None, typer.Option(help="Frames per second; the motion stays.", show_default=False)] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, help="Videos made at once.", show_default="one a core")
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Render scenes as videos. What is there and up to date is not made again.

    Examples: emovid render --emotion anger · emovid render --all --jobs 2 · emovid render my.yaml --set robot.l=0.002
    """
    from emovid.batch.order import write_presentation_order
    from emovid.batch.videos import make_videos
    from emovid.cli.progress import reporter
    from emovid.scene.emotions import EMOTIONS
    from emovid.whole_files import make_folder

    overrides = settings(assignments, seed, size, fps)
    if every:
        if source or emotion:
            raise InputError("--all means the six emotions: no scene goes with it")
        work = [_job(name, output, overrides) for name in EMOTIONS]
        if len({job.target for job in work}) < len(work):
            raise InputError(f"-o {output}: is one file; expected a folder for six videos")
    else:
        work = [_job(one_source(source, emotion), output, overrides)]
    for job in work:
        make_folder(job.target.parent)
    with reporter(work, quiet=quiet or as_json) as report:
        records = make_videos(work, jobs or os.cpu_count() or 1, report, force=force)
    if every:
        names = {str(job.scene.emotion): job.target.name for job in work}
        write_presentation_order(work[0].target.parent, names, seed or 0)
    if as_json:
        typer.echo(json.dumps({"videos": {str(path): entry for path, entry in records.items()}}, indent=2))


def _job(source: str, output: Path | None, overrides: "Sequence[Setting]") -> "Job":
    """Return the job for a scene or a run. All that can be wrong with it is found here, before anything is written."""
    from emovid.batch.videos import Job
    from emovid.scene.load import find_scene, load_scene
    from emovid.swarm.files import load_trajectory
    from emovid.swarm.simulate import check_start

    run = load_trajectory(Path(source), overrides) if source.endswith(".npz") else None
    scene = run.scene if run else load_scene(source, overrides)
    if run is None:
        check_start(scene)
    stem = Path(source).stem if run else find_scene(source).stem
    return Job(scene, output_file(output, f"{stem}.mp4", FOLDER, (".mp4",), _OTHER_VIDEOS), run)
