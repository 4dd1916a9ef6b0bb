"""Pictures and a video of every shipped robot."""

from collections import Counter

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from emovid.scene.load import load_robot, shipped_robots
from emovid.scene.robots import Body
from emovid.swarm.simulate import simulate
from emovid.video.painter import Painter
from emovid.video.render import render_video

_BODY = (18, 52, 86)
_LOOK = {f"video.colours.{part}": "#123456" for part in ("body", "wheels", "front")} | {"video.trails.robots": 0}


def arena(make_scene, name: str, **keys: object):
    start = {"place": "poses", "poses": [{"x": 0.6, "y": 0.2, "heading": 0.6}, {"x": -0.7, "y": -0.1, "heading": 2}]}
    common = {"robot.model": name, "robots": 2, "stage": {"width": 3.2, "height": 2}, "start": start, "duration": 0.5}
    return make_scene("fear", common | {"robot.l": 0.03, "behaviour.separation": None, "video.size": "320x200"} | keys)


def outline(body: Body) -> shapely.Geometry:
    """Return the outline of a robot in its own frame, without its axle, computed with shapely."""
    shape = body.shape
    if shape.kind == "circle":
        drawn = shapely.Point(shape.ahead, 0).buffer(shape.radius)
    elif shape.kind == "rectangle":
        half = np.array(shape.box) / 2 - shape.corner
        drawn = shapely.box(shape.ahead - half[0], -half[1], shape.ahead + half[0], half[1]).buffer(shape.corner)
    else:
        drawn = shapely.Polygon(shape.corners)
    if body.wheels:
        reach, near, far = body.wheels.radius, *(body.wheels.base + np.array([-1, 1]) * body.wheels.width) / 2
        drawn = drawn.union(shapely.box(-reach, near, reach, far)).union(shapely.box(-reach, -far, reach, -near))
    return drawn


@pytest.mark.parametrize("name", shipped_robots())
def test_robot_drawing_has_correct_scale_position_and_heading(make_scene, name) -> None:
    still = {"place": "poses", "poses": [{"x": 0.1, "y": -0.05, "heading": 0.6}]}
    keys = {"robots": 1, "start": still, "stage": {"width": 0.64, "height": 0.4}, "video.size": "640x400", **_LOOK}
    run = simulate(arena(make_scene, name, **keys))
    painter, heading = Painter(run), float(run.poses[0, 0, 2])  # a single integrator's is where it goes
    # The axle is drawn too, thinner than a pixel or under the body, and the mark of the front on it.
    dark = (painter.frame(0.0)[..., :3].astype(int) == _BODY).all(axis=-1)
    placed = translate(rotate(outline(run.scene.robot.body), heading, origin=(0, 0), use_radians=True), 0.1, -0.05)
    rows, columns = np.mgrid[: dark.shape[0], : dark.shape[1]]
    x = (columns + 0.5 - dark.shape[1] / 2) / painter.camera.scale
    y = (dark.shape[0] / 2 - rows - 0.5) / painter.camera.scale
    pixel = 1 / painter.camera.scale
    assert dark[shapely.contains_xy(placed.buffer(-pixel), x, y)].all()
    assert not dark[~shapely.contains_xy(placed.buffer(pixel), x, y)].any()
    assert shapely.contains_xy(placed.buffer(-pixel), x, y).sum() > 80


@pytest.mark.parametrize("name", shipped_robots())
def test_every_shipped_robot_renders_to_a_video(make_scene, name, tmp_path) -> None:
    scene = arena(make_scene, name, **{"robot.limits": "model" if load_robot(name).limits else None})
    run = simulate(scene)
    if limits := scene.robot.limits:
        v, omega = np.abs(run.commands[..., 0]), np.abs(run.commands[..., 1])
        wheel = v + scene.robot.body.wheel_base / 2 * omega
        for demand, most in ((v, limits.v_max), (omega, limits.omega_max), (wheel, limits.wheel_max)):
            assert most is None or demand.max() <= most * (1 + 1e-12)
    checksums = render_video(run, tmp_path / "robot.mp4")
    assert (tmp_path / "robot.mp4").stat().st_size > 1000
    assert checksums


def test_shipped_robots_have_distinct_drawings(make_scene) -> None:
    frames = Counter(Painter(simulate(arena(make_scene, name))).frame(0.0).tobytes() for name in shipped_robots())
    assert set(frames.values()) == {1}
