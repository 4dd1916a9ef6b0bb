"""The top view: from metres on the stage to pixels of a frame."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from emovid.scene.model import Stage
from emovid.swarm.arrays import Array

MARGIN = 0.035  # of the frame's smaller side, left free around the stage


@dataclass(frozen=True)
class Camera:
    """Looks straight down on the stage's centre.

    Attributes:
        width, height: of the frame [pixels].
        scale: pixels per metre.
    """

    width: int
    height: int
    scale: float

    @classmethod
    def framing(cls, stage: Stage, width: int, height: int) -> Self:
        """Return the camera that shows the whole stage as large as the frame allows."""
        margin = 2 * MARGIN * min(width, height)
        return cls(width, height, min((width - margin) / stage.width, (height - margin) / stage.height))

    def pixels(self, points: Array) -> Array:
        """Return where points (..., 2) [m] lie in the frame [pixels], from its lower left corner, y upwards."""
        return self.scale * points + np.array([self.width, self.height]) / 2
