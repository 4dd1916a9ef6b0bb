"""Figures of any scene, run or video at some times: snapshots with trails, and contact sheets of frames."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from emovid.errors import InputError, reason
from emovid.figures.catalogue import Entry
from emovid.figures.contact import contact_figure, in_rows, picture_width
from emovid.figures.runs import frames_figure
from emovid.figures.style import DOUBLE_COLUMN, SINGLE_COLUMN
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene
from emovid.scene.model import Scene
from emovid.swarm.files import is_run, load_trajectory
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.frame_reader import frame_times, read_frames
from emovid.video.painter import Painter

Pictures = Callable[[int], NDArray[np.uint8]]  # from a width [pixels] to frames (K, height, width, 3)

FRAMES, CONTACT = "frames", "contact-sheet"
_SOURCES = {
    FRAMES: "one scene: a file (.yaml), a finished run (.npz), or an emotion",
    CONTACT: "one video file, scene (.yaml), finished run (.npz) or emotion",
}
_ON_A_SHEET = 16  # frames: one a second in a run of 15 s
MOST = 100  # times
_MAX_RATIO = 3  # of height to width of a picture on a sheet: enough for videos of a phone held upright


class Moments(NamedTuple):
    """The times of a figure.

    Attributes:
        times: seconds with commas between; None for times at equal distances, or the default ones.
        number: of times at equal distances from start to end; None for the default times.
    """

    times: str | None
    number: int | None

    def within(self, end: float, default: Sequence[float]) -> list[float]:
        """Return the times [s]; an `InputError` is raised for a time outside the run."""
        if self.times is None:
            return list(default) if self.number is None else _evenly(self.number, end)
        try:
            chosen = [float(part) for part in self.times.split(",")]
        except ValueError:
            raise InputError(f"--times {self.times}: expected seconds with commas between, as in 0,2,8") from None
        for t in chosen:
            if not 0 <= t <= end:
                raise InputError(f"--times {self.times}: {t:g} s is outside the run of 0 to {end:g} s")
        if len(chosen) > MOST:
            raise InputError(f"--times: {len(chosen)} times; expected at most {MOST}")
        return chosen


def figure_at_times(kind: str, sources: Sequence[str], moments: Moments, settings: Sequence[Setting]) -> Entry:
    """Return the figure of a source at some times; errors in the times are raised here.

    Args:
        kind: `FRAMES` or `CONTACT`.
        sources: exactly one.
        moments: the times.
        settings: keys of the scene to replace.
    """
    if len(sources) != 1:
        raise InputError(f"{kind}: expected {_SOURCES[kind]}")
    (source,) = sources
    if Path(source).is_dir() and source not in EMOTIONS:
        raise InputError(f"{source}: is a folder; expected {_SOURCES[kind]}")
    if kind == FRAMES:
        return _entry(source, FRAMES, frames_figure, *_run(source, moments, _snapshot_times, settings))
    if is_run(source) or Path(source).suffix.lower() in (".yaml", ".yml", ""):  # "": an emotion, or a misspelled one
        return _sheet_of_scene(source, moments, settings)
    return _sheet_of_video(source, moments, settings)


def _evenly(count: int, end: float) -> list[float]:
    """Return `count` times from 0 to the end [s]; a single one is the end."""
    return [end * k / (count - 1) for k in range(count)] if count > 1 else [end]


def _snapshot_times(scene: Scene, end: float) -> Sequence[float]:
    own = scene.snapshot_times
    return own if own and own[-1] <= end else _evenly(3, end)


def _run(
    source: str, moments: Moments, default: Callable[[Scene, float], Sequence[float]], settings: Sequence[Setting]
) -> tuple[Trajectory, list[float]]:
    """Return the run of a scene, or a finished one, and the times, which are checked before the simulation.

    Args:
        source: a scene or a finished run.
        moments: the times.
        default: from a scene and its end [s] to its default times.
        settings: keys of the scene to replace.
    """
    if is_run(source):
        run = load_trajectory(Path(source), settings)
        end = float(run.t[-1])
        return run, moments.within(end, default(run.scene, end))
    scene = load_scene(source, settings)
    times = moments.within(scene.duration, default(scene, scene.duration))
    return simulate(scene), times


def _sheet_of_scene(source: str, moments: Moments, settings: Sequence[Setting]) -> Entry:
    run, times = _run(source, moments, lambda _, end: _evenly(_ON_A_SHEET, end), settings)
    video = run.scene.video

    def pictures(width: int) -> NDArray[np.uint8]:
        size = "{}x{}".format(*_scaled(width, video.width, video.height))
        painter = Painter(run, video.model_copy(update={"size": size}))
        return np.stack([painter.frame(t)[..., :3].copy() for t in times])

    return _entry(source, CONTACT, _sheet, pictures, times)


def _sheet_of_video(source: str, moments: Moments, settings: Sequence[Setting]) -> Entry:
    if settings:
        raise InputError(f"{settings[0].origin}: {source} is a video; only scenes have keys to replace")
    path = Path(source)
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"{source}: cannot be read: {reason(error)}") from None
    film = frame_times(path)
    times = moments.within(film.end, _evenly(_ON_A_SHEET, film.end))

    def pictures(width: int) -> NDArray[np.uint8]:
        size = _scaled(width, film.width, film.height)
        return read_frames(path, film.frames_at(np.array(times)).tolist(), *size)

    return _entry(source, CONTACT, _sheet, pictures, times)


def _scaled(width: int, video_width: int, video_height: int) -> tuple[int, int]:
    """Return the size of pictures with a video's proportions: of a width [pixels], or narrower if too tall."""
    scale = min(width / video_width, _MAX_RATIO * width / video_height)
    return max(round(video_width * scale), 1), max(round(video_height * scale), 1)


def _sheet(pictures: Pictures, times: Sequence[float], *, width: float) -> Figure:
    """Draw frames in rows, the time under each."""
    columns = min(len(times), 4 if width > SINGLE_COLUMN else 2)
    grid = in_rows(pictures(picture_width(columns, width)), columns)
    return contact_figure(grid, captions=[f"{round(t, 2):g} s" for t in times], width=width)


def _entry(
    source: str, kind: str, draw: Callable[..., Figure], shown: Trajectory | Pictures, times: Sequence[float]
) -> Entry:
    def parts(_: Any) -> Sequence[Any]:
        return shown, times

    caption = f"{source} at {', '.join(f'{t:.4g}' for t in times)} s"
    return Entry(f"{Path(source).stem}-{kind}", "", caption, draw, parts, DOUBLE_COLUMN)
