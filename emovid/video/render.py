"""From a trajectory to a video: files, checksums, and players for notebooks."""

import base64
import tempfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from emovid.errors import InputError
from emovid.scene.video import MAX_SIDE, MIN_SIDE, FormatName
from emovid.swarm.arrays import Array
from emovid.swarm.trajectory import Trajectory
from emovid.video.canvas import Change, Pixels
from emovid.video.encoder import FORMATS, video_arguments, write_pictures, write_video
from emovid.video.painter import Painter
from emovid.video.pixel_formats import Colours24, PaletteIndices, Yuv420, frequent_colours

_SAMPLES = 8  # frames from which the colors of a GIF are chosen


def render_video(
    trajectory: Trajectory,
    target: str | Path,
    on_frame: Callable[[int], None] | None = None,
    *,
    crf: int | None = None,
) -> str:
    """Write a trajectory as a video: a complete file, or none.

    Frame k shows the time begin + k speed / fps of the run, as in `video`.

    Args:
        trajectory: its scene's `video` gives look and format.
        target: in an existing folder; itself a folder if the format is a sequence of pictures.
        on_frame: called with the number of frames done.
        crf: see `encoder_arguments`.

    Returns:
        The checksum of the frames, in hexadecimal: where files differ, it tells whether frames do.

    Raises:
        InputError: if the name does not end like the format's files, or a sequence would replace something else.
        RenderError: if the video cannot be made.
    """
    if not isinstance(trajectory, Trajectory):
        raise InputError(f"render_video: {trajectory!r} is not a trajectory; expected the result of simulate(scene)")
    scene = trajectory.scene
    suffix = FORMATS[scene.video.format].suffix
    if suffix and Path(target).suffix.lower() not in ("", suffix):
        expected = f"expected {suffix}, or a scene whose video.format is another"
        raise InputError(f"{target}: cannot write {Path(target).suffix}; {expected}")
    write = write_pictures if scene.video.format == "png-sequence" else write_video
    drawn = _DrawnFrames(trajectory)
    write(_encodable(drawn, trajectory), scene.frames, video_arguments(scene.video, crf), Path(target), on_frame)
    return drawn.checksum


def frames_checksum(trajectory: Trajectory) -> str:
    """Return the checksum of `render_video`, without encoding anything."""
    drawn = _DrawnFrames(trajectory)
    for _ in drawn:
        pass
    return drawn.checksum


def frames(trajectory: Trajectory) -> Iterator[Pixels]:
    """Yield the frames of a video, RGBA, each overwritten by the next."""
    painter = Painter(trajectory)
    for t in _frame_times(trajectory):
        yield painter.frame(t)


@dataclass(frozen=True)
class Player:
    """A video that plays in a loop in a notebook.

    Attributes:
        mp4: the video.
        label: text where nothing plays.
        width: of the player [pixels].
    """

    mp4: bytes
    label: str
    width: int

    def __repr__(self) -> str:
        return f"Player({self.label})"

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.mp4).decode()
        return (
            f'<video autoplay loop muted playsinline controls width="{self.width}" '
            f'src="data:video/mp4;base64,{data}">{self.label}</video>'
        )


def show(trajectory: Trajectory, width: int = 480, fps: int = 15) -> Player:
    """Return a player of a trajectory, which Jupyter shows as the last value of a cell.

    Args:
        trajectory: its scene's `video` gives the look.
        width: of the player [pixels], the height in proportion; both are made even and large enough for a video.
        fps: frames per second, at most those of the scene.

    Raises:
        RenderError: if the video cannot be made.
    """
    run = reduced(trajectory, width, fps)
    scene = run.scene
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "run.mp4"
        render_video(run, target)
        label = f"{scene.emotion or 'a swarm'}, {scene.duration:g} s, {scene.video.size}"
        return Player(target.read_bytes(), label, scene.video.width)


def reduced(trajectory: Trajectory, width: int, fps: int, format: FormatName = "mp4") -> Trajectory:
    """Return the same run with a smaller video.

    Args:
        trajectory: any run.
        width: of the video [pixels], the height in proportion; both are made even and kept within bounds.
        fps: frames per second, at most those of the scene.
        format: of the video.
    """
    video = trajectory.scene.video
    sides = (
        min(max(side - side % 2, MIN_SIDE), MAX_SIDE) for side in (width, round(width * video.height / video.width))
    )
    smaller = {"size": "{}x{}".format(*sides), "fps": max(min(fps, video.fps), 1), "format": format}
    return replace(trajectory, scene=trajectory.scene.model_copy(update={"video": video.model_copy(update=smaller)}))


class _DrawnFrames:
    """The frames of a video, each with its changes; a frame is overwritten by the next.

    Attributes:
        checksum: CRC-32 of the changed pixels of the frames taken so far.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        self._crc = 0

    def __iter__(self) -> Iterator[tuple[Pixels, Change]]:
        painter = Painter(self._trajectory)
        for t in _frame_times(self._trajectory):
            picture, changed = painter.frame(t), painter.changed()
            self._crc = zlib.crc32(
                changed.pixels.tobytes(), zlib.crc32(changed.where.astype("<i8").tobytes(), self._crc)
            )
            yield picture, changed

    @property
    def checksum(self) -> str:
        return f"{self._crc:08x}"


def _encodable(drawn: Iterable[tuple[Pixels, Change]], trajectory: Trajectory) -> Iterator[Pixels]:
    """Return frames in the pixel format of the video's encoder, each overwritten by the next."""
    video = trajectory.scene.video
    match FORMATS[video.format].pixels:
        case "rgba":
            return (picture for picture, _ in drawn)
        case "yuv420p":
            convert = Yuv420(video.width, video.height).convert
        case "pal8":  # pragma: no branch - there is no other format
            convert = PaletteIndices(video.width, video.height, _palette(trajectory)).convert
    return (convert(picture, changed) for picture, changed in drawn)


def _frame_times(trajectory: Trajectory) -> Array:
    """Return the times of the run that the frames show (F,) [s]."""
    scene, video = trajectory.scene, trajectory.scene.video
    return np.minimum(video.begin + np.arange(scene.frames) * video.speed / video.fps, trajectory.t[-1])


def _palette(trajectory: Trajectory) -> Colours24:
    """Return the most frequent colors in some frames of a video."""
    times, painter = _frame_times(trajectory), Painter(trajectory)
    chosen = np.linspace(0, len(times) - 1, min(_SAMPLES, len(times))).round().astype(int)
    return frequent_colours(painter.frame(t) for t in times[chosen])
