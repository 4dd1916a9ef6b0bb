import signal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb

from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_robot, load_scene, shipped_robots
from emovid.scene.video import THEMES, Colours, Overlays
from emovid.swarm.laws import coverage_velocity
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.overlays import targets_of
from emovid.video.painter import Painter
from emovid.video.robots import robot_parts, robot_rim
from emovid.video.trails import trailed_robots
from tests.helpers.stages import HEXAGON, THIN, TRACES, TRIANGLE, keys_of

BACK = np.array([0xFA, 0xFA, 0xF7])


def parked(make_scene, poses: list[tuple[float, float, float]], **keys: object) -> Trajectory:
    """Return a run in which robots stand still at the given poses."""
    listed = [dict(zip(("x", "y", "heading"), pose, strict=True)) for pose in poses]
    base = TRACES | {
        "robots": len(poses),
        "start": {"place": "poses", "poses": listed},
        "duration": 2,
        "control_period": 2.0,
    }
    scene = make_scene("fear", base | {"video.size": "640x480"} | keys)
    still = np.zeros((1, len(poses), 2))
    cut = np.zeros((1, len(poses)), dtype=bool)
    return Trajectory(scene, np.array([0.0, 2.0]), np.array([poses, poses], dtype=float), still, cut, cut)


def ink(frame: np.ndarray) -> np.ndarray:
    """Return the difference of each pixel from the stage color, summed over the channels."""
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
    """Return the part of a frame around a position, and the position of its lower left corner [pixels]."""
    x, y = painter.camera.pixels(np.array(point)).astype(int)
    row = frame.shape[0] - y
    return frame[row - half : row + half, x - half : x + half], np.array([x - half, y - half])


@pytest.mark.parametrize("shift", [0.0, 0.13, 0.5, 0.77])
@pytest.mark.parametrize("model", ["gritsbot", "single_integrator"])
def test_robots_are_drawn_with_subpixel_accuracy(make_scene, model, shift) -> None:
    painter = Painter(parked(make_scene, [(0.0, 0.0, 0.0)], **{"robot.model": model, "video.trails.robots": 0}))
    x = 0.1 + shift / painter.camera.scale
    moved = Painter(
        parked(make_scene, [(x, -0.05, np.pi / 2)], **{"robot.model": model, "video.colours.front": "#1684ea"})
    )
    part, corner = around(moved.frame(0.0), moved, (x, -0.05))
    found = centroid(ink(part)) + corner
    assert found == pytest.approx(moved.camera.pixels(np.array([x, -0.05])), abs=0.05)


def test_slow_robots_move_evenly_between_frames(make_scene) -> None:
    # A tenth of a pixel a frame: with markers snapped to whole pixels the robot would stand and jump.
    scale = Painter(parked(make_scene, [(0.0, 0.0, 0.0)])).camera.scale
    places = []
    for k in range(12):
        x = 0.1 * k / scale
        painter = Painter(parked(make_scene, [(x, 0.0, 0.0)]))
        places.append(centroid(ink(painter.frame(0.0)[100:380, 200:440]))[0])
    assert np.diff(places) == pytest.approx(np.full(11, 0.1), abs=0.02)


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, -2.0])
def test_mark_points_in_the_heading_direction(make_scene, heading) -> None:
    painter = Painter(parked(make_scene, [(0.05, 0.02, heading)], **{"video.colours.front": "#ff0000"}))
    part, corner = around(painter.frame(0.0), painter, (0.05, 0.02))
    red = np.clip(part[..., 0].astype(float) - part[..., 1] - 60, 0, None)
    towards = centroid(red) + corner - painter.camera.pixels(np.array([0.05, 0.02]))
    assert np.cos(np.arctan2(towards[1], towards[0]) - heading) > 0.995
    assert np.hypot(*towards) == pytest.approx(0.03 * 0.1467 * painter.camera.scale, rel=0.15)  # a third from its base


