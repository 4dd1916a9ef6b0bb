"""Figures of any scene, run or video at some times: snapshots with trails, and contact sheets of frames."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from emovid.cli.options import is_run
from emovid.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from emovid.figures.catalogue import Entry
    from emovid.scene.load import Setting
    from emovid.scene.model import Scene
    from emovid.swarm.trajectory import Trajectory

    Pictures = Callable[[int], NDArray[np.uint8]]  # frames (K, height, width, 3) of some width [pixels]

FRAMES, CONTACT = "frames", "contact-sheet"
_KINDS = {
    FRAMES: "one scene: a file (.yaml), a finished run (.npz), or an emotion",
    CONTACT: "one video file, scene (.yaml), finished run (.npz) or emotion",
}
_ON_A_SHEET = 16  # frames: in a run of 15 s, one a second
MOST = 100  # times
_TALLEST = 3  # times as high as wide may a picture have room: a video of a telephone fills it, one of a ruler does not


class Moments(NamedTuple):
    """The times that are asked for.

    Attributes:
        times: seconds with commas between; None for others.
        number: of times from start to end; None for the default.
    """

    times: str | None
    number: int | None

    def within(self, end: float, default: Sequence[float]) -> list[float]:
        """Return the times [s], held against the end of the run."""
        if self.times is None:
            return list(default) if self.number is None else evenly(self.number, end)
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


def evenly(count: int, end: float) -> list[float]:
    """Return so many times from 0 to the end [s]; one is the end."""
    return [end * k / (count - 1) for k in range(count)] if count > 1 else [end]


def at_times(kind: str, sources: Sequence[str], asked: Moments, overrides: "Sequence[Setting]") -> "Entry":
    """Return the figure of what a source shows at some times, which are held against it here.

    Args:
        kind: `FRAMES` or `CONTACT`.
        sources: one.
        asked: the times.
        overrides: keys of the scene to replace.
    """
    from emovid.scene.emotions import EMOTIONS

    if len(sources) != 1:
        raise InputError(f"{kind}: expected {_KINDS[kind]}")
    (source,) = sources
    if Path(source).is_dir() and source not in EMOTIONS:
        raise InputError(f"{source}: is a folder; expected {_KINDS[kind]}")
    if kind == FRAMES:
        return _frames(source, asked, overrides)
    return _sheet_of_scene(source, asked, overrides) if _is_scene(source) else _sheet_of_film(source, asked, overrides)


def _is_scene(source: str) -> bool:
    """Return whether a source is no video: a scene, a run, or a word that names neither and will be said to."""
    return is_run(source) or Path(source).suffix.lower() in (".yaml", ".yml", "")


def _run(
    source: str, asked: Moments, usual: "Callable[[Scene, float], Sequence[float]]", overrides: "Sequence[Setting]"
) -> "tuple[Trajectory, list[float]]":
    """Return the run of a scene, or a finished one, and the times, which are held against it before it is simulated.

    Args:
        source: a scene or a finished run.
        asked: the times.
        usual: gives those of a scene and its end [s] if none are asked for.
        overrides: keys of the scene to replace.
    """
    from emovid.scene.load import load_scene
    from emovid.swarm.files import load_trajectory
    from emovid.swarm.simulate import simulate

    if is_run(source):
        run = load_trajectory(Path(source), overrides)
        end = float(run.t[-1])
        return run, asked.within(end, usual(run.scene, end))
    scene = load_scene(source, overrides)
    times = asked.within(scene.duration, usual(scene, scene.duration))
    return simulate(scene), times


def _frames(source: str, asked: Moments, overrides: "Sequence[Setting]") -> "Entry":
    from emovid.figures.runs import frames_figure

    def usual(scene: "Scene", end: float) -> Sequence[float]:
        own = scene.snapshot_times
        return own if own and own[-1] <= end else evenly(3, end)

    return _entry(source, FRAMES, frames_figure, *_run(source, asked, usual, overrides))


def _sheet_of_scene(source: str, asked: Moments, overrides: "Sequence[Setting]") -> "Entry":
    import numpy as np

    from emovid.video.painter import Painter

    run, times = _run(source, asked, lambda _, end: evenly(_ON_A_SHEET, end), overrides)
    video = run.scene.video

    def pictures(width: int) -> "NDArray[np.uint8]":
        size = "{}x{}".format(*_within(width, video.width, video.height))
        painter = Painter(run, video.model_copy(update={"size": size}))
        return np.stack([painter.frame(t)[..., :3].copy() for t in times])

    return _entry(source, CONTACT, _sheet, pictures, times)


def _sheet_of_film(source: str, asked: Moments, overrides: "Sequence[Setting]") -> "Entry":
    import numpy as np

    from emovid.errors import reason
    from emovid.video.frame_reader import frame_times, read_frames

    if overrides:
        raise InputError(f"{overrides[0].origin}: {source} is a video; only scenes have keys to replace")
    path = Path(source)
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"{source}: cannot be read: {reason(error)}") from None
    film = frame_times(path)
    times = asked.within(film.end, evenly(_ON_A_SHEET, film.end))

    def pictures(width: int) -> "NDArray[np.uint8]":
        size = _within(width, film.width, film.height)
        return read_frames(path, film.frames_at(np.array(times)).tolist(), *size)

    return _entry(source, CONTACT, _sheet, pictures, times)


def _within(width: int, wide: int, high: int) -> tuple[int, int]:
    """Return the size of pictures of a video's form: of some width [pixels], or narrower where they were too tall."""
    scale = min(width / wide, _TALLEST * width / high)
    return max(round(wide * scale), 1), max(round(high * scale), 1)


def _sheet(pictures: "Pictures", times: Sequence[float], *, width: float) -> "Figure":
    """Draw frames in rows, the time under each."""
    from emovid.figures.contact import contact_figure, in_rows, picture_width
    from emovid.figures.style import SINGLE_COLUMN

    columns = min(len(times), 4 if width > SINGLE_COLUMN else 2)
    grid = in_rows(pictures(picture_width(columns, width)), columns)
    return contact_figure(grid, captions=[f"{round(t, 2):g} s" for t in times], width=width)


def _entry(source: str, kind: str, draw: "Callable[..., Figure]", shown: Any, times: Sequence[float]) -> "Entry":
    from emovid.figures.catalogue import Entry
    from emovid.figures.style import DOUBLE_COLUMN

    said = f"What {source} shows at {', '.join(f'{t:.4g}' for t in times)} s"
    return Entry(f"{Path(source).stem}-{kind}", "", said, draw, lambda _: (shown, times), DOUBLE_COLUMN)
