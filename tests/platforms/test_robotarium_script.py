"""The script for the Robotarium: its text, and its runs in stand-ins for both simulators."""

import ast
import json
import subprocess
import sys
from functools import cache
from importlib.metadata import version

import numpy as np
import pytest
from PIL import Image

from emovid.cli.main import main
from emovid.errors import SourceError
from emovid.measure.describe import describe
from emovid.platforms.robotarium import ARENAS, robotarium_script
from emovid.scene.behaviour import Coverage
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene, scene_digest
from emovid.scene.model import Scene
from emovid.swarm.densities import density_of
from emovid.swarm.laws import corners_of, followed_points, mass_and_centroid, start_angles
from emovid.swarm.projection import nearest_within
from emovid.swarm.simulate import simulate
from emovid.swarm.tracks import load_positions
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import wrapped
from tests.helpers import rps_stand_in

ROUND, SPREAD = ("happiness", "surprise", "sadness"), ("fear", "disgust", "anger")
TODAY = ARENAS["3.2x2.0"]
INTERFACES = (rps_stand_in.Robotarium1, rps_stand_in.Robotarium2)


def scene_of(emotion: str, **keys: object) -> Scene:
    settings = {"duration": 15, "snapshots": None} | keys
    named = [Setting(key.replace("__", "."), value, f"test {key}") for key, value in settings.items()]
    return load_scene(f"robotarium-today/{emotion}", named)


@cache
def runs(emotion: str, seed: int = 1) -> tuple[Trajectory, Trajectory, rps_stand_in.StandIn]:
    """Return the simulated run of 15 s, the run of the script in simulator 1.x, and the simulator."""
    scene = scene_of(emotion, seed=seed)
    simulator, _ = rps_stand_in.run(robotarium_script(scene, emotion, TODAY, trails=True), INTERFACES[0])
    return simulate(scene), simulator.run_of(scene), simulator


def functions(scene: Scene) -> dict:
    """Return the definitions of the script of a scene, without running the experiment."""
    text = robotarium_script(scene, "scene", TODAY).removesuffix("\n\n\nmain()\n")
    names: dict = {"__name__": "script"}
    with rps_stand_in.installed(INTERFACES[0]):
        exec(text, names)  # noqa: S102
    return names


# --- runs -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_robots_neither_collide_leave_the_arena_nor_exceed_motor_limits(emotion) -> None:
    assert runs(emotion)[2].errors == {"boundary": 0, "collision": 0, "actuator": 0}


@pytest.mark.parametrize("emotion", ROUND)
def test_contours_match_the_simulation_within_a_centimeter_over_15_s(emotion) -> None:
    ours, theirs, _ = runs(emotion)
    times = theirs.t[theirs.t <= 15]
    off = np.hypot(*np.moveaxis((theirs.at(times) - ours.at(times))[..., :2], -1, 0))
    assert times[-1] > 14.95
    assert off.max() < 0.01


@pytest.mark.parametrize("emotion", SPREAD)
def test_coverage_matches_the_simulation_in_its_descriptors(emotion) -> None:
    # Angular motion is chaotic: rounding differences change single turns. The mean of three seeds is steadier.
    pairs = [[describe(run) for run in runs(emotion, seed)[:2]] for seed in (1, 2, 3)]
    for name in ("speed_mean", "speed_p95", "radius_of_gyration_mean", "nearest_neighbour_mean", "trace_length"):
        assert np.mean([theirs[name] / ours[name] for ours, theirs in pairs]) == pytest.approx(1, abs=0.05), name
    for name in ("radius_of_gyration_end", "distance_to_boundary_end", "turning_per_metre"):
        assert np.mean([theirs[name] / ours[name] for ours, theirs in pairs]) == pytest.approx(1, abs=0.1), name


@pytest.mark.parametrize("emotion", ["happiness", "surprise"])
def test_both_simulator_interfaces_give_the_same_run_within_common_limits(emotion) -> None:
    scene = scene_of(emotion, duration=1.65)
    script = robotarium_script(scene, emotion, TODAY)
    one, two = (rps_stand_in.run(script, interface)[0] for interface in INTERFACES)
    assert one.errors == two.errors == {"boundary": 0, "collision": 0, "actuator": 0}
    assert two.run_of(scene).poses == pytest.approx(one.run_of(scene).poses, abs=1e-9)


def test_robot_of_simulator_2_respects_its_turning_limit() -> None:
    simulator, _ = rps_stand_in.run(robotarium_script(scene_of("disgust", duration=3), "disgust", TODAY), INTERFACES[1])
    assert simulator.errors == {"boundary": 0, "collision": 0, "actuator": 0}
    wheel = np.abs(np.array(simulator.done)) * [[1], [0.055]]
    assert 0.199 < wheel.sum(axis=1).max() <= 0.2