def test_wheels_are_drawn_beside_the_body(make_scene) -> None:
    painter = Painter(
        parked(make_scene, [(0.0, 0.0, 0.0)], **{"video.colours.wheels": "#00ff00", "video.trails.robots": 0})
    )
    frame = painter.frame(0.0).astype(float)
    green = np.clip(frame[..., 1] - frame[..., 0] - 60, 0, None)
    rows = np.nonzero(green.sum(axis=1))[0]
    extent = (rows.max() - rows.min() + 1) / painter.camera.scale
    assert extent == pytest.approx(0.035 + 0.003, abs=2 / painter.camera.scale)
    assert centroid(green) == pytest.approx([320, 240], abs=0.05)  # left and right alike


@pytest.mark.parametrize("model", shipped_robots())
def test_drawn_outline_fits_in_the_spacing_radius(model) -> None:
    body = load_robot(model)
    corners = np.concatenate([np.asarray(path.vertices) for path in robot_parts(body).values()])
    assert np.hypot(*corners.T).max() <= body.radius + 1e-12
    assert np.hypot(*corners.T).max() > body.radius - 1e-3


@pytest.mark.parametrize("model", shipped_robots())
def test_rim_covers_all_points_near_the_body(model) -> None:
    body, rim = load_robot(model), 0.0012
    outline = robot_rim(body, rim)
    parts = [path.interpolated(40).to_polygons() for name, path in robot_parts(body).items() if name != "front"]
    edge = np.concatenate([polygon for polygons in parts for polygon in polygons])
    angle = np.linspace(0, 2 * np.pi, 24)
    around = edge[:, None] + np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    near = edge[:, None] + 0.97 * rim * (around - edge[:, None])
    assert outline.contains_points(near.reshape(-1, 2)).all()
    corners = np.asarray(outline.vertices)
    far = np.hypot(*(corners[:, None] - edge).transpose(2, 0, 1)).min(axis=1)
    covered = np.any([path.contains_points(corners) for path in robot_parts(body).values()], axis=0)
    assert far[~covered].max() < 1.02 * rim


@pytest.mark.parametrize("corners", [TRIANGLE, HEXAGON, THIN])
def test_stage_of_any_shape_is_drawn_with_edge_and_surroundings(make_scene, corners) -> None:
    middle = np.mean(corners, axis=0)
    painter = Painter(parked(make_scene, [(*middle, 0.0)], stage=keys_of(corners), **{"video.size": "1280x960"}))
    frame = painter.frame(0.0)[..., :3]
    rows, columns = np.mgrid[:960, :1280]
    at = painter.camera.metres(np.stack([columns + 0.5, 960 - rows - 0.5], axis=-1))
    inside, to_corner = np.full((2, 960, 1280), np.inf)
    for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        x, y = at[..., 0] - x0, at[..., 1] - y0
        left = ((x1 - x0) * y - (y1 - y0) * x) / np.hypot(x1 - x0, y1 - y0)  # of the line from corner to corner
        inside, to_corner = np.minimum(inside, left), np.minimum(to_corner, np.hypot(x, y))
    pixel, width = 1 / painter.camera.scale, 0.003
    robot = np.hypot(*(at - middle).transpose(2, 0, 1)) < 0.022
    line = (inside < -pixel) & (inside > pixel - width) & (to_corner > 0.02)
    assert line.sum() > 500
    assert (frame[(inside > pixel) & ~robot] == BACK).all()
    assert (frame[line] == [0x9A, 0x9E, 0xA8]).all()
    assert (frame[inside < -width - pixel] == [0xE3, 0xE4, 0xE8]).all()


@pytest.mark.parametrize(
    ("robots", "trails", "expected"),
    [(15, 5, [0, 3, 6, 9, 12]), (3, 5, [0, 1, 2]), (4, 0, []), (12, 4, [0, 3, 6, 9]), (7, None, list(range(7)))],
)
def test_robots_with_trails_are_evenly_spaced_around_a_ring(robots, trails, expected) -> None:
    angles = 0.3 + 2 * np.pi * np.arange(robots) / robots
    assert trailed_robots(np.column_stack([np.cos(angles), np.sin(angles)]), trails).tolist() == expected


