"""Rendering many scenes and runs: which videos are requested, which are missing, and making those."""

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from emovid.atomic_io import file_digest, writing
from emovid.batch import contact_sheet, manifest, results
from emovid.batch.cache import Made, Reporter, find_current, make_missing, workers
from emovid.batch.job import Job, Record
from emovid.batch.manifest import Journal, read_manifest
from emovid.batch.scheduler import Pool
from emovid.csv_writer import csv_text
from emovid.errors import EmovidError, InputError
from emovid.scene.difference import differences, differences_of
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, find_scene, load_scene, scene_of, shipped_names
from emovid.scene.model import Scene
from emovid.scene.video import FormatName
from emovid.swarm.files import is_run, load_trajectory
from emovid.swarm.simulate import check_start
from emovid.swarm.trajectory import Trajectory
from emovid.video.encoder import FORMATS

FOLDER = Path("videos")
ORDER = "presentation_order.csv"
_NAMED = 3  # keys named in the message about a result with other settings


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
    for source, file in zip(sources, targets, strict=True):
        if targets.count(file) > 1 and file == output:
            raise InputError(f"-o {file}: is one file; expected a folder for {len(targets)} videos")
        if targets.count(file) > 1:
            raise InputError(f"{source}: {file} is the video of another scene, too; render one of them with -o")
    return [Job(source.scene, target, source.run) for source, target in zip(loaded, targets, strict=True)]


def make_all(
    jobs: Sequence[Job],
    report: Reporter,
    processes: int | None,
    *,
    force: bool,
    files: Sequence[str] = (manifest.NAME,),
) -> Made:
    """Make the results that are missing or out of date; with `force`, all of them.

    Args:
        jobs: with targets in one folder.
        report: receives the progress.
        processes: how many to use at once; None for one per core.
        force: whether to make results that are up to date again, and to overwrite those with other settings.
        files: that will be written beside the results.

    Raises:
        InputError: if an existing file is of other settings, or not of emovid; nothing has been written then.
    """
    check_folder(jobs[0].target.parent, files)
    if not force:
        check_settings(jobs)
    known = {} if force else find_current(jobs, report)
    missing = [job for job in jobs if job.target not in known]
    with workers(min(processes or os.cpu_count() or 1, len(missing)), report.advanced) as pool:
        if not force:
            known |= _adopted(missing, pool)
        made = make_missing([job for job in missing if job.target not in known], report, pool)
    return Made(known | made.records | made.elsewhere, failures=made.failures)


def check_settings(jobs: Sequence[Job]) -> None:
    """Raise an `InputError` for an existing result that was made with other settings than a job of the same name."""
    manifests = {folder: read_manifest(folder) for folder in {job.target.parent for job in jobs}}
    for job in jobs:
        known = manifests[job.target.parent].get(job.target.name)
        if known and (job.target.exists() or not known.has_file):
            _refuse_other(job.target, _differing(known, job))


def check_trajectory(target: Path, scene: Scene) -> None:
    """Raise an `InputError` for an existing .npz that is not a run of the same scene."""
    if target.suffix.lower() == ".npz" and target.is_file():
        try:
            known = load_trajectory(target).scene
        except InputError:
            raise InputError(f"{target}: was not written by emovid; use --force to overwrite it, or -o") from None
        _refuse_other(target, [row.key for row in differences(known, scene)])


def _refuse_other(target: Path, keys: Sequence[str]) -> None:
    """Raise an `InputError` for an existing result if its settings differ in some keys."""
    if keys:
        others = f" and {len(keys) - _NAMED} more" if len(keys) > _NAMED else ""
        settings = ", ".join(keys[:_NAMED]) + others
        raise InputError(f"{target} exists with other settings ({settings}); use --force to overwrite it, or -o")


def _differing(known: Record, job: Job) -> list[str]:
    """Return the keys in which the scene of a record differs from that of a job; "run" for another trajectory."""
    try:
        scene = scene_of(known.scene or {}, {}).resolved()  # with the default of a key that is newer than the record
    except InputError:
        scene = known.scene or {}
    keys = [row.key for row in differences_of(scene, job.scene.resolved())]
    if not keys and job.recipe.run not in (None, known.run, known.trajectory_sha256):
        return ["run"]
    return keys


