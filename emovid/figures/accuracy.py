"""How many of each group recognised each emotion, as in Figs. 11 and 12."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from emovid.figures.style import (
    DOUBLE_COLUMN,
    FAINT,
    INK,
    POINTS,
    SINGLE_COLUMN,
    heading,
    in_style,
    settle,
    steps,
    text_width,
)

Rates = NDArray[np.float64]

_BARS = 0.8  # share of an emotion's place that its bars fill
_BESIDE = 40.0  # what the vertical axis takes of the width [pt]
_SWATCH = 28.0  # what a legend's entry takes beside its text [pt]
_BAR = 8.0  # least width of a bar in a figure of one column [pt]


@in_style()
def accuracy_figure(
    rates: Rates,
    low: Rates,
    high: Rates,
    emotions: Sequence[str],
    levels: Sequence[str],
    chance: float,
    *,
    width: float = SINGLE_COLUMN,
) -> Figure:
    """Draw the share of right answers as bars, one for each level of a group beside the next, with intervals.

    Args:
        rates: (levels, emotions) share of right answers, 0 to 1; nan where nobody answered: no bar.
        low: lower ends of the intervals, alike (95 % Wilson intervals, say).
        high: upper ends.
        emotions: labels of the videos.
        levels: what the legend calls the levels, such as "female (n = 13)".
        chance: share of right answers by guessing, drawn as a line.
        width: of the figure [in]; two columns if its bars do not fit into that.
    """
    shape = (len(levels), len(emotions))
    if any(np.shape(table) != shape for table in (rates, low, high)):
        raise ValueError(f"rates and intervals are {[np.shape(table) for table in (rates, low, high)]}, not {shape}")
    fits = len(emotions) * len(levels) * _BAR / _BARS <= width * POINTS - _BESIDE
    width = width if fits and len(emotions) <= 8 else DOUBLE_COLUMN
    figure = Figure(figsize=(width, 2.4), layout="constrained")
    axes = figure.add_subplot()
    _draw_bars(axes, levels, *(100 * np.asarray(table) for table in (rates, low, high)))
    axes.axhline(100 * chance, color=INK, linewidth=0.9, linestyle=(0, (4, 2)), label="chance")
    _draw_axes(axes, [heading(emotion) for emotion in emotions], (width * POINTS - _BESIDE) / len(emotions))
    _draw_legend(figure, axes, width * POINTS)
    return settle(figure)


def _draw_bars(axes: Axes, levels: Sequence[str], rates: Rates, low: Rates, high: Rates) -> None:
    """Draw the bars and, over them, the intervals [percent]."""
    width = _BARS / len(levels)
    places = np.arange(rates.shape[1])
    for i, (level, colour) in enumerate(zip(levels, steps(len(levels), "Blues"), strict=True)):
        x = places + (i - (len(levels) - 1) / 2) * width
        axes.bar(x, np.nan_to_num(rates[i]), width, color=colour, edgecolor=INK, linewidth=0.5, label=level)
        # Lines and not error bars: those want lengths, which rounding makes negative where a rate is 0 or 1.
        axes.vlines(x, low[i], high[i], color="white", linewidth=2.2)
        axes.vlines(x, low[i], high[i], color=INK, linewidth=0.9)


def _draw_axes(axes: Axes, emotions: list[str], place: float) -> None:
    """Draw the axes; names wider than an emotion's place [pt] are slanted."""
    slanted = text_width(emotions) > place - 3
    slant: dict[str, Any] = {"rotation": 35, "ha": "right", "rotation_mode": "anchor"} if slanted else {}
    axes.set_xticks(range(len(emotions)), emotions, **slant)
    axes.set_xlim(-0.55, len(emotions) - 0.45)
    axes.set_ylim(0, 100)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel("Accuracy (%)")
    axes.tick_params(axis="x", length=0)
    axes.grid(axis="y", color=FAINT, linewidth=0.4)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _draw_legend(figure: Figure, axes: Axes, width: float) -> None:
    """Draw the legend above, in as many columns as fit into the width [pt]."""
    handles, labels = axes.get_legend_handles_labels()
    bars = handles[1:] + handles[:1]  # matplotlib lists lines first
    names = labels[1:] + labels[:1]
    columns = _columns([text_width([name]) + _SWATCH for name in names], width)
    figure.legend(bars, names, loc="outside upper center", ncols=columns, handlelength=1.4, columnspacing=1.2)


def _columns(widths: list[float], room: float) -> int:
    """Return the most columns that fit, filled as matplotlib does: down, the first ones with one more."""
    counts = range(len(widths), 1, -1)
    return next((n for n in counts if sum(part.max() for part in np.array_split(widths, n)) <= room), 1)
