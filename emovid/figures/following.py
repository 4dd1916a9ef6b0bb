"""What the look-ahead distance l does to a trace, as in Fig. 9: one path, followed in three ways."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from emovid.figures.style import INK, SINGLE_COLUMN, in_style
from emovid.figures.top_view import LINE, PAPER, draw_lines, draw_robots, panels, write_below
from emovid.scene.load import load_robot
from emovid.swarm.arrays import Array
from emovid.swarm.unicycle import look_ahead, move, near_identity

# The path is ours, as are the numbers: the paper shows both without saying them. A path needs corners: along a smooth
# one a robot follows as closely with any l once it has caught up.
PATH = 0.001 * np.array(
    [[0, 0], [160, 0], [250, 100], [390, 100], [460, -30], [550, 60], [610, 60], [690, -50], [840, -50], [930, 30]]
)  # m
SMALL_L, LARGE_L = 0.005, 0.08  # m
_SPEED = 0.08  # of the particle that is followed [m/s]
_GAIN = 8.0  # K
_PERIOD = 0.033  # s
_STEPS = 4  # points of the trace in a period

_BLUE, _RED = "#5aa0dc", "#e08a5f"  # light enough for the dashed path to be seen on them
_TRACE = 2.0  # width of a trace [pt]


class Following(NamedTuple):
    """A run along a path.

    Attributes:
        l: the look-ahead distance [m]; None for a single integrator.
        poses: (P, 3), often enough for a smooth line.
    """

    l: float | None
    poses: Array


def follow(path: Array, l: float | None) -> Following:
    """Return how a robot follows a particle that runs along `path` (C, 2) [m] at constant speed.

    The law is that of a contour, u = particle - p, for p~ in place of p where there is one: it starts on the particle.

    Args:
        path: its corners; the first edge is longer than `l`.
        l: look-ahead distance [m]; None for a robot that moves as a single integrator.
    """
    lengths = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    ahead = l or 0.0
    heading = np.arctan2(path[1, 1] - path[0, 1], path[1, 0] - path[0, 0])
    pose = np.array([[*path[0], heading]])
    poses = [pose]
    for k in range(int((lengths[-1] - ahead) / (_SPEED * _PERIOD))):
        run = ahead + k * _SPEED * _PERIOD
        particle = np.stack([np.interp(run, lengths, along) for along in path.T])
        u = particle - look_ahead(pose, ahead)
        if l is None:
            speed = _GAIN * np.hypot(*u.T)
            pose = np.column_stack([pose[:, :2], np.where(speed > 0, np.arctan2(u[:, 1], u[:, 0]), pose[:, 2])])
            command = np.column_stack([speed, 0 * speed])
        else:
            command = near_identity(u, pose[:, 2], _GAIN, l)
        poses += [move(pose, command, _PERIOD * (i + 1) / _STEPS) for i in range(_STEPS)]
        pose = poses[-1]
    return Following(l, np.concatenate(poses))


def strays(points: Array, path: Array) -> Array:
    """Return the distances (P,) [m] of points (P, 2) from a path with corners (C, 2)."""
    start, edge = path[:-1], np.diff(path, axis=0)
    along = np.einsum("pcd,cd->pc", points[:, None] - start, edge) / np.sum(edge**2, axis=1)
    nearest = start + np.clip(along, 0, 1)[..., None] * edge
    return np.hypot(*np.moveaxis(points[:, None] - nearest, -1, 0)).min(axis=1)


@in_style()
def following_figure(runs: Sequence[Following], path: Array = PATH, *, width: float = SINGLE_COLUMN) -> Figure:
    """Draw runs along one path, dashed, one above the other, each with the robot at its end.

    Args:
        runs: from `follow`.
        path: that they follow (C, 2) [m].
        width: of the figure [in].
    """
    shown = np.concatenate([path, *(run.poses[:, :2] for run in runs)])
    room = 1.1 * load_robot("gritsbot").radius
    bounds = np.array([shown.min(axis=0) - room, shown.max(axis=0) + room])
    figure, axes = panels(bounds, len(runs), 1, width, below=LINE)
    for panel, run in zip(axes, runs, strict=True):
        colour = _RED if run.l is None else _BLUE
        panel.plot(*path.T, color=INK, linewidth=0.6, linestyle=(0, (4, 3)), zorder=2.5, label="path")
        draw_lines(panel, [run.poses[:, :2]], [colour], _TRACE)
        body = load_robot("single_integrator" if run.l is None else "gritsbot")
        draw_robots(panel, body, run.poses[-1:], [colour], PAPER)
        write_below(panel, "single integrator" if run.l is None else f"unicycle, $l$ = {1000 * run.l:g} mm")
    return figure