def _adopted(jobs: Sequence[Job], pool: Pool) -> dict[Path, Record]:
    """Record the existing files that no manifest knows but that are the results of their jobs.

    A run that was killed before it could record a file leaves such files. Each result is made again, elsewhere, and
    compared.

    Raises:
        InputError: for a file that is something else.
    """
    manifests = {folder: read_manifest(folder) for folder in {job.target.parent for job in jobs}}
    unknown = [job for job in jobs if job.target.name not in manifests[job.target.parent] and _is_result(job)]
    adopted = {}
    with TemporaryDirectory() as folder:
        copies = {job: replace(job, target=Path(folder) / job.target.name) for job in unknown}
        made = make_missing(list(copies.values()), _Silent(), pool)
        for job, copy in copies.items():
            record = made.records.get(copy.target)
            if record and record.has_file:
                if file_digest(job.target) != record.sha256:
                    problem = "exists with other settings, or not from emovid"
                    raise InputError(f"{job.target} {problem}; use --force to overwrite it, or -o")
                adopted[job.target] = record
    if adopted:
        with Journal(next(iter(adopted)).parent) as journal:
            for target, record in adopted.items():
                journal.add(target.name, record)
    return adopted


def _is_result(job: Job) -> bool:
    """Return whether the target of a job may be a result: a file, or a folder of pictures."""
    if job.scene.video.format == "png-sequence":
        return job.target.is_dir() and any(job.target.iterdir())
    return job.target.is_file()  # making it fails if there is a folder


class _Silent:
    """Ignores all progress."""

    def advanced(self, job: Job, done: int, total: int) -> None:
        """See `Reporter`."""

    def finished(self, job: Job, record: Record, *, made: bool) -> None:
        """See `Reporter`."""

    def failed(self, job: Job, error: EmovidError) -> None:
        """See `Reporter`."""

    def died(self, job: Job, attempt: int) -> None:
        """See `Reporter`."""

    def noted(self, line: str) -> None:
        """See `Reporter`."""


def check_folder(folder: Path, names: Iterable[str] = (manifest.NAME,)) -> None:
    """Raise an `InputError` for a file in a folder of results that emovid would write, but did not write before.

    Args:
        folder: of the results.
        names: of the files, each with a format of its own.
    """
    for name in names:
        with suppress(FileNotFoundError, NotADirectoryError):
            if not _FORMATS[name]((folder / name).read_bytes()):
                raise InputError(f"{folder / name}: was not written by emovid; move it, or choose another folder")


def _is_manifest(data: bytes) -> bool:
    return _has_only_keys(data, set(manifest.SECTIONS.values()))


def _is_plan(data: bytes) -> bool:
    return _has_only_keys(data, {"file", "only", "scenes", "set", "list", "grid", "seeds"})


def _has_only_keys(data: bytes, keys: set[str]) -> bool:
    """Return whether a file is a JSON object with some of the keys; a damaged file counts as one."""
    try:
        values = json.loads(data)
    except ValueError:
        return True
    return isinstance(values, dict) and values.keys() <= keys


def _starts_with(head: str) -> Callable[[bytes], bool]:
    return lambda data: data.startswith(head.encode()) or not data


_FORMATS: Mapping[str, Callable[[bytes], bool]] = {
    manifest.NAME: _is_manifest,
    manifest.PLAN: _is_plan,
    results.TABLE: _starts_with("item,name"),
    results.PARQUET: results.is_parquet_of_sweep,
    contact_sheet.NAME: contact_sheet.is_contact_sheet,
    ORDER: _starts_with("position,emotion,video"),
}


def write_presentation_order(jobs: Sequence[Job], seed: int) -> None:
    """Write `presentation_order.csv` beside the videos of the six emotions: a random order, fixed by the seed."""
    videos = list(zip(EMOTIONS, jobs, strict=True))
    order = np.random.default_rng(seed).permutation(len(videos))
    rows = [(place, videos[i][0], videos[i][1].target.name) for place, i in enumerate(order, start=1)]
    with writing(jobs[0].target.parent / ORDER) as file:
        file.write(csv_text(("position", "emotion", "video"), rows).encode())


def format_of(output: Path | None) -> FormatName | None:
    """Return the format of videos with the suffix of `-o`, if it has one."""
    suffixes = {made.suffix: name for name, made in FORMATS.items() if made.suffix}
    return suffixes.get(output.suffix.lower()) if output and not output.is_dir() else None


def _default_folder(source: str) -> Path:
    """Return the folder of a video without `-o`: scenes for a platform have one of their own."""
    return FOLDER / Path(source).parent if source in shipped_names() else FOLDER
