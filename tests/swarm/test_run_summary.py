import numpy as np
import pytest
from scipy.spatial.distance import pdist

from emovid.swarm.simulate import simulate
from emovid.swarm.summary import closest_approach, summarize
from emovid.swarm.trajectory import Trajectory


def run_of(make_scene, poses: list[list[float]], commands: list[list[float]]) -> Trajectory:
    listed = [dict(zip(("x", "y", "heading"), pose, strict=True)) for pose in poses]
    keys = {"robots": len(poses), "start": {"place": "poses", "poses": listed}, "duration": 1, "control_period": 1.0}
    cut = np.zeros((1, len(poses)), dtype=bool)
    held = np.array([commands])
    scene = make_scene("fear", keys)
    first = np.array(poses)
    return Trajectory(scene, np.array([0.0, 1.0]), np.stack([first, first]), held, cut, cut)


def test_closest_approach_between_samples_is_found(make_scene) -> None:
    # In opposite directions on lines 50 mm apart, side by side at t = 0.5 s: at the samples, at least 0.2 m apart.
    run = run_of(make_scene, [[-0.1, 0.025, 0.0], [0.1, -0.025, np.pi]], [[0.2, 0.0], [0.2, 0.0]])
    assert closest_approach(run) == pytest.approx(0.05, abs=2e-6)


@pytest.mark.parametrize("emotion", ["surprise", "disgust", "anger"])
def test_closest_approach_agrees_with_dense_sampling(make_scene, emotion) -> None:
    run = simulate(make_scene(emotion, {"duration": 5}))
    sampled = min(pdist(points).min() for points in run.at(np.linspace(0, 5, 20001))[..., :2])
    found = closest_approach(run)
    assert found <= sampled + 1e-9
    assert found == pytest.approx(sampled, abs=1e-4)


def test_single_robot_has_no_body_distance(make_scene) -> None:
    run = simulate(make_scene("fear", {"robots": 1, "duration": 1}))
    assert summarize(run).body_distance is None


def test_overlap_is_a_negative_distance(make_scene) -> None:
    run = run_of(make_scene, [[-0.1, 0.0, 0.0], [0.1, 0.0, np.pi]], [[0.1, 0.0], [0.09, 0.0]])
    radius = run.scene.robot.body.radius
    assert summarize(run).body_distance == pytest.approx(0.01 - 2 * radius, abs=2e-6)


def test_speeds_by_hand(make_scene) -> None:
    found = summarize(run_of(make_scene, [[-0.1, 0.0, 0.0], [0.1, 0.1, 0.0]], [[0.1, 0.0], [-0.3, 0.0]]))
    assert (found.mean_speed, found.peak_speed) == pytest.approx((0.2, 0.3))
    assert (found.stage_cut_share, found.separation_cut_share) == (0, 0)