def test_robots_are_placed_far_apart_and_drive_to_their_start() -> None:
    # The simulator 2.x places robots at least 0.25 m apart, within 0.05 m.
    ours, theirs, simulator = runs("sadness")
    first = simulator.seen[0][:2]
    apart = np.hypot(*(first[:, :, None] - first[:, None])) + 9 * np.eye(first.shape[1])
    assert apart.min() > 0.3
    assert 0 < len(simulator.seen) - len(theirs.commands) < 20 / rps_stand_in.STEP
    assert np.hypot(*(theirs.poses[0] - ours.poses[0])[:, :2].T).max() < 0.003
    assert np.abs(wrapped(theirs.poses[0] - ours.poses[0])[:, 2]).max() < 0.01


def test_trails_match_the_scene() -> None:
    _, theirs, simulator = runs("sadness")
    lines = simulator.canvas.lines
    assert len(lines) == 4
    for line, robot in zip(lines, (0, 3, 6, 9), strict=True):
        np.testing.assert_allclose(line.points.T, theirs.poses[:-1, robot, :2])
    assert len({line.look["color"] for line in lines}) == 4
    without, _ = rps_stand_in.run(robotarium_script(scene_of("sadness", duration=0.1), "s", TODAY), INTERFACES[1])
    assert without.canvas.lines == []


def test_initial_placement_errors_of_some_centimeters_are_tolerated() -> None:
    script = robotarium_script(scene_of("sadness", duration=3), "sadness", TODAY)

    class Careless(INTERFACES[1]):
        def __init__(self, **keys: object) -> None:
            super().__init__(**keys)
            self._state += np.random.default_rng(4).uniform(-1, 1, self._state.shape) * [[0.035], [0.035], [0.2]]

    simulator, _ = rps_stand_in.run(script, Careless)
    assert simulator.errors == {"boundary": 0, "collision": 0, "actuator": 0}


# --- parts of the script compared with the package --------------------------------------------------------------------


@pytest.fixture
def picture(tmp_path) -> str:
    Image.fromarray(np.random.default_rng(1).integers(0, 255, (20, 30), dtype=np.uint8)).save(tmp_path / "p.png")
    return str(tmp_path / "p.png")


@pytest.mark.parametrize("kind", ["uniform", "gaussian", "boundary", "image", "sum"])
def test_centroids_match_the_simulation(kind, picture, monkeypatch) -> None:
    basic = {
        "uniform": {"kind": "uniform"},
        "gaussian": {"kind": "gaussian", "sigma": 0.3, "centre": {"x": 0.2, "y": -0.1}},
        "boundary": {"kind": "boundary", "width": 0.12, "inset": 0.15},
        "image": {"kind": "image", "file": picture, "smoothing": 0.2},
    }
    parts = [{"weight": 2.0, "density": basic["gaussian"]}, {"weight": 0.5, "density": basic["image"]}]
    scene = scene_of("fear", behaviour__density=basic.get(kind) or {"kind": "sum", "parts": parts})
    scene = scene.model_copy(update={"behaviour": scene.behaviour.model_copy(update={"u_max": None})})
    script = functions(scene)
    density = density_of(scene.behaviour.density, scene.stage)
    rng = np.random.default_rng(2)
    if "phi" in script:  # a picture
        x, y = rng.uniform([[-1.6], [-1.0]], [[1.6], [1.0]], (2, 40))
        assert script["phi"](x, y) == pytest.approx(density.phi(x, y), rel=2e-3)
    # The package neglects parts of a border that are negligible for both cells, the script those for one of them.
    exact = 1e-8 if density.gaussians else 2e-4  # the numbers of a picture have four digits
    for neglected in (None, None, 40.0, 40.0) if density.gaussians else (None, None):
        if neglected:
            monkeypatch.setattr("emovid.swarm.line_integrals._NEGLIGIBLE", neglected)
            script["_NEGLIGIBLE"], exact = neglected, 1e-12
        points = rng.uniform([-1.5, -0.9], [1.5, 0.9], (12, 2))
        _, ours = mass_and_centroid(points, corners_of(scene.stage), density)
        u = script["law"](0.0, np.vstack([points.T, np.zeros(12)]))
        assert points + u.T / scene.behaviour.kappa == pytest.approx(ours, abs=exact)


