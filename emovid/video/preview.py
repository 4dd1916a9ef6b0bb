"""A run at a glance: small, at few frames a second, for tuning and for notebooks."""

import base64
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from emovid.scene.video import MAX_SIDE, MIN_SIDE, FormatName, Video
from emovid.swarm.trajectory import Trajectory
from emovid.video.render import render_video


@dataclass(frozen=True)
class Player:
    """A video that plays in a notebook, again and again.

    Attributes:
        mp4: the video.
        label: what it says where nothing plays.
        width: it is shown at [pixels].
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
    """Return a player of a trajectory, which Jupyter shows in the place of the last value of a cell.

    Args:
        trajectory: with the scene whose `video` is the look.
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
    """Return the same run with a smaller video: `width` [pixels], the height in proportion, `fps` at most."""
    video = reduced_video(trajectory.scene.video, width).model_copy(
        update={"fps": max(min(fps, trajectory.scene.video.fps), 1), "format": format}
    )
    return replace(trajectory, scene=trajectory.scene.model_copy(update={"video": video}))


def reduced_video(video: Video, width: int) -> Video:
    """Return the look of a video at another width [pixels], the height in proportion, both even and within bounds."""
    height = round(width * video.height / video.width)
    sides = (min(max(side - side % 2, MIN_SIDE), MAX_SIDE) for side in (width, height))
    return video.model_copy(update={"size": "{}x{}".format(*sides)})
