import numpy as np
import pytest

from emovid.measure.claim_metrics import claim_metrics, speeds_in_a_second
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate


def test_slowest_second_agrees_with_a_fine_search() -> None:
    trajectory = simulate(load_scene("anger"))
    fine = np.linspace(0, 15, 15001)
    v = np.abs(trajectory.commands[..., 0]).mean(axis=1)
    way = np.interp(fine, trajectory.t, np.concatenate([[0], np.cumsum(v * np.diff(trajectory.t))]))
    in_a_second = way[1000:] - way[:-1000]
    slowest, fastest = speeds_in_a_second(trajectory)
    assert slowest == pytest.approx(in_a_second.min(), rel=1e-3)
    assert slowest <= in_a_second.min() + 1e-9
    assert fastest == pytest.approx(in_a_second.max(), rel=1e-3)


def test_a_run_of_less_than_a_second_is_one_window() -> None:
    scene = load_scene("sadness", [Setting("duration", 0.5, "test")])
    slowest, fastest = speeds_in_a_second(simulate(scene))
    assert slowest == fastest > 0


def test_a_second_lasts_as_much_shorter_or_longer_as_the_last_snapshot_comes() -> None:
    keys = [Setting("duration", 4, "test"), Setting("snapshots", [0, 1, 3], "test")]  # 6 s in the paper
    trajectory = simulate(load_scene("anger", keys))
    found = claim_metrics(trajectory)
    assert (found["slowest_second"], found["fastest_second"]) == speeds_in_a_second(trajectory, 0.5)


def test_sadness_turns_by_an_eighth_of_a_circle() -> None:
    found = claim_metrics(simulate(load_scene("sadness")))
    assert found["circumference_share"] == pytest.approx(1 / 8, rel=0.05)
    assert found["neighbour_gain"] == pytest.approx(1, abs=0.02)


@pytest.mark.parametrize("name", ["happiness", "fear"])
def test_growth_is_undefined_for_a_single_robot(name: str) -> None:
    alone = simulate(load_scene(name, [Setting("robots", 1, "test"), Setting("duration", 1, "test")]))
    found = claim_metrics(alone)
    missing = {key for key, value in found.items() if np.isnan(value)}
    assert {"size_gain", "circumference_share", "neighbour_gain"} <= missing
    assert not missing & {"slowest_second", "fastest_second", "centre_gain", "boundary_share", "speed_mean"}