def test_script_saves_poses_in_a_measurable_file(tmp_path) -> None:
    scene, _, simulator = scene_of("surprise"), *runs("surprise")[1:]
    assert list(simulator.files) == ["surprise-poses.csv"]
    (tmp_path / "poses.csv").write_text(simulator.files["surprise-poses.csv"])
    saved = load_positions(tmp_path / "poses.csv", scene)
    ours = simulate(scene)
    assert saved.poses.shape[1] == 12
    assert saved.t[-1] == pytest.approx(15, abs=0.04)
    assert saved.poses[..., :2] == pytest.approx(ours.at(np.minimum(saved.t, 15))[..., :2], abs=0.01)


@pytest.mark.parametrize("emotion", ROUND)
def test_followed_points_match_the_simulation(emotion) -> None:
    scene = scene_of(emotion)
    script = functions(scene)
    poses = np.random.default_rng(3).normal(size=(3, scene.robots))
    for t in (0.0, 1.3, 14.9):
        ahead = poses[:2] + scene.robot.l * np.array([np.cos(poses[2]), np.sin(poses[2])])
        points = followed_points(scene.behaviour, start_angles(scene.robots), t)
        assert script["law"](t, poses) + ahead == pytest.approx(points.T)


def test_a_command_beyond_the_limits_keeps_its_curvature() -> None:
    script = functions(scene_of("anger"))
    commands = np.array([np.linspace(-0.5, 0.5, 12), np.linspace(8, -3, 12)])
    scaled = script["within_limits"](commands, 0.11)
    assert scaled[0] * commands[1] == pytest.approx(scaled[1] * commands[0])
    assert np.max(np.abs(scaled[0]) + 0.055 * np.abs(scaled[1])) <= 0.2
    slow = commands / 20
    assert script["within_limits"](slow, 0.11) == pytest.approx(slow)


def test_nearest_commands_match_the_barrier_of_the_simulation() -> None:
    script = functions(scene_of("fear"))
    rng = np.random.default_rng(6)
    for _ in range(40):
        a, b = rng.normal(size=(25, 6)), rng.uniform(0, 0.1, 25)
        point = rng.normal(size=6) * 0.2
        ours = nearest_within(point / 0.2, a, b / 0.2)
        assert ours is not None
        assert script["nearest_within"](point, a, b) == pytest.approx(0.2 * ours, abs=1e-7)


def test_robots_driving_at_each_other_or_a_wall_stop_in_time() -> None:
    script = functions(scene_of("fear"))
    rng = np.random.default_rng(5)
    poses = np.array(script["PARKED"])
    for _ in range(150):
        towards = np.arctan2(-poses[1], 1.6 - poses[0])
        turn = np.arctan2(np.sin(towards - poses[2]), np.cos(towards - poses[2]))
        wanted = script["within_limits"](np.array([np.full(12, 0.2), 3 * turn + rng.normal(size=12)]), 0.11)
        v, omega = script["safe"](poses, wanted, 0.033, 0.11)
        assert np.max(np.abs(v) + 0.055 * np.abs(omega)) <= 0.2
        poses = poses + 0.033 * np.array([v * np.cos(poses[2]), v * np.sin(poses[2]), omega])
        points = script["look_ahead"](poses, 0.025)
        apart = np.hypot(*(points[:, :, None] - points[:, None])) + 9 * np.eye(12)
        assert apart.min() > 0.135
        assert np.abs(poses[0]).max() < 1.6
        assert np.abs(poses[1]).max() < 1.0
    assert apart.min() < 0.2  # the robots did meet


