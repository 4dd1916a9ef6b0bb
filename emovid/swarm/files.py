"""Trajectories on disk: .npz to render and measure again, .csv for other programs."""

import zipfile
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import IO, Any

import numpy as np

from emovid.atomic_io import writing
from emovid.errors import EmovidError, InputError, SourceError, reason
from emovid.scene.behaviour import Recorded
from emovid.scene.load import Setting, parse_scene, scene_text
from emovid.scene.model import Scene
from emovid.scene.robots import Barrier
from emovid.swarm.tracks import is_track, load_track
from emovid.swarm.trajectory import RecordedTrajectory, Trajectory

SUFFIXES = (".npz", ".csv")
_ARRAYS = ("t", "poses", "commands", "stage_cut", "separation_cut")
_OF_BARRIER = ("bend", "relaxed")
# Time of every entry of the archive, so that equal runs are equal files: the earliest possible in a zip file.
_ZIP_TIME = (1980, 1, 1, 0, 0, 0)


def is_run(source: str | Path) -> bool:
    """Return whether a source names a finished run or a track, by its suffix."""
    return Path(source).suffix.lower() == ".npz" or is_track(source)


def save_trajectory(trajectory: Trajectory, target: Path) -> None:
    """Write a trajectory as .npz (arrays and the resolved scene as YAML text) or .csv (the table of `to_dataframe`).

    Raises:
        EmovidError: if the file cannot be written.
    """
    with writing(target) as file:
        write_trajectory(trajectory, target.suffix, file)


def write_trajectory(trajectory: Trajectory, suffix: str, file: IO[bytes]) -> None:
    """Write a trajectory to an open file in the format of a suffix, ".npz" or ".csv"."""
    if suffix.lower() == ".npz":
        _write_npz(trajectory, file)
    else:
        _write_csv(trajectory, file)


def load_trajectory(source: Path, settings: Sequence[Setting] = ()) -> Trajectory:
    """Return the trajectory of an .npz that `save_trajectory` wrote, or of a .track.yaml.

    Args:
        source: the file.
        settings: keys of its scene to replace; only keys of `video`, since the motion is fixed.

    Raises:
        InputError: if it is not such a file, or a setting would change the motion.
    """
    for setting in settings:
        if not setting.key.startswith("video."):
            raise SourceError(setting.origin, f"{source} is a finished run; only video.* can be set", key=setting.key)
    if is_track(source):
        return load_track(source, tuple(settings))
    try:
        with source.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            scene = parse_scene(str(arrays["scene"]), f"{source}:scene", settings)
            names = _ARRAYS + (_OF_BARRIER if isinstance(scene.safety, Barrier) else ())
            loaded = {name: arrays[name] for name in names}
    except OSError as error:
        raise InputError(f"{source}: cannot be read: {reason(error)}") from None
    except (EmovidError, MemoryError):
        raise
    except Exception:  # numpy, zipfile and tokenize do not document their errors for broken files
        raise InputError(f"{source}: not a run: expected an .npz written by emovid simulate") from None
    _check_arrays(scene, loaded, source)
    kind = RecordedTrajectory if isinstance(scene.behaviour, Recorded) else Trajectory
    return kind(scene, **loaded)


def _write_npz(trajectory: Trajectory, file: IO[bytes]) -> None:
    arrays = {name: array for name in _ARRAYS + _OF_BARRIER if (array := getattr(trajectory, name)) is not None}
    arrays["scene"] = np.array(scene_text(trajectory.scene))
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            with archive.open(zipfile.ZipInfo(f"{name}.npy", _ZIP_TIME), "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, array, allow_pickle=False)


def _write_csv(trajectory: Trajectory, file: IO[bytes]) -> None:
    """Write the rows of `to_dataframe` without pandas, whose import takes longer than a simulation."""
    file.write(b"time,robot,x,y,heading,v,omega\n")
    none = trajectory.scene.robots * [("", "")]  # no command is held after the last sample
    held = chain((commands.tolist() for commands in trajectory.commands), [none])
    for t, poses, commands in zip(trajectory.t.tolist(), trajectory.poses, held, strict=True):
        rows = (
            f"{t},{robot},{x},{y},{heading},{v},{omega}\n"
            for robot, ((x, y, heading), (v, omega)) in enumerate(zip(poses.tolist(), commands, strict=True), start=1)
        )
        file.write("".join(rows).encode())


def _check_arrays(scene: Scene, arrays: Mapping[str, Any], source: Path) -> None:
    samples, robots = len(arrays["t"]), scene.robots
    of_period = (samples - 1, robots)
    expected = [(samples,), (samples, robots, 3), (*of_period, 2), *((len(arrays) - 3) * [of_period])]
    found = [array.shape for array in arrays.values()]
    if samples < 2 or found != expected:
        raise InputError(f"{source}: not a run: arrays of shapes {found} for {robots} robots")
    for name, array in arrays.items():
        if array.dtype.kind not in "fiub" or not np.isfinite(array).all():
            raise InputError(f"{source}: not a run: not all of {name} are finite numbers")
    t = arrays["t"]
    if (np.diff(t) <= 0).any():
        raise InputError(f"{source}: not a run: the times in t do not rise")
    if t[0] != 0:
        raise InputError(f"{source}: not a complete run: t begins at {t[0]:g}, expected 0")
    if not np.isclose(t[-1], scene.duration, rtol=1e-9, atol=0):
        raise InputError(
            f"{source}: not a complete run: t ends at {t[-1]:g}, expected the duration, {scene.duration:g}"
        )
