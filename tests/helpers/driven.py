"""Runs of robots under given commands."""

import numpy as np

from emovid.scene.model import Scene
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import move


def driven(scene: Scene, start: object, commands: object, seconds: float) -> Trajectory:
    """Return the run from the poses `start` (N, 3) under `commands` (T-1, N, 2), each held for `seconds`."""
    commands = np.asarray(commands, dtype=float)
    poses = [np.asarray(start, dtype=float)]
    for command in commands:
        poses.append(move(poses[-1], command, seconds))
    nothing = np.zeros(commands.shape[:2], dtype=bool)
    return Trajectory(scene, seconds * np.arange(len(poses)), np.array(poses), commands, nothing, nothing)


def standing(scene: Scene, points: object, seconds: float = 1.0) -> Trajectory:
    """Return the run of robots that stay at points (N, 2)."""
    start = np.column_stack([points, np.zeros(len(points))])
    return driven(scene, start, np.zeros((10, len(points), 2)), seconds / 10)


def ring(robots: int, radius: float) -> np.ndarray:
    """Return points (N, 2) evenly on a circle about the origin."""
    angle = 2 * np.pi * np.arange(robots) / robots
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def refined(run: Trajectory, parts: int) -> Trajectory:
    """Return the same motion with each control period cut into equal parts."""
    t = np.interp(np.arange(parts * (len(run.t) - 1) + 1) / parts, np.arange(len(run.t)), run.t)
    commands, stage, apart = (
        np.repeat(each, parts, axis=0) for each in (run.commands, run.stage_cut, run.separation_cut)
    )
    return Trajectory(run.scene, t, run.at(t), commands, stage, apart)
