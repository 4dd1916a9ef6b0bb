"""Trails: the robots that leave one, their paths in pieces of time, and lines on the floor in perspective."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.path import Path

from emovid.scene import video
from emovid.scene.video import Colours
from emovid.swarm.arrays import Array, Indices, Mask
from emovid.swarm.trajectory import Trajectory
from emovid.video.cameras import PinholeCamera

PIECE = 1.0  # seconds of a permanent trail that are drawn at once
_SHADES = 16  # pieces of a trail that fades
_INSTANT = 1e-9  # seconds: sample times nearer than this are equal
_SMOOTH = 0.1  # turn [rad] up to which pieces share their corners: the error is a thousandth of the width
_SHORT = 0.2  # length over width: shorter pieces would turn inside out where they share corners
_ARC = np.linspace(0, 1, 9)  # corners of a round joint or end, from one side to the other
_OVERLAP = 0.75  # overlap with the line that this one continues [pixels]: without it, a gap would show
_NOWHERE = 1e-9  # m: length drawn for a line of length 0


class Span(NamedTuple):
    """A part of the time that trails show.

    Attributes:
        start, end: in the run [s].
        share: of the trail's own color; the rest is the stage's.
    """

    start: float
    end: float
    share: float = 1.0


class Piece(NamedTuple):
    """A part of one trail.

    Attributes:
        line: points (P, 2) [m], P > 1.
        before: point (2,) [m] of the same trail before the line; None if the trail starts here.
    """

    line: Array
    before: Array | None


class Trails:
    """The trails of a run, to be drawn piece by piece, the oldest first: each robot has its own trail right behind it.

    Args:
        trajectory: the run.
        robots: indices of the robots that leave a trail (M,).
        tolerance: largest deviation of a drawn line from the robots' arcs [m].
    """

    def __init__(self, trajectory: Trajectory, robots: Indices, tolerance: float) -> None:
        self.robots = robots
        self._traces = [trajectory.trace(robot, tolerance) for robot in robots.tolist()]
        # The robots of a frame stand at the ends of trails, and a piece starts where another one ends.
        self.poses = lru_cache(maxsize=2 * _SHADES)(lambda t: trajectory.at(np.array([t]))[0])

    def pieces(self, span: Span, oldest: float = 0.0) -> list[Piece]:
        """Return the part of each trail in a span; trails begin at the time `oldest` [s]."""
        first_ends, last_ends = (self.poses(t)[self.robots, None, :2] for t in (span.start, span.end))
        made = []
        for (times, points), first_end, last_end in zip(self._traces, first_ends, last_ends, strict=True):
            first, last = times.searchsorted([span.start + _INSTANT, span.end - _INSTANT])
            earlier = times.searchsorted(span.start - _INSTANT) - 1
            before = points[earlier] if span.start > oldest and earlier >= 0 else None
            made.append(Piece(np.concatenate([first_end, points[first:last], last_end]), before))
        return made


def trailed_robots(start: Array, trails: int | None) -> Indices:
    """Return the robots that leave a trail: `trails` of them, spread around the swarm at its start; all for None.

    Robots whose direction from the middle of the swarm is nearest to even angles, the first of them that of robot 0: a
    choice by number would bunch where robots start at random.

    Args:
        start: positions or poses (N, 2 or more) [m] at the start.
        trails: number of trails.
    """
    if trails is None or trails >= len(start):
        return np.arange(len(start))
    x, y = (start[:, :2] - start[:, :2].mean(axis=0)).T
    angles = np.arctan2(y, x)
    chosen: list[int] = []
    for target in angles[0] + 2 * np.pi * np.arange(trails) / trails:
        off = np.abs(np.angle(np.exp(1j * (angles - target)))).round(9)
        off[chosen] = np.inf
        chosen.append(int(off.argmin()))
    return np.array(chosen, dtype=np.intp)


def spans(look: video.Trails, t: float, since: float = 0.0) -> list[Span]:
    """Return the spans that trails of a look show at the time `t` [s], the oldest first, none before `since` [s].

    All but the first and the last are the same at all times, so that they are prepared once.
    """
    if look.seconds and look.fade:
        piece = look.seconds / _SHADES
        starts = piece * np.arange(max(np.ceil((t - look.seconds) / piece), 0), np.ceil(t / piece))
        ends = np.minimum(starts + piece, t)
        shares = 1 - (t - ends) / (look.seconds - piece)  # 0 where the piece starts before the trail
        return [Span(*span) for span in np.stack([starts, ends, shares], axis=1).tolist() if span[2] > 0]
    start = max(since, oldest(look, t))
    inner = PIECE * np.arange(np.floor(start / PIECE) + 1, np.ceil(t / PIECE))
    return [Span(*ends) for ends in pairwise([start, *inner.tolist(), t])] if t > start else []


def oldest(look: video.Trails, t: float) -> float:
    """Return the time at which trails of a look begin at the time `t` [s]; fading ones fade into that of the start."""
    return 0.0 if look.seconds is None or look.fade else max(t - look.seconds, 0.0)


def trail_colours(colours: Colours, count: int) -> Array:
    """Return the colors of trails (count, 4), RGBA from 0 to 1."""
    return np.array([to_rgba(colours.trails[i % len(colours.trails)]) for i in range(count)]).reshape(-1, 4)


def faded(colours: Array, stage: str, shares: Sequence[float]) -> Array:
    """Return the colors of trails (M, 4) where only a share is their own, for each of S shares in turn (S M, 4).

    They are mixed with the stage's, not translucent: overlaps of two pieces of a trail do not show.
    """
    share = np.array(shares)[:, None, None]
    return (colours * share + np.array(to_rgba(stage)) * (1 - share)).reshape(-1, 4)


def ribbon(camera: PinholeCamera, line: Array, width: float, before: Array | None = None) -> Path:
    """Return the outline [pixels] of a line on the floor as the camera sees it, foreshortened, with round joints.

    Its pieces all run counter-clockwise, so that overlaps stay filled. They hardly overlap: with overlaps, a line
    thinner than a pixel would look bolder.

    Args:
        camera: of the view.
        line: points (P, 2) [m], P > 1.
        width: [m].
        before: a point (2,) [m] of the line that this one continues; without one, both its ends are round.
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
    return Path.make_compound_path(*(Path.make_compound_path_from_polys(rings) for rings in pieces))


