"""Rotated and mirrored runs.

Control laws and robots are symmetric, so that the results are possible runs too. Speeds, distances between robots and
the shapes of traces stay the same; a mirror image turns in the other direction.
"""

from dataclasses import replace

import numpy as np

from emovid.scene.behaviour import ContourKeys
from emovid.scene.model import Scene
from emovid.scene.stage import OnContour, StageKeys
from emovid.swarm.arrays import Array
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import wrapped

_ROUNDING = 1e-9  # m


def turned(run: Trajectory, angle: float, center: tuple[float, float]) -> Trajectory:
    """Return a run rotated by an angle [rad], counterclockwise about a point [m]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = run.poses[..., 0] - center[0], run.poses[..., 1] - center[1]
    heading = wrapped(run.poses[..., 2] + angle)
    poses = np.stack([center[0] + cos * x - sin * y, center[1] + sin * x + cos * y, heading], axis=-1)
    return replace(run, poses=poses)


def mirrored(run: Trajectory) -> Trajectory:
    """Return the mirror image of a run: x becomes -x."""
    x, y, heading = np.moveaxis(run.poses, -1, 0)
    poses: Array = np.stack([-x, y, wrapped(np.pi - heading)], axis=-1)
    return replace(run, poses=poses, commands=run.commands * [1.0, -1.0])


def can_turn(run: Trajectory) -> bool:
    """Return whether a run can be rotated about its contour: it starts there, and the stage never limited it."""
    scene = run.scene
    on_contour = isinstance(scene.behaviour, ContourKeys) and isinstance(scene.start, OnContour)
    return on_contour and not run.stage_cut.any()


def can_mirror(scene: Scene) -> bool:
    """Return whether the stage of a scene is its own mirror image, x to -x."""
    return _is_kept(scene.stage, [-1, 1])


def can_half_turn(scene: Scene) -> bool:
    """Return whether the stage of a scene is symmetric under rotation by pi about the origin."""
    return _is_kept(scene.stage, [-1, -1])


def _is_kept(stage: StageKeys, signs: list[int]) -> bool:
    corners = np.array(stage.outline)
    distance = np.abs(corners[:, None] * signs - corners).max(axis=-1)
    return bool((distance.min(axis=1) < _ROUNDING).all())
