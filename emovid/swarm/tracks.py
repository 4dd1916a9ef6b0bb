"""Tracks: motion from files of trackers and testbeds, described by a small YAML file that ends in .track.yaml.

Scale, rate and the direction of y are keys that the file has to have: none of them is guessed.
"""

import csv
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from emovid.errors import InputError, SourceError, nearest, reason
from emovid.scene.emotions import EmotionName
from emovid.scene.load import Setting, apply_settings, read_robot
from emovid.scene.model import Scene
from emovid.scene.resources import read_text
from emovid.scene.robots import Body
from emovid.scene.stage import Stage
from emovid.scene.video import Video
from emovid.swarm.arrays import Array, Mask
from emovid.swarm.trajectory import RecordedTrajectory, Trajectory
from emovid.yaml_models import Keys, inconsistent, source_error
from emovid.yaml_source import place_of, read_yaml

SUFFIX = ".track.yaml"
_TIMED = ("emovid", "mcap")  # formats that always have times in seconds
_NOT_INDIVIDUALS = ("posture", "recognition", "statistics", "tracklet_images")  # other files in a TRex data folder


class Columns(Keys):
    """Names of the columns of a long CSV: one row for each robot and time."""

    time: str | None = Field(None, description="time [s]; null: frame and rate")
    frame: str | None = Field(None, description="number of the frame; null: time")
    robot: str = Field("id", description="name or number of the robot")
    x: str = Field("x", description="position to the right")
    y: str = Field("y", description="position up, or down with y: down")
    heading: str | None = Field(None, description="heading [rad], counter-clockwise from x as y goes up; or null")


class Origin(Keys):
    """A point in the coordinates of a file."""

    x: float = Field(description="to the right")
    y: float = Field(description="up, or down with y: down")


class Track(Keys):
    """A recorded motion: where its file is, what its numbers mean, and the stage and robots it is shown with."""

    file: Annotated[str, Field(min_length=1)] = Field(description="file or folder, relative to this file")
    format: Literal["emovid", "long", "deeplabcut", "trex", "idtracker", "mcap"] = Field(description="kind of file")
    scale: Annotated[float, Field(gt=0, le=1e6)] = Field(description="meters in one unit of the file's coordinates")
    y: Literal["up", "down"] = Field(description="direction of the file's y axis; down in images")
    rate: Annotated[float, Field(gt=0, le=100_000)] | None = Field(
        None, description="frames per second, for files that count frames; null: the file has times"
    )
    start: Annotated[float, Field(ge=0)] | None = Field(
        None, description="time in the file at which the motion starts [s]; null: its first"
    )
    end: Annotated[float, Field(gt=0)] | None = Field(
        None, description="time in the file at which the motion ends [s]; null: its last"
    )
    origin: Origin = Field(Origin(x=0.0, y=0.0), description="the stage's origin in the file's coordinates")
    columns: Columns = Field(Columns(), description="columns of a long CSV")
    bodypart: str | None = Field(None, description="body part of a DeepLabCut file; null: the only one")
    likelihood: Annotated[float, Field(ge=0, le=1)] = Field(
        0.0, description="smallest likelihood of a DeepLabCut point"
    )
    topic: str | None = Field(None, description="topic of PoseArray messages in a bag; null: the only one")
    gaps: Literal["refuse", "interpolate"] = Field("refuse", description="treatment of missing positions")
    robot: Body = Field(description="the robot, or another body: a shipped robot by its name, a file or keys")
    stage: Stage = Field(description="the area it moves in")
    emotion: EmotionName | None = Field(None, description="the emotion that it expresses; null for none")
    snapshots: Annotated[tuple[float, ...], Field(strict=False, min_length=1)] | None = Field(
        None, description="times of its figure [s], increasing; measurements end at the last"
    )
    video: Video = Field(Video(), description="appearance in videos and figures")

    @model_validator(mode="after")
    def _timed(self) -> "Track":
        timed = self.format in _TIMED or (self.format == "long" and self.columns.time is not None)
        counted = self.format == "deeplabcut" or (self.format == "long" and not timed)
        if self.format == "long" and not (self.columns.time or self.columns.frame):
            raise inconsistent("columns.frame", "missing: a long CSV needs a column of times or of frames")
        if counted and self.rate is None:
            raise inconsistent("rate", "missing: a file that counts frames needs its frames per second")
        if timed and self.rate is not None:
            raise inconsistent("rate", f"{self.rate:g}: the file has times in seconds; expected no rate")
        if self.start is not None and self.end is not None and self.end <= self.start:
            raise inconsistent("end", f"{self.end:g}: expected a time after the start, {self.start:g}")
        return self


