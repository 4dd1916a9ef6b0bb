"""The densities phi of fear, disgust and anger (Appendix A, Fig. 16): plain functions of points.

All are smooth inside the stage, so that their integrals over Voronoi cells converge fast.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from emovid.scene.behaviour import AnyDensity, Boundary, Gaussian, Image, Sum, Uniform
from emovid.scene.picture import picture_of
from emovid.scene.stage import Stage
from emovid.swarm.arrays import Array

_BEYOND = 5  # cells by which a picture extends past its edges: as many standard deviations


class Density(NamedTuple):
    """A density over the stage.

    Attributes:
        phi: from x and y [m], arrays of one shape, to values >= 0 of that shape; only ratios of values matter.
        scale: standard deviation [m], the length over which it changes; infinite for a constant.
        one_peak: whether it is a single Gaussian, without valleys.
    """

    phi: Callable[[Array, Array], Array]
    scale: float
    one_peak: bool = False


def density_of(density: AnyDensity, stage: Stage) -> Density:
    """Return the density of a scene."""
    match density:
        case Uniform():
            return Density(lambda x, _: np.ones_like(x), np.inf)
        case Gaussian():
            return _gaussian(density)
        case Boundary():
            return _boundary(density, stage)
        case Image():
            return _image(density, stage)
        case Sum():  # pragma: no branch - there is no other
            return _sum(density, stage)


def _gaussian(density: Gaussian) -> Density:
    """exp(-|q - centre|^2 / 2 sigma^2), the density of anger."""
    factor, x_0, y_0 = -0.5 / density.sigma**2, density.centre.x, density.centre.y
    return Density(lambda x, y: np.exp(factor * ((x - x_0) ** 2 + (y - y_0) ** 2)), density.sigma, one_peak=True)


def _boundary(density: Boundary, stage: Stage) -> Density:
    """The sum over the edges of exp(-(d - inset)^2 / 2 width^2), d the distance from the edge's line: disgust's.

    A sum, not the distance from the nearest edge, which has creases where two edges are equally near. The paper draws
    the density, on a rectangle, without a formula (Fig. 16b).
    """
    factor = -0.5 / density.width**2
    crests = [(edge.x, edge.y, edge.offset - density.inset) for edge in stage.edges]

    def phi(x: Array, y: Array) -> Array:
        ridges = (np.exp(factor * (n_x * x + n_y * y - crest) ** 2) for n_x, n_y, crest in crests)
        return sum(ridges, np.zeros_like(x))

    return Density(phi, density.width)


def _sum(density: Sum, stage: Stage) -> Density:
    parts = [(part.weight, density_of(part.density, stage)) for part in density.parts]

    def phi(x: Array, y: Array) -> Array:
        return sum((weight * part.phi(x, y) for weight, part in parts), np.zeros_like(x))

    return Density(phi, min(part.scale for _, part in parts))


@lru_cache(maxsize=8)  # a law needs its density in every period
def _image(density: Image, stage: Stage) -> Density:
    """A picture over the upright rectangle around the stage, 1 where it is black and 0 where it is white, smoothed."""
    weights, x_peaks, y_peaks = picture_peaks(density, stage)
    factor = -0.5 / density.smoothing**2

    def phi(x: Array, y: Array) -> Array:
        along_x = np.exp(factor * (x.reshape(-1, 1) - x_peaks) ** 2)
        along_y = np.exp(factor * (y.reshape(-1, 1) - y_peaks) ** 2)
        return np.sum(along_x @ weights * along_y, axis=1).reshape(x.shape)

    return Density(phi, density.smoothing)


def picture_peaks(density: Image, stage: Stage) -> tuple[Array, Array, Array]:
    """Return heights (X, Y) and positions, x (X,) and y (Y,) [m], of the peaks whose sum is a picture's density.

    It is averaged to cells no larger than the smoothing s, and each cell is a peak of standard deviation s: peaks one s
    apart add up to a constant within 1e-8. So it is as smooth as a single peak is, which pixels and straight lines
    between them are not, and its integrals are as exact. Beyond the rectangle it has the values of its edge.
    """
    assert density.pixels is not None  # a valid scene has read its picture
    picture = picture_of(density.pixels)
    assert picture is not None
    left, bottom, right, top = stage.box
    grey = np.frombuffer(picture.values, np.uint8).reshape(picture.height, picture.width)
    dark = 1 - grey[::-1].T / 255  # x, then y upwards
    columns, rows = (int(np.ceil(extent / density.smoothing)) for extent in (right - left, top - bottom))
    cells = _averaging(columns, picture.width) @ dark @ _averaging(rows, picture.height).T
    area = (right - left) / columns * (top - bottom) / rows
    weights = np.pad(cells, _BEYOND, mode="edge") * area / (2 * np.pi * density.smoothing**2)
    return weights, _middles(left, right, columns), _middles(bottom, top, rows)


def _middles(low: float, high: float, cells: int) -> Array:
    """Return the middles of equal cells from `low` to `high`, and of `_BEYOND` more at both ends."""
    return low + (high - low) / cells * np.arange(0.5 - _BEYOND, cells + _BEYOND, dtype=float)


def _averaging(cells: int, pixels: int) -> Array:
    """Return the matrix (cells, pixels) that averages pixels in a row to equal cells over the same length."""
    cuts = np.arange(cells + 1) / cells * pixels
    before = np.clip(cuts[:, None] - np.arange(pixels), 0.0, 1.0)  # share of each pixel before each cut
    shares: Array = np.diff(before, axis=0) * (cells / pixels)
    return shares