# --- text -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("emotion", ["happiness", "surprise", "disgust", "anger"])
def test_script_is_one_file_that_needs_only_numpy_and_rps(emotion, tmp_path) -> None:
    text = robotarium_script(scene_of(emotion), emotion, TODAY, trails=True)
    tree = ast.parse(text)
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert imported == {"numpy", "rps.robotarium"}
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert modules <= {"__future__", "functools", "itertools", "math", "types", "typing"}
    assert not {"open", "eval", "exec", "input"} & {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    assert "{{" not in text
    assert "#:" not in text
    (tmp_path / "script.py").write_text(text)
    lint = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "E,F,W,I,B,UP,D4", "--line-length", "120"]
    done = subprocess.run(
        [*lint, "--ignore", "B905,D413", str(tmp_path / "script.py")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_script_header_names_scene_seed_arena_and_version() -> None:
    scene = scene_of("fear", seed=7)
    header = ast.get_docstring(ast.parse(robotarium_script(scene, "my_scene", TODAY)))
    assert header is not None
    for said in (f"Scene: my_scene, SHA-256 {scene_digest(scene)}", "Emotion: fear", "Seed: 7", "Arena: 3.2 m x 2.0 m"):
        assert said in header
    assert f"Written by: emovid {version('emovid')}" in header


def test_scene_name_cannot_inject_code() -> None:
    text = robotarium_script(scene_of("fear"), 'a"""\nimport os\n"""\\', TODAY)
    assert "\nimport os" not in text
    header = ast.get_docstring(ast.parse(text))
    assert header is not None
    assert header.startswith("a____import os_____: 12 robots")


def test_equal_scenes_give_identical_scripts() -> None:
    first, second = (robotarium_script(scene_of("anger"), "anger", TODAY) for _ in range(2))
    assert first == second


def test_contour_script_contains_no_coverage_code() -> None:
    text = robotarium_script(scene_of("happiness"), "happiness", TODAY)
    assert "voronoi" not in text
    assert "TRAILS" not in text
    assert isinstance(scene_of("fear").behaviour, Coverage)


@pytest.mark.parametrize(
    ("emotion", "keys", "message"),
    [
        ("fear", {"robots": 21, "start__place": "stage", "start__region": None}, None),
        ("happiness", {"duration": 841}, "test duration: duration: 841: expected at most 840 s"),
        ("happiness", {"safety": "none"}, "test safety: safety: none: expected barrier; a collision there is an error"),
        ("happiness", {"stage": {"width": 4.3, "height": 3.6}}, "test stage: stage: 4.3 m x 3.6 m: does not fit in the "
         "arena of 3.2 m x 2.0 m; --arena names another"),
    ],
)  # fmt: skip
def test_infeasible_scene_is_refused_with_a_one_line_message(emotion, keys, message) -> None:
    if message is None:
        start = {"place": "stage", "min_spacing": 0.2}
        keys, message = {"robots": 21, "start": start}, "test robots: robots: 21: the Robotarium has at most 20"
    with pytest.raises(SourceError) as caught:
        robotarium_script(scene_of(emotion, **keys), "scene", TODAY)
    assert str(caught.value) == message


def test_a_start_that_counts_as_a_collision_is_refused() -> None:
    face_to_face = {
        "place": "poses",
        "poses": [{"x": -0.085, "y": 0, "heading": 0}, {"x": 0.085, "y": 0, "heading": np.pi}],
    }
    with pytest.raises(SourceError, match=r"robots: two would start 120 mm apart; a collision there is at 135$"):
        robotarium_script(scene_of("fear", robots=2, start=face_to_face, safety__spacing=0.135), "scene", TODAY)


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_writes_the_six_scripts(tmp_path, capsys) -> None:
    assert main(["export", "robotarium", "--all", "-o", str(tmp_path / "upload"), "--trails"]) == 0
    assert {path.name for path in (tmp_path / "upload").iterdir()} == {f"{emotion}.py" for emotion in EMOTIONS}
    assert capsys.readouterr().err.count("for the Robotarium's arena of 3.2 m x 2.0 m") == 6
    assert "TRAILS" in (tmp_path / "upload" / "fear.py").read_text()


def test_command_accepts_scene_seed_and_arena(tmp_path, capsys) -> None:
    target = tmp_path / "mine.py"
    arguments = ["export", "robotarium", "anger", "--seed", "5", "--arena", "4.3x3.6", "-o", str(target), "--json"]
    assert main(arguments) == 0
    (said,) = json.loads(capsys.readouterr().out)
    assert said["seed"] == 5
    assert said["scene_digest"] in target.read_text()
    assert "Arena: 4.3 m x 3.6 m" in target.read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["anger", "--arena", "3.2x2"], "--arena 3.2x2: expected 3.2x2.0 or 4.3x3.6 (did you mean 3.2x2.0?)"),
        (
            ["robotarium/anger"],
            "stage: 4.3 m x 3.6 m: does not fit in the arena of 3.2 m x 2.0 m; --arena names another",
        ),
        (["angr"], "angr: no such file or emotion (did you mean anger?)"),
        ([], "expected one scene: a file, or --emotion and one of happiness, surprise, sadness, fear, disgust, anger"),
        (["anger", "--all"], "--all: cannot be combined with a scene"),
        (["--all", "-o", "a.py"], "-o a.py: is one file; expected a folder for six scripts"),
        (["anger", "-o", "a.m"], "-o a.m: cannot write .m; expected .py, or a folder"),
    ],
)
def test_invalid_input_gives_one_line_and_writes_no_file(arguments, message, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["export", "robotarium", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.endswith(f"{message}\n")
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())
