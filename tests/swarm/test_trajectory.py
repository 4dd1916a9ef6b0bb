import numpy as np
import pytest

from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory


@pytest.fixture(scope="module")
def anger(make_scene) -> Trajectory:
    return simulate(make_scene("anger", {"duration": 3}))


def test_poses_at_sample_times_are_exact(anger) -> None:
    assert anger.at(anger.t) == pytest.approx(anger.poses, abs=1e-9)


def test_motion_is_continuous_between_samples(anger) -> None:
    before, after = anger.at(anger.t[1:] - 1e-9), anger.at(anger.t[1:])
    assert np.abs(before[..., :2] - after[..., :2]).max() < 1e-8


@pytest.mark.parametrize("times", [[-0.1], [0.0, 3.01], [np.inf]])
def test_times_outside_the_run_are_refused(anger, times) -> None:
    with pytest.raises(ValueError, match="the run is 0 to 3 s"):
        anger.at(np.array(times))


@pytest.mark.parametrize("tolerance", [1e-5, 1e-4, 1e-3])
def test_trace_deviates_from_the_arcs_by_less_than_the_tolerance(anger, tolerance) -> None:
    times, points = anger.trace(4, tolerance)
    assert (np.diff(times) > 0).all()
    assert anger.at(times)[:, 4, :2] == pytest.approx(points, abs=1e-9)
    for share in np.linspace(0.1, 0.9, 9):
        between = times[:-1] + share * np.diff(times)
        exact = anger.at(between)[:, 4, :2]
        along = np.diff(points, axis=0)
        offset = exact - points[:-1]
        length = np.maximum(np.hypot(*along.T), 1e-12)
        aside = np.abs(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]) / length
        assert aside.max() <= tolerance * 1.0001


def test_a_coarse_trace_has_fewer_points_than_a_fine_one(anger) -> None:
    assert len(anger.trace(0, 1e-3)[0]) < len(anger.trace(0, 1e-5)[0])


def test_digest_depends_only_on_the_motion(anger, make_scene) -> None:
    again = simulate(make_scene("anger", {"duration": 3, "video.fps": 60}))
    other = simulate(make_scene("anger", {"duration": 3, "seed": 2}))
    assert again.digest() == anger.digest()
    assert other.digest() != anger.digest()