Samples = dict[str, dict[float, tuple[float, float, float]]]  # by robot and time or frame: x, y, heading or NaN


def is_track(source: str | Path) -> bool:
    """Return whether a source names the description of a track, by its suffix."""
    return str(source).lower().endswith(SUFFIX)


def load_track(source: Path, settings: tuple[Setting, ...] = ()) -> RecordedTrajectory:
    """Return the recorded motion of a .track.yaml file.

    Args:
        source: the description.
        settings: keys of its `video` to replace.

    Raises:
        SourceError: for an invalid description, with file, line and key; for missing positions.
        InputError: for a file that cannot be read.
    """
    data, places = read_yaml(read_text(source, "track"), str(source), "track")
    if not isinstance(data, dict):
        raise SourceError(str(source), "not a track: expected keys such as file, format, scale")
    data, places = apply_settings(data, places, settings)
    wrapped = {"robot": {"model": data.get("robot")}}
    read_robot(wrapped, source.parent, places)
    data["robot"] = wrapped["robot"]["model"]
    try:
        track = Track.model_validate(data)
    except ValidationError as error:
        raise source_error(error, places, Track) from None
    t, poses = _gathered(_READERS[track.format](source.parent / track.file, track), track, source)
    if fault := _scale_fault(poses[..., :2], track):
        raise SourceError(place_of(("scale",), places), fault, key="scale")
    try:
        return Trajectory.from_poses(
            t, poses, body=track.robot, stage=track.stage, emotion=track.emotion, video=track.video,
            snapshots=track.snapshots,
        )  # fmt: skip
    except ValidationError as error:
        raise InputError(f"{source}: {error.errors()[0]['msg']}") from None


def load_positions(source: Path, scene: Scene) -> RecordedTrajectory:
    """Return the motion of a CSV of emovid's own, in meters and seconds, with the stage and robots of a scene.

    Raises:
        InputError: for a file that cannot be read or is not such a CSV.
    """
    track = Track(
        file=source.name, format="emovid", scale=1.0, y="up", robot=scene.robot.body, stage=scene.stage,
        emotion=scene.emotion, video=scene.video,
    )  # fmt: skip
    t, poses = _gathered(_own_csv(source, track), track, source)
    return Trajectory.from_poses(
        t, poses, body=track.robot, stage=track.stage, emotion=track.emotion, video=track.video
    )


def _gathered(samples: Samples, track: Track, source: Path) -> tuple[Array, Array]:
    """Return times (T,) [s] and poses (T, N, 3), or positions (T, N, 2) without headings, in meters, y up."""
    for name, robot in samples.items():
        if any(not np.isfinite(at) and np.isfinite(pose[:2]).all() for at, pose in robot.items()):
            raise InputError(f"{source}: {track.file}: robot {name} has a position without a time")
    rate = track.rate or 1.0  # without one, samples have times in seconds
    first, last = -np.inf if track.start is None else track.start, np.inf if track.end is None else track.end
    times = sorted(
        {at for robot in samples.values() for at in robot if first <= at / rate + 1e-9 and at / rate <= last + 1e-9}
    )
    if len(times) < 2:
        within = "" if track.start is None and track.end is None else " from start to end"
        raise InputError(f"{source}: fewer than two samples in {track.file}{within}")
    values = np.full((len(times), len(samples), 3), np.nan)
    at = {time: i for i, time in enumerate(times)}
    for i, robot in enumerate(samples.values()):
        for time, pose in robot.items():
            if time in at:
                values[at[time], i] = pose
    t = np.array(times) / rate
    missing: Mask = np.logical_not(np.isfinite(values[..., :2]).all(axis=2))
    if missing.any():
        _fill(values, t, missing, track, list(samples), source)
    sign = -1.0 if track.y == "down" else 1.0
    values[..., 0] = (values[..., 0] - track.origin.x) * track.scale
    values[..., 1] = sign * (values[..., 1] - track.origin.y) * track.scale
    values[..., 2] *= sign
    return t, values if np.isfinite(values[..., 2]).all() else values[..., :2]


