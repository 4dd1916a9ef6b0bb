"""`manifest.json`: what each video beside it was made from, so that nothing is made twice and all can be cited."""

import hashlib
import json
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from emovid.scene.load import scene_digest
from emovid.scene.model import Scene
from emovid.swarm.trajectory import Trajectory
from emovid.video.encode import ffmpeg_version
from emovid.video.render import video_arguments
from emovid.whole_files import file_digest, writing

NAME = "manifest.json"
Record = dict[str, Any]
_ROOMS = ("scene", "swarm", "video")  # their code decides a video's bytes


def recipe(scene: Scene, run: str | None = None) -> Record:
    """Return what decides a video's bytes: the part of its record that is known before it is made.

    Args:
        scene: to be rendered.
        run: SHA-256 of the trajectory, if it was not made from the scene here.
    """
    return {
        "scene_digest": scene_digest(scene),
        "run": run,
        "versions": versions(),
        "encoder": video_arguments(scene.video),
    }


def record(scene: Scene, trajectory: Trajectory, video: Path, run: str | None = None) -> Record:
    """Return the record of a finished video."""
    return {
        "emotion": scene.emotion,
        "seed": scene.seed,
        "frames": scene.frames,
        "fps": scene.video.fps,
        "size": scene.video.size,
        "duration": scene.frames / scene.video.fps,
        "sha256": file_digest(video),
        "trajectory_sha256": trajectory.digest(),
        **recipe(scene, run),
    }


def is_current(known: Record | None, wanted: Record, video: Path) -> bool:
    """Return whether `video` is the one that `known` records, made by the recipe `wanted`."""
    if known is None or any(known.get(key) != value for key, value in wanted.items()):
        return False
    return video.is_file() and file_digest(video) == known.get("sha256")


def read_manifest(folder: Path) -> dict[str, Record]:
    """Return the records in a folder by file name; none if the manifest is missing or is not ours."""
    try:
        videos = json.loads((folder / NAME).read_text(encoding="utf-8"))["videos"]
        return {str(name): dict(entry) for name, entry in videos.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def add_to_manifest(folder: Path, name: str, entry: Record) -> None:
    """Record a video in its folder's manifest, keeping the other records of files that are still there."""
    videos = {known: old for known, old in read_manifest(folder).items() if (folder / known).is_file()}
    videos[name] = entry
    text = json.dumps({"videos": dict(sorted(videos.items()))}, indent=2) + "\n"
    with writing(folder / NAME) as file:
        file.write(text.encode())


@cache
def versions() -> dict[str, str]:
    """Return the versions of all that a video's bytes may depend on; `code` is a digest of our own rooms."""
    return {
        **{name: version(name) for name in ("emovid", "numpy", "scipy", "matplotlib")},
        "ffmpeg": ffmpeg_version(),
        "machine": platform.machine(),
        "code": _code_digest(),
    }


def _code_digest() -> str:
    """Return a digest of the modules that make videos: an edited checkout is another version too."""
    package = Path(__file__).parent.parent
    sha = hashlib.sha256()
    for path in sorted(path for room in _ROOMS for path in (package / room).glob("*.py")):
        sha.update(path.read_bytes())
    return sha.hexdigest()[:16]
