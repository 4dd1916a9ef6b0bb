import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from emovid.cli.main import main
from emovid.platforms.feasibility import TESTBEDS, check_platform, contour_spacing, wall_distance
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.load import Setting, load_scene
from emovid.scene.model import Scene
from emovid.swarm.clearance import room_on_stage
from emovid.swarm.laws import followed_points, start_angles
from emovid.swarm.simulate import simulate
from emovid.swarm.unicycle import look_ahead

SHORT = {"duration": 10, "snapshots": None}


def scene_of(name: str, keys: dict[str, object]) -> Scene:
    return load_scene(name, [Setting(key, value, key) for key, value in keys.items()])


def failed(name: str, keys: dict[str, object], platform: str = "robotarium") -> set[str]:
    run = simulate(scene_of(name, SHORT | keys))
    return {check.name for check in check_platform(run, TESTBEDS[platform]) if not check.holds}


@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize("emotion", EMOTIONS)
def test_shipped_scenes_are_feasible_on_other_seeds(platform: str, emotion: str) -> None:
    # Seeds 0 to 49 and complete runs: benchmarks/robotarium_safety.py.
    for seed in (3, 17) if emotion in ("fear", "disgust", "anger") else (1,):
        assert failed(f"{platform}/{emotion}", {"seed": seed}, platform) == set()


@pytest.mark.parametrize(
    ("name", "keys", "expected"),
    [
        ("robotarium/sadness", {"robots": 21, "behaviour.R": 0.8, "duration": 1}, {"robots"}),
        ("robotarium/sadness", {"behaviour.R": 0.285, "safety.spacing": 0.14}, {"spacing on the contour"}),
        ("robotarium/sadness", {"control_period": 0.05, "safety.period": None}, {"step of commands"}),
        ("robotarium/fear", {"safety": "none", "robot.limits": None}, {"barrier", "fastest wheel"}),
        ("robotarium/anger", {"robot.limits": {"wheel_max": 0.25}}, {"fastest wheel"}),
    ],
)  # fmt: skip
def test_infeasible_scenes_fail_the_check(name: str, keys: dict[str, object], expected: set[str]) -> None:
    assert expected <= failed(name, keys)


def test_spacing_on_a_contour_considers_all_pairs_of_points() -> None:
    # Its dents nearly touch the center: points that are not neighbors along the contour come closest there.
    scene = scene_of("happiness", {"behaviour.R": 0.19, "behaviour.A": 0.18})
    theta_0, law = start_angles(scene.robots), scene.behaviour
    seen = np.inf
    for t in np.linspace(0, scene.duration, 3000):
        points = followed_points(law, theta_0, t)
        seen = min(seen, *pdist(points))
    assert contour_spacing(scene) == pytest.approx(seen, rel=0.01)
    assert contour_spacing(scene) == pytest.approx(np.sqrt(3) * 0.01, rel=0.01)  # three at a time in dents 0.01 m out


def test_spacing_is_not_checked_for_one_robot() -> None:
    run = simulate(scene_of("robotarium/fear", {"duration": 1, "snapshots": None, "robots": 1}))
    names = [check.name for check in check_platform(run, TESTBEDS["robotarium"])]
    assert not {"spacing on the contour", "between bodies", "collision points"} & set(names)
    assert {"robots", "from bodies to walls", "fastest wheel", "time without a solution"} <= set(names)


def test_experiment_longer_than_15_minutes_fails() -> None:
    run = simulate(scene_of("robotarium/sadness", {"duration": 1, "snapshots": None}))
    for duration, holds in ((900.0, True), (901.0, False)):
        longer = replace(run, scene=run.scene.model_copy(update={"duration": duration}))
        (check,) = (each for each in check_platform(longer, TESTBEDS["robotarium"]) if each.name == "duration")
        assert check.holds == holds


def test_infeasible_barrier_program_fails() -> None:
    with pytest.warns(RuntimeWarning, match="the barrier has no solution"):
        assert "time without a solution" in failed("robotarium/sadness", {"safety.spacing": 0.5, "duration": 1})


