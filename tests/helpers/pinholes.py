"""Strategies for pinhole cameras."""

import numpy as np
from hypothesis import strategies as st

from emovid.scene.video import Aim
from emovid.video.cameras import PinholeCamera

AIMS = st.builds(
    Aim,
    x=st.floats(-2, 2),
    y=st.floats(-5, -2),
    z=st.floats(0.5, 4),
    tilt=st.floats(0.1, 1.2),
    focal=st.floats(200, 3000),
)
PINHOLES = AIMS.map(lambda aim: PinholeCamera(1280, 720, aim, (0.0, 0.0), (0.0, -0.4)))
FLOOR = st.tuples(st.floats(-1, 1), st.floats(-1, 1)).map(np.array)


def matrix(camera: PinholeCamera) -> np.ndarray:
    """Return the camera as textbooks write it: K [R | -R c], 3 x 4, for pixels from the upper left corner, y down."""
    x, y, z, tilt, focal = camera.aim
    level = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # right, down and away of a camera that looks along y
    pitch = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    rotation = pitch @ level
    inner = np.array([[focal, 0, camera.width / 2], [0, focal, camera.height / 2], [0, 0, 1]])
    return inner @ np.column_stack([rotation, -rotation @ [x, y, z]])
