"""The confusion matrix as a heat map, laid out like Table III."""

from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from numpy.typing import NDArray

from emovid.figures.style import (
    DOUBLE_COLUMN,
    POINTS,
    SINGLE_COLUMN,
    TEXT,
    heading,
    in_style,
    settle,
    text_on,
    text_width,
)
from emovid.statistics.confusions import percent

_CELL_WIDTH, _CELL_HEIGHT = 31.0, 25.0  # least width and height of a cell [pt]: "64.44" in bold, over "(29)"
_BESIDE, _ABOVE = 12.0, 26.0  # width of margins; height of the heading and margins [pt]


@in_style()
def confusion_figure(
    counts: NDArray[np.int64],
    signalled: Sequence[str],
    perceived: Sequence[str] | None = None,
    *,
    width: float = SINGLE_COLUMN,
) -> Figure:
    """Draw how many participants gave each answer to each video: percent of the column, and counts in brackets.

    Right answers are bold.

    Args:
        counts: (perceived, signalled) answers.
        signalled: labels of the columns.
        perceived: labels of the rows, as "none" after those of the columns; the same as `signalled` if left out.
        width: of the figure [in]; two columns if its cells do not fit into that.
    """
    rows = list(signalled if perceived is None else perceived)
    counts = np.asarray(counts)
    if counts.shape != (len(rows), len(signalled)):
        raise ValueError(f"counts are {counts.shape}, labels {(len(rows), len(signalled))}")
    top, left = ([heading(label) for label in labels] for labels in (signalled, rows))
    needed = text_width(left) + _BESIDE + _CELL_WIDTH * len(top)
    width = width if needed <= width * POINTS else DOUBLE_COLUMN
    upright = text_width(top) > (width * POINTS - text_width(left) - _BESIDE) / len(top) - 2
    above = text_width(top) * np.sin(np.pi / 4) + TEXT if upright else TEXT
    height = (len(left) * _CELL_HEIGHT + above + _ABOVE) / POINTS
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.add_subplot()
    _draw_cells(axes, counts, [[row == column for column in signalled] for row in rows])
    _draw_headings(axes, top, left, 45 if upright else 0)
    return settle(figure)


def _draw_cells(axes: Axes, counts: NDArray[np.int64], right: list[list[bool]]) -> None:
    """Draw the cells on a scale from 0 to 100 % that is the same in every figure."""
    shares = percent(counts)
    colours = matplotlib.colormaps["Blues"](np.nan_to_num(shares) / 100)
    rows, columns = counts.shape
    axes.pcolormesh(np.arange(columns + 1) - 0.5, np.arange(rows + 1) - 0.5, colours)  # an image would have pixels
    axes.invert_yaxis()
    for (i, j), count in np.ndenumerate(counts):
        share = "–" if np.isnan(shares[i, j]) else f"{shares[i, j]:.2f}".replace("100.00", "100")
        colour, weight = text_on(to_hex(tuple(colours[i, j]))), "bold" if right[i][j] else "normal"
        axes.text(j, i, f"{share}\n({count})", ha="center", va="center", linespacing=1.1, color=colour, weight=weight)


def _draw_headings(axes: Axes, top: list[str], left: list[str], turn: float) -> None:
    axes.set_xticks(range(len(top)), top, rotation=turn, ha="left" if turn else "center", rotation_mode="anchor")
    axes.set_yticks(range(len(left)), left)
    axes.xaxis.tick_top()
    axes.xaxis.set_label_position("top")
    axes.set_xlabel("Signaled Emotion")
    # In the corner, not beside the rows: the cells get the width, so that bold numbers do not touch their edges.
    where: Any = {"xycoords": "axes fraction", "textcoords": "offset points"}
    axes.annotate("Response\n(%)", (0, 1), xytext=(-3.5, 3.5), ha="right", va="bottom", **where)
    axes.tick_params(length=0)
    axes.set_xticks(np.arange(len(top) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(left) + 1) - 0.5, minor=True)
    axes.tick_params(which="minor", length=0)
    axes.grid(which="minor", color="white", linewidth=0.8)
    axes.spines[:].set_visible(False)
