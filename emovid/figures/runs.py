"""Figures of runs: snapshots with trails (Figs. 3 to 8), the Robotarium (Figs. 13 and 14), full traces, descriptors."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil
from string import ascii_lowercase

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emovid.figures.control_laws import draw_contour
from emovid.figures.stage_panels import (
    LINE,
    columns_of,
    draw_swarm,
    draw_trails,
    perspective_panels,
    print_colours,
    stage_panels,
    write_above,
    write_below,
)
from emovid.figures.style import DOUBLE_COLUMN, EMOTION_COLOURS, FAINT, SINGLE_COLUMN, heading, in_style, settle
from emovid.scene.behaviour import ContourKeys
from emovid.scene.video import Colours
from emovid.swarm.trajectory import Trajectory

# The authors' own videos, from the captions of their Figs. 13 and 14.
OVERHEAD_VIDEOS = {
    "happiness": "https://youtu.be/HQ6YkoADMBg",
    "surprise": "https://youtu.be/xhPTQg4iLvM",
    "sadness": "https://youtu.be/i7cLP_GcL54",
    "fear": "https://youtu.be/6xqb-sQck6I",
    "disgust": "https://youtu.be/RgPyXVuprX8",
    "anger": "https://youtu.be/VGlLPJGlwvo",
}
PERSPECTIVE_VIDEOS = {
    "happiness": "https://youtu.be/EeEyIGn2BV0",
    "surprise": "https://youtu.be/hHMjYMv6Ojo",
    "sadness": "https://youtu.be/jFWMtu5oYEo",
    "fear": "https://youtu.be/j72EXA14Scs",
    "disgust": "https://youtu.be/py_cUXCkgZM",
    "anger": "https://youtu.be/Thj5s1vQvYA",
}
_THIN = 0.5  # smallest width of a trace where all robots leave one [pt]


def with_traces(trajectory: Trajectory, robots: int | None) -> Trajectory:
    """Return the run with full traces of some robots, all for None, in place of its video's trails.

    Traces have the colors of the theme.
    """
    video = trajectory.scene.video
    trails = {"robots": robots, "seconds": None, "fade": False}
    shown = {
        "trails": video.trails.model_copy(update=trails),
        "colours": video.colours.model_copy(update={"trails": ("theme",) * len(Colours().trails)}),
    }
    scene = trajectory.scene.model_copy(update={"video": video.model_copy(update=shown)})
    return replace(trajectory, scene=scene)


@in_style()
def frames_figure(trajectory: Trajectory, times: Sequence[float], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw the swarm at some times, three in a row, with the trails up to each time (Figs. 3 to 8).

    From above, a contour is drawn faintly at t = 0.

    Args:
        trajectory: its scene's `video` gives the view, the trails, and the colors.
        times: within the run [s].
        width: of the figure [in].

    Raises:
        ValueError: for a time outside the run.
    """
    scene, columns, camera = trajectory.scene, columns_of(len(times), width), None
    if scene.video.view == "perspective":
        figure, panels, camera = perspective_panels(scene, len(times), columns, width, below=LINE)
    else:
        figure, panels = stage_panels(scene.stage, len(times), columns, width, print_colours(scene), below=LINE)
    for i, (axes, t) in enumerate(zip(panels, times, strict=True)):
        if t == 0 and camera is None and isinstance(scene.behaviour, ContourKeys):
            draw_contour(axes, scene.behaviour, t, FAINT)
        draw_trails(axes, trajectory, t, camera)
        draw_swarm(axes, trajectory, t, camera)
        letter = f"({ascii_lowercase[i]}) " if 1 < len(times) <= len(ascii_lowercase) else ""
        write_below(axes, f"{letter}$t$ = {round(t, 3):g} s")
    return figure


@in_style()
def traces_figure(trajectories: Mapping[str, Trajectory], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw the full traces of all robots, one panel for each run with its name above.

    Args:
        trajectories: by name, for example that of an emotion, on stages of one size and color.
        width: of the figure [in].
    """
    scenes = [run.scene for run in trajectories.values()]
    colours, columns = print_colours(scenes[0]), columns_of(len(scenes), width)
    figure, panels = stage_panels(scenes[0].stage, len(scenes), columns, width, colours, above=LINE)
    for axes, (name, run) in zip(panels, trajectories.items(), strict=True):
        draw_trails(axes, with_traces(run, None), float(run.t[-1]), thinnest=_THIN)
        write_above(axes, heading(name))
    return figure


@in_style()
def overhead_figure(runs: Mapping[str, Trajectory], times: Sequence[float], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw a snapshot of each run on the Robotarium from overhead with its trails (Fig. 13).

    Args:
        runs: by emotion, on one stage.
        times: of the snapshots [s].
        width: of the figure [in].
    """
    scene = next(iter(runs.values())).scene
    columns, narrow = columns_of(len(runs), width), width <= SINGLE_COLUMN
    colours, below = print_colours(scene), 2 * LINE if narrow else LINE
    figure, panels = stage_panels(scene.stage, len(runs), columns, width, colours, above=LINE, below=below)
    for axes, (emotion, run), t in zip(panels, runs.items(), times, strict=True):
        draw_trails(axes, run, t)
        draw_swarm(axes, run, t)
        _label(axes, emotion, OVERHEAD_VIDEOS, "\n" if narrow else " ")
    return figure


@in_style()
def perspective_figure(
    runs: Mapping[str, Trajectory], times: Sequence[float], *, width: float = DOUBLE_COLUMN
) -> Figure:
    """Draw a snapshot of each run from its scene's camera, without trails as in the paper (Fig. 14).

    Two panels stand side by side: in a third of a page, robots at the far edge would be half a millimeter high.

    Args:
        runs: by emotion, on one stage.
        times: of the snapshots [s].
        width: of the figure [in].
    """
    scene = next(iter(runs.values())).scene
    columns = 2 if width > SINGLE_COLUMN else 1
    figure, panels, camera = perspective_panels(scene, len(runs), columns, width, above=LINE, below=LINE)
    for axes, (emotion, run), t in zip(panels, runs.items(), times, strict=True):
        draw_swarm(axes, run, t, camera)
        _label(axes, emotion, PERSPECTIVE_VIDEOS)
    return figure


def _label(axes: Axes, emotion: str, videos: Mapping[str, str], between: str = " ") -> None:
    write_above(axes, heading(emotion))
    write_below(axes, f"authors' video:{between}{videos[emotion].removeprefix('https://')}")


# --- descriptors -----------------------------------------------------------------------------------------------------

# One or two of each family of docs/descriptors.md, and the labels of their axes.
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
_APART = 0.64  # between two axes [in], so that their labels do not touch
_MARKERS = dict(zip(EMOTION_COLOURS, "osDP^v", strict=True))  # for print in gray, and where lines cross


@in_style()
def descriptors_figure(values: Mapping[str, Mapping[str, float]], width: float = DOUBLE_COLUMN) -> Figure:
    """Draw parallel coordinates: an axis per descriptor from its smallest to its largest value, a line per emotion.

    Args:
        values: by emotion and descriptor.
        width: of the figure [in].
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
    """Draw some descriptors into axes with space for a number of columns."""
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
