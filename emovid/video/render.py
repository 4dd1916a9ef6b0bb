"""From a trajectory to a video: the door of this room."""

import zlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from emovid.scene.video import Video
from emovid.swarm.arrays import Array
from emovid.swarm.trajectory import Trajectory
from emovid.video.canvas import Box, Pixels
from emovid.video.draw import Painter
from emovid.video.encode import write_pictures, write_video
from emovid.video.formats import FORMATS, encoder_arguments
from emovid.video.indexed import Colours24, Indexed, frequent_colours
from emovid.video.yuv import Yuv420

_SAMPLES = 8  # frames that a GIF's colours are chosen from


def render_video(
    trajectory: Trajectory,
    target: str | Path,
    on_frame: Callable[[int], None] | None = None,
    *,
    crf: int | None = None,
) -> str:
    """Write a trajectory as a video into `target`: complete, or not at all.

    Frame k shows the time k / fps.

    Args:
        trajectory: with the scene whose `video` is the look, and the format.
        target: in a folder that exists; itself a folder if the format is a sequence of pictures.
        on_frame: called with the number of frames done.
        crf: see `encoder_arguments`.

    Returns:
        The checksum of the frames, in hexadecimal: where files differ, it tells whether frames do.

    Raises:
        InputError: if something else is in the way of a sequence.
        RenderError: if it cannot be made.
    """
    scene = trajectory.scene
    write = write_pictures if scene.video.format == "png-sequence" else write_video
    drawn = _Drawn(trajectory)
    write(_encodable(drawn, trajectory), scene.frames, video_arguments(scene.video, crf), Path(target), on_frame)
    return drawn.checksum


def frames_checksum(trajectory: Trajectory) -> str:
    """Return what `render_video` does, without encoding anything."""
    drawn = _Drawn(trajectory)
    for _ in drawn:
        pass
    return drawn.checksum


def frames(trajectory: Trajectory) -> Iterator[Pixels]:
    """Yield the frames of a video, RGBA; each is overwritten by the next."""
    painter = Painter(trajectory)
    for t in _times(trajectory):
        yield painter.frame(t)


def video_arguments(video: Video, crf: int | None = None) -> list[str]:
    """Return the encoder's arguments for a scene's video. See `encoder_arguments`."""
    return encoder_arguments(video.width, video.height, video.fps, video.format, crf)


class _Drawn:
    """The frames of a video, each with the boxes that hold what changed; a frame is overwritten by the next.

    Attributes:
        checksum: of the frames that have been taken: the CRC-32 of what is in the boxes, a tenth of all there is.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        self._crc = 0

    def __iter__(self) -> Iterator[tuple[Pixels, list[Box]]]:
        painter = Painter(self._trajectory)
        for t in _times(self._trajectory):
            picture, changed = painter.frame(t), painter.changed()
            for top, bottom, left, right in changed:
                self._crc = zlib.crc32(picture[top:bottom, left:right].tobytes(), self._crc)
            yield picture, changed

    @property
    def checksum(self) -> str:
        return f"{self._crc:08x}"


def _encodable(drawn: Iterable[tuple[Pixels, list[Box]]], trajectory: Trajectory) -> Iterator[Pixels]:
    """Return frames in the pixels that the video's encoder takes; each is overwritten by the next."""
    video = trajectory.scene.video
    match FORMATS[video.format].pixels:
        case "rgba":
            return (picture for picture, _ in drawn)
        case "yuv420p":
            convert = Yuv420(video.width, video.height).convert
        case "pal8":  # pragma: no branch - there is no other kind
            convert = Indexed(video.width, video.height, _frequent_colours(trajectory)).convert
    return (convert(picture, changed) for picture, changed in drawn)


def _times(trajectory: Trajectory) -> Array:
    """Return the times of the frames (F,) [s]."""
    scene = trajectory.scene
    return np.minimum(np.arange(scene.frames) / scene.video.fps, trajectory.t[-1])


def _frequent_colours(trajectory: Trajectory) -> Colours24:
    """Return the colours that most pixels of a video have, from some of its frames."""
    times, painter = _times(trajectory), Painter(trajectory)
    chosen = np.linspace(0, len(times) - 1, min(_SAMPLES, len(times))).round().astype(int)
    return frequent_colours(painter.frame(t) for t in times[chosen])
