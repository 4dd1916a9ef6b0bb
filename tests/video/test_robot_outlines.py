"""Robot outlines shared by videos and figures."""

import numpy as np
import pytest

from emovid.scene.robots import Body
from emovid.video.robots import robot_parts, robot_rim

ARROW = [[0.03, 0.0], [-0.02, 0.02], [-0.01, 0.0], [-0.02, -0.02]]


def body(corners: list[list[float]]) -> Body:
    shape = {"kind": "polygon", "corners": corners}
    return Body.model_validate({"kinematics": "single_integrator", "shape": shape, "height": 0.02})


def doubled_area(ring: np.ndarray) -> float:
    x, y = ring.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("corners", [ARROW, ARROW[::-1]], ids=["counter-clockwise", "clockwise"])
def test_outlines_are_counterclockwise_for_either_corner_order(corners) -> None:
    outline, rim = robot_parts(body(corners))["body"], robot_rim(body(corners), 0.005)
    for path, count in ((outline, 1), (rim, 1 + len(corners))):
        rings = path.to_polygons()
        assert len(rings) == count
        assert all(doubled_area(ring) > 0 for ring in rings)  # otherwise the overlap of two pieces would be a hole
    assert doubled_area(outline.to_polygons()[0]) == pytest.approx(abs(doubled_area(np.array(ARROW))))
