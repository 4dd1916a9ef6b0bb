"""A contact sheet: small pictures in labeled rows and columns."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from emovid.figures.style import POINTS, TEXT, in_style, text_width

DPI = 300.0  # as figures are saved
_GAP = 6  # pixels between pictures
_MARGIN = 1.0  # between labels and edges [in units of the text's height]
_LINE = 1.5 * TEXT / POINTS  # height of a line of text [in]
_EDGE = _LINE / 2  # around the pictures [in]


@in_style()
def contact_figure(
    pictures: NDArray[np.uint8],
    rows: Sequence[str] = (),
    columns: Sequence[str] = (),
    row_title: str = "",
    column_title: str = "",
    captions: Sequence[str] = (),
    width: float | None = None,
) -> Figure:
    """Draw pictures in rows and columns at the resolution of the file.

    Args:
        pictures: (R, C, height, width, 3), RGB; empty places are white.
        rows: R labels.
        columns: C labels.
        row_title: title of the rows' labels.
        column_title: title of the columns' labels.
        captions: of the pictures, row by row, instead of labels.
        width: smallest width of the figure [in].
    """
    high, wide, height, across, _ = pictures.shape
    if (len(rows), len(columns)) != (high, wide) and not captions:
        raise ValueError(f"{high} x {wide} pictures, {len(rows)} x {len(columns)} labels")
    below = round(_LINE * DPI) if captions else 0
    step = np.array([across + _GAP, height + below + _GAP])  # from a picture to the next [pixels]
    inside = np.array([wide, high]) * step - _GAP
    left = text_width(rows) / POINTS + (2.5 if row_title else 1.0) * _LINE
    slanted = not captions and text_width(columns) > step[0] / DPI * POINTS - 4
    top = (text_width(columns) / POINTS if slanted else _LINE) + (2.0 if column_title else 1.0) * _LINE
    if captions:
        left = top = _EDGE
    size = np.maximum(inside / DPI + [left + _EDGE, top + _EDGE], [width or 0, 0])
    figure = Figure(figsize=(float(size[0]), float(size[1])))
    bounds = (left / size[0], _EDGE / size[1], *(inside / DPI / size))
    axes = figure.add_axes(bounds, xlim=(0, inside[0]), ylim=(inside[1], 0))
    for i, row in enumerate(pictures):  # row by row, since matplotlib takes some 130 bytes per pixel of an image
        extent = (0, inside[0], i * step[1] + height, i * step[1])
        axes.imshow(_joined(row), interpolation="none", aspect="auto", extent=extent)
    axes.set_axis_off() if captions else axes.spines[:].set_visible(False)
    x, y = np.arange(wide) * step[0] + across / 2, np.arange(high) * step[1] + height / 2
    if captions:
        _caption(axes, x, y + height / 2 + below / 2, captions)
        return figure
    axes.set_xticks(x, columns, rotation=90 if slanted else 0)
    axes.set_yticks(y, rows)
    axes.tick_params(length=0)
    axes.xaxis.tick_top()
    axes.xaxis.set_label_position("top")
    axes.set_xlabel(column_title)
    axes.set_ylabel(row_title)
    return figure


def picture_width(columns: int, width: float) -> int:
    """Return the width of pictures with captions [pixels] for `columns` side by side in a figure of `width` [in]."""
    return int(((width - 2 * _EDGE) * DPI - (columns - 1) * _GAP) / columns + 1e-9)


def in_rows(pictures: NDArray[np.uint8], columns: int) -> NDArray[np.uint8]:
    """Return pictures (P, height, width, 3) in rows (R, columns, height, width, 3), the last row padded with white."""
    missing = -len(pictures) % columns
    blank = np.full((missing, *pictures.shape[1:]), 255, np.uint8)
    return np.concatenate([pictures, blank]).reshape(-1, columns, *pictures.shape[1:])


def _joined(pictures: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return one picture from those of a row (C, height, width, 3), with gaps between them."""
    wide, height, width, _ = pictures.shape
    cells = np.full((height, wide, width + _GAP, 3), 255, np.uint8)
    cells[:, :, :width] = pictures.swapaxes(0, 1)
    return cells.reshape(height, wide * (width + _GAP), 3)[:, :-_GAP]


def _caption(axes: Axes, x: NDArray[np.float64], y: NDArray[np.float64], captions: Sequence[str]) -> None:
    for i, caption in enumerate(captions):
        axes.text(x[i % len(x)], y[i // len(x)], caption, ha="center", va="center")
