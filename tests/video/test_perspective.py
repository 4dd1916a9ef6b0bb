"""Videos in perspective: comparison with ray casting, and redrawing of changed parts only."""

import numpy as np
import pytest

from emovid.kit.symmetry import mirrored
from emovid.scene.emotions import EMOTIONS
from emovid.scene.video import THEMES
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.painter import Painter
from emovid.video.pixel_formats import Yuv420
from emovid.video.render import frames_checksum
from tests.helpers.reference import hits_of_rays, whole_frame
from tests.helpers.stages import HEXAGON, TRACES, keys_of

SIDE = {"video.view": "perspective"}
LOOKS = {
    "plain": {},
    "near": {"video.camera.height": 0.4, "video.trails.width": 0.02},
    "trails that fade": {"video.trails.seconds": 0.7, "video.trails.fade": True, "video.trails.robots": None},
    "overlays": {f"video.overlays.{name}": True for name in ("cells", "targets", "clock")},
}


def parked(make_scene, poses: list[tuple[float, float, float]], **keys: object) -> Trajectory:
    """Return a run in which robots stand still at the given poses."""
    listed = [dict(zip(("x", "y", "heading"), pose, strict=True)) for pose in poses]
    base = {"robots": len(poses), "start": {"place": "poses", "poses": listed}, "duration": 2, "control_period": 2.0}
    scene = make_scene("fear", base | {"video.size": "640x480"} | SIDE | keys)
    still, cut = np.zeros((1, len(poses), 2)), np.zeros((1, len(poses)), dtype=bool)
    return Trajectory(scene, np.array([0.0, 2.0]), np.array([poses, poses], dtype=float), still, cut, cut)


def test_occlusion_of_robots_matches_ray_casting(make_scene) -> None:
    box = {"kinematics": "single_integrator", "height": 0.12}
    box |= {"shape": {"kind": "rectangle", "length": 0.12, "width": 0.07}}
    poses = [
        (-0.3, -0.2, 0.3),
        (-0.25, -0.05, 1.2),
        (-0.2, 0.12, -0.5),
        (0.1, 0.0, 0.8),
        (0.12, 0.2, 2.0),
        (0.4, 0.3, 3),
    ]
    keys = {"robot.model": box, "video.trails.robots": None, "video.trails.width": 1e-6}
    keys |= {"video.camera.height": 0.6, "video.camera.distance": 1.0}
    shades = [f"#{220 - 20 * i:02x}{100 + 20 * i:02x}60" for i in range(6)]
    painter = Painter(parked(make_scene, poses, **keys, **{"video.colours.trails": shades}))
    frame = painter.frame(0.0)[..., :3].astype(int)
    flat = np.array([0.06 + 0.035j, -0.06 + 0.035j, -0.06 - 0.035j, 0.06 - 0.035j])
    turned = [x + 1j * y + np.exp(1j * heading) * flat for x, y, heading in poses]
    x, y, z, tilt, focal = painter.camera.aim
    prisms = [np.stack([corners.real, corners.imag], axis=-1) for corners in turned]
    first, up = hits_of_rays((x, y, z), tilt, focal, (640, 480), prisms, 0.12)
    pieces = np.where(first < 0, -1, 2 * first + (up > 0.12 - 1e-9))
    around = [np.roll(pieces, (i, j), axis=(0, 1)) for i in (-2, -1, 0, 1, 2) for j in (-2, -1, 0, 1, 2)]
    clear = np.all([other == pieces for other in around], axis=0)  # of any edge
    colours = np.array([[int(shade[i : i + 2], 16) for i in (1, 3, 5)] for shade in shades])
    for i, colour in enumerate(colours):
        top, side = clear & (pieces == 2 * i + 1), clear & (pieces == 2 * i)
        assert top.sum() > 50
        assert side.sum() > 50
        assert (frame[top] == colour).all(), i
        share = frame[side] / colour
        assert (np.ptp(share[:, [0, 2]], axis=1) < 0.03).all()  # the same hue
        assert ((share[:, 0] > 0.5) & (share[:, 0] < 0.9)).all(), i  # darker
    hidden = [i for i in range(6) if (first == i).sum() < 0.8 * (hits_alone(painter, prisms[i]) >= 0).sum()]
    assert hidden  # one stands behind another


