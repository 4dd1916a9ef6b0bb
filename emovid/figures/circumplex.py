"""The answers in the valence-arousal plane, as in Fig. 10."""

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from emovid.figures.bubbles import CROSS, Array, Row, largest_rows
from emovid.figures.style import (
    FAINT,
    INK,
    POINTS,
    QUIET,
    SINGLE_COLUMN,
    TEXT,
    heading,
    in_style,
    label_colours,
    text_on,
    text_width,
)
from emovid.statistics.circumplex import ANGLES

_MARGIN = 2.0  # around the figure [pt]
_PLANE = 0.235  # radius of the circle by the figure's width
_ENDS = np.array([-1, 1])
_DIGIT = 0.73  # height of a digit in DejaVu Sans by the size of text


class Position(NamedTuple):
    """Position of an emotion in the plane, each coordinate from -1 to 1, with its source."""

    valence: float
    arousal: float
    source: str


def _position(emotion: str, degrees: float) -> Position:
    word = _WORDS.get(emotion)
    source = f"Russell 1980, circular scaling by the method of Ross 1938: {word} at {degrees:g} degrees"
    if word is None:
        source = "ours: Russell scaled no such word; near his distressed, between fear and sadness"
    return Position(float(np.cos(np.radians(degrees))), float(np.sin(np.radians(degrees))), source)


_WORDS = {"happiness": "happy", "surprise": "astonished", "anger": "angry", "fear": "afraid", "sadness": "sad"}
POSITIONS = {emotion: _position(emotion, degrees) for emotion, degrees in ANGLES.items()}


@in_style()
def circumplex_figure(
    counts: NDArray[np.int64],
    signalled: Sequence[str],
    perceived: Sequence[str] | None = None,
    *,
    positions: Mapping[str, Position] = POSITIONS,
    proportional: Literal["diameter", "area"] = "diameter",
    width: float = SINGLE_COLUMN,
) -> Figure:
    """Draw a cross for each signaled emotion and beside it a bubble for each answer given, the most frequent first.

    Bubbles have the colors of the perceived emotions and, where it fits, the number of answers in them. All bubbles of
    a figure share one scale.

    Args:
        counts: (perceived, signalled) answers.
        signalled: labels of the videos.
        perceived: labels of the answers, as "none" after the emotions; the same as `signalled` if left out.
        positions: of the signaled emotions.
        proportional: what of a bubble is proportional to the answers; the paper's is the diameter, which makes twice as
            many answers look like four times as many.
        width: of the figure [in].

    Raises:
        ValueError: if an emotion has no position.
    """
    answers = list(signalled if perceived is None else perceived)
    missing = [emotion for emotion in signalled if emotion not in positions]
    if missing or np.shape(counts) != (len(answers), len(signalled)):
        raise ValueError(f"no position for {missing}" if missing else f"counts are {np.shape(counts)}")
    order = [np.argsort(-column, kind="stable")[: np.count_nonzero(column)] for column in np.asarray(counts).T]
    given = [np.asarray(counts)[kept, i].astype(float) for i, kept in enumerate(order)]
    sizes = [np.sqrt(column) for column in given] if proportional == "area" else given
    places = np.array([positions[emotion][:2] for emotion in signalled]) * _PLANE * width * POINTS
    names = [heading(emotion) for emotion in signalled]
    rows = largest_rows(places, sizes, names, width * POINTS - 2 * _MARGIN)
    figure, axes = _page(rows, width * POINTS)
    _draw_plane(axes, _PLANE * width * POINTS)
    colours = label_colours([*answers, *(emotion for emotion in signalled if emotion not in answers)])
    for i, row in enumerate(rows):
        axes.plot(*np.vstack([row.cross, row.centres[:1]]).T, color=FAINT, linewidth=0.6, zorder=1)
        axes.plot(*row.cross, "X", color=colours[signalled[i]], markersize=CROSS, mec=INK, mew=0.4, zorder=3)
        axes.text(row.name[0], row.name[1], names[i], ha="center", va="center", zorder=4)
        for centre, radius, answer, count in zip(row.centres, row.radii, order[i], given[i], strict=True):
            _draw_bubble(axes, centre, radius, colours[answers[answer]], f"{count:.0f}")
    return figure


def _page(rows: list[Row], width: float) -> tuple[Figure, Axes]:
    """Return a figure as high as the rows need, with axes in points about the plane's origin all over it."""
    parts = [(row.centres[:, 1], row.radii) for row in rows]
    parts += [(row.name[1:], np.array([TEXT / 2])) for row in rows]
    around = np.concatenate([_PLANE * width * _ENDS, *(y + end * half for y, half in parts for end in _ENDS)])
    bottom, top = around.min() - _MARGIN, around.max() + _MARGIN
    figure = Figure(figsize=(width / POINTS, (top - bottom) / POINTS))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(-width / 2, width / 2), ylim=(bottom, top))
    axes.set_axis_off()
    return figure, axes


def _draw_plane(axes: Axes, radius: float) -> None:
    """Draw the axes, which end on the circle that the emotions lie on."""
    axes.add_patch(Circle((0, 0), radius, fill=False, edgecolor=FAINT, linewidth=0.5, linestyle=(0, (2, 2)), zorder=1))
    for tip in ((radius, 0), (0, radius)):
        axes.plot([-tip[0], tip[0]], [-tip[1], tip[1]], color=FAINT, linewidth=0.6, zorder=1)
    axes.text(0.06 * radius, -0.05 * radius, "Valence →", ha="left", va="top", color=QUIET, zorder=1)
    axes.text(-0.04 * radius, 0.06 * radius, "Arousal →", ha="right", va="bottom", rotation=90, color=QUIET, zorder=1)


def _draw_bubble(axes: Axes, centre: Array, radius: float, colour: str, count: str) -> None:
    axes.add_patch(Circle(tuple(centre), radius, facecolor=colour, edgecolor=INK, linewidth=0.3, zorder=2))
    if np.hypot(text_width([count]), _DIGIT * TEXT) < 2 * radius:
        # By the height of digits: matplotlib centers the line, with room for descenders.
        x, y = centre - [0, _DIGIT * TEXT / 2]
        axes.text(x, y, count, ha="center", va="baseline", color=text_on(colour), zorder=4)
