"""A job: a scene to turn into a video, a trajectory or measurements, the record of its result, and the work itself."""

import hashlib
import json
import tempfile
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from math import isnan
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter, ValidationError

from emovid.atomic_io import file_digest
from emovid.batch.scheduler import OnStep
from emovid.batch.versions import RecordKind, Versions, check_versions, versions
from emovid.errors import EmovidError
from emovid.scene.load import scene_digest
from emovid.scene.model import Scene
from emovid.scene.robots import Barrier
from emovid.swarm.files import save_trajectory
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.encoder import video_arguments
from emovid.video.render import render_video

Kind = Literal["video", "trajectory", "measure"]


@dataclass(frozen=True)
class Recipe:
    """Everything that decides the bytes of a result.

    Attributes:
        only: kind of the result.
        scene_digest: SHA-256 of the resolved scene.
        run: SHA-256 of the trajectory, if the job was given one.
        versions: of packages, programs and our own code.
        encoder: arguments of ffmpeg, for a video.
    """

    only: RecordKind
    scene_digest: str | None
    run: str | None
    versions: Versions
    encoder: list[str] | None


@dataclass(frozen=True)
class SweepPoint:
    """The place of a result in a sweep.

    Attributes:
        base: digest of everything that the items of a scene have in common.
        cells: the scene's name and the settings, by key.
    """

    base: str
    cells: dict[str, Any]


@dataclass(frozen=True)
class Record:
    """Entry of the manifest for one result: facts about it, its digests, and its recipe.

    Attributes:
        sha256: of the file; of a folder, see `file_digest`; of measurements, see `descriptors_digest`.
        trajectory_sha256: of times, poses and commands.
        frames_crc32: of the frames as drawn.
        scene: the resolved scene as plain values.
        shows: digest of what a contact sheet shows.
        point: of the sweep that made the result.
    """

    only: RecordKind
    emotion: str | None = None
    seed: int | None = None
    frames: int | None = None
    fps: int | None = None
    size: str | None = None
    duration: float | None = None
    frames_crc32: str | None = None
    samples: int | None = None
    descriptors: dict[str, float | None] | None = None
    sha256: str | None = None
    trajectory_sha256: str | None = None
    scene: dict[str, Any] | None = None
    scene_digest: str | None = None
    run: str | None = None
    versions: Versions | None = None
    encoder: list[str] | None = None
    shows: str | None = None
    point: SweepPoint | None = None

    @property
    def recipe(self) -> Recipe:
        """The recipe of the result."""
        return Recipe(self.only, self.scene_digest, self.run, self.versions or {}, self.encoder)

    @property
    def has_barrier(self) -> bool:
        """True if the scene has a barrier, so that the result depends on the BLAS kernel."""
        return bool(((self.scene or {}).get("safety") or {}).get("kind") == "barrier")

    @property
    def has_file(self) -> bool:
        """True if the result is a file or a folder; measurements exist only in the record."""
        return self.only != "measure"

    def to_json(self) -> dict[str, Any]:
        """Return the record as plain values."""
        return {key: value for key, value in asdict(self).items() if value is not None}

    @staticmethod
    def from_json(values: Any) -> "Record | None":
        """Return the record of plain values, or None if they are not a record."""
        try:
            return _RECORD.validate_python(values)
        except ValidationError:
            return None


_RECORD = TypeAdapter(Record)


@dataclass(frozen=True)
class Job:
    """One result to make.

    Attributes:
        scene: to make it from.
        target: the file, in an existing folder; measurements have no file, only this name.
        run: a finished trajectory to use instead of simulating.
        only: kind of the result.
        point: of the sweep that the job belongs to.
    """

    scene: Scene
    target: Path
    run: Trajectory | None = None
    only: Kind = "video"
    point: SweepPoint | None = None

    @property
    def recipe(self) -> Recipe:
        """The recipe that this version of emovid uses."""
        return Recipe(
            self.only,
            scene_digest(self.scene),
            self.run.digest() if self.run else None,
            versions(self.only, barrier=isinstance(self.scene.safety, Barrier)),
            video_arguments(self.scene.video) if self.only == "video" else None,
        )


def make(job: Job, on_step: OnStep | None = None) -> Record:
    """Make the result of a job and return its record.

    Args:
        job: to do.
        on_step: receives the frames done, or the control periods where no video is made, and their total.

    Raises:
        EmovidError: if the file cannot be made.
    """
    scene, frames = job.scene, job.scene.frames
    trajectory = job.run or simulate(scene, on_step if job.only != "video" else None)
    record = Record(job.only, scene.emotion, scene.seed, scene=scene.resolved(), point=job.point)
    record = replace(record, trajectory_sha256=trajectory.digest())
    if job.only == "video":
        checksum = render_video(trajectory, job.target, (lambda done: on_step(done, frames)) if on_step else None)
        fps, size = scene.video.fps, scene.video.size
        record = replace(record, frames=frames, fps=fps, size=size, duration=frames / fps, frames_crc32=checksum)
    elif job.only == "trajectory":
        save_trajectory(trajectory, job.target)
        record = replace(record, samples=len(trajectory.t))
    else:
        # Only measurements need scipy, which takes half as long to import as a video takes to draw.
        from emovid.measure.describe import describe  # noqa: PLC0415

        measured = describe(trajectory)
        record = replace(record, descriptors={name: None if isnan(x) else x for name, x in measured.items()})
    record = replace(record, sha256=file_digest(job.target) if record.has_file else descriptors_digest(record))
    recipe = job.recipe
    return replace(
        record, scene_digest=recipe.scene_digest, run=recipe.run, versions=recipe.versions, encoder=recipe.encoder
    )


def descriptors_digest(record: Record) -> str:
    """Return the SHA-256 of the measurements in a record."""
    return hashlib.sha256(json.dumps(record.descriptors, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Order:
    """A job for a worker.

    Attributes:
        job: to do. Its target is the final one, which a worker never writes to.
        versions: that the worker must have.
        folder: to write the result to; None for a worker elsewhere, which sends the result back.
    """

    job: Job
    versions: Versions
    folder: Path | None


@dataclass(frozen=True)
class Delivery:
    """The result of an order.

    Attributes:
        record: of the result.
        content: bytes of each file, by its path inside the result; None if the worker wrote to the order's folder.
    """

    record: Record
    content: Mapping[str, bytes] | None = None


def fulfill(order: Order, on_step: OnStep | None = None) -> Delivery:
    """Do a job with the versions that were ordered, and refuse to do it with others.

    Raises:
        OtherVersionsError: if this process has other versions; nothing is made then.
        EmovidError: if the result cannot be made.
    """
    job = order.job
    check_versions(job.only, order.versions)
    with nullcontext(order.folder) if order.folder else tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / job.target.name
        try:
            record = make(replace(job, target=target), on_step)
            check_versions(job.only, order.versions)  # a module may have been edited before this job imported it
            return Delivery(record, None if order.folder or not record.has_file else _content(target))
        except EmovidError as error:
            if str(target) in str(error):
                raise EmovidError(str(error).replace(str(target), str(job.target))) from None
            raise


def _content(path: Path) -> dict[str, bytes]:
    if path.is_dir():
        return {inside.name: inside.read_bytes() for inside in sorted(path.iterdir())}
    return {"": path.read_bytes()}
