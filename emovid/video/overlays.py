"""Optional parts of a frame: density, Voronoi cells, targets, clock."""

from functools import lru_cache

import matplotlib
import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D

from emovid.scene.behaviour import ContourKeys, Coverage
from emovid.scene.model import Scene
from emovid.scene.stage import Stage
from emovid.scene.video import MARGIN, Colours
from emovid.swarm.arrays import Array
from emovid.swarm.densities import Density, density_of
from emovid.swarm.laws import corners_of, followed_points, mass_and_centroid, start_angles
from emovid.swarm.voronoi import voronoi_cells
from emovid.video.cameras import Camera
from emovid.video.canvas import Canvas, Layer, Pixels, rgba

_LINE = 0.0015  # width of thin lines [m]
_THIN = 1.0  # smallest width of an even line [pixels]
_DOT = 0.004  # radius of a target [m]
_RIM = 1.4  # radius of its light rim over its own radius
_CELL_OPACITY = 0.3  # of a cell's edge; most edges are those of two cells
_TARGET_OPACITY = 0.75  # of the line to a target
_DIGIT = 0.62  # height of the clock's digits over the margin around the stage


def cells_of(stage: Stage, points: Array) -> Array:
    """Return the Voronoi cells (N, M, 2) [m] of robots at `points` (N, 2) [m]. See `voronoi_cells`."""
    return voronoi_cells(points, corners_of(stage))


def targets_of(scene: Scene, points: Array, t: float) -> Array:
    """Return the targets (N, 2) [m] of robots at `points` (N, 2) [m] at time `t` [s].

    They are the followed points of a contour, or the centroids of the cells; a cell without mass has its robot's
    position.
    """
    if isinstance(scene.behaviour, ContourKeys):
        return followed_points(scene.behaviour, start_angles(scene.robots), t)
    assert isinstance(scene.behaviour, Coverage)  # a valid scene of recorded motion shows no targets
    density = density_of(scene.behaviour.density, scene.stage)
    return mass_and_centroid(points, corners_of(scene.stage), density)[1]


def paint_density(picture: Pixels, camera: Camera, stage: Stage, density: Density, colour: str) -> None:
    """Tint the stage in `picture` (height, width, 4), from no tint where the density is 0 to `colour` at its peak."""
    corners = camera.pixels(corners_of(stage))
    (first, low), (last, high) = corners.min(axis=0), corners.max(axis=0)
    rows = np.arange(int(camera.height - high), min(int(camera.height - low) + 1, camera.height))
    columns = np.arange(int(first), min(int(last) + 1, camera.width))
    middles = np.stack(np.meshgrid(columns + 0.5, camera.height - rows - 0.5), axis=-1)
    x, y = np.moveaxis(camera.metres(middles), -1, 0)
    phi, cover = density.phi(x, y), camera.stage_share(stage, middles)
    share = np.where(cover > 0, cover * phi, 0.0)[..., None] / phi[cover > 0.5].max()
    part = picture[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1, :3]
    part[:] = np.round(part + share * (255 * np.array(to_rgb(colour)) - part))


def draw_cells(canvas: Canvas, camera: Camera, cells: Array, colour: str) -> None:
    """Draw the edges of cells (N, M, 2) [m] as thin lines."""
    rings = camera.pixels(np.concatenate([cells, cells[:, :1]], axis=1))
    canvas.lines(list(rings), _faint(colour, _CELL_OPACITY), _thin(camera))


def draw_targets(canvas: Canvas, camera: Camera, points: Array, targets: Array, colours: Colours) -> None:
    """Draw the targets (N, 2) [m] of robots at `points` (N, 2) [m]: a dot, and a thin line from the robot to it."""
    ends = camera.pixels(np.stack([points, targets], axis=1))
    canvas.lines(list(ends), _faint(colours.overlay, _TARGET_OPACITY), _thin(camera))
    radius = max(_DOT * camera.scale, 1.5 * _THIN)
    rim = Path.unit_circle().transformed(Affine2D().scale(_RIM))
    dot = [Layer(rim, rgba([colours.stage])), Layer(Path.unit_circle(), rgba([colours.overlay]))]
    turns = camera.disc_maps(targets, radius)
    canvas.stamp(dot, turns, ends[:, 1])


def draw_clock(canvas: Canvas, camera: Camera, t: float, colour: str) -> None:
    """Write the time `t` [s], to a tenth, in the margin at the upper left corner."""
    margin = MARGIN * min(camera.width, camera.height)
    outline = _text(f"{t:.1f} s")
    size = _DIGIT * margin / _text("0").get_extents().height
    place = np.array([[margin, camera.height - (1 + _DIGIT) * margin / 2]])
    canvas.stamp([Layer(outline, rgba([colour]))], np.diag([size, size, 1.0])[None], place)


@lru_cache(maxsize=16)
def _text(text: str) -> Path:
    """Return the outline of a text at font size 1.

    The font comes with matplotlib, so that it is the same on every machine; its digits have one width.
    """
    font = FontProperties(fname=f"{matplotlib.get_data_path()}/fonts/ttf/DejaVuSans.ttf")
    large = 100.0  # outlines of fonts are rounded to fractions of a pixel
    outline = TextPath((0, 0), text, size=large, prop=font)
    return Path(np.asarray(outline.vertices) / large, outline.codes)


def _thin(camera: Camera) -> float:
    return max(_LINE * camera.scale, _THIN)


def _faint(colour: str, opacity: float) -> Array:
    return rgba([colour]) * np.array([1, 1, 1, opacity])
