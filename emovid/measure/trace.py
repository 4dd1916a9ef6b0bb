"""Angularity of the robots' traces, as an observer of their positions sees it.

A robot's commands can turn far more than its trace: it may spin on the spot, or move to and fro by micrometers. The
trace is therefore divided into visible steps: each step ends where the path first leaves the circle about the start of
the step. Motion within a circle does not count, and the steps do not depend on the control period or the frame rate.
This is the rediscretized path of P. Bovet and S. Benhamou, "Spatial analysis of animals' movements using a correlated
random walk model", J. Theor. Biol. 131(4), 1988. All turning is turning between its steps.

The step is a sixth of the body's width (`Window.step`). A corner turns by more than 60 degrees within two steps, a
third of a body: a curve turns as much only if its radius is below a third of the body, too tight to look round. A
corner reaches half a body along the trace to either side: the length that a body on it covers.
"""

from math import hypot, radians, sqrt

import numpy as np
from scipy.ndimage import binary_dilation

from emovid.measure.window import Descriptor, Window
from emovid.swarm.arrays import Array, Mask

_SOURCE = "on the rediscretized path of Bovet and Benhamou 1988"

TRACE = (
    Descriptor("trace_length", "m", "visible steps times their length; mean over robots", _SOURCE),
    Descriptor(
        "turning_per_metre",
        "rad/m",
        "turning of the traces over their length, both summed over robots; turns to and fro below 15 degrees are not "
        "counted",
        _SOURCE,
    ),
    Descriptor(
        "sharp_corner_share",
        "share",
        "share of the length of all traces within half a body width, along the trace, of a turn by more than 60 "
        "degrees within two visible steps",
        _SOURCE,
    ),
    Descriptor(
        "cusps", "1", "turns by more than 120 degrees from one visible step to the next; mean over robots", _SOURCE
    ),
    Descriptor("cusps_per_metre", "1/m", "cusps over trace_length", _SOURCE),
    Descriptor("cusps_per_second", "1/s", "cusps over the window's length", _SOURCE),
)

_DETAIL = 1 / 200  # of a visible step: largest distance of the polylines from the exact arcs
_SWING = radians(15)  # steps along a straight zigzag 0.6 mm wide swing by less
_CORNER = radians(60)
_CUSP = radians(120)  # a tip of less than 30 degrees turns one pair of steps by more, wherever the steps start
_REACH = 3  # steps: half a body


def trace(window: Window) -> dict[str, float]:
    """Return the descriptors of the traces; NaN where no robot has two visible steps."""
    robots = window.trajectory.poses.shape[1]
    walks = [visible_steps(path(window, robot), window.step) for robot in range(robots)]
    steps = sum(len(points) - 1 for points in walks)
    turned = [turns(points) for points in walks if len(points) > 2]
    between = sum(len(turn) for turn in turned)
    cusps = sum(int(np.sum(np.abs(turn) > _CUSP)) for turn in turned)
    sharp = sum(int(near_corner(turn).sum()) for turn in turned)
    length = steps * window.step
    undefined = float("nan")
    return {
        "trace_length": length / robots,
        # The first and the last half step have no turn: this gives 1 / r for a circle of any length.
        "turning_per_metre": sum(map(turning, turned)) / (between * window.step) if between else undefined,
        "sharp_corner_share": sharp / steps if between else undefined,
        "cusps": cusps / robots,
        "cusps_per_metre": cusps / length if between else undefined,
        "cusps_per_second": cusps / robots / window.length,
    }


def path(window: Window, robot: int) -> Array:
    """Return the points (P, 2) [m] of a robot's path in the window, arcs within a two-hundredth of a visible step."""
    times, points = window.trajectory.trace(robot, window.step * _DETAIL)
    first, last = window.points(np.array([window.start, window.end]))[:, robot]
    within = (times > window.start) & (times < window.end)
    return np.concatenate([first[None], points[within], last[None]])


def visible_steps(points: Array, step: float) -> Array:
    """Return the ends (L + 1, 2) [m] of the steps of a divider of width `step` [m] along a polyline (P, 2)."""
    x_0, y_0 = points[0].tolist()
    ends = [(x_0, y_0)]
    from_x, from_y = x_0, y_0
    for x, y in points[1:].tolist():
        # A segment leaves the circle about (x_0, y_0) if and only if its end is outside, since its start is within.
        while hypot(x - x_0, y - y_0) >= step:
            along_x, along_y, off_x, off_y = x - from_x, y - from_y, from_x - x_0, from_y - y_0
            a = along_x * along_x + along_y * along_y
            b = off_x * along_x + off_y * along_y
            c = min(off_x * off_x + off_y * off_y - step * step, 0.0)
            share = (sqrt(b * b - a * c) - b) / a
            x_0, y_0 = from_x, from_y = from_x + share * along_x, from_y + share * along_y
            ends.append((x_0, y_0))
        from_x, from_y = x, y
    return np.array(ends)


def turns(points: Array) -> Array:
    """Return the turns (L - 1,) [rad], in [-pi, pi], between the L steps of a walk (L + 1, 2)."""
    along = np.diff(points, axis=0)
    before, after = along[:-1], along[1:]
    across = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.arctan2(across, np.sum(before * after, axis=1))


def turning(turned: Array) -> float:
    """Return the total turning [rad] of successive turns (L - 1,): the direction's swings to and fro, added up.

    A swing of less than 15 degrees belongs to the one that it interrupts: steps along a straight line with a fine
    zigzag turn all the time, by little, without a change of direction.
    """
    total = low = high = 0.0  # the swing under way is from low to high or back
    way = 0  # 1: to high, -1: to low, 0: not yet known
    for direction in np.cumsum(turned).tolist():
        if way >= 0:
            high = max(high, direction)
        if way <= 0:
            low = min(low, direction)
        if way >= 0 and high - direction >= _SWING:
            total += way * (high - low)
            way, low = -1, direction
        elif way <= 0 and direction - low >= _SWING:
            total -= way * (high - low)
            way, high = 1, direction
    return total + abs(way) * (high - low)


def near_corner(turned: Array) -> Mask:
    """Return which of the L steps with the turns (L - 1,) between them lie within half a body of a corner."""
    alone = np.abs(turned) > _CORNER
    shared = (np.abs(turned[:-1] + turned[1:]) > _CORNER) & ~alone[:-1] & ~alone[1:]  # the corner is within a step
    corner = np.zeros(2 * len(turned) + 3, dtype=bool)  # ends of steps at even places, their middles at odd ones
    corner[2:-1:2], corner[3:-2:2] = alone, shared
    return binary_dilation(corner, np.ones(4 * _REACH + 1, dtype=bool))[1::2]
