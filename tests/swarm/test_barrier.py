from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from emovid.scene.load import Setting, load_scene
from emovid.scene.model import Scene
from emovid.scene.robots import spacing_of
from emovid.swarm.barrier import Certified, certified
from emovid.swarm.clearance import room_on_stage
from emovid.swarm.laws import coverage_velocity
from emovid.swarm.simulate import simulate
from emovid.swarm.start import start_poses
from emovid.swarm.summary import closest_approach
from emovid.swarm.unicycle import look_ahead, move, within_limits

STEP = 0.033
SEED = st.integers(0, 2**32 - 1)
ROOM = {"gritsbot_x": (1.3, 1.0), "e_puck2": (0.7, 0.6), "turtlebot3_burger": (2.4, 2.0), "crazyflie": (1.3, 1.2)}
SPACING = {"gritsbot_x": 0.17, "e_puck2": 0.075, "turtlebot3_burger": 0.29, "crazyflie": 0.14}


def crowd(model: str = "gritsbot_x", robots: int = 12, **keys: object) -> Scene:
    """Return a scene with many robots on a narrow stage, with a barrier."""
    width, height = ROOM[model]
    given = {
        "behaviour": {"law": "coverage", "kappa": 2, "density": {"kind": "gaussian", "sigma": 0.2}},
        "robot.model": model,
        "robot.l": 0.03,
        "robot.limits": "model",
        "robots": robots,
        "stage": {"width": width, "height": height},
        "start": {"place": "stage", "min_spacing": SPACING[model]},
        "control_period": STEP,
        "safety.kind": "barrier",
    }  # fmt: skip
    return load_scene("anger", [Setting(key, value, key) for key, value in (given | keys).items()])


@dataclass
class Driven:
    """A crowd under random commands: the smallest margins [m] of the disks over D, and over D / 2 from the walls."""

    apart: float
    walls: float
    periods: list[Certified]


def drive(scene: Scene, seed: int, periods: int = 60, hold: int = 7) -> Driven:
    rng = np.random.default_rng(seed)
    poses = start_poses(scene, rng)
    robot, ahead = scene.robot, scene.robot.body.guarded[0]
    D = spacing_of(scene.safety, robot)
    apart, walls, made = [], [], []
    own = np.where(np.eye(len(poses)) > 0, np.inf, 0.0)
    for k in range(periods):
        if k % hold == 0:
            wild = rng.uniform(-1, 1, (len(poses), 2)) * [0.5, 12.0 if robot.body.steers else 0.0]
            nominal = within_limits(wild, robot.limits, robot.body.wheel_base)
        done = certified(poses, nominal, scene.step, robot, scene.stage, scene.safety)
        poses[:, 2] = done.headings
        for t in np.linspace(0, scene.step, 5):
            q = look_ahead(move(poses, done.commands, t), ahead)
            apart.append((np.hypot(*(q[:, None] - q).transpose(2, 0, 1)) + own).min() - D)
            walls.append(room_on_stage(q, scene.stage).min() - D / 2)
        made.append(done)
        poses = move(poses, done.commands, scene.step)
    return Driven(min(apart), min(walls), made)


@pytest.mark.parametrize("model", list(ROOM))
@given(seed=SEED)
@settings(max_examples=3)
def test_bodies_keep_their_distance_under_any_commands(model: str, seed: int) -> None:
    scene = crowd(model)
    driven = drive(scene, seed)
    assert min(driven.apart, driven.walls) >= -1e-9
    assert any((done.bend > 1e-6).any() for done in driven.periods)


@pytest.mark.parametrize(("period", "gamma"), [(0.033, 30.0), (0.2, 5.0)])
def test_distance_holds_between_samples_too(period: float, gamma: float) -> None:
    driven = drive(
        crowd(control_period=period, **{"safety.period": period, "safety.gamma": gamma}), 5, periods=40, hold=2
    )
    assert min(driven.apart, driven.walls) >= -1e-9


@given(seed=SEED)
@settings(max_examples=8)
def test_commands_stay_within_the_motor_limits(seed: int) -> None:
    for done in drive(crowd(), seed, periods=20).periods:
        v, omega = np.abs(done.commands).T
        assert (v + 0.105 / 2 * omega).max() <= 0.2 * (1 + 1e-9)


