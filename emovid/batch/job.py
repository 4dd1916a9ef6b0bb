"""A job: a scene to turn into a video, a trajectory or measurements, the record of its result, and the work itself."""

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.metadata import version
from math import isnan
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter, ValidationError

from emovid.atomic_io import file_digest
from emovid.batch.scheduler import OnStep
from emovid.scene.load import scene_digest
from emovid.scene.model import Scene
from emovid.swarm.files import save_trajectory
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video import ffmpeg
from emovid.video.encoder import video_arguments
from emovid.video.render import render_video

Kind = Literal["video", "trajectory", "measure"]
RecordKind = Literal["video", "trajectory", "measure", "sheet"]

# Modules and packages that a result of each kind depends on.
_MODULES: Mapping[RecordKind, tuple[str, ...]] = {
    "video": ("scene/*.py", "swarm/*.py", "video/*.py"),
    "trajectory": ("scene/*.py", "swarm/*.py"),
    "measure": ("scene/*.py", "swarm/*.py", "measure/*.py"),
    "sheet": ("video/*.py", "figures/*.py", "batch/*.py"),
}
_PACKAGES: Mapping[RecordKind, tuple[str, ...]] = {
    "video": ("numpy", "scipy", "matplotlib"),
    "trajectory": ("numpy", "scipy"),
    "measure": ("numpy", "scipy"),
    "sheet": ("numpy", "matplotlib"),
}


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
    versions: Mapping[str, str]
    encoder: list[str] | None


@dataclass(frozen=True)
class Record:
    """Entry of the manifest for one result: facts about it, its digests, and its recipe.

    Attributes:
        sha256: of the file; of a folder, see `file_digest`.
        trajectory_sha256: of times, poses and commands.
        frames_crc32: of the frames as drawn.
        scene: the resolved scene as plain values.
        shows: digest of what a contact sheet shows.
    """

    only: RecordKind
    emotion: str | None = None
    seed: int | None = None
    frames: int | None = None
    fps: float | None = None
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
    versions: Mapping[str, str] | None = None
    encoder: list[str] | None = None
    shows: str | None = None

    @property
    def recipe(self) -> Recipe:
        """The recipe of the result."""
        return Recipe(self.only, self.scene_digest, self.run, self.versions or {}, self.encoder)

    @property
    def has_file(self) -> bool:
        """Whether the result is a file or a folder; measurements exist only in the record."""
        return self.only != "measure"

    def to_json(self) -> dict[str, Any]:
        """Return the record as plain values."""
        return {key: value for key, value in asdict(self).items() if value is not None}

    @staticmethod
    def from_json(values: Any) -> "Record | None":
        """Return the record of plain values, or None if they are no record."""
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
    """

    scene: Scene
    target: Path
    run: Trajectory | None = None
    only: Kind = "video"

    @property
    def recipe(self) -> Recipe:
        """The recipe that this version of emovid uses."""
        return Recipe(
            self.only,
            scene_digest(self.scene),
            self.run.digest() if self.run else None,
            versions(self.only),
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
    record = Record(job.only, scene.emotion, scene.seed, scene=scene.resolved(), trajectory_sha256=trajectory.digest())
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
    if record.has_file:
        record = replace(record, sha256=file_digest(job.target))
    recipe = job.recipe
    return replace(
        record, scene_digest=recipe.scene_digest, run=recipe.run, versions=recipe.versions, encoder=recipe.encoder
    )


@cache
def versions(only: RecordKind) -> dict[str, str]:
    """Return the versions of everything that such a result depends on; `code` is a digest of our own modules."""
    return {
        **{name: version(name) for name in ("emovid", *_PACKAGES[only])},
        **({"ffmpeg": ffmpeg.version()} if only == "video" else {}),
        "machine": platform.machine(),
        "code": _code_digest(_MODULES[only]),
    }


def _code_digest(patterns: tuple[str, ...]) -> str:
    """Return a digest of our modules: an edited checkout counts as another version."""
    package = Path(__file__).parent.parent
    sha = hashlib.sha256()
    for path in sorted(path for pattern in patterns for path in package.glob(pattern)):
        sha.update(path.read_bytes())
    return sha.hexdigest()[:16]
