"""Every scene is either simulated and drawn or refused with a one-line message."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from emovid.errors import SourceError
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.clearance import room_on_stage
from emovid.swarm.simulate import simulate
from emovid.swarm.summary import summarize
from emovid.video.painter import Painter
from emovid.video.pixel_formats import Yuv420
from tests.helpers.reference import whole_frame
from tests.helpers.stages import HEXAGON, THIN, TRIANGLE, keys_of

MAGNITUDES = st.sampled_from([1e-300, 1e-6, 1e-3, 0.01, 0.05, 0.1, 0.3, 0.5, 1.0, 2.0, 10.0, 100.0, 1000.0])
COUNTS = st.sampled_from([0, 1, 2, 3, 7, 40])
KEYS = {
    **dict.fromkeys(("robot.l", "robot.K", "control_period", "stage.width", "stage.height", "duration"), MAGNITUDES),
    **dict.fromkeys(("behaviour.R", "behaviour.A", "behaviour.R_min", "behaviour.R_max"), MAGNITUDES),
    **dict.fromkeys(("behaviour.angular_rate", "behaviour.expansion_rate", "behaviour.kappa"), MAGNITUDES),
    **dict.fromkeys(("behaviour.u_max", "behaviour.separation", "behaviour.density.sigma"), MAGNITUDES),
    **dict.fromkeys(("behaviour.density.width", "behaviour.density.inset", "start.min_spacing"), MAGNITUDES),
    **dict.fromkeys(("robot.limits.v_max", "robot.limits.omega_max", "robot.limits.wheel_max"), MAGNITUDES),
    **dict.fromkeys(("video.trails.width", "video.trails.seconds", "start.region.width"), MAGNITUDES),
    **dict.fromkeys(("robots", "behaviour.f", "video.fps", "video.trails.robots", "seed"), COUNTS),
    "stage": st.sampled_from([HEXAGON, TRIANGLE, THIN, TRIANGLE[:2], HEXAGON + HEXAGON]).map(keys_of),
    "robot.model": st.sampled_from(["gritsbot", "single_integrator"]),
    "video.size": st.sampled_from(["64x64", "66x300", "2000x64"]),
    "video.trails": st.sampled_from([{"robots": None}, {"seconds": 0.1, "fade": True}, {"fade": True}]),
    "video.camera": st.builds(
        lambda **keys: {key: value for key, value in keys.items() if value is not None},
        height=MAGNITUDES,
        distance=st.sampled_from([None, 0.0, 0.3, 3.0]),
        tilt=st.sampled_from([None, 0.0, 40.0, 90.0]),
        field_of_view=st.sampled_from([None, 1.0, 60.0, 150.0]),
    ),
    "video.theme": st.sampled_from(["light", "dark"]),
    **dict.fromkeys([f"video.overlays.{name}" for name in ("density", "cells", "targets", "clock")], st.booleans()),
}
SETTING = st.sampled_from(sorted(KEYS)).flatmap(lambda key: st.tuples(st.just(key), KEYS[key]))


@given(st.sampled_from(list(EMOTIONS)), st.lists(SETTING, max_size=3), st.sampled_from(["overhead", "perspective"]))
@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
def test_every_scene_is_drawn_or_refused_with_a_one_line_message(emotion, pairs, view) -> None:
    base = [("duration", 0.3), ("video.size", "64x64"), ("video.view", view)]
    refused = None
    try:
        scene = load_scene(emotion, [Setting(key, value, f"test {key}") for key, value in [*base, *pairs]])
        if scene.robots * scene.duration / scene.control_period > 20_000:
            return  # meant, but not here
        run = simulate(scene)
    except SourceError as error:
        refused = error
    if refused:
        assert refused.where
        assert refused.key
        assert len(str(refused).splitlines()) == 1
        return
    assert np.isfinite(run.poses).all()
    assert np.isfinite(run.commands).all()
    points = run.poses[..., :2].reshape(-1, 2)
    assert room_on_stage(points, scene.stage).min() >= scene.robot.body.radius - 1e-9
    if getattr(scene.behaviour, "separation", None) is not None and scene.robots > 1:
        assert summarize(run).body_distance >= scene.behaviour.separation - 1e-8
    painter, planes = Painter(run), Yuv420(scene.video.width, scene.video.height)
    for t in (0.0, scene.duration / 2, scene.duration):
        frame = painter.frame(t)
        assert frame.shape == (scene.video.height, scene.video.width, 4)
        assert (frame[..., 3] == 255).all()
        assert np.array_equal(planes.convert(frame, painter.changed()), whole_frame(frame))