@given(robots=st.integers(1, 30), trails=st.integers(1, 8), seed=st.integers(0, 1000))
def test_robots_with_trails_are_spread_over_a_random_swarm(robots, trails, seed) -> None:
    poses = np.random.default_rng(seed).uniform(-1, 1, (robots, 3))
    chosen = trailed_robots(poses, trails).tolist()
    assert len(set(chosen)) == min(robots, trails)


def test_robots_with_trails_do_not_cluster_after_random_starts() -> None:
    for seed in range(50):
        poses = np.random.default_rng(seed).uniform([-0.6, -0.4], [0.6, 0.4], (15, 2))
        x, y = (poses - poses.mean(axis=0))[trailed_robots(poses, 5)].T
        angles = np.sort(np.arctan2(y, x))
        assert np.diff(np.append(angles, angles[0] + 2 * np.pi)).max() < np.radians(72 + 2 * 45)


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_frames_are_independent_of_earlier_frames(emotion) -> None:
    run = simulate(load_scene(emotion))
    through, jumping = Painter(run), Painter(run)
    wanted = {0.0, 0.5, 1.0, 14.9, 3.0333}
    shown = {t: through.frame(t).copy() for t in sorted({*wanted, *np.arange(0, 15, 0.5)})}
    for t in (14.9, 0.5, 3.0333, 0.0, 1.0):
        assert np.array_equal(jumping.frame(t), shown[t]), t


def test_trails_pass_through_past_robot_positions(make_scene) -> None:
    run = simulate(make_scene("happiness", TRACES | {"video.trails.robots": 1, "duration": 4}))
    painter = Painter(run)
    frame = painter.frame(4.0)
    blue = np.array([0x16, 0x84, 0xEA])
    for t in np.arange(0.2, 3.4, 0.1):
        x, y = painter.camera.pixels(run.at(np.array([t]))[0, 0, :2])
        near = frame[int(720 - y) - 1 : int(720 - y) + 2, int(x) - 1 : int(x) + 2, :3].astype(int)
        others = run.at(np.array([4.0]))[0, 1:, :2]
        if np.hypot(*(others - run.at(np.array([t]))[0, 0, :2]).T).min() > 0.03:  # not covered by a robot
            assert np.abs(near - blue).sum(axis=-1).min() < 12, t


def test_trails_can_be_limited_in_duration(make_scene) -> None:
    keys = TRACES | {"video.trails.robots": 1, "duration": 5, "video.trails.seconds": 1.5}
    run = simulate(make_scene("happiness", keys))
    frame = Painter(run).frame(5.0)
    long = Painter(
        run, run.scene.video.model_copy(update={"trails": run.scene.video.trails.model_copy(update={"seconds": None})})
    )
    blue = lambda picture: (np.abs(picture[..., :3].astype(int) - [0x16, 0x84, 0xEA]).sum(axis=-1) < 30).sum()  # noqa: E731
    assert 0 < blue(frame) < 0.5 * blue(long.frame(5.0))


def test_first_frame_has_no_trails(make_scene) -> None:
    shown = Painter(simulate(make_scene("anger", TRACES | {"duration": 1}))).frame(0.0)
    none = Painter(
        simulate(make_scene("anger", {"duration": 1, "video.trails.robots": 0, "video.colours.body": "#1684ea"}))
    )
    # The same robots stand at the same places; only their bodies' colors differ.
    assert (ink(shown) > 0).sum() == pytest.approx((ink(none.frame(0.0)) > 0).sum(), abs=2)


