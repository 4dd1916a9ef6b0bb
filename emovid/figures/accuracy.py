"""How many of each group recognized each emotion, as in Figs. 11 and 12."""

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
    QUIET,
    SINGLE_COLUMN,
    TEXT,
    heading,
    in_style,
    settle,
    steps,
    text_width,
    wrapped,
)

Rates = NDArray[np.float64]

_BARS = 0.8  # share of an emotion's place that its bars fill
_BESIDE = 40.0  # width of the vertical axis [pt]
_SWATCH = 28.0  # width of a legend entry without its text [pt]
_BAR = 8.0  # least width of a bar in a figure of one column [pt]
_LINE = 1.6 * TEXT  # of a legend [pt]
_HEIGHT = 2.4  # of a figure with short names [in]
_SHORT = 30.0  # names on the axis that are longer [pt] make it higher, as do more lines of legend than two
_GAP = 5.0  # from the horizontal axis to the numbers of answers [pt]: below the 0 of the vertical axis
_SLANT = 35  # of names that do not fit side by side [degrees]


@in_style()
def accuracy_figure(
    rates: Rates,
    low: Rates,
    high: Rates,
    emotions: Sequence[str],
    levels: Sequence[str],
    chance: float,
    answers: NDArray[np.int64] | None = None,
    *,
    width: float = SINGLE_COLUMN,
) -> Figure:
    """Draw the share of right answers as bars, one for each level of a group beside the next, with intervals.

    The number of answers stands below each bar.

    Args:
        rates: (levels, emotions) share of right answers, 0 to 1; nan where nobody answered: no bar, no interval.
        low: lower ends of the intervals, alike (95 % Wilson intervals, say).
        high: upper ends.
        emotions: labels of the videos.
        levels: what the legend calls the levels, such as "female (n = 13)".
        chance: share of right answers by guessing, drawn as a line.
        answers: (levels, emotions) number of answers; None: no numbers.
        width: of the figure [in]; two columns if its bars do not fit into that.
    """
    shape = (len(levels), len(emotions))
    if any(np.shape(table) != shape for table in (rates, low, high)):
        raise ValueError(f"rates and intervals are {[np.shape(table) for table in (rates, low, high)]}, not {shape}")
    fits = len(emotions) * len(levels) * _BAR / _BARS <= width * POINTS - _BESIDE
    width = width if fits and len(emotions) <= 8 else DOUBLE_COLUMN
    figure = Figure(figsize=(width, _HEIGHT), layout="constrained")
    axes = figure.add_subplot()
    _draw_bars(axes, levels, *(100 * np.asarray(table) for table in (rates, low, high)))
    axes.axhline(100 * chance, color=INK, linewidth=0.9, linestyle=(0, (4, 2)), label="chance")
    place = (width * POINTS - _BESIDE) / len(emotions)
    numbers = 0.0 if answers is None else _draw_numbers(axes, np.asarray(answers), place * _BARS / len(levels))
    below = numbers + _draw_axes(axes, [heading(emotion) for emotion in emotions], place, numbers)
    above = _draw_legend(figure, axes, width * POINTS)
    figure.set_figheight(_HEIGHT + max(below - _SHORT, 0) / POINTS + max(above - 2, 0) * _LINE / POINTS)
    return settle(figure)


def _draw_bars(axes: Axes, levels: Sequence[str], rates: Rates, low: Rates, high: Rates) -> None:
    """Draw the bars and, over them, the intervals [percent]."""
    width = _BARS / len(levels)
    places = np.arange(rates.shape[1])
    for i, (level, colour) in enumerate(zip(levels, steps(len(levels), "Blues"), strict=True)):
        x = places + (i - (len(levels) - 1) / 2) * width
        axes.bar(x, np.nan_to_num(rates[i]), width, color=colour, edgecolor=INK, linewidth=0.5, label=level)
        # Lines and not error bars: those want lengths, which rounding makes negative where a rate is 0 or 1.
        answered = ~np.isnan(rates[i])
        ends = x[answered], low[i][answered], high[i][answered]
        axes.vlines(*ends, color="white", linewidth=2.2)
        axes.vlines(*ends, color=INK, linewidth=0.9)


def _draw_numbers(axes: Axes, answers: NDArray[np.int64], bar: float) -> float:
    """Draw the number of answers below each bar, upright if wider than the bar [pt]; return their height [pt]."""
    texts = [str(n) for n in answers.ravel().tolist()]
    widest = text_width(texts)
    upright = widest > bar - 1
    where: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "center", "va": "top"}
    for (level, emotion), n in np.ndenumerate(answers):
        x = emotion + (level - (len(answers) - 1) / 2) * _BARS / len(answers)
        axes.annotate(str(n), (x, 0), (0, -_GAP), rotation=90 if upright else 0, color=QUIET, **where)
    axes.annotate(
        "n",
        (0, 0),
        (-4, -_GAP),
        xycoords="axes fraction",
        textcoords="offset points",
        ha="right",
        va="top",
        color=QUIET,
    )
    return (widest if upright else TEXT) + _GAP + 2


def _draw_axes(axes: Axes, emotions: list[str], place: float, numbers: float) -> float:
    """Draw the axes and return how far down names reach [pt]: slanted or upright if wider than their place [pt]."""
    widest = text_width(emotions)
    turn = 0 if widest <= place - 3 else _SLANT if widest * np.cos(np.radians(_SLANT)) <= _BESIDE + place else 90
    how: dict[str, Any] = {"rotation": turn, "ha": "right", "rotation_mode": "anchor"} if turn else {}
    if turn == 90:
        how["va"] = "center"
    axes.set_xticks(range(len(emotions)), emotions, **how)
    axes.set_xlim(-0.55, len(emotions) - 0.45)
    axes.set_ylim(0, 100)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel("Accuracy (%)")
    axes.tick_params(axis="x", length=0, pad=3.5 + numbers)
    axes.grid(axis="y", color=FAINT, linewidth=0.4)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    return float(widest * np.sin(np.radians(turn)))


def _draw_legend(figure: Figure, axes: Axes, width: float) -> int:
    """Draw the legend above, in as many columns as fit into the width [pt]; return how many lines it has at most."""
    handles, labels = axes.get_legend_handles_labels()
    bars = handles[1:] + handles[:1]  # matplotlib lists lines first
    names = [wrapped(label, width - _SWATCH) for label in labels[1:] + labels[:1]]
    columns = _columns([text_width(lines) + _SWATCH for lines in names], width)
    texts = ["\n".join(lines) for lines in names]
    figure.legend(bars, texts, loc="outside upper center", ncols=columns, handlelength=1.4, columnspacing=1.2)
    return max(int(lines.sum()) for lines in np.array_split([len(lines) for lines in names], columns))


def _columns(widths: list[float], room: float) -> int:
    """Return the most columns that fit, filled as matplotlib does: down, the first ones with one more."""
    counts = range(len(widths), 1, -1)
    return next((n for n in counts if sum(part.max() for part in np.array_split(widths, n)) <= room), 1)
