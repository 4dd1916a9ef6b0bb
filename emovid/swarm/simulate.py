"""Simulation: from a scene to its trajectory. Nothing here depends on frames, trails or files."""

import warnings
from collections.abc import Callable

import numpy as np

from emovid.errors import InputError
from emovid.scene.behaviour import ContourKeys, Coverage
from emovid.scene.model import Scene
from emovid.scene.robots import Barrier, Robot
from emovid.swarm.arrays import Array, Mask
from emovid.swarm.clearance import share_apart, share_on_stage
from emovid.swarm.laws import coverage_velocity, followed_points, start_angles
from emovid.swarm.start import start_poses
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import look_ahead, move, near_identity, within_limits

# From the time [s] and the poses (N, 3) to single-integrator velocities u (N, 2) [m/s].
Law = Callable[[float, Array], Array]


def simulate(scene: Scene, on_period: Callable[[int, int], None] | None = None) -> Trajectory:
    """Return the run of a scene: the same for the same scene and seed, bit for bit.

    Once in a control period each robot evaluates its law, turns the result into a command and holds it until the end
    of the period, as a robot's firmware does. A barrier may change commands more often: once in its own period.

    Args:
        scene: its `video` has no influence.
        on_period: called with the number of periods done and their total.

    Raises:
        SourceError: if the robots cannot start where the scene says.
        InputError: for anything else than a scene.

    Warns:
        RuntimeWarning: once, where a barrier's program has no solution: with the time and the robots.
    """
    if not isinstance(scene, Scene):
        raise InputError(f"simulate: {scene!r} is not a scene; expected one such as load_scene('fear')")
    rng = np.random.default_rng(scene.seed)
    t = sample_times(scene.duration, scene.step)
    law = _law(scene)
    periods = len(t) - 1
    poses = np.empty((len(t), scene.robots, 3))
    commands = np.empty((periods, scene.robots, 2))
    stage_cut = np.zeros((periods, scene.robots), dtype=bool)
    separation_cut = np.zeros_like(stage_cut)
    barrier = scene.safety if isinstance(scene.safety, Barrier) else None
    if barrier:  # few scenes have one, and importing scipy.optimize takes longer than a run
        from emovid.swarm.barrier import certified  # noqa: PLC0415
    bend, relaxed = np.zeros(stage_cut.shape), np.zeros_like(stage_cut)
    poses[0] = start_poses(scene, rng)
    for k in range(periods):
        seconds = t[k + 1] - t[k]
        if k % scene.steps_held == 0:
            poses[k], wanted = _command(scene.robot, poses[k], law(t[k], poses[k]))
            aim = poses[k, :, 2].copy()
        elif not scene.robot.body.steers:
            poses[k, :, 2] = aim
        if barrier:
            poses[k, :, 2], commands[k], bend[k], relaxed[k] = certified(
                poses[k], wanted, seconds, scene.robot, scene.stage, barrier
            )
            if relaxed[k].any() and not relaxed[:k].any():
                _warn(t[k], relaxed[k])
        else:
            commands[k], stage_cut[k], separation_cut[k] = _cut(scene, poses[k], wanted, seconds)
        poses[k + 1] = move(poses[k], commands[k], seconds)
        if on_period:
            on_period(k + 1, periods)
    kept = (bend, relaxed) if barrier else ()
    return Trajectory(scene, t, poses, commands, stage_cut, separation_cut, *kept)


def check_start(scene: Scene) -> None:
    """Raise the `SourceError` that `simulate` would, without simulating."""
    start_poses(scene, np.random.default_rng(scene.seed))


def sample_times(duration: float, control_period: float) -> Array:
    """Return the multiples of the control period within the duration, and the duration itself, (T,) [s]."""
    whole = int(np.ceil(duration / control_period - 1e-9))
    return np.append(control_period * np.arange(max(whole, 1)), duration)


def _law(scene: Scene) -> Law:
    """Return the behavior's law.

    A contour's is evaluated at the look-ahead points, which then obey it as single integrators with gain K; coverage at
    the robots' centers, as the paper prints it.
    """
    behaviour, stage, robot = scene.behaviour, scene.stage, scene.robot
    if isinstance(behaviour, Coverage):
        return lambda _, poses: coverage_velocity(behaviour, stage, poses[:, :2])
    assert isinstance(behaviour, ContourKeys)  # recorded motion has no start
    theta_0 = start_angles(scene.robots)
    ahead = robot.l if robot.body.steers and robot.l else 0.0
    return lambda t, poses: followed_points(behaviour, theta_0, t) - look_ahead(poses, ahead)


def _command(robot: Robot, poses: Array, u: Array) -> tuple[Array, Array]:
    """Return the poses (N, 3) and the commands (N, 2) with which the robots set out to move at K u.

    A unicycle keeps its heading. A single integrator faces the direction of its motion at once, the limit of l to 0.
    """
    if robot.body.steers:
        assert robot.l is not None  # a valid scene gives a unicycle its l
        commands = near_identity(u, poses[:, 2], robot.K, robot.l)
    else:
        speed = robot.K * np.hypot(u[:, 0], u[:, 1])
        poses[:, 2] = np.where(speed > 0, np.arctan2(u[:, 1], u[:, 0]), poses[:, 2])
        commands = np.stack([speed, np.zeros_like(speed)], axis=-1)
    return poses, within_limits(commands, robot.limits, robot.body.wheel_base, robot.saturation == "clip")


def _warn(t: float, relaxed: Mask) -> None:
    robots = ", ".join(str(i + 1) for i in np.flatnonzero(relaxed))
    message = (
        f"the barrier has no solution at {t:.3g} s: robots {robots} are nearer to each other or a wall than the "
        "spacing, and cannot part as the barrier asks; they part as fast as they can and come no nearer"
    )
    warnings.warn(message, RuntimeWarning, stacklevel=3)


def _cut(scene: Scene, poses: Array, commands: Array, seconds: float) -> tuple[Array, Mask, Mask]:
    """Return the commands with v cut to what fits, and whether it was for the stage and for the separation."""
    radius, law = scene.robot.body.radius, scene.behaviour
    on_stage = share_on_stage(poses, commands, seconds, scene.stage, radius)
    commands = commands.copy()
    commands[:, 0] *= on_stage
    apart = np.ones_like(on_stage)
    if isinstance(law, Coverage) and law.separation is not None:
        apart = share_apart(poses, commands, seconds, radius, law.separation)
        commands[:, 0] *= apart
    return commands, on_stage < 1, apart < 1