def test_a_stage_must_fit_the_arena() -> None:
    assert failed("robotarium/sadness", {"duration": 1}, "robotarium-today") == {"stage"}


def test_twelve_robots_need_a_circle_of_29_cm() -> None:
    for radius, fits in ((0.289, False), (0.2899, True)):
        scene = scene_of("robotarium/sadness", {"behaviour.R": radius})
        assert (contour_spacing(scene) >= 0.15) == fits
    assert contour_spacing(load_scene("robotarium/fear")) is None


def test_wall_distance_is_the_minimum_along_the_arcs() -> None:
    run = simulate(scene_of("robotarium-today/anger", {"duration": 6, "snapshots": None, "seed": 5}))
    ahead, radius = run.scene.robot.body.disc
    times = np.linspace(0, run.t[-1], 6001)
    seen = min(room_on_stage(look_ahead(poses, ahead), run.scene.stage).min() for poses in run.at(times)) - radius
    assert wall_distance(run) <= seen + 1e-12
    assert wall_distance(run) == pytest.approx(seen, abs=2e-4)


def test_command_prints_a_report_and_sets_the_exit_code(capsys) -> None:
    assert main(["check-platform", "sadness", "--set", "duration=2", "--set", "snapshots=[0, 1]"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("robotarium-today/sadness on robotarium-today\n")
    assert said.endswith("can run there\n")
    assert re.search(r"^  holds  duration: +2 s \(expected at most 900 s\)$", said, re.MULTILINE)
    settings = ["--set", "duration=2", "--set", "snapshots=null", "--set", "robot.limits={wheel_max: 0.3}"]
    assert main(["check-platform", "anger", "-p", "robotarium-today", *settings]) == 1
    assert "FAILS  fastest wheel:" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "name", "failed"),
    [
        (["sadness"], "robotarium-today/sadness", []),
        (["robotarium-today/anger", "--set", "robot.limits={wheel_max: 0.3}"], None, ["fastest wheel"]),
    ],
)
def test_command_reports_as_json(arguments, name, failed, capsys) -> None:
    short = ["--set", "duration=2", "--set", "snapshots=null", "--json"]
    assert main(["check-platform", *arguments, *short]) == bool(failed)
    said = json.loads(capsys.readouterr().out)
    assert (said["scene"], said["holds"]) == (name or arguments[0], not failed)
    assert said["platform"] == said["scene"].split("/")[0]
    assert [check["name"] for check in said["checks"] if not check["holds"]] == failed


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["check-platform", "angr"], "angr: no such file or emotion (did you mean anger?)"),
        (["check-platform", "anger", "-p", "robotarum"], "robotarium-today (did you mean robotarium?)"),
        (["render", "my.yaml", "--platform", "robotarium"], "--platform robotarium: my.yaml is not an emotion"),
    ],
)  # fmt: skip
def test_invalid_input_gives_a_one_line_message(arguments: list[str], words: str, capsys) -> None:
    assert main(arguments) == 2
    said = capsys.readouterr()
    assert words in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""


def test_platform_is_part_of_a_scenes_name(capsys, tmp_path: Path) -> None:
    assert main(["scene", "show", "fear", "--platform", "robotarium"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("# Fear on robots: ")
    assert main(["scene", "show", "robotarium/fear"]) == 0
    assert capsys.readouterr().out == shown
    assert main(["scene", "new", str(tmp_path / "my.yaml"), "--from", "fear", "-p", "robotarium"]) == 0
    assert (tmp_path / "my.yaml").read_text().split("\n", 1)[1] == shown  # below the line for editors
    capsys.readouterr()
    assert main(["scene", "list", "--platform", "robotarium-today"]) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert names == [f"robotarium-today/{emotion}" for emotion in EMOTIONS]
    out = tmp_path / "run.npz"
    few = ["--set", "duration=1", "--set", "snapshots=null", "-q", "-o", str(out)]
    assert main(["simulate", "fear", "-p", "robotarium-today", *few]) == 0
    assert main(["measure", str(out), "--json"]) == 0