def _fill(values: Array, t: Array, missing: Mask, track: Track, names: list[str], source: Path) -> None:
    """Interpolate positions that are missing; refuse them at the ends, or if the track does not allow it."""
    whole = np.flatnonzero(~missing.any(axis=1))
    for i, name in enumerate(names):
        known = np.flatnonzero(~missing[:, i])
        gap = np.flatnonzero(missing[:, i])
        if not len(gap):
            continue
        file = f"{source}: {track.file}" if is_track(source) else str(source)
        where = f"{file}: robot {name} has no position at {t[gap[0]]:.6g} s; "
        if track.gaps == "refuse":
            described = "" if is_track(source) else f" in a description of the file, NAME{SUFFIX}"
            raise InputError(f"{where}expected all positions, or gaps: interpolate{described}")
        if not len(known) or missing[0, i] or missing[-1, i]:
            first, last = (f"{t[k]:.6g}" for k in (whole[[0, -1]] if len(whole) else (0, -1)))
            remedy = f"expected start and end where all have one, such as {first} and {last} s" if len(whole) else ""
            raise InputError(f"{where}gaps at the start or end cannot be interpolated{remedy and '; ' + remedy}")
        for axis in (0, 1):
            values[gap, i, axis] = np.interp(t[gap], t[known], values[known, i, axis])
        values[gap, i, 2] = np.nan