def test_safe_commands_are_not_changed():
    scene = crowd(robots=2, stage={"width": 4.0, "height": 4.0})
    poses = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, np.pi]])
    commands = np.array([[0.2, 0.0], [0.1, 1.0]])
    done = certified(poses, commands, STEP, scene.robot, scene.stage, scene.safety)
    assert np.array_equal(done.commands, commands)
    assert not done.bend.any()
    assert np.array_equal(done.headings, poses[:, 2])


def test_robots_driving_head_on_slow_to_the_certified_speed():
    scene = crowd(robots=2, **{"stage": {"width": 4.0, "height": 4.0}, "safety.spacing": 0.2, "safety.gamma": 5.0})
    gap, ahead = 0.02, scene.robot.body.disc[0]
    x = (0.2 + gap) / 2 + ahead
    poses = np.array([[-x, 0.0, 0.0], [x, 0.0, np.pi]])
    done = certified(poses, np.full((2, 2), [0.15, 0.0]), STEP, scene.robot, scene.stage, scene.safety)
    assert done.commands[:, 0] == pytest.approx(5.0 * gap / 2, abs=1e-12)
    assert done.commands[:, 1] == pytest.approx(0, abs=1e-12)
    assert done.bend == pytest.approx(0.15 - 5.0 * gap / 2)


def test_one_robot_stops_at_a_wall():
    scene = crowd(robots=1, **{"safety.spacing": 0.16})
    ahead = scene.robot.body.disc[0]
    poses = np.array([[0.3, 0.0, 0.0]])
    for _ in range(300):
        done = certified(poses, np.array([[0.2, 0.0]]), STEP, scene.robot, scene.stage, scene.safety)
        poses = move(poses, done.commands, STEP)
    assert poses[0, 0] + ahead == pytest.approx(1.3 / 2 - 0.08, abs=1e-6)


@given(seed=SEED)
@settings(max_examples=10)
def test_change_of_commands_is_minimal_by_an_independent_solver(seed: int) -> None:
    # Two robots and a wall, written independently: the smallest change of wheel speeds under all constraints.
    rng = np.random.default_rng(seed)
    scene = crowd(robots=2, **{"safety.spacing": 0.16, "safety.gamma": 5.0})
    a, c, gamma, wheel_max = scene.robot.body.disc[0], 0.105 / 2, 5.0, 0.2
    angle, heading = rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi, 2)
    q = np.array([[0.54, 0.0], [0.54 - 0.17 * abs(np.cos(angle)), 0.17 * np.sin(angle)]])
    poses = np.column_stack([q - a * np.stack([np.cos(heading), np.sin(heading)], axis=-1), heading])
    nominal = within_limits(rng.uniform(-1, 1, (2, 2)) * [0.4, 8.0], scene.robot.limits, 0.105)
    n = (q[1] - q[0]) / np.hypot(*(q[1] - q[0]))

    def speed(command: np.ndarray, robot: int) -> np.ndarray:
        cos, sin = np.cos(heading[robot]), np.sin(heading[robot])
        return command[0] * np.array([cos, sin]) + a * command[1] * np.array([-sin, cos])

    def slack(flat: np.ndarray) -> np.ndarray:
        each = flat.reshape(2, 2)
        found = []
        for signs in product((1, -1), repeat=2):
            curve = wheel_max * STEP / 2 * np.array(signs) * each[:, 1]
            closing = n @ (speed(each[0], 0) - speed(each[1], 1))
            found.append(gamma * (np.hypot(*(q[1] - q[0])) - 0.16) - closing - curve.sum())
            found += [gamma * (0.65 - 0.08 - q[i, 0]) - speed(each[i], i)[0] - curve[i] for i in range(2)]
            found += list(wheel_max - each @ (np.array(signs) * [1.0, c]))
        return np.array(found)

    def change(flat: np.ndarray) -> float:
        off = (flat.reshape(2, 2) - nominal) * [1.0, c]
        return 100 * float(np.sum(off**2))

    done = certified(poses, nominal, STEP, scene.robot, scene.stage, scene.safety)
    assert slack(done.commands.ravel()).min() >= -1e-9
    held = {"type": "ineq", "fun": slack}
    other = minimize(change, np.zeros(4), constraints=held, method="SLSQP", options={"ftol": 1e-11})
    assert slack(other.x).min() >= -1e-8
    assert (done.commands.ravel() - other.x) * [1, c, 1, c] == pytest.approx(0, abs=1e-4)


