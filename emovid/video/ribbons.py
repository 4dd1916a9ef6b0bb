"""Lines drawn on the floor: ribbons, foreshortened like everything else."""

from typing import NamedTuple

import numpy as np
from matplotlib.path import Path

from emovid.swarm.arrays import Array, Mask
from emovid.video.pinhole import Pinhole

_SMOOTH = 0.1  # turn [rad] up to which pieces share their corners: a thousandth of the width goes amiss there
_SHORT = 0.2  # of the width: shorter pieces would turn inside out where they share corners
_ARC = np.linspace(0, 1, 9)  # corners of a round joint or end, from one side to the other
_OVERLAP = 0.75  # by which a line lies on the one that it continues [pixels]: an edge on an edge lets light through
_NOWHERE = 1e-9  # m; length of a line that has none


class Ribbon(NamedTuple):
    """A line with a width, as it is seen.

    Attributes:
        path: its outline [pixels], of pieces that all run one way round, so that they fill as one.
        low, high: corners of boxes (B, 2) that together hold it [pixels].
    """

    path: Path
    low: Array
    high: Array


def ribbon(camera: Pinhole, line: Array, width: float, before: Array | None = None, group: int = 8) -> Ribbon:
    """Return a line on the floor as it is seen, with round joints.

    Its pieces hardly overlap: where they did, a line thinner than a pixel would look bolder.

    Args:
        camera: that sees it.
        line: its points (P, 2) [m], P > 1.
        width: [m].
        before: a point (2,) [m] of the line that this one continues; without one, both its ends are round.
        group: how many of its pieces share a box.
    """
    points = line[np.concatenate([[True], np.diff(line, axis=0).any(axis=1)])]
    if len(points) == 1:
        points = np.concatenate([points, points + np.array([_NOWHERE, 0.0])])
    joined = before is not None and bool((before != points[0]).any())
    if before is not None and joined:
        back = before - points[0]
        points = np.concatenate([[points[0] + back * min(_OVERLAP / camera.scale / np.hypot(*back), 1)], points])
    along = np.diff(points, axis=0)
    length = np.hypot(along[:, 0], along[:, 1])
    normal = along[:, ::-1] * [-1, 1] / length[:, None]
    starts, ends, smooth = _mitred(normal, length, width)
    aside = width / 2 * normal
    first, last = points[:-1], points[1:]
    strips = np.stack([first - starts, last - ends, last + ends, first + starts], axis=1)
    if joined:
        smooth[0] = False
    wedges = _joints(points[1:-1], aside)[~smooth]
    if before is None:
        caps = _wedges(points[[0, -1]], aside[[0, -1]] * [[1], [-1]], np.full(2, np.pi))
        wedges = np.concatenate([caps[:1], wedges, caps[1:]])
    pieces = [camera.pixels(rings) for rings in (strips, wedges) if len(rings)]
    low = [np.minimum.reduceat(rings.min(axis=1), np.arange(0, len(rings), group)) for rings in pieces]
    high = [np.maximum.reduceat(rings.max(axis=1), np.arange(0, len(rings), group)) for rings in pieces]
    path = Path.make_compound_path(*(Path.make_compound_path_from_polys(rings) for rings in pieces))
    return Ribbon(path, np.concatenate(low), np.concatenate(high))


def _mitred(normal: Array, length: Array, width: float) -> tuple[Array, Array, Mask]:
    """Return the ways to the left at the start and the end of pieces (S, 2), and which joints (S - 1,) this closes.

    Where a line hardly turns, pieces share their corners: an arc is many of them.
    """
    cos = (normal[:-1] * normal[1:]).sum(axis=1)
    long = length > _SHORT * width
    smooth = (cos > np.cos(_SMOOTH)) & long[:-1] & long[1:]
    middle = (normal[:-1] + normal[1:]) / (1 + np.where(smooth, cos, 0.0))[:, None]
    starts, ends = normal.copy(), normal.copy()
    starts[1:][smooth] = ends[:-1][smooth] = middle[smooth]
    return width / 2 * starts, width / 2 * ends, smooth


def _joints(points: Array, aside: Array) -> Array:
    """Return what is missing between pieces, on the outer side of their joints (J, C, 2)."""
    angle = np.arctan2(aside[:, 1], aside[:, 0])
    turn = (np.diff(angle) + np.pi) % (2 * np.pi) - np.pi
    return _wedges(points, np.where((turn > 0)[:, None], -aside[:-1], aside[1:]), np.abs(turn))


def _wedges(points: Array, first: Array, angles: Array) -> Array:
    """Return sectors of circles (J, C, 2) about points (J, 2), counter-clockwise from the radius `first` (J, 2)."""
    cos, sin = np.cos(angles[:, None] * _ARC), np.sin(angles[:, None] * _ARC)
    x, y = first[:, :1] * cos - first[:, 1:] * sin, first[:, :1] * sin + first[:, 1:] * cos
    return np.concatenate([points[:, None], points[:, None] + np.stack([x, y], axis=-1)], axis=1)
