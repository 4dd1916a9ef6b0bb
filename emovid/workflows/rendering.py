"""Rendering many scenes and runs: which videos are requested, which are missing, and making those."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from emovid.batch.cache import Made, Reporter, find_current, make_missing, workers
from emovid.batch.job import Job
from emovid.batch.manifest import read_manifest
from emovid.errors import InputError
from emovid.scene.difference import differences_of
from emovid.scene.load import Setting, find_scene, load_scene, shipped_names
from emovid.scene.model import Scene
from emovid.scene.video import FormatName
from emovid.swarm.files import is_run, load_trajectory
from emovid.swarm.simulate import check_start
from emovid.swarm.trajectory import Trajectory
from emovid.video.encoder import FORMATS

FOLDER = Path("videos")
_NAMED = 3  # keys named in the message about a video with other settings


class Source(NamedTuple):
    """A scene, or a finished run with its scene; `stem` names the files that are made from it."""

    scene: Scene
    run: Trajectory | None
    stem: str


def load_source(source: str, settings: Sequence[Setting]) -> Source:
    """Return the scene or the finished run of a source; all its errors are raised here, before anything is written."""
    if is_run(source):
        run = load_trajectory(Path(source), settings)
        return Source(run.scene, run, Path(source).stem)
    scene = load_scene(source, settings)
    check_start(scene)
    return Source(scene, None, find_scene(source).stem)


def video_jobs(
    sources: Sequence[str], settings: Sequence[Setting], output: Path | None, target: Callable[[Path, Source], Path]
) -> list[Job]:
    """Return a job for the video of each source.

    Args:
        sources: scenes, emotions and finished runs.
        settings: keys of their scenes to replace.
        output: as given to `-o`.
        target: the file of a video, from `-o`, or else the default folder, and its source.
    """
    loaded = [load_source(source, settings) for source in sources]
    folders = [output or _default_folder(source) for source in sources]
    targets = [target(folder, source) for folder, source in zip(folders, loaded, strict=True)]
    if len(set(targets)) < len(targets):
        twice = next(target for target in targets if targets.count(target) > 1)
        raise InputError(f"-o {twice}: is one file; expected a folder for {len(targets)} videos")
    return [Job(source.scene, target, source.run) for source, target in zip(loaded, targets, strict=True)]


def make_all(jobs: Sequence[Job], report: Reporter, processes: int | None, *, force: bool) -> Made:
    """Make the videos that are missing or out of date, with `force` all of them.

    Args:
        jobs: with targets in one folder.
        report: told of progress.
        processes: how many to use at once; None for one per core.
        force: whether to make up-to-date videos again.
    """
    known = {} if force else find_current(jobs, report)
    missing = [job for job in jobs if job.target not in known]
    with workers(min(processes or os.cpu_count() or 1, len(missing)), report.advanced) as pool:
        made = make_missing(missing, report, pool)
    return Made(known | made.records, made.failures)


def overwritten(jobs: Sequence[Job]) -> Iterator[str]:
    """Yield a line for each existing video with other settings, which a video of the same name will overwrite."""
    manifests = {folder: read_manifest(folder) for folder in {job.target.parent for job in jobs}}
    for job in jobs:
        known = manifests[job.target.parent].get(job.target.name)
        if known and known.scene and job.target.exists():
            keys = [row.key for row in differences_of(known.scene, job.scene.resolved())]
            others = f" and {len(keys) - _NAMED} more" if len(keys) > _NAMED else ""
            if keys:
                yield f"{job.target}: replaces one with another {', '.join(keys[:_NAMED])}{others}"


def format_of(output: Path | None) -> FormatName | None:
    """Return the format of videos with the suffix of `-o`, if it has one."""
    suffixes = {made.suffix: name for name, made in FORMATS.items() if made.suffix}
    return suffixes.get(output.suffix.lower()) if output and not output.is_dir() else None


def _default_folder(source: str) -> Path:
    """Return the folder of a video without `-o`: scenes for a platform have one of their own."""
    return FOLDER / Path(source).parent if source in shipped_names() else FOLDER
