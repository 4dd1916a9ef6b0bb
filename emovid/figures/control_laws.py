"""The control laws of Appendix A: contours with robots on them (Fig. 15), densities with converged robots (Fig. 16)."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon, Rectangle

from emovid.figures.schematic import THIN, draw_arrow, scale_of, write_math
from emovid.figures.stage_panels import LINE, columns_of, stage_panels, write_below
from emovid.figures.style import DOUBLE_COLUMN, FAINT, INK, POINTS, QUIET, TEXT, heading, in_style
from emovid.scene.behaviour import CircularSinusoid, Contour, ContourKeys, Coverage, ExpandingCircle
from emovid.scene.model import Scene
from emovid.swarm.arrays import Array
from emovid.swarm.densities import Density, density_of
from emovid.swarm.laws import corners_of, followed_points, lloyd, mass_and_centroid, radius, start_angles
from emovid.swarm.start import start_poses
from emovid.swarm.trajectory import Trajectory

AGENT, TARGET, ARROW = "#c0281f", INK, "#1f6fb4"
_AGENT_SIZE, _TARGET_SIZE = 3.6, 2.2  # diameters [pt]
_ARROWS = 3  # number of robots with an arrow to their target
_HEADS, _HEAD_SHARE = (2.5, 5.0), 0.5  # smallest and largest head of an arrow [pt]; of its length in between
_SHORT = 5.0  # arrows shorter than this are also shown enlarged [pt]
_LARGER = 5.0  # scale of the enlarged part
_INSET = 0.3  # side of the enlarged part, over the panel's width
_BRACKET = "|-|,widthA=0.3,widthB=0.3"
_TURN = np.linspace(0, 2 * np.pi, 721)
_ENDS = np.array([-1, 1])
_COLOURS = LinearSegmentedColormap.from_list("density", matplotlib.colormaps["Blues"](np.linspace(0, 0.62, 64)))
_DOTS = 300  # of the heat map per inch
_STILL = 1e-5  # motion in a step of robots at rest [m]; a crowd around a peak keeps turning
_MAX_STEPS = 2000


@in_style()
def shapes_figure(runs: Sequence[Trajectory], times: Sequence[float], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw the contour of each run, its robots, the points they follow, and three go-to-goal arrows (Fig. 15).

    An expanding circle is drawn twice: at t = 0, where R(t) is R_min, and just before it starts again, near R_max.
    Where the arrows are very short, a part of the panel is shown enlarged.

    Args:
        runs: of contour laws, on stages of one size.
        times: at which each is drawn [s]; not used for an expanding circle.
        width: of the figure [in].
    """
    figure, panels = stage_panels(runs[0].scene.stage, len(runs), columns_of(len(runs), width), width, below=LINE)
    for axes, run, t in zip(panels, runs, times, strict=True):
        contour = contour_of(run.scene)
        moments = [0.0, expanded(contour, run)] if isinstance(contour, ExpandingCircle) else [t]
        ends = np.concatenate([arrows_of(run, moment) for moment in moments])
        dots = np.concatenate([*ends.swapaxes(0, 1), ends.mean(axis=1)])
        _draw_radii(axes, contour, moments, dots)
        for moment in moments:
            _draw_moment(axes, contour, arrows_of(run, moment), moment)
        lengths = np.hypot(*np.diff(arrows_of(run, moments[0]), axis=1)[:, 0].T)
        if lengths.mean() * scale_of(axes) < _SHORT:
            _draw_enlarged(axes, contour, arrows_of(run, moments[0]), moments[0])
        write_below(axes, heading(run.scene.emotion or ""))
    return figure


def contour_of(scene: Scene) -> Contour:
    """Return the contour of a scene.

    Raises:
        ValueError: for a scene without one.
    """
    if not isinstance(scene.behaviour, ContourKeys):
        raise ValueError(f"a {scene.behaviour.law} behavior has no contour")
    return scene.behaviour