def test_robots_that_start_too_close_move_apart():
    scene = crowd(robots=2, **{"stage": {"width": 4.0, "height": 4.0}, "safety.spacing": 0.23})
    poses = np.array([[-0.1, 0.0, 0.0], [0.1, 0.0, 0.3]])
    done = certified(poses, np.zeros((2, 2)), STEP, scene.robot, scene.stage, scene.safety)
    assert not done.relaxed.any()
    after = look_ahead(move(poses, done.commands, STEP), scene.robot.body.disc[0])
    before = look_ahead(poses, scene.robot.body.disc[0])
    assert np.hypot(*(after[1] - after[0])) > np.hypot(*(before[1] - before[0])) + 1e-3


PACKED = {
    "robots": 2,
    "start": {"place": "poses", "poses": [{"x": -0.1, "y": 0}, {"x": 0.1, "y": 0, "heading": 0.4}]},
    "safety.spacing": 1.2,  # on a stage of 1.3 m x 1 m: every command leads too close to a wall or to the other robot
    "duration": 1,
}


def test_infeasible_program_is_reported_once_and_robots_come_no_closer():
    scene = crowd(**PACKED)
    with pytest.warns(RuntimeWarning, match=r"^the barrier has no solution at 0 s: robots 1, 2 are nearer") as said:
        run = simulate(scene)
    assert len(said) == 1
    assert run.relaxed.any(axis=1).sum() > 10
    ahead = scene.robot.body.disc[0]
    middles = look_ahead(run.poses[0], ahead)
    assert closest_approach(run, ahead) >= np.hypot(*(middles[1] - middles[0])) - 1e-6


def test_simulation_records_the_changes_of_the_barrier():
    quiet = simulate(crowd(duration=1, safety="none"))
    assert quiet.bend is None
    assert quiet.relaxed is None
    run = simulate(crowd(duration=3, **{"safety.spacing": 0.19, "behaviour.density.sigma": 0.06}))
    assert run.bend.shape == run.relaxed.shape == run.commands.shape[:2]
    assert (run.bend > 1e-6).any()
    assert not run.relaxed.any()
    assert not run.stage_cut.any()
    assert closest_approach(run, run.scene.robot.body.disc[0]) >= spacing_of(run.scene.safety, run.scene.robot) - 1e-6


def test_barrier_with_a_shorter_period_keeps_the_held_command():
    # Far from everything: solved ten times in a control period, it changes no motion.
    keys = {"robots": 1, "duration": 2, "control_period": 0.33, "stage": {"width": 4.0, "height": 4.0}}
    own, whole = (
        simulate(crowd(**keys, **{"safety.period": 0.033})),
        simulate(crowd(**keys, **{"safety.period": 0.33, "safety.gamma": 3.0})),
    )
    assert len(own.commands) > 8 * len(whole.commands)
    times = np.linspace(0, 2, 50)
    assert np.abs(own.at(times)[..., :2] - whole.at(times)[..., :2]).max() < 1e-12


def test_omnidirectional_robot_resumes_its_course_after_an_obstacle() -> None:
    scene = crowd("crazyflie", robots=8, control_period=1.0, duration=10)
    run, held = (
        simulate(scene),
        scene.steps_held,
    )  # desired velocities are up to 1 s old, and other robots pass in the meantime
    assert run.bend is not None
    back = 0
    for start in range(0, len(run.commands), held):
        u = coverage_velocity(scene.behaviour, scene.stage, run.poses[start, :, :2])
        course = np.arctan2(u[:, 1], u[:, 0])
        for k in range(start, start + held):
            free = run.bend[k] == 0
            assert run.poses[k, free, 2] == pytest.approx(course[free])
            back += np.count_nonzero(free & run.bend[start:k].any(axis=0))
    assert back > 0
