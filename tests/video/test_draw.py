import numpy as np
import pytest

from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene
from emovid.scene.robots import BODIES
from emovid.scene.video import Colours
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.draw import Painter, robot_parts, trailed_robots

BACK = np.array([0xFA, 0xFA, 0xF7])


def parked(make_scene, poses: list[tuple[float, float, float]], **keys: object) -> Trajectory:
    """Return a run in which robots stand at the poses."""
    listed = [dict(zip(("x", "y", "heading"), pose, strict=True)) for pose in poses]
    base = {"robots": len(poses), "start": {"place": "poses", "poses": listed}, "duration": 2, "control_period": 2.0}
    scene = make_scene("fear", base | {"video.size": "640x480"} | keys)
    still = np.zeros((1, len(poses), 2))
    cut = np.zeros((1, len(poses)), dtype=bool)
    return Trajectory(scene, np.array([0.0, 2.0]), np.array([poses, poses], dtype=float), still, cut, cut)


def ink(frame: np.ndarray) -> np.ndarray:
    """Return how much each pixel differs from the stage, all colours together."""
    return np.abs(frame[..., :3].astype(float) - BACK).sum(axis=-1)


def centroid(weight: np.ndarray) -> np.ndarray:
    """Return the mean (x, y) of a picture [pixels], from the lower left corner."""
    height, width = weight.shape
    x = (weight.sum(axis=0) * (np.arange(width) + 0.5)).sum() / weight.sum()
    y = (weight.sum(axis=1) * (height - 0.5 - np.arange(height))).sum() / weight.sum()
    return np.array([x, y])


