"""The pinhole: from metres in the room to pixels of a frame, along straight lines through one point."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from emovid.scene.stage import Stage
from emovid.scene.video import Video
from emovid.scene.view import Aim, aim_of
from emovid.swarm.arrays import Array
from emovid.swarm.coverage import corners_of


@dataclass(frozen=True)
class Pinhole:
    """Looks at the stage from its side.

    Attributes:
        width, height: of the frame [pixels].
        aim: where it is and looks.
        middle: of the stage (x, y) [m], where `scale` is taken.
        nearest: the corner of the stage (x, y) [m] nearest to it, where `finest` is.
    """

    width: int
    height: int
    aim: Aim
    middle: tuple[float, float]
    nearest: tuple[float, float]

    @classmethod
    def framing(cls, stage: Stage, video: Video, tallest: float) -> Self:
        """Return the camera of a video for a stage with robots as high as `tallest` [m]."""
        aim = aim_of(video, stage, tallest)
        left, bottom, right, top = stage.box
        middle = (left + right) / 2, (bottom + top) / 2
        corners = corners_of(stage)
        nearest = corners[np.hypot(*(corners - [aim.x, aim.y]).T).argmin()]
        return cls(video.width, video.height, aim, middle, (float(nearest[0]), float(nearest[1])))

    @property
    def eye(self) -> Array:
        """Where it is (3,) [m]."""
        return np.array(self.aim[:3])

    @cached_property
    def axes(self) -> Array:
        """Unit vectors (3, 3) to the right and up in the picture, and along the way it looks."""
        cos, sin = np.cos(self.aim.tilt), np.sin(self.aim.tilt)
        return np.array([[1.0, 0.0, 0.0], [0.0, sin, cos], [0.0, cos, -sin]])

    @cached_property
    def scale(self) -> float:
        """Pixels per metre across the picture, in the middle of the stage."""
        return float(self.aim.focal / self._depth(np.array([*self.middle, 0.0])))

    @cached_property
    def finest(self) -> float:
        """Most pixels per metre on the stage, in any direction."""
        near = self.turns(np.array([self.nearest]), 1.0)[0, :2, :2] * self.scale
        return float(np.linalg.norm(near, ord=2))

    @property
    def horizon(self) -> float:
        """How far above the lower edge of the frame the floor ends [pixels]; infinite if it looks straight down."""
        cos, sin = np.cos(self.aim.tilt), np.sin(self.aim.tilt)
        return float(self.height / 2 + self.aim.focal * sin / cos) if cos > 1e-9 else np.inf

    def project(self, points: Array) -> Array:
        """Return where points (..., 3) [m] before the camera lie in the frame (..., 2) [pixels].

        From its lower left corner, y upwards.
        """
        seen = (points - self.eye) @ self.axes.T
        return self.aim.focal * seen[..., :2] / seen[..., 2:] + np.array([self.width, self.height]) / 2

    def pixels(self, points: Array) -> Array:
        """Return where points (..., 2) [m] of the floor lie in the frame [pixels]. See `project`."""
        return self.project(np.concatenate([points, np.zeros_like(points[..., :1])], axis=-1))

    def metres(self, pixels: Array) -> Array:
        """Return which places of the floor (..., 2) [m] lie below the horizon at (..., 2) [pixels]."""
        offset = (pixels - np.array([self.width, self.height]) / 2) / self.aim.focal
        rays = np.concatenate([offset, np.ones_like(offset[..., :1])], axis=-1) @ self.axes
        return self.eye[:2] - self.eye[2] * rays[..., :2] / rays[..., 2:]

    def turns(self, points: Array, radius: float) -> Array:
        """Return the maps (N, 3, 3) from the unit circle to small discs on the floor at points (N, 2) [m].

        Args:
            points: their middles.
            radius: that they would have in the middle of the stage, were they upright there [pixels].
        """
        maps = np.zeros((len(points), 3, 3))
        depth = self._depth(np.concatenate([points, np.zeros((len(points), 1))], axis=1))[:, None]
        offset = (self.pixels(points) - np.array([self.width, self.height]) / 2) / self.aim.focal
        # The derivative of (right, up) / depth along x and along y of the floor.
        for i in range(2):
            right_up, away = self.axes[:2, i], self.axes[2, i]
            maps[:, :2, i] = self.aim.focal * (right_up - offset * away) / depth
        maps[:, :2, :2] *= radius / self.scale
        maps[:, 2, 2] = 1
        return maps

    def cover(self, stage: Stage, pixels: Array) -> Array:
        """Return how much of the pixels with middles (..., 2) shows the stage: 0 to 1, to within some hundredths."""
        corners = self.pixels(corners_of(stage))
        along = np.roll(corners, -1, axis=0) - corners
        outward = np.stack([along[:, 1], -along[:, 0]], axis=-1) / np.hypot(*along.T)[:, None]
        beyond = [(pixels - corner) @ normal for corner, normal in zip(corners, outward, strict=True)]
        return np.clip(0.5 - np.max(beyond, axis=0), 0, 1)

    def _depth(self, points: Array) -> Array:
        return (points - self.eye) @ self.axes[2]
