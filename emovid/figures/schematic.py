"""Parts of technical drawings: a page in meters, arrows, dimension lines, angles."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyArrowPatch

from emovid.figures.style import INK, POINTS, QUIET
from emovid.scene.video import Colours
from emovid.swarm.arrays import Array

THIN, THICK = 0.6, 1.2  # widths of lines [pt]
LINEAR, ANGULAR = "#1f6fb4", "#c9501c"  # of v, of omega
PALE = Colours(body="#d5d8de", wheels="#8d93a0", front="#ffffff", stage="#ffffff")  # for a robot under a drawing
_HEAD = 7.0  # size of an arrow's head [pt]
_BEYOND = 2.0  # length of an extension line beyond its dimension line [pt]


def drawing(bounds: Array, width: float, largest: float) -> tuple[Figure, Axes]:
    """Return a page with axes in meters, as large as its width allows, with the drawing in its middle.

    Args:
        bounds: lower left and upper right corner (2, 2) [m] of the drawing.
        width: of the page [in].
        largest: largest height of the page [in].
    """
    (left, bottom), (right, top) = bounds
    height = min(width * (top - bottom) / (right - left), largest)
    half = (top - bottom) / height * width / 2
    middle = (left + right) / 2
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(middle - half, middle + half), ylim=(bottom, top))
    axes.set_axis_off()
    return figure, axes


def scale_of(axes: Axes) -> float:
    """Return the scale of axes in meters [pt/m]."""
    left, right = axes.get_xlim()
    return float(axes.bbox.width / axes.figure.dpi * POINTS / (right - left))


def write_math(axes: Axes, place: Array, text: str, colour: str = INK) -> None:
    """Write a text, which may hold formulas, centered at a point (2,) [m]."""
    how: Any = {"ha": "center", "va": "center", "parse_math": True, "zorder": 6}  # Any: the stubs lack parse_math
    axes.text(float(place[0]), float(place[1]), text, color=colour, **how)


def draw_arrow(
    axes: Axes, tail: Array, tip: Array, colour: str = INK, width: float = THICK, style: str = "-|>"
) -> None:
    """Draw a straight arrow between two points (2,) [m]."""
    axes.add_patch(_arrow(tail, tip, colour, width, style))


def draw_turn(axes: Axes, centre: Array, radius: float, start: float, end: float, colour: str = INK) -> None:
    """Draw an arrow along an arc of less than half a turn, from the angle `start` to `end` [rad]."""
    tail, tip = (centre + radius * np.array([np.cos(angle), np.sin(angle)]) for angle in (start, end))
    axes.add_patch(_arrow(tail, tip, colour, THICK, bow=float(np.tan((end - start) / 4))))


def draw_angle(axes: Axes, centre: Array, radius: float, start: float, end: float) -> None:
    """Draw the arc of an angle from `start` to `end` [rad]."""
    degrees = np.degrees([start, end])
    axes.add_patch(
        Arc(tuple(centre), 2 * radius, 2 * radius, theta1=degrees[0], theta2=degrees[1], color=QUIET, linewidth=THIN)
    )


def draw_line(
    axes: Axes, points: Sequence[Array], colour: str = QUIET, dashes: tuple[float, ...] = (), zorder: float = 2
) -> None:
    """Draw a thin line through points (2,) [m], dashed if there are dashes [line widths]."""
    line = (0, dashes) if dashes else "-"
    axes.plot(*np.transpose(points), color=colour, linewidth=THIN, linestyle=line, zorder=zorder)


def draw_dimension(axes: Axes, foot: Array, other: Array, offset: Array, text: str) -> None:
    """Draw a dimension line between two points (2,) [m], shifted by `offset` (2,) [m], with extension lines.

    The text, which may hold formulas, is at its middle, on the side of the offset.
    """
    along = offset / np.linalg.norm(offset)
    beyond = along * _BEYOND / scale_of(axes)
    for end in (foot, other):
        draw_line(axes, [end, end + offset + beyond])
    axes.add_patch(_arrow(foot + offset, other + offset, QUIET, THIN, "<|-|>", 0.7 * _HEAD))
    sides = {-1: ("right", "top"), 0: ("center", "center"), 1: ("left", "bottom")}
    x, y = (foot + other) / 2 + offset + 1.5 * beyond
    horizontal, vertical = (sides[int(np.round(part))][axis] for axis, part in enumerate(along))
    how: Any = {"ha": horizontal, "va": vertical, "parse_math": True}
    axes.text(x, y, text, **how)


def _arrow(
    tail: Array,
    tip: Array,
    colour: str,
    width: float,
    style: str = "-|>",
    head: float = _HEAD,
    bow: float = 0.0,
) -> FancyArrowPatch:
    patch = FancyArrowPatch(
        (float(tail[0]), float(tail[1])),
        (float(tip[0]), float(tip[1])),
        arrowstyle=style,
        connectionstyle=f"arc3,rad={bow:.6f}",
        mutation_scale=head,
        shrinkA=0,
        shrinkB=0,
    )
    patch.set(color=colour, linewidth=width, joinstyle="miter", capstyle="butt", zorder=5)
    return patch
