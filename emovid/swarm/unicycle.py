"""The unicycle: the near-identity diffeomorphism of Appendix B, and exact motion under held commands.

Arrays are over robots: `poses` (N, 3) = x [m], y [m], heading [rad]; `commands` (N, 2) = v [m/s], omega [rad/s]. Extra
leading axes are allowed throughout.
"""

import numpy as np

from emovid.scene.robots import Limits
from emovid.swarm.arrays import Array


def look_ahead(poses: Array, l: float) -> Array:
    """Return the points p~ (N, 2) [m], a distance `l` [m] in front of each robot (Fig. 17)."""
    heading = poses[..., 2]
    return poses[..., :2] + l * np.stack([np.cos(heading), np.sin(heading)], axis=-1)


def near_identity(u: Array, heading: Array, K: float, l: float) -> Array:
    """Return the commands (N, 2) that move each look-ahead point with velocity `K u`.

    Appendix B: (v, omega) = K [[cos, sin], [-sin / l, cos / l]] u. While the robot turns the look-ahead point leaves
    that direction, so with a command held for T its motion is `K u` only at first: a larger `K |u| T / l` makes a more
    angular trace.

    Args:
        u: single-integrator velocities (N, 2) [m/s].
        heading: (N,) [rad].
        K: proportional gain.
        l: look-ahead distance [m].
    """
    cos, sin = np.cos(heading), np.sin(heading)
    forward = cos * u[..., 0] + sin * u[..., 1]
    lateral = cos * u[..., 1] - sin * u[..., 0]
    return K * np.stack([forward, lateral / l], axis=-1)


def move(poses: Array, commands: Array, seconds: float | Array) -> Array:
    """Return the poses after `seconds` under constant commands: an exact arc of a circle, not an Euler step.

    The chord of an arc of length v t that turns by omega t is v t sinc(omega t / 2), at the mean heading; this form
    also holds for omega = 0. Headings are returned in (-pi, pi].
    """
    turn = commands[..., 1] * seconds
    chord = commands[..., 0] * seconds * np.sinc(turn / (2 * np.pi))  # numpy's sinc has the pi inside
    middle = poses[..., 2] + turn / 2
    x = poses[..., 0] + chord * np.cos(middle)
    y = poses[..., 1] + chord * np.sin(middle)
    return np.stack([x, y, wrapped(poses[..., 2] + turn)], axis=-1)


def wrapped(angle: Array) -> Array:
    """Return the angle [rad] in (-pi, pi]."""
    return np.pi - np.mod(np.pi - angle, 2 * np.pi)


def within_limits(commands: Array, limits: Limits | None, wheel_base: float, clip: bool = False) -> Array:
    """Return the commands within the motors' limits, v and omega scaled alike so that the path keeps its curvature.

    Args:
        commands: (N, 2).
        limits: of v [m/s], omega [rad/s] and the wheels' speed [m/s], or None.
        wheel_base: distance of the wheels [m]; a wheel runs at v -+ omega wheel_base / 2.
        clip: first cut each wheel's speed on its own, which bends the path, as the Robotarium's simulator does.
    """
    if limits is None:
        return commands
    if clip and limits.wheel_max is not None:
        commands = _clipped(commands, limits.wheel_max, wheel_base)
    v, omega = np.abs(commands[..., 0]), np.abs(commands[..., 1])
    demands = ((v, limits.v_max), (omega, limits.omega_max), (v + wheel_base / 2 * omega, limits.wheel_max))
    excess = np.max([np.ones_like(v)] + [demand / most for demand, most in demands if most is not None], axis=0)
    return commands / excess[..., None]


def _clipped(commands: Array, wheel_max: float, wheel_base: float) -> Array:
    """Return the commands with each wheel's speed cut to at most `wheel_max` [m/s]."""
    v, difference = commands[..., 0], wheel_base / 2 * commands[..., 1]
    left, right = (np.clip(wheel, -wheel_max, wheel_max) for wheel in (v - difference, v + difference))
    return np.stack([(left + right) / 2, (right - left) / wheel_base], axis=-1)
