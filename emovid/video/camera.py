"""The top view: from metres on the stage to pixels of a frame."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from emovid.scene.stage import Stage
from emovid.scene.view import MARGIN
from emovid.swarm.arrays import Array
from emovid.video.pinhole import Pinhole


@dataclass(frozen=True)
class Camera:
    """Looks straight down on the stage.

    Attributes:
        width, height: of the frame [pixels].
        scale: pixels per metre.
        centre: the place (x, y) [m] in the middle of the frame.
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
    def finest(self) -> float:
        """Most pixels per metre anywhere on the stage: everywhere the same."""
        return self.scale

    def pixels(self, points: Array) -> Array:
        """Return where points (..., 2) [m] lie in the frame [pixels], from its lower left corner, y upwards."""
        return self.scale * (points - np.array(self.centre)) + np.array([self.width, self.height]) / 2

    def metres(self, pixels: Array) -> Array:
        """Return where places in the frame (..., 2) [pixels] lie on the stage [m]: the inverse of `pixels`."""
        return (pixels - np.array([self.width, self.height]) / 2) / self.scale + np.array(self.centre)

    def turns(self, points: Array, radius: float) -> Array:
        """Return the maps (N, 3, 3) from the unit circle to discs at points (N, 2) [m], of a radius [pixels]."""
        return np.repeat(np.diag([radius, radius, 1.0])[None], len(points), axis=0)

    def cover(self, stage: Stage, pixels: Array) -> Array:
        """Return whether places in the frame (..., 2) [pixels] show the stage: 1.0 or 0.0."""
        x, y = np.moveaxis(self.metres(pixels), -1, 0)
        return np.all([edge.x * x + edge.y * y <= edge.offset for edge in stage.edges], axis=0).astype(float)


AnyCamera = Camera | Pinhole