def hits_alone(painter: Painter, prism: np.ndarray) -> np.ndarray:
    x, y, z, tilt, focal = painter.camera.aim
    return hits_of_rays((x, y, z), tilt, focal, (640, 480), [prism], 0.12)[0]


@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5, 0.75])
def test_slow_robots_do_not_snap_to_pixels(make_scene, shift) -> None:
    def centroid(painter: Painter) -> np.ndarray:
        weight = np.abs(painter.frame(0.0)[..., :3].astype(float) - empty).sum(axis=-1)[::-1]
        x, y = np.arange(640) + 0.5, np.arange(480) + 0.5
        return np.array([weight.sum(axis=0) @ x, weight.sum(axis=1) @ y]) / weight.sum()

    empty = Painter(parked(make_scene, [(0.5, 0.3, 0.0)])).frame(0.0)[..., :3].astype(float)
    empty[:, 320:] = empty[:, :320][:, ::-1]  # the robot stands on the right
    still = {"video.trails.robots": 0}
    here, scale = centroid(Painter(parked(make_scene, [(0.0, 0.0, 0.0)], **still))), painter_scale(make_scene)
    there = centroid(Painter(parked(make_scene, [(shift / scale, 0.0, 0.0)], **still)))
    assert there - here == pytest.approx([shift, 0.0], abs=0.03)


def painter_scale(make_scene) -> float:
    return Painter(parked(make_scene, [(0.0, 0.0, 0.0)])).camera.scale


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("emotion", ["surprise", "anger"])
def test_frames_are_independent_of_earlier_ones(make_scene, emotion, look) -> None:
    keys = SIDE | {"duration": 3.5, "video.size": "320x180"} | LOOKS[look]
    run = simulate(make_scene(emotion, keys))
    painter, planes = Painter(run), Yuv420(320, 180)
    for t in (0.0, 1 / 30, 1.1, 3.4, 2.0):
        frame, changed = painter.frame(t), painter.changed()
        assert np.array_equal(frame, Painter(run).frame(t)), t  # drawn from scratch
        assert np.array_equal(planes.convert(frame, changed), whole_frame(frame)), t


def test_trails_follow_past_positions_on_the_floor(make_scene) -> None:
    keys = TRACES | SIDE | {"video.trails.robots": 1, "duration": 4, "video.trails.width": 0.01, "robots": 2}
    run = simulate(make_scene("happiness", keys))
    painter = Painter(run)
    frame = painter.frame(4.0)[..., :3].astype(int)
    found = 0
    for t in np.arange(0.2, 3.4, 0.1):
        x, y = painter.camera.pixels(run.at(np.array([t]))[0, 0, :2])
        at = run.at(np.array([4.0]))[0, :, :2] - run.at(np.array([t]))[0, 0, :2]
        if np.abs(at).max(axis=1).min() > 0.06:  # not covered by a robot
            found += 1
            assert np.abs(frame[int(720 - y), int(x)] - [0x16, 0x84, 0xEA]).sum() < 12, t
    assert found > 10


def test_motion_and_times_match_the_overhead_view(make_scene) -> None:
    views = ("overhead", "perspective")
    above, side = (simulate(make_scene("fear", {"duration": 1, "video.view": view})) for view in views)
    assert np.array_equal(above.poses, side.poses)
    assert above.scene.frames == side.scene.frames
    assert frames_checksum(above) != frames_checksum(side)


