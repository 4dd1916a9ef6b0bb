"""How the six emotions move: parallel coordinates of their descriptors."""

from collections.abc import Mapping
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emovid.figures.style import DOUBLE_COLUMN, EMOTION_COLOURS, FAINT, in_style, settle

# One or two of each family of docs/descriptors.md, and how an axis calls them.
SHOWN = {
    "speed_mean": "mean\nspeed\n[m/s]",
    "speed_peak": "peak\nspeed\n[m/s]",
    "distance_travelled": "distance\ntraveled\n[m]",
    "turning_per_metre": "turning\n[rad/m]",
    "sharp_corner_share": "sharp\ncorners\n[share]",
    "cusps_per_second": "cusps\n[1/s]",
    "sparc": "smoothness\n(SPARC)",
    "hull_area_share_end": "hull at\nthe end\n[share]",
    "hull_circularity": "roundness\nof the hull",
    "nearest_neighbour_end": "nearest\nneighbor\n[m]",
    "distance_to_boundary_end": "boundary\ndistance\n[m]",
}
_APART = 0.64  # of two axes [in], so that their texts do not touch
_MARKERS = dict(zip(EMOTION_COLOURS, "osDP^v", strict=True))  # in grey, and where lines cross


@in_style()
def descriptors_figure(values: Mapping[str, Mapping[str, float]], width: float = DOUBLE_COLUMN) -> Figure:
    """Return parallel coordinates: an axis for each descriptor, from its least to its largest value, a line an emotion.

    Args:
        values: from emotion to descriptor to value.
        width: [in].
    """
    names = list(SHOWN)
    in_row = ceil(len(names) / ceil(len(names) * _APART / width))
    rows = [names[first : first + in_row] for first in range(0, len(names), in_row)]
    figure = Figure(figsize=(width, 0.5 + 2.3 * len(rows)), layout="constrained")
    for axes, shown in zip(figure.subplots(len(rows), squeeze=False)[:, 0], rows, strict=True):
        _draw(axes, shown, in_row, values)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    in_line = len(values) if len(rows) == 1 else len(values) // 2
    figure.legend(handles, labels, loc="outside upper center", ncols=in_line)
    return settle(figure)


def _draw(axes: Axes, shown: list[str], columns: int, values: Mapping[str, Mapping[str, float]]) -> None:
    """Draw the coordinates of some descriptors into axes with room for as many columns."""
    table = np.array([[found[name] for name in shown] for found in values.values()])
    least, largest = table.min(axis=0), table.max(axis=0)
    shares = (table - least) / np.where(largest > least, largest - least, 1.0)
    places = np.arange(len(shown)).tolist()
    for x in places:
        axes.axvline(x, color=FAINT, linewidth=0.6, zorder=0)
        axes.text(x, 1.04, _number(largest[x]), ha="center", va="bottom")
        axes.text(x, -0.04, _number(least[x]), ha="center", va="top")
    for emotion, share in zip(values, shares, strict=True):
        colour, marker = EMOTION_COLOURS[emotion], _MARKERS[emotion]
        axes.plot(places, share, color=colour, marker=marker, lw=1.2, ms=4.5, label=emotion, clip_on=False)
    axes.set_xticks(places, [SHOWN[name] for name in shown])
    axes.tick_params(length=0, pad=11)
    axes.set_yticks([])
    axes.set_xlim(-0.5, columns - 0.5)
    axes.set_ylim(-0.02, 1.02)
    axes.spines[:].set_visible(False)


def _number(value: float) -> str:
    return "0" if abs(value) < 1e-9 else f"{value:.3g}".replace("-", "\N{MINUS SIGN}")