def around(
    frame: np.ndarray, painter: Painter, point: tuple[float, float], half: int = 40
) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of a frame around a place, and where its lower left corner lies [pixels]."""
    x, y = painter.camera.pixels(np.array(point)).astype(int)
    row = frame.shape[0] - y
    return frame[row - half : row + half, x - half : x + half], np.array([x - half, y - half])


@pytest.mark.parametrize("shift", [0.0, 0.13, 0.5, 0.77])
@pytest.mark.parametrize("model", ["gritsbot", "single_integrator"])
def test_robots_stand_where_they_are_to_a_fraction_of_a_pixel(make_scene, model, shift) -> None:
    painter = Painter(parked(make_scene, [(0.0, 0.0, 0.0)], **{"robot.model": model, "video.trails.robots": 0}))
    x = 0.1 + shift / painter.camera.scale
    moved = Painter(
        parked(make_scene, [(x, -0.05, np.pi / 2)], **{"robot.model": model, "video.colours.front": "#1684ea"})
    )
    part, corner = around(moved.frame(0.0), moved, (x, -0.05))
    found = centroid(ink(part)) + corner
    assert found == pytest.approx(moved.camera.pixels(np.array([x, -0.05])), abs=0.05)


def test_slow_motion_is_even(make_scene) -> None:
    # A tenth of a pixel a frame: with markers snapped to whole pixels the robot would stand and jump.
    scale = Painter(parked(make_scene, [(0.0, 0.0, 0.0)])).camera.scale
    places = []
    for k in range(12):
        x = 0.1 * k / scale
        painter = Painter(parked(make_scene, [(x, 0.0, 0.0)]))
        places.append(centroid(ink(painter.frame(0.0)[100:380, 200:440]))[0])
    assert np.diff(places) == pytest.approx(np.full(11, 0.1), abs=0.02)


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, -2.0])
def test_the_mark_points_to_the_front(make_scene, heading) -> None:
    painter = Painter(parked(make_scene, [(0.05, 0.02, heading)], **{"video.colours.front": "#ff0000"}))
    part, corner = around(painter.frame(0.0), painter, (0.05, 0.02))
    red = np.clip(part[..., 0].astype(float) - part[..., 1] - 60, 0, None)
    towards = centroid(red) + corner - painter.camera.pixels(np.array([0.05, 0.02]))
    assert np.cos(np.arctan2(towards[1], towards[0]) - heading) > 0.995
    assert np.hypot(*towards) == pytest.approx(0.03 * 0.1467 * painter.camera.scale, rel=0.15)  # a third from its base


def test_wheels_stand_beside_the_body(make_scene) -> None:
    painter = Painter(
        parked(make_scene, [(0.0, 0.0, 0.0)], **{"video.colours.wheels": "#00ff00", "video.trails.robots": 0})
    )
    frame = painter.frame(0.0).astype(float)
    green = np.clip(frame[..., 1] - frame[..., 0] - 60, 0, None)
    rows = np.nonzero(green.sum(axis=1))[0]
    extent = (rows.max() - rows.min() + 1) / painter.camera.scale
    assert extent == pytest.approx(0.035 + 0.003, abs=2 / painter.camera.scale)
    assert centroid(green) == pytest.approx([320, 240], abs=0.05)  # left and right alike


@pytest.mark.parametrize("model", BODIES)
def test_the_drawn_outline_lies_within_the_body_that_spacing_is_measured_with(model) -> None:
    body = BODIES[model]
    corners = np.concatenate([np.asarray(path.vertices) for path in robot_parts(body).values()])
    assert np.hypot(*corners.T).max() <= body.radius + 1e-12
    assert np.hypot(*corners.T).max() > body.radius - 1e-3


@pytest.mark.parametrize(
    ("robots", "trails", "expected"), [(15, 5, [0, 3, 6, 9, 12]), (3, 5, [0, 1, 2]), (4, 0, []), (12, 4, [0, 3, 6, 9])]
)
def test_trails_are_evenly_spread_through_the_swarm(robots, trails, expected) -> None:
    assert trailed_robots(robots, trails).tolist() == expected


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_a_frame_does_not_depend_on_those_before(emotion) -> None:
    run = simulate(load_scene(emotion))
    through, jumping = Painter(run), Painter(run)
    wanted = {0.0, 0.5, 1.0, 14.9, 3.0333}
    shown = {t: through.frame(t).copy() for t in sorted({*wanted, *np.arange(0, 15, 0.5)})}
    for t in (14.9, 0.5, 3.0333, 0.0, 1.0):
        assert np.array_equal(jumping.frame(t), shown[t]), t


def test_trails_pass_through_where_their_robots_were(make_scene) -> None:
    run = simulate(make_scene("happiness", {"video.trails.robots": 1, "duration": 4}))
    painter = Painter(run)
    frame = painter.frame(4.0)
    blue = np.array([0x16, 0x84, 0xEA])
    for t in np.arange(0.2, 3.4, 0.1):
        x, y = painter.camera.pixels(run.at(np.array([t]))[0, 0, :2])
        near = frame[int(720 - y) - 1 : int(720 - y) + 2, int(x) - 1 : int(x) + 2, :3].astype(int)
        others = run.at(np.array([4.0]))[0, 1:, :2]
        if np.hypot(*(others - run.at(np.array([t]))[0, 0, :2]).T).min() > 0.03:  # no robot stands on it
            assert np.abs(near - blue).sum(axis=-1).min() < 12, t


def test_a_trail_can_fade_from_memory(make_scene) -> None:
    keys = {"video.trails.robots": 1, "duration": 5, "video.trails.seconds": 1.5}
    run = simulate(make_scene("happiness", keys))
    frame = Painter(run).frame(5.0)
    long = Painter(
        run, run.scene.video.model_copy(update={"trails": run.scene.video.trails.model_copy(update={"seconds": None})})
    )
    blue = lambda picture: (np.abs(picture[..., :3].astype(int) - [0x16, 0x84, 0xEA]).sum(axis=-1) < 30).sum()  # noqa: E731
    assert 0 < blue(frame) < 0.5 * blue(long.frame(5.0))


def test_no_robot_has_a_trail_at_the_start(make_scene) -> None:
    shown = Painter(simulate(make_scene("anger", {"duration": 1}))).frame(0.0)
    none = Painter(
        simulate(make_scene("anger", {"duration": 1, "video.trails.robots": 0, "video.colours.body": "#1684ea"}))
    )
    # The same robots stand at the same places; only their bodies' colours differ.
    assert (ink(shown) > 0).sum() == pytest.approx((ink(none.frame(0.0)) > 0).sum(), abs=2)


# --- colours ---------------------------------------------------------------------------------------------------------

# G. M. Machado, M. M. Oliveira and L. A. F. Fernandes, "A physiologically-based model for simulation of color vision
# deficiency", IEEE TVCG 15(6), 2009: severity 1.0, in linear RGB.
DEFICIENCIES = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    "none": np.eye(3),
}


def linear(colour: str) -> np.ndarray:
    value = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIE L*a*b* of linear sRGB, white D65."""
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ rgb
    t = xyz / np.array([0.9505, 1.0, 1.089])
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def contrast(a: str, b: str) -> float:
    """WCAG contrast ratio."""
    light = sorted((linear(colour) @ [0.2126, 0.7152, 0.0722] for colour in (a, b)), reverse=True)
    return (light[0] + 0.05) / (light[1] + 0.05)


@pytest.mark.parametrize("colour", Colours().trails)
def test_trails_stand_out_from_the_stage_in_luminance(colour) -> None:
    assert contrast(colour, Colours().stage) > 3.5  # WCAG asks 3 of graphics


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_trails_differ_for_colour_blind_eyes(deficiency) -> None:
    matrix = np.array(DEFICIENCIES[deficiency])
    seen = [lab(np.clip(matrix @ linear(colour), 0, 1)) for colour in Colours().trails]
    closest = min(np.linalg.norm(a - b) for i, a in enumerate(seen) for b in seen[:i])
    assert closest > 25  # 2.3 is just noticeable


def test_shipped_scenes_have_the_tested_colours() -> None:
    assert all(load_scene(emotion).video.colours == Colours() for emotion in EMOTIONS)