@pytest.mark.parametrize("theme", THEMES)
def test_the_density_tints_the_floor_up_to_the_edge_of_the_stage(make_scene, theme) -> None:
    keys = {"video.overlays.density": True, "video.theme": theme, "stage": keys_of(HEXAGON), "robots": 1}
    keys |= {"start": {"place": "poses", "poses": [{"x": 0.0, "y": 0.3}]}, "behaviour.separation": None, "duration": 1}
    run = simulate(make_scene("fear", SIDE | keys))
    painter = Painter(run)
    frame = painter.frame(0.0)[::-1, :, :3]
    dense = run.scene.video.palette.density
    for share in (0.2, 0.5, 0.9, 0.97):
        for corner in HEXAGON:
            x, y = painter.camera.pixels(share * np.array(corner)).astype(int)
            if share < 0.5 or corner[1] < 0.3:  # no robot there
                assert frame[y, x].tolist() == [int(dense[i : i + 2], 16) for i in (1, 3, 5)]
    around = painter.camera.stage_share(run.scene.stage, np.array([[x, y] for x in (5, 640, 1275) for y in (5, 715)]))
    assert (around == 0).all()
    surround = run.scene.video.palette.surround
    assert frame[5, 640].tolist() == [int(surround[i : i + 2], 16) for i in (1, 3, 5)]


def test_targets_are_disks_on_the_floor(make_scene) -> None:
    keys = {"video.overlays.targets": True, "video.colours.overlay": "#ff0000", "duration": 1, "robots": 1}
    keys |= {"video.camera.height": 0.4, "video.camera.distance": 0.8, "video.size": "1920x1080"}
    keys |= {"behaviour.separation": None}
    keys |= {"start": {"place": "poses", "poses": [{"x": 0.55, "y": 0.35}]}}  # far from its target, the middle
    painter = Painter(simulate(make_scene("fear", SIDE | keys)))
    frame = painter.frame(0.0)[..., :3].astype(int)
    x, y = painter.camera.pixels(np.zeros(2))
    part = frame[int(1080 - y) : int(1080 - y) + 30, int(x) - 30 : int(x)]  # a quarter; the line to it ends in another
    red = np.clip(part[..., 0] - part[..., 1], 0, 255) / 255  # how much of each pixel is a dot
    turn = painter.camera.disc_maps(np.zeros((1, 2)), 1.0)[0]
    assert red.sum(axis=0).max() / red.sum(axis=1).max() == pytest.approx(turn[1, 1] / turn[0, 0], abs=0.15)


def test_mirrored_run_gives_a_mirrored_picture(make_scene) -> None:
    # Only the shading of the sides differs: the light comes from the left in both.
    keys = SIDE | {"duration": 2, "video.colours.trails": ["#101010"] * 5, "video.colours.body": "#101010"}
    run = simulate(make_scene("surprise", keys))
    shown = Painter(run).frame(1.5).astype(int)
    other = Painter(mirrored(run)).frame(1.5)[:, ::-1].astype(int)
    assert np.abs(shown - other).max() < 40
    assert (np.abs(shown - other).max(axis=-1) > 8).mean() < 0.001


def test_floor_fades_evenly_to_a_uniform_color_at_the_horizon(make_scene) -> None:
    keys = {"video.camera.tilt": 10.0, "video.camera.height": 0.5, "video.trails.robots": 0}
    painter = Painter(parked(make_scene, [(0.0, 0.0, 0.0)], **keys))
    frame = painter.frame(0.0)[::-1, :, :3].astype(int)
    horizon = int(painter.camera.horizon)
    assert 250 < horizon < 470
    assert (frame[horizon + 1 :] == frame[-1, 0]).all()
    column = frame[:, 0]
    assert (np.diff(column.sum(axis=1)) >= 0).all()
    assert np.abs(np.diff(column, axis=0)).max() <= 3  # no line where the floor ends


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_every_shipped_scene_renders_in_perspective(make_scene, emotion) -> None:
    run = simulate(make_scene(emotion, SIDE | {"duration": 0.5, "video.size": "320x180"}))
    stage = Painter(run).frame(0.5)[90, 20:300, :3]
    assert (stage == [0xFA, 0xFA, 0xF7]).all(axis=-1).mean() > 0.5
