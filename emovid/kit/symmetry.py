"""The same motion seen otherwise: turned about a point, in a mirror, upside down.

Laws and robots know no left and right: what is returned is a run that they could have made. Speeds, distances between
robots and the shapes of their traces stay; a mirror image turns the other way.
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


def turned(run: Trajectory, angle: float, centre: tuple[float, float]) -> Trajectory:
    """Return a run turned by an angle [rad], counter-clockwise about a point [m]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = run.poses[..., 0] - centre[0], run.poses[..., 1] - centre[1]
    heading = wrapped(run.poses[..., 2] + angle)
    poses = np.stack([centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y, heading], axis=-1)
    return replace(run, poses=poses)


def mirrored(run: Trajectory) -> Trajectory:
    """Return a run with left and right exchanged: x to -x."""
    x, y, heading = np.moveaxis(run.poses, -1, 0)
    poses: Array = np.stack([-x, y, wrapped(np.pi - heading)], axis=-1)
    return replace(run, poses=poses, commands=run.commands * [1.0, -1.0])


def can_turn(run: Trajectory) -> bool:
    """Return whether a run can be turned about its contour: it follows one from the start, and never met the edge."""
    scene = run.scene
    on_contour = isinstance(scene.behaviour, ContourKeys) and isinstance(scene.start, OnContour)
    return on_contour and not run.stage_cut.any()


def can_mirror(scene: Scene) -> bool:
    """Return whether a scene's stage is its own mirror image, left and right."""
    return _is_kept(scene.stage, [-1, 1])


def can_half_turn(scene: Scene) -> bool:
    """Return whether a scene's stage looks the same upside down: turned by pi about the origin."""
    return _is_kept(scene.stage, [-1, -1])


def _is_kept(stage: StageKeys, signs: list[int]) -> bool:
    corners = np.array(stage.outline)
    distance = np.abs(corners[:, None] * signs - corners).max(axis=-1)
    return bool((distance.min(axis=1) < _ROUNDING).all())
