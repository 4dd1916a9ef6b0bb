"""The densities of anger, disgust and fear with robots that have spread over them, as in Fig. 16 (Appendix A)."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from emovid.figures.schematic import scale_of
from emovid.figures.shapes import AGENT, draw_discs
from emovid.figures.style import DOUBLE_COLUMN, POINTS, heading, in_style
from emovid.figures.top_view import LINE, columns_of, stage_panels, write_below
from emovid.scene.behaviour import Coverage
from emovid.scene.model import Scene
from emovid.swarm.arrays import Array
from emovid.swarm.densities import density_of
from emovid.swarm.laws import corners_of, coverage_velocity
from emovid.swarm.start import start_poses

_COLOURS = LinearSegmentedColormap.from_list("density", matplotlib.colormaps["Blues"](np.linspace(0, 0.48, 64)))
_DOTS = 300  # of the heat map per inch
_STILL = 1e-5  # m by which robots that have arrived still move in a step; a crowd around a peak turns on for ever
_MOST = 2000  # steps


def converged(scene: Scene) -> Array:
    """Return where the robots (N, 2) [m] of a coverage scene are once its law has converged, from its own start.

    Robots are the paper's omnidirectional points: each goes to the centroid of its Voronoi cell, again and again.
    """
    points = start_poses(scene, np.random.default_rng(scene.seed))[:, :2]
    for _ in range(_MOST):
        before, points = points, centroids(scene, points)
        if np.abs(points - before).max() < _STILL:
            break
    return points


def centroids(scene: Scene, points: Array) -> Array:
    """Return the centroids (N, 2) [m] of the Voronoi cells of robots at `points` (N, 2) [m].

    Raises:
        ValueError: for a scene without a density.
    """
    if not isinstance(scene.behaviour, Coverage):
        raise ValueError("only coverage has a density")
    law = scene.behaviour.model_copy(update={"u_max": None, "kappa": 1.0})
    return points + coverage_velocity(law, scene.stage, points)


def density_map(scene: Scene, dots: float) -> Array:
    """Return the density over the stage's upright rectangle, `dots` to the metre, as a share of its largest value."""
    assert isinstance(scene.behaviour, Coverage)
    left, bottom, right, top = scene.stage.box
    columns, rows = (int(np.ceil(dots * extent)) for extent in (right - left, top - bottom))
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    x, y = np.meshgrid(x, y)
    phi = density_of(scene.behaviour.density, scene.stage).phi(x, y)
    inside = np.all([edge.x * x + edge.y * y <= edge.offset for edge in scene.stage.edges], axis=0)
    return phi / phi[inside].max()


@in_style()
def densities_figure(scenes: Sequence[Scene], points: Sequence[Array], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw the density of each scene, from 0 to its largest value, darker where it is denser, and robots on it.

    Args:
        scenes: of coverage, on stages of one size.
        points: where the robots of each are (N, 2) [m].
        width: of the figure [in].
    """
    figure, panels = stage_panels(scenes[0].stage, len(scenes), columns_of(len(scenes), width), width, below=LINE)
    for axes, scene, robots in zip(panels, scenes, points, strict=True):
        shares, (left, bottom, right, top) = density_map(scene, scale_of(axes) * _DOTS / POINTS), scene.stage.box
        tones = axes.imshow(
            shares, cmap=_COLOURS, vmin=0, vmax=1, extent=(left, right, bottom, top), origin="lower", zorder=0
        )
        tones.set_clip_path(Polygon(corners_of(scene.stage), transform=axes.transData))
        axes.set_aspect("auto")
        draw_discs(axes, robots, 2 * scene.robot.body.radius * scale_of(axes), AGENT, "robots")
        write_below(axes, heading(scene.emotion or ""))
    return figure