def test_a_trail_fades_toward_its_old_end(make_scene) -> None:
    # On one line: the older, the nearer to the stage's color.
    keys = {"video.trails.robots": None, "video.trails.seconds": 2.0, "video.trails.fade": True, "duration": 3}
    keys = TRACES | keys
    run = simulate(make_scene("sadness", keys | {"robots": 1, "behaviour.angular_rate": 1.0}))
    painter = Painter(run)
    frame = ink(painter.frame(3.0))
    shades = []
    for age in (0.4, 0.8, 1.2, 1.6):
        x, y = painter.camera.pixels(run.at(np.array([3.0 - age]))[0, 0, :2])
        shades.append(frame[int(720 - y) - 1 : int(720 - y) + 2, int(x) - 1 : int(x) + 2].max())
    whole = np.abs(np.array([0x16, 0x84, 0xEA]) - BACK).sum()
    assert shades == pytest.approx([whole * (1 - age / 2) for age in (0.4, 0.8, 1.2, 1.6)], abs=0.07 * whole)


def test_robot_edges_hide_lines_below_them(make_scene) -> None:
    # A small robot on a broad red line: the edge of its body is body, rim or a mixture of the two. A rim that is only a
    # line around the body, with nothing below the edge of the body, lets 25 levels of red through.
    keys = {"video.trails.robots": 0, "video.colours.front": "#4a5160", "video.size": "320x240"}
    run = parked(make_scene, [(0.0, 0.0, 0.6)], **keys)
    painter = Painter(run)
    painter._canvas.lines([np.array([[0.0, 120.0], [320.0, 120.0]])], np.array([[1.0, 0.0, 0.0, 1.0]]), 150.0)
    painter._canvas.keep()
    frame = painter.frame(0.0)[..., :3].astype(float)
    assert frame[120, 140].tolist() == [255, 0, 0]
    rows, columns = np.mgrid[:240, :320] + 0.5
    body = run.scene.robot.body
    turned = np.exp(-0.6j) * ((columns - 160) + 1j * (120 - rows)) / painter.camera.scale
    edge = body.width / 2 + 0.0004  # of the pixels whose middles are just outside the body
    near = (np.abs(turned.real) < edge) & (np.abs(turned.imag) < edge)
    near &= np.abs(turned.real) + np.abs(turned.imag) < body.width - 1.5 * body.shape.corner
    rim, way = BACK, np.array([0x4A, 0x51, 0x60]) - BACK
    share = np.clip((frame[near] - rim) @ way / (way @ way), 0, 1)
    assert near.sum() > 40
    assert np.abs(frame[near] - (rim + share[:, None] * way)).max() < 12


# --- overlays --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("moment", ["start", "frame"])
def test_signal_during_agg_drawing_is_not_reported_as_an_agg_error(make_scene, monkeypatch, moment) -> None:
    class Interrupted:
        """A transform that raises a signal when Agg reads its matrix."""

        def __array__(self, *_, **__):
            signal.raise_signal(signal.SIGTERM)
            return np.eye(3)

    def end(*_):
        raise SystemExit(143)

    run = simulate(make_scene())
    before = signal.signal(signal.SIGTERM, end)
    try:
        if moment == "frame":
            painter = Painter(run)
        monkeypatch.setattr("emovid.video.canvas._AS_IS", Interrupted())
        with pytest.raises(SystemExit):
            painter.frame(1.0) if moment == "frame" else Painter(run)
    finally:
        signal.signal(signal.SIGTERM, before)


def test_study_videos_have_no_overlays() -> None:
    assert all(load_scene(emotion).video.overlays == Overlays() for emotion in EMOTIONS)
    assert not any(dict(Overlays()).values())


def shown_by(make_scene, emotion: str, overlay: str, t: float, **keys: object) -> tuple[np.ndarray, Painter]:
    """Return the difference between frames with and without an overlay, and the painter."""
    keys = {"video.trails.robots": 0, "duration": 2} | keys
    run = simulate(make_scene(emotion, keys))
    painter = Painter(simulate(make_scene(emotion, keys | {f"video.overlays.{overlay}": True})))
    difference = painter.frame(t)[..., :3].astype(int) - Painter(run).frame(t)[..., :3]
    return np.abs(difference).sum(axis=-1), painter