def _scale_fault(points: Array, track: Track) -> str | None:
    """Return why positions (T, N, 2) [m] cannot be right: bodies all in one place, or a swarm never on its stage."""
    extent = float(np.ptp(points, axis=(0, 1)).max())
    if points.shape[1] > 1 and extent < track.robot.width:
        return (
            f"{track.scale:g}: all positions of {points.shape[1]} robots are within {1000 * extent:.3g} mm, and one "
            f"robot is {1000 * track.robot.width:.3g} mm wide; expected meters per unit of the file"
        )
    x, y = points[..., 0], points[..., 1]
    if not np.all([edge.x * x + edge.y * y <= edge.offset for edge in track.stage.edges], axis=0).any():
        return (
            f"{track.scale:g}: no position is on the stage: x from {x.min():.3g} to {x.max():.3g} m, y from "
            f"{y.min():.3g} to {y.max():.3g} m; expected another scale, origin, y or stage"
        )
    return None


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows of a CSV file with their line numbers.

    Raises:
        InputError: for a file that cannot be read, or a row that is not as long as the first one.
    """
    width = 0
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            for row in reader:
                width = width or len(row)
                if row and len(row) != width:
                    where = f"{path}:{reader.line_num}"
                    raise InputError(f"{where}: ragged row: {len(row)} cells where the header has {width}")
                if row:
                    yield reader.line_num, row
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read: {reason(error) if isinstance(error, OSError) else error}") from None


def _number(text: str, where: str) -> float:
    """Return a number; an empty cell or NaN is a missing one."""
    if not text.strip():
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{where}: {text!r}: expected a number") from None


def _own_csv(path: Path, _: Track) -> Samples:
    """The CSV of `emovid simulate`: time [s], robot, x, y [m], and perhaps heading [rad]; commands are left out."""
    names = {"time": "time", "robot": "robot", "x": "x", "y": "y"}
    return _long(path, names, optional={"heading": "heading"})


def _long_csv(path: Path, track: Track) -> Samples:
    columns = track.columns
    names = {"time": columns.time or columns.frame or "", "robot": columns.robot, "x": columns.x, "y": columns.y}
    return _long(path, names | ({"heading": columns.heading} if columns.heading else {}))


def _long(path: Path, names: Mapping[str, str], optional: Mapping[str, str] | None = None) -> Samples:
    rows = _rows(path)
    _, head = next(rows, (0, []))
    place = {key: head.index(name) for key, name in {**names, **(optional or {})}.items() if name in head}
    for key, name in names.items():
        if key not in place:
            commas = "; expected commas between columns" if len(head) == 1 and {";", "\t"} & set(head[0]) else ""
            has = commas or f"{nearest(name, head)}; it has {', '.join(head) or 'none'}"
            raise InputError(f"{path}: no column {name!r}{has}")
    samples: Samples = {}
    for line, row in rows:
        where = f"{path}:{line}"
        time, x, y = (_number(row[place[key]], where) for key in ("time", "x", "y"))
        heading = _number(row[place["heading"]], where) if "heading" in place else float("nan")
        robot = samples.setdefault(row[place["robot"]], {})
        if time in robot:
            raise InputError(f"{where}: robot {row[place['robot']]} is given twice at {time:g}")
        robot[time] = (x, y, heading)
    return samples


def _deeplabcut(path: Path, track: Track) -> Samples:
    """Three header rows (scorer, bodyparts, coords), or four with individuals; then a row for each frame."""
    rows = _rows(path)
    heads: dict[str, list[str]] = {}
    body = []
    for line, row in rows:
        if row[0] in ("scorer", "individuals", "bodyparts", "coords"):
            heads[row[0]] = row
        else:
            body.append((line, row))
    if not {"bodyparts", "coords"} <= heads.keys():
        raise InputError(f"{path}: not a DeepLabCut CSV: expected header rows scorer, bodyparts and coords")
    parts = list(dict.fromkeys(heads["bodyparts"][1:]))
    part = track.bodypart or (parts[0] if len(parts) == 1 else None)
    if part not in parts:
        given = f"{part}: " if part else ""
        raise InputError(f"{path}: bodypart: {given}expected one of {', '.join(parts)}{nearest(part or '', parts)}")
    samples: Samples = {}
    for i, (name, coord) in enumerate(zip(heads["bodyparts"], heads["coords"], strict=False)):
        if name != part or coord != "x":
            continue
        who = heads["individuals"][i] if "individuals" in heads else "1"
        for line, row in body:
            frame, x, y, likelihood = (_number(row[k], f"{path}:{line}") for k in (0, i, i + 1, i + 2))
            sure = likelihood >= track.likelihood
            samples.setdefault(who, {})[frame] = (x, y, float("nan")) if sure else (float("nan"),) * 3
    return samples


def _trex(path: Path, track: Track) -> Samples:
    """A folder of .npz or .csv files, one for each individual: X#wcentroid, Y#wcentroid [cm], time [s] or frame."""
    found = (
        [file for file in sorted(path.iterdir()) if not any(word in file.stem for word in _NOT_INDIVIDUALS)]
        if path.is_dir()
        else [path]
    )
    files = [file for file in found if file.suffix == ".npz"] or [file for file in found if file.suffix == ".csv"]
    clock = "time" if track.rate is None else "frame"
    samples: Samples = {}
    for file in files:
        arrays = _trex_arrays(file)
        for name in (clock, "X#wcentroid", "Y#wcentroid"):
            if name not in arrays:
                raise InputError(f"{file}: not an individual of TRex: no {name}; it has {', '.join(arrays)}")
        nan = float("nan")
        samples[file.stem] = {
            float(t): (float(a), float(b), nan) if np.isfinite([a, b]).all() else (nan, nan, nan)
            for t, a, b in zip(arrays[clock], arrays["X#wcentroid"], arrays["Y#wcentroid"], strict=True)
        }
    if not samples:
        raise InputError(f"{path}: expected a folder of TRex's files, .npz or .csv, one for each individual")
    return samples