def _mitred(normal: Array, length: Array, width: float) -> tuple[Array, Array, Mask]:
    """Return the offsets to the left at the start and the end of pieces (S, 2), and the joints (S - 1,) closed by them.

    Where a line hardly turns, as in an arc of many pieces, neighbors share their corners.
    """
    cos = (normal[:-1] * normal[1:]).sum(axis=1)
    long = length > _SHORT * width
    smooth = (cos > np.cos(_SMOOTH)) & long[:-1] & long[1:]
    middle = (normal[:-1] + normal[1:]) / (1 + np.where(smooth, cos, 0.0))[:, None]
    starts, ends = normal.copy(), normal.copy()
    starts[1:][smooth] = ends[:-1][smooth] = middle[smooth]
    return width / 2 * starts, width / 2 * ends, smooth


def _joints(points: Array, aside: Array) -> Array:
    """Return the wedges on the outer side of joints between pieces (J, C, 2)."""
    angle = np.arctan2(aside[:, 1], aside[:, 0])
    turn = (np.diff(angle) + np.pi) % (2 * np.pi) - np.pi
    return _wedges(points, np.where((turn > 0)[:, None], -aside[:-1], aside[1:]), np.abs(turn))


def _wedges(points: Array, first: Array, angles: Array) -> Array:
    """Return sectors of circles (J, C, 2) about points (J, 2), counter-clockwise from the radius `first` (J, 2)."""
    cos, sin = np.cos(angles[:, None] * _ARC), np.sin(angles[:, None] * _ARC)
    x, y = first[:, :1] * cos - first[:, 1:] * sin, first[:, :1] * sin + first[:, 1:] * cos
    return np.concatenate([points[:, None], points[:, None] + np.stack([x, y], axis=-1)], axis=1)