@pytest.mark.parametrize("theme", THEMES)
def test_density_has_full_color_at_its_peak_and_none_at_zero(make_scene, theme) -> None:
    keys = {"video.overlays.density": True, "video.theme": theme, "behaviour.density.sigma": 0.05}
    keys |= {"behaviour.density.centre": {"x": 0.3, "y": -0.2}, "video.trails.robots": 0, "duration": 1, "robots": 1}
    run = simulate(make_scene("anger", keys | {"start": {"place": "poses", "poses": [{"x": -0.5, "y": 0.3}]}}))
    painter = Painter(run)
    frame = painter.frame(0.0)[::-1, :, :3].astype(float)
    colours = run.scene.video.palette
    dense, stage = (255 * np.array(to_rgb(colour)) for colour in (colours.density, colours.stage))
    for offset in ((0.0, 0.0), (0.03, 0.0), (-0.06, 0.02), (0.0, 0.05), (0.0, -0.05), (0.3, 0.1)):
        x, y = painter.camera.pixels(np.array([0.3, -0.2]) - offset).astype(int)
        middle = painter.camera.metres(np.array([x + 0.5, y + 0.5]))
        share = np.exp(-0.5 * np.sum((middle - [0.3, -0.2]) ** 2) / 0.05**2)
        assert frame[y, x] == pytest.approx(stage + share * (dense - stage), abs=0.6)


def test_the_density_ends_at_the_edge_of_any_stage(make_scene) -> None:
    corners = [{"x": 0, "y": 0}, {"x": 1, "y": 0}, {"x": 0, "y": 0.8}]
    keys = {"stage": {"corners": corners}, "start.min_spacing": 0.05, "robots": 1, "start.place": "stage"}
    keys |= {"start": {"place": "stage"}, "behaviour.separation": None}
    difference, painter = shown_by(make_scene, "fear", "density", 0.0, **keys)
    rows, columns = np.nonzero(difference)
    at = painter.camera.metres(np.stack([columns + 0.5, 720 - rows - 0.5], axis=-1))
    assert (at.min(axis=0) > -1e-9).all()
    assert (0.8 * at[:, 0] + at[:, 1]).max() < 0.8 + 1e-9
    assert len(rows) == pytest.approx(
        0.4 * painter.camera.scale**2, rel=0.02
    )  # a triangle of 0.4 m^2 without the area of a robot


def test_cell_edges_are_equidistant_from_the_two_nearest_robots(make_scene) -> None:
    difference, painter = shown_by(make_scene, "disgust", "cells", 1.0)
    rows, columns = np.nonzero(difference > 100)
    at = painter.camera.metres(np.stack([columns + 0.5, 720 - rows - 0.5], axis=-1))
    inside = (np.abs(at) < [0.59, 0.39]).all(axis=1)  # not the stage's own edge
    robots = painter.trajectory.at(np.array([1.0]))[0, :, :2]
    distance = np.sort(np.hypot(*(at[inside, None] - robots).transpose(2, 0, 1)), axis=1)
    assert inside.sum() > 2000
    assert (distance[:, 1] - distance[:, 0]).max() * painter.camera.scale < 6  # a line of 1.3 pixels, seen from afar
    assert np.median(distance[:, 1] - distance[:, 0]) * painter.camera.scale < 1


