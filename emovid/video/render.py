"""From a trajectory to a video file: the door of this room."""

from collections.abc import Callable, Iterator
from pathlib import Path

from emovid.scene.video import Video
from emovid.swarm.trajectory import Trajectory
from emovid.video.draw import Painter, Pixels
from emovid.video.encode import encoder_arguments, write_video


def render_video(trajectory: Trajectory, target: Path, on_frame: Callable[[int], None] | None = None) -> None:
    """Write a trajectory as a video into `target`: complete, or not at all.

    Frame k shows the time k / fps.

    Args:
        trajectory: with the scene whose `video` is the look.
        target: an .mp4 in a folder that exists.
        on_frame: called with the number of frames done.

    Raises:
        RenderError: if it cannot be made.
    """
    scene = trajectory.scene
    write_video(frames(trajectory), scene.frames, video_arguments(scene.video), target, on_frame)


def frames(trajectory: Trajectory) -> Iterator[Pixels]:
    """Yield the frames of a video; each is overwritten by the next."""
    painter = Painter(trajectory)
    end = float(trajectory.t[-1])
    for k in range(trajectory.scene.frames):
        yield painter.frame(min(k / trajectory.scene.video.fps, end))


def video_arguments(video: Video) -> list[str]:
    """Return the encoder's arguments for a scene's video."""
    return encoder_arguments(video.width, video.height, video.fps)
