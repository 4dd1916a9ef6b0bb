"""One piece of work: a scene as a video, a trajectory or measurements, what decides its result, and its making."""

import hashlib
import platform
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from math import isnan
from pathlib import Path
from typing import Any, Literal

from emovid.atomic_io import file_digest
from emovid.batch.pool import OnStep
from emovid.scene.load import scene_digest
from emovid.scene.model import Scene
from emovid.swarm.files import save_trajectory
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video import ffmpeg
from emovid.video.encoder import video_arguments
from emovid.video.render import render_video

Kind = Literal["video", "trajectory", "measure"]
Record = dict[str, Any]  # of a finished job: its recipe, and what came of it

# The modules whose code, and the packages whose versions, a result may depend on.
_MODULES = {
    "video": ("scene/*.py", "swarm/*.py", "looks.py", "perspective/*.py", "video/*.py"),
    "trajectory": ("scene/*.py", "swarm/*.py"),
    "measure": ("scene/*.py", "swarm/*.py", "measure/*.py"),
    "sheet": ("looks.py", "perspective/*.py", "video/*.py", "figures/*.py", "batch/*.py"),
}
_PACKAGES = {
    "video": ("numpy", "scipy", "matplotlib"),
    "trajectory": ("numpy", "scipy"),
    "measure": ("numpy", "scipy"),
    "sheet": ("numpy", "matplotlib"),
}


@dataclass(frozen=True)
class Job:
    """One thing to make.

    Attributes:
        scene: what it is of.
        target: the file, in a folder that exists; for measurements, which are a record and no file, only a name there.
        run: the trajectory, if there is one already.
        only: what is made.
    """

    scene: Scene
    target: Path
    run: Trajectory | None = None
    only: Kind = "video"

    @property
    def run_digest(self) -> str | None:
        """SHA-256 of the given trajectory."""
        return self.run.digest() if self.run else None

    @property
    def recipe(self) -> Record:
        """What decides the result, to the byte: the part of its record that is known before it is made."""
        return {
            "only": self.only,
            "scene_digest": scene_digest(self.scene),
            "run": self.run_digest,
            "versions": versions(self.only),
            "encoder": video_arguments(self.scene.video) if self.only == "video" else None,
        }


def make(job: Job, on_step: OnStep | None = None) -> Record:
    """Do a job and return its record.

    Args:
        job: to do.
        on_step: hears of frames, or of control periods where no video is made.

    Raises:
        EmovidError: if its file cannot be made.
    """
    scene, frames = job.scene, job.scene.frames
    trajectory = job.run or simulate(scene, on_step if job.only != "video" else None)
    facts: Record = {"emotion": scene.emotion, "seed": scene.seed}
    if job.only == "video":
        told = (lambda done: on_step(done, frames)) if on_step else None
        facts |= {"frames": frames, "fps": scene.video.fps, "size": scene.video.size}
        facts |= {"duration": frames / scene.video.fps, "frames_crc32": render_video(trajectory, job.target, told)}
    elif job.only == "trajectory":
        save_trajectory(trajectory, job.target)
        facts |= {"samples": len(trajectory.t)}
    else:
        # Only measuring needs scipy, which takes as long to import as half of a video takes to draw.
        from emovid.measure.describe import describe  # noqa: PLC0415

        measured = describe(trajectory)
        facts |= {"descriptors": {name: None if isnan(value) else value for name, value in measured.items()}}
    if job.only != "measure":
        facts |= {"sha256": file_digest(job.target)}
    return facts | {"trajectory_sha256": trajectory.digest(), "scene": scene.resolved()} | job.recipe


def is_current(known: Record, job: Job) -> bool:
    """Return whether a job's result is there, whole, and what `known` records of the job's recipe."""
    if not is_by_recipe(known, job):
        return False
    return job.only == "measure" or (job.target.exists() and file_digest(job.target) == known.get("sha256"))


def is_by_recipe(known: Record, job: Job) -> bool:
    """Return whether `known` records a job's recipe."""
    return all(known.get(key) == value for key, value in job.recipe.items())


@cache
def versions(only: str) -> dict[str, str]:
    """Return the versions of all that such a result may depend on; `code` is a digest of our own rooms."""
    return {
        **{name: version(name) for name in ("emovid", *_PACKAGES[only])},
        **({"ffmpeg": ffmpeg.version()} if only == "video" else {}),
        "machine": platform.machine(),
        "code": _code_digest(_MODULES[only]),
    }


def _code_digest(modules: tuple[str, ...]) -> str:
    """Return a digest of the modules that decide a result: an edited checkout is another version too."""
    package = Path(__file__).parent.parent
    sha = hashlib.sha256()
    for path in sorted(path for pattern in modules for path in package.glob(pattern)):
        sha.update(path.read_bytes())
    return sha.hexdigest()[:16]