@pytest.mark.parametrize("emotion", ["happiness", "disgust"])
def test_targets_are_drawn_at_the_goals_of_the_robots(make_scene, emotion) -> None:
    difference, painter = shown_by(make_scene, emotion, "targets", 1.0)
    run = painter.trajectory
    points = run.at(np.array([1.0]))[0, :, :2]
    targets = targets_of(run.scene, points, 1.0)
    if emotion == "happiness":  # r(theta) = R + A sin(6 theta), at theta_i(0) + t
        theta = 2 * np.pi * np.arange(1, 16) / 15 + run.scene.behaviour.angular_rate
        r = run.scene.behaviour.R + run.scene.behaviour.A * np.sin(6 * theta)
        assert targets == pytest.approx(np.stack([r * np.cos(theta), r * np.sin(theta)], axis=-1))
    else:  # the law: u = kappa (c - p)
        law = run.scene.behaviour.model_copy(update={"u_max": None})
        assert targets - points == pytest.approx(coverage_velocity(law, run.scene.stage, points) / law.kappa)
    for x, y in painter.camera.pixels(targets).astype(int):
        assert painter.frame(1.0)[719 - y, x, :3] == pytest.approx([0x14, 0x16, 0x1B], abs=3)
        assert difference[719 - y, x] > 0


def test_clock_advances_in_a_corner_outside_the_stage(make_scene) -> None:
    difference, painter = shown_by(make_scene, "fear", "clock", 1.5, **{"video.size": "640x360"})
    rows, columns = np.nonzero(difference)
    assert rows.max() < 0.035 * 360
    assert columns.max() < 80
    assert len(rows) > 100
    shown = {t: painter.frame(t).copy() for t in (0.0, 0.3, 1.5)}
    assert len({picture[:12, :80].tobytes() for picture in shown.values()}) == 3


# --- colors ---------------------------------------------------------------------------------------------------------

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


@pytest.mark.parametrize("theme", THEMES)
def test_trails_differ_from_the_stage_in_luminance(theme) -> None:
    for colour in THEMES[theme].trails:
        assert contrast(colour, THEMES[theme].stage) > 3.5, colour  # WCAG asks 3 of graphics


@pytest.mark.parametrize("theme", THEMES)
def test_robots_and_overlays_are_visible_in_every_theme(theme) -> None:
    colours = THEMES[theme]
    assert contrast(colours.body, colours.stage) > 4.5
    assert contrast(colours.front, colours.body) > 4.5
    assert contrast(colours.wheels, colours.stage) > 7
    assert contrast(colours.boundary, colours.stage) > 2
    assert contrast(colours.overlay, colours.stage) > 7
    assert contrast(colours.overlay, colours.surround) > 7
    assert contrast(colours.density, colours.stage) > 1.5  # where it is highest
    for colour in (colours.body, *colours.trails):
        assert contrast(colour, colours.density) > 1.75, colour


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_trail_colors_are_distinct_with_color_vision_deficiency(deficiency, theme) -> None:
    matrix = np.array(DEFICIENCIES[deficiency])
    seen = [lab(np.clip(matrix @ linear(colour), 0, 1)) for colour in THEMES[theme].trails]
    closest = min(np.linalg.norm(a - b) for i, a in enumerate(seen) for b in seen[:i])
    assert closest > 25  # 2.3 is just noticeable


def test_shipped_scenes_use_the_tested_colors() -> None:
    for emotion in EMOTIONS:
        colours = load_scene(emotion).video.palette
        assert (
            colours
            == Colours().model_copy(update={"trails": 5 * (colours.body,)})
            == THEMES["light"].model_copy(update={"trails": 5 * (colours.body,)})
        )


def test_trails_can_use_the_body_color(make_scene) -> None:
    own = make_scene("fear", {"video.theme": "dark", "video.colours.body": "#123456"}).video
    assert own.palette.trails == 5 * ("#123456",)
    assert make_scene("fear", {"video.theme": "dark"}).video.palette.trails == 5 * (THEMES["dark"].body,)


def test_scene_colors_override_theme_colors(make_scene) -> None:
    video = make_scene("fear", TRACES | {"video.theme": "dark", "video.colours.body": "#123456"}).video
    assert video.palette == THEMES["dark"].model_copy(update={"body": "#123456"})
