"""The six behaviours on the Robotarium: a snapshot of each from overhead (Fig. 13) and in perspective (Fig. 14)."""

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emovid.figures.side_view import draw_seen_swarm, seen_panels
from emovid.figures.style import DOUBLE_COLUMN, SINGLE_COLUMN, heading, in_style
from emovid.figures.top_view import (
    LINE,
    columns_of,
    draw_swarm,
    draw_trails,
    print_colours,
    stage_panels,
    write_above,
    write_below,
)
from emovid.swarm.trajectory import Trajectory

# The paper's own videos, from the captions of its Figs. 13 and 14.
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
_SIDE_BY_SIDE = 2  # panels in perspective: in a third of a page, robots at the far edge would be half a millimetre


@in_style()
def overhead_figure(runs: Mapping[str, Trajectory], times: Sequence[float], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw each run from overhead with its trails, its emotion over it and the paper's video under it.

    Args:
        runs: by emotion, on one stage.
        times: of the snapshots [s].
        width: of the figure [in].
    """
    scene = next(iter(runs.values())).scene
    columns = columns_of(len(runs), width)
    figure, panels = stage_panels(scene.stage, len(runs), columns, width, print_colours(scene), above=LINE, below=LINE)
    for axes, (emotion, run), t in zip(panels, runs.items(), times, strict=True):
        draw_trails(axes, run, t)
        draw_swarm(axes, run, t)
        _label(axes, emotion, OVERHEAD_VIDEOS)
    return figure


@in_style()
def perspective_figure(
    runs: Mapping[str, Trajectory], times: Sequence[float], *, width: float = DOUBLE_COLUMN
) -> Figure:
    """Draw each run as the camera of its scene sees it, without trails, like the paper. See `overhead_figure`."""
    scene = next(iter(runs.values())).scene
    columns = _SIDE_BY_SIDE if width > SINGLE_COLUMN else 1
    figure, panels, camera = seen_panels(scene, len(runs), columns, width, above=LINE, below=LINE)
    for axes, (emotion, run), t in zip(panels, runs.items(), times, strict=True):
        draw_seen_swarm(axes, run, t, camera)
        _label(axes, emotion, PERSPECTIVE_VIDEOS)
    return figure


def _label(axes: Axes, emotion: str, videos: Mapping[str, str]) -> None:
    write_above(axes, heading(emotion))
    write_below(axes, videos[emotion].removeprefix("https://"))