def _trex_arrays(file: Path) -> Mapping[str, Array]:
    """Return the arrays of an individual by name; a CSV has units in parentheses behind the names."""
    if file.suffix == ".csv":
        (_, head), *rows = list(_rows(file)) or [(0, [])]
        columns = np.array([[_number(cell, f"{file}:{line}") for cell in row] for line, row in rows])
        columns = columns.reshape(len(rows), len(head)).T
        return {name.partition(" (")[0]: np.array(column) for name, column in zip(head, columns, strict=True)}
    try:
        with np.load(file, allow_pickle=False) as arrays:
            return {
                name: np.atleast_1d(np.asarray(arrays[name], float))
                for name in arrays
                if name in ("X#wcentroid", "Y#wcentroid", "time", "frame")
            }
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: not an individual of TRex: {error}") from None


def _idtracker(path: Path, track: Track) -> Samples:
    """The trajectories folder of a session: a CSV with x1, y1, x2, y2, ... and times, or frames with a rate."""
    found = sorted(path.rglob("*.csv")) if path.is_dir() else [path]
    names = [file for file in found if file.stem.startswith("trajectories")]
    if len(names) != 1:
        raise InputError(f"{path}: expected one trajectories CSV of idtracker.ai; found {len(names)}")
    rows = _rows(names[0])
    _, head = next(rows, (0, []))
    head = [name.strip() for name in head]
    timed = next((i for i, name in enumerate(head) if name in ("time", "seconds")), None)
    if timed is None and track.rate is None:
        raise InputError(f"{names[0]}: has no times; expected rate in the track{_rate_of(names[0].parent)}")
    samples: Samples = {}
    for frame, (line, row) in enumerate(rows):
        where = f"{names[0]}:{line}"
        time = float(frame) if timed is None or track.rate is not None else _number(row[timed], where)
        for i, name in enumerate(head):
            if name.startswith("x") and name[1:].isdigit():
                x, y = _number(row[i], where), _number(row[head.index(f"y{name[1:]}")], where)
                samples.setdefault(name[1:], {})[time] = (x, y, float("nan"))
    return samples


def _rate_of(folder: Path) -> str:
    """Return a hint with the rate that a session's attributes name, if they do."""
    file = folder / "attributes.json"
    try:
        return f"; {file.name} says {json.loads(file.read_text())['frames_per_second']}"
    except (OSError, ValueError, KeyError):
        return ""


def _mcap(path: Path, track: Track) -> Samples:
    """A ROS 2 bag (MCAP or SQLite) with geometry_msgs/PoseArray messages; needs the extra `bags`."""
    try:
        from rosbags.highlevel import AnyReader  # noqa: PLC0415 - an extra
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415
    except ImportError:
        raise InputError(f"{path}: ROS bags need the extra bags: pip install 'emovid[bags]'") from None
    samples: Samples = {}
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            arrays = [each for each in bag.connections if each.msgtype == "geometry_msgs/msg/PoseArray"]
            topics = sorted({each.topic for each in arrays})
            topic = track.topic or (topics[0] if len(topics) == 1 else None)
            if topic not in topics:
                expected = f"expected one of {', '.join(topics) or 'none: it has no PoseArray messages'}"
                raise InputError(f"{path}: topic: {expected}{nearest(topic or '', topics)}")
            for connection, stamp, raw in bag.messages([each for each in arrays if each.topic == topic]):
                message: Any = bag.deserialize(raw, connection.msgtype)
                time = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec or 1e-9 * stamp
                for i, pose in enumerate(message.poses):
                    q = pose.orientation
                    heading = np.arctan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
                    samples.setdefault(str(i + 1), {})[time] = (pose.position.x, pose.position.y, float(heading))
    except InputError:
        raise
    except Exception as error:  # rosbags documents no base class for broken bags
        raise InputError(f"{path}: not a readable ROS bag: {error}") from None
    return samples


_READERS: Mapping[str, Callable[[Path, Track], Samples]] = {
    "emovid": _own_csv,
    "long": _long_csv,
    "deeplabcut": _deeplabcut,
    "trex": _trex,
    "idtracker": _idtracker,
    "mcap": _mcap,
}
