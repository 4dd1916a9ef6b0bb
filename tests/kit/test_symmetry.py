import numpy as np
import pytest

from emovid.kit.symmetry import can_half_turn, can_mirror, can_turn, mirrored, turned
from emovid.swarm.simulate import simulate

TIMES = np.linspace(0, 1.5, 31)


@pytest.fixture(scope="module")
def run_of(make_scene):
    def run(emotion="happiness", **keys):
        return simulate(make_scene(emotion, {"duration": 1.5, **keys}))

    return run


def as_sets(poses):
    """Sort the robots at each time, so that swarms are compared without robot numbers."""
    rounded = np.round(poses, 6) + 0.0
    return np.array([sorted(map(tuple, swarm[:, :2])) for swarm in rounded])


@pytest.mark.parametrize("emotion", ["happiness", "surprise", "sadness"])
def test_mirrored_contour_run_is_the_run_in_the_other_direction(run_of, emotion) -> None:
    # Positions equal to their mirror image: an even number of robots, and five ripples, since sin 5(pi - x) = sin 5x.
    keys = {"robots": 8} | ({"behaviour.f": 5} if emotion == "happiness" else {})
    run = run_of(emotion, **keys)
    back = run_of(emotion, **keys, **{"behaviour.angular_rate": -run.scene.behaviour.angular_rate})
    assert np.allclose(as_sets(mirrored(run).at(TIMES)), as_sets(back.at(TIMES)), atol=2e-6)


def test_ring_turned_by_one_robot_spacing_equals_the_ring_with_robots_renumbered(run_of) -> None:
    run = run_of("sadness")
    step = turned(run, 2 * np.pi / 15, (0.0, 0.0)).at(TIMES)
    assert np.allclose(step[:, :-1, :2], run.at(TIMES)[:, 1:, :2], atol=1e-9)


@pytest.mark.parametrize("emotion", ["fear", "anger", "happiness"])
@pytest.mark.parametrize("change", [mirrored, lambda run: turned(run, 2.1, (0.03, -0.02))], ids=["mirror", "turn"])
def test_transformed_commands_lead_from_pose_to_pose(run_of, emotion, change) -> None:
    run = change(run_of(emotion))
    ends = run.at(np.nextafter(run.t[1:], 0))
    assert np.allclose(ends[..., :2], run.poses[1:, :, :2], atol=1e-9)
    assert np.allclose(np.exp(1j * ends[..., 2]), np.exp(1j * run.poses[1:, :, 2]), atol=1e-6)


@pytest.mark.parametrize("emotion", ["fear", "surprise"])
def test_distances_and_speeds_are_invariant(run_of, emotion) -> None:
    run = run_of(emotion)
    for other in (mirrored(run), turned(run, 1.0, (0.0, 0.1))):
        between = [np.linalg.norm(p[:, :, None, :2] - p[:, None, :, :2], axis=-1) for p in (run.poses, other.poses)]
        assert np.allclose(*between)
        assert np.array_equal(np.abs(other.commands), np.abs(run.commands))


def test_mirroring_twice_gives_the_original_run(run_of) -> None:
    run = run_of("anger")
    assert np.allclose(mirrored(mirrored(run)).poses[..., :2], run.poses[..., :2])


def test_a_turned_ring_stays_on_its_stage(run_of) -> None:
    run = run_of("surprise", duration=5)
    assert can_turn(run)
    for angle in np.linspace(0, 6, 7):
        poses = turned(run, angle, (0.0, 0.0)).poses
        assert np.abs(poses[..., 0]).max() < 0.6
        assert np.abs(poses[..., 1]).max() < 0.4


def test_random_starts_are_not_turned(run_of) -> None:
    assert not can_turn(run_of("fear"))


@pytest.mark.parametrize(
    ("corners", "mirror", "half"),
    [
        ([[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], True, True),
        ([[-0.6, -0.4], [0.6, -0.4], [0.0, 0.6]], True, False),
        ([[-0.6, -0.4], [0.5, -0.4], [0.6, 0.4], [-0.5, 0.4]], False, True),
        ([[-0.6, -0.4], [0.6, -0.4], [-0.5, 0.6]], False, False),
    ],
)
def test_a_stage_is_mirrored_only_onto_itself(make_scene, corners, mirror, half) -> None:
    stage = {"corners": [{"x": x, "y": y} for x, y in corners]}
    keys = {"stage": stage, "robots": 3, "start": {"place": "stage"}}
    scene = make_scene("fear", keys)
    assert (can_mirror(scene), can_half_turn(scene)) == (mirror, half)
