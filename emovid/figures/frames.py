"""What a swarm does, in still pictures: snapshots with trails (Figs. 3 to 8), and all that every robot has drawn."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emovid.figures.schematic import scale_of
from emovid.figures.side_view import draw_seen_swarm, draw_seen_trails, seen_panels
from emovid.figures.style import DOUBLE_COLUMN, heading, in_style
from emovid.figures.top_view import (
    LINE,
    columns_of,
    draw_lines,
    draw_swarm,
    draw_trails,
    print_colours,
    slices,
    stage_panels,
    write_above,
    write_below,
)
from emovid.swarm.trajectory import Trajectory

Draw = Callable[[Axes, Trajectory, float], None]

_THIN = 0.5  # width of a trace where all robots leave one [pt]
_FINE = 0.03  # by which such a trace may stray from its arcs [pt]


@in_style()
def frames_figure(trajectory: Trajectory, times: Sequence[float], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw the swarm at some times, three in a row, with the trails up to each and the time under it.

    From straight above, or as the camera sees it if that is the view of its video.

    Args:
        trajectory: with the scene whose `video` says which robots leave trails, in which colours.
        times: within the run [s].
        width: of the figure [in].

    Raises:
        ValueError: for a time outside the run.
    """
    scene, columns = trajectory.scene, columns_of(len(times), width)
    if scene.video.view == "perspective":
        figure, panels, camera = seen_panels(scene, len(times), columns, width, below=LINE)
        draws: Sequence[Draw] = (partial(draw_seen_trails, camera=camera), partial(draw_seen_swarm, camera=camera))
    else:
        figure, panels = stage_panels(scene.stage, len(times), columns, width, print_colours(scene), below=LINE)
        draws = (draw_trails, draw_swarm)
    for axes, t in zip(panels, times, strict=True):
        for draw in draws:
            draw(axes, trajectory, t)
        write_below(axes, f"$t$ = {round(t, 3):g} s")
    return figure


@in_style()
def traces_figure(trajectories: Mapping[str, Trajectory], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw the whole traces of all robots, one panel for each run, its name over it: what their motion looks like.

    Args:
        trajectories: by name, on stages of one size and colour; the names are those of emotions, say.
        width: of the figure [in].
    """
    scenes = [run.scene for run in trajectories.values()]
    colours, columns = print_colours(scenes[0]), columns_of(len(scenes), width)
    figure, panels = stage_panels(scenes[0].stage, len(scenes), columns, width, colours, above=LINE)
    for axes, (name, run) in zip(panels, trajectories.items(), strict=True):
        robots, trails = range(run.scene.robots), print_colours(run.scene).trails
        lines = slices(run, robots, 0.0, float(run.t[-1]), _FINE / scale_of(axes))
        draw_lines(axes, lines, [trails[i % len(robots) % len(trails)] for i in range(len(lines))], _THIN)
        write_above(axes, heading(name))
    return figure