def expanded(contour: ExpandingCircle, run: Trajectory) -> float:
    """Return the last sample time [s] before the circle starts again at R_min, or the end of a shorter run."""
    fold = (contour.R_max - contour.R_min) / contour.expansion_rate
    return float(run.t[np.searchsorted(run.t, fold * (1 - 1e-9)) - 1])


def arrows_of(run: Trajectory, t: float) -> Array:
    """Return each robot's position and the point it follows, (N, 2, 2) [m], at the time `t` [s]."""
    agents = run.at(np.array([t]))[0, :, :2]
    targets = followed_points(contour_of(run.scene), start_angles(run.scene.robots), t)
    return np.stack([agents, targets], axis=1)


def draw_contour(axes: Axes, contour: Contour, t: float, colour: str = QUIET) -> None:
    """Draw a contour at the time `t` [s]."""
    _draw_curve(axes, contour, radius(contour, _TURN, t), colour, "contour")


def _draw_moment(axes: Axes, contour: Contour, arrows: Array, t: float) -> None:
    """Draw the contour, the agents, their targets, and some of the arrows between."""
    draw_contour(axes, contour, t)
    for agent, target in arrows[np.arange(_ARROWS) * len(arrows) // _ARROWS]:
        head = np.clip(_HEAD_SHARE * np.hypot(*(target - agent)) * scale_of(axes), *_HEADS)
        arrow = FancyArrowPatch(
            tuple(agent), tuple(target), arrowstyle="-|>", mutation_scale=head, shrinkA=0, shrinkB=_TARGET_SIZE / 2
        )
        arrow.set(color=ARROW, linewidth=0.9, zorder=3.5, joinstyle="miter", capstyle="butt")
        axes.add_patch(arrow)
    draw_discs(axes, arrows[:, 0], _AGENT_SIZE, AGENT, "agents")
    draw_discs(axes, arrows[:, 1], _TARGET_SIZE, TARGET, "targets")


def _draw_curve(axes: Axes, contour: Contour, r: Array, colour: str, label: str) -> None:
    x, y = contour.centre.x + r * np.cos(_TURN), contour.centre.y + r * np.sin(_TURN)
    axes.plot(x, y, color=colour, linewidth=0.7, linestyle=(0, (3, 2)), zorder=2, label=label)


def draw_discs(axes: Axes, centres: Array, diameter: float, colour: str, label: str) -> None:
    """Draw disks of a diameter [pt] around points (N, 2) [m]."""
    sizes = np.full(len(centres), diameter)
    discs = EllipseCollection(
        sizes, sizes, np.zeros(len(centres)), units="points", offsets=centres, offset_transform=axes.transData
    )
    discs.set(facecolor=colour, edgecolor="white", linewidth=0.4, zorder=4, label=label, snap=False)
    axes.add_collection(discs, autolim=False)


def _draw_enlarged(axes: Axes, contour: Contour, arrows: Array, t: float) -> None:
    """Draw the surroundings of the first arrow again, enlarged, in the panel's lower right corner."""
    left, right = axes.get_xlim()
    bottom, _ = axes.get_ylim()
    side = _INSET * (right - left)
    away = 0.03 * (right - left)
    corner = np.array([right - away - side, bottom + away])
    middle, half = arrows[0].mean(axis=0), side / _LARGER / 2
    inset = axes.inset_axes((*corner, side, side), transform=axes.transData)
    inset.set(xlim=middle[0] + half * _ENDS, ylim=middle[1] + half * _ENDS, xticks=[], yticks=[], aspect="equal")
    inset.spines[:].set(color=FAINT, linewidth=0.6)
    _draw_moment(inset, contour, arrows, t)
    axes.add_patch(
        Rectangle(tuple(middle - half), 2 * half, 2 * half, fill=False, edgecolor=FAINT, linewidth=0.6, zorder=5)
    )
    for x, y in ((-1, -1), (1, 1)):
        ends = np.array([middle + half * np.array([x, y]), corner + side / 2 * (1 + np.array([x, y]))])
        axes.plot(*ends.T, color=FAINT, linewidth=0.6, zorder=1.5)


def _draw_radii(axes: Axes, contour: Contour, moments: Sequence[float], dots: Array) -> None:
    """Draw the radii and the amplitude of a sinusoid as arrows with names, away from `dots` (D, 2) [m]."""
    centre, room = np.array([contour.centre.x, contour.centre.y]), 1.1 * TEXT / scale_of(axes)
    if isinstance(contour, CircularSinusoid):
        _draw_curve(axes, contour, np.full_like(_TURN, contour.R), FAINT, "circle")
        crests = 2 * np.pi / contour.f * (0.25 + np.arange(contour.f, dtype=float))
        crest = _clearest(centre, contour.R + contour.A / 2, crests, dots)
        draw_arrow(axes, centre + contour.R * crest, centre + (contour.R + contour.A) * crest, QUIET, THIN, _BRACKET)
        write_math(axes, centre + (contour.R + contour.A + 0.8 * room) * crest, "$A$", QUIET)
    two = isinstance(contour, ExpandingCircle)
    names = {r"$R_{\min}$": 285, r"$R_{\max}$": 35} if two else {"$R$": 255}  # and approximate directions [degrees]
    for (name, middle), t in zip(names.items(), moments, strict=True):
        r = contour.R if isinstance(contour, CircularSinusoid) else float(radius(contour, np.zeros(1), t)[0])
        along = _clearest(centre, r, np.radians(middle + np.arange(-18.0, 19.0, 3.0)), dots)
        draw_arrow(axes, centre, centre + r * along, QUIET, THIN)
        beside = 0.62 * r * along + room * np.array([-along[1], along[0]])
        beyond = (r + room) * along
        write_math(axes, centre + (beside if r > 3 * room else beyond), name, QUIET)


def _clearest(centre: Array, r: float, angles: Array, dots: Array) -> Array:
    """Return the direction (2,), among some angles [rad], in which the point at `r` [m] is farthest from the dots."""
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    away = np.linalg.norm(centre + r * directions[:, None] - dots, axis=-1).min(axis=1)
    return directions[np.argmax(away)]


def converged(scene: Scene) -> Array:
    """Return the positions (N, 2) [m] to which the robots of a coverage scene converge from its own start.

    They are points without a heading, as in the paper, and go to the centroids of their Voronoi cells in each step.

    Raises:
        ValueError: for a scene without a density.
    """
    points = start_poses(scene, np.random.default_rng(scene.seed))[:, :2]
    corners, density = corners_of(scene.stage), _density(scene)
    return lloyd(points, corners, density, gain=_STILL**2 / len(points), steps=_MAX_STEPS)


def centroids(scene: Scene, points: Array) -> Array:
    """Return the centroids (N, 2) [m] of the Voronoi cells of robots at `points` (N, 2) [m].

    Raises:
        ValueError: for a scene without a density.
    """
    return mass_and_centroid(points, corners_of(scene.stage), _density(scene))[1]


def _density(scene: Scene) -> Density:
    if not isinstance(scene.behaviour, Coverage):
        raise ValueError("only coverage has a density")
    return density_of(scene.behaviour.density, scene.stage)


def density_map(scene: Scene, dots: float) -> Array:
    """Return the density over the stage's bounding box, `dots` per meter, as a share of its largest value."""
    left, bottom, right, top = scene.stage.box
    columns, rows = (int(np.ceil(dots * extent)) for extent in (right - left, top - bottom))
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    x, y = np.meshgrid(x, y)
    phi = _density(scene).phi(x, y)
    inside = np.all([edge.x * x + edge.y * y <= edge.offset for edge in scene.stage.edges], axis=0)
    return phi / phi[inside].max()


@in_style()
def densities_figure(scenes: Sequence[Scene], points: Sequence[Array], *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw the density of each scene, from 0 to its largest value, darker where denser, and its robots (Fig. 16).

    Args:
        scenes: of coverage, on stages of one size.
        points: positions of the robots of each (N, 2) [m].
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
