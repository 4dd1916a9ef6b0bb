"""Cameras: from meters on the stage to pixels of a frame, from straight above or in perspective.

Pixels are counted from the lower left corner of the frame, y upward.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from emovid.scene.stage import Stage
from emovid.scene.video import MARGIN, Aim, Video, aim_of
from emovid.swarm.arrays import Array
from emovid.swarm.laws import corners_of


@dataclass(frozen=True)
class OverheadCamera:
    """A camera that looks straight down on the stage.

    Attributes:
        width, height: frame size [pixels].
        scale: pixels per meter.
        centre: point (x, y) [m] in the middle of the frame.
    """

    width: int
    height: int
    scale: float
    centre: tuple[float, float]

    @classmethod
    def framing(cls, stage: Stage, width: int, height: int) -> Self:
        """Return the camera that shows the whole stage as large as the frame allows."""
        margin = 2 * MARGIN * min(width, height)
        left, bottom, right, top = stage.box
        scale = min((width - margin) / (right - left), (height - margin) / (top - bottom))
        return cls(width, height, scale, ((left + right) / 2, (bottom + top) / 2))

    @property
    def max_scale(self) -> float:
        """Largest scale anywhere on the stage [pixels per meter]: the same everywhere."""
        return self.scale

    def pixels(self, points: Array) -> Array:
        """Return the pixels (..., 2) of points (..., 2) [m]."""
        return self.scale * (points - np.array(self.centre)) + np.array([self.width, self.height]) / 2

    def metres(self, pixels: Array) -> Array:
        """Return the points (..., 2) [m] of pixels (..., 2): the inverse of `pixels`."""
        return (pixels - np.array([self.width, self.height]) / 2) / self.scale + np.array(self.centre)

    def disc_maps(self, points: Array, radius: float) -> Array:
        """Return the maps (N, 3, 3) from the unit circle to disks at points (N, 2) [m], of a radius [pixels]."""
        return np.repeat(np.diag([radius, radius, 1.0])[None], len(points), axis=0)

    def stage_share(self, stage: Stage, pixels: Array) -> Array:
        """Return 1.0 for pixels (..., 2) on the stage and 0.0 for others."""
        x, y = np.moveaxis(self.metres(pixels), -1, 0)
        return np.all([edge.x * x + edge.y * y <= edge.offset for edge in stage.edges], axis=0).astype(float)


@dataclass(frozen=True)
class PinholeCamera:
    """A camera at the side of the stage: straight lines from points in space through the eye.

    Attributes:
        width, height: frame size [pixels].
        aim: position and direction.
        middle: point of the stage (x, y) [m] at which `scale` is measured.
        nearest: corner of the stage (x, y) [m] nearest to the camera, at which `max_scale` is measured.
    """

    width: int
    height: int
    aim: Aim
    middle: tuple[float, float]
    nearest: tuple[float, float]

    @classmethod
    def framing(cls, stage: Stage, video: Video, tallest: float) -> Self:
        """Return the camera of a video for a stage with robots up to `tallest` high [m]."""
        aim = aim_of(video, stage, tallest)
        left, bottom, right, top = stage.box
        middle = (left + right) / 2, (bottom + top) / 2
        corners = corners_of(stage)
        nearest = corners[np.hypot(*(corners - [aim.x, aim.y]).T).argmin()]
        return cls(video.width, video.height, aim, middle, (float(nearest[0]), float(nearest[1])))

    @property
    def eye(self) -> Array:
        """Position (3,) [m]."""
        return np.array(self.aim[:3])

    @cached_property
    def axes(self) -> Array:
        """Unit vectors (3, 3): right and up in the frame, and the viewing direction."""
        cos, sin = np.cos(self.aim.tilt), np.sin(self.aim.tilt)
        return np.array([[1.0, 0.0, 0.0], [0.0, sin, cos], [0.0, cos, -sin]])

    @cached_property
    def scale(self) -> float:
        """Pixels per meter across the frame in the middle of the stage."""
        return float(self.aim.focal / self._depth(np.array([*self.middle, 0.0])))

    @cached_property
    def max_scale(self) -> float:
        """Largest scale anywhere on the stage, in any direction [pixels per meter]."""
        near = self.disc_maps(np.array([self.nearest]), 1.0)[0, :2, :2] * self.scale
        return float(np.linalg.norm(near, ord=2))

    @property
    def horizon(self) -> float:
        """Height of the horizon above the lower edge of the frame [pixels]; infinite for a camera that looks down."""
        cos, sin = np.cos(self.aim.tilt), np.sin(self.aim.tilt)
        return float(self.height / 2 + self.aim.focal * sin / cos) if cos > 1e-9 else np.inf

    def project(self, points: Array) -> Array:
        """Return the pixels (..., 2) of points (..., 3) [m] in front of the camera."""
        seen = (points - self.eye) @ self.axes.T
        return self.aim.focal * seen[..., :2] / seen[..., 2:] + np.array([self.width, self.height]) / 2

    def pixels(self, points: Array) -> Array:
        """Return the pixels (..., 2) of points (..., 2) [m] on the floor."""
        return self.project(np.concatenate([points, np.zeros_like(points[..., :1])], axis=-1))

    def metres(self, pixels: Array) -> Array:
        """Return the points of the floor (..., 2) [m] at pixels (..., 2) below the horizon."""
        offset = (pixels - np.array([self.width, self.height]) / 2) / self.aim.focal
        rays = np.concatenate([offset, np.ones_like(offset[..., :1])], axis=-1) @ self.axes
        return self.eye[:2] - self.eye[2] * rays[..., :2] / rays[..., 2:]

    def disc_maps(self, points: Array, radius: float) -> Array:
        """Return the maps (N, 3, 3) from the unit circle to small disks on the floor at points (N, 2) [m].

        Args:
            points: centers of the disks.
            radius: radius of such a disk in the middle of the stage if it faced the camera [pixels].
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

    def stage_share(self, stage: Stage, pixels: Array) -> Array:
        """Return the share of each pixel (..., 2) that the stage covers, 0 to 1, to within some hundredths."""
        corners = self.pixels(corners_of(stage))
        along = np.roll(corners, -1, axis=0) - corners
        outward = np.stack([along[:, 1], -along[:, 0]], axis=-1) / np.hypot(*along.T)[:, None]
        beyond = [(pixels - corner) @ normal for corner, normal in zip(corners, outward, strict=True)]
        return np.clip(0.5 - np.max(beyond, axis=0), 0, 1)

    def _depth(self, points: Array) -> Array:
        return (points - self.eye) @ self.axes[2]


Camera = OverheadCamera | PinholeCamera
