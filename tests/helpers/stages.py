"""Strategies for convex stages of any shape."""

import numpy as np
from hypothesis import strategies as st

from emovid.scene.stage import Polygon

HEXAGON = [(0.6 * np.cos(angle), 0.6 * np.sin(angle)) for angle in np.arange(6) * np.pi / 3]
TRIANGLE = [(-0.6, -0.4), (0.6, -0.4), (0.0, 0.6)]
THIN = [(2.0, 1.0), (3.0, 1.8), (2.94, 1.88), (1.95, 1.1)]  # about 0.1 m across, slanted, far from the origin


def keys_of(corners: list[tuple[float, float]]) -> dict:
    """Return the keys of a stage."""
    return {"corners": [{"x": float(x), "y": float(y)} for x, y in corners]}


def polygon(corners: list[tuple[float, float]]) -> Polygon:
    return Polygon.model_validate(keys_of(corners))


@st.composite
def convex_corners(draw: st.DrawFn, widest: float = 1.0, narrowest: float = 0.1) -> list[tuple[float, float]]:
    """Draw the corners of a polygon inscribed in an ellipse, counter-clockwise, somewhere near the origin."""
    gaps = np.array(draw(st.lists(st.floats(0.3, 1), min_size=3, max_size=9)))
    angles = 2 * np.pi * np.cumsum(gaps) / gaps.sum()
    long, short = widest, draw(st.floats(narrowest, widest))
    turn, x, y = draw(st.floats(0, 2 * np.pi)), draw(st.floats(-1, 1)), draw(st.floats(-1, 1))
    ring = np.exp(1j * turn) * (long * np.cos(angles) + 1j * short * np.sin(angles)) + (x + 1j * y)
    return [(point.real, point.imag) for point in ring]


# Permanent trails of five robots in the colors of the theme, as figures show them and videos did at first.
TRACES = {
    "video.trails.robots": 5,
    "video.trails.seconds": None,
    "video.trails.fade": False,
    "video.colours.trails": 5 * ["theme"],
}
