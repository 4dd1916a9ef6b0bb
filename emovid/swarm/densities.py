"""The densities phi of fear, disgust and anger (Appendix A, Fig. 16): plain functions of points.

All are smooth inside the stage, so that their integrals over Voronoi cells converge fast.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from emovid.scene.behaviour import AnyDensity, Boundary, Gaussian, Image, Sum, Uniform
from emovid.scene.picture import picture_of
from emovid.scene.stage import Stage
from emovid.swarm.arrays import Array

_MAX_TERMS = 64  # of a sum of Gaussians, for which line integrals pay
_NEGLIGIBLE = 1e-22  # of a product of ridges: 1e-11 of the ridges where both are as large
_PARALLEL = 1e-12  # determinant
_BEYOND = 5  # cells by which a picture extends past its edges: as many standard deviations


class Ridge(NamedTuple):
    """weight exp(-(n . q - crest)^2 / 2 width^2), with the unit normal n."""

    weight: float
    n_x: float
    n_y: float
    crest: float
    width: float


class Peak(NamedTuple):
    """weight exp(-|M (q - center)|^2 / 2), M the matrix of xx, xy; yx, yy."""

    weight: float
    x: float
    y: float
    xx: float
    xy: float
    yx: float
    yy: float


class Gaussians(NamedTuple):
    """A density as a constant and Gaussian terms, whose weights may be negative.

    Attributes:
        uniform: the constant.
        ridges: fields of `Ridge` (F, 5).
        peaks: fields of `Peak` (F, 7).
    """

    uniform: float
    ridges: Array
    peaks: Array


class Density(NamedTuple):
    """A density over the stage.

    Attributes:
        phi: from x and y [m], arrays of one shape, to values >= 0 of that shape; only ratios of values matter.
        scale: standard deviation [m], the length over which it changes; infinite for a constant.
        gaussians: the same as a sum of Gaussians, for line integrals; None if there is none of a few terms.
    """

    phi: Callable[[Array, Array], Array]
    scale: float
    gaussians: Gaussians | None = None


@lru_cache(maxsize=8)  # a law needs its density in every period
def density_of(density: AnyDensity, stage: Stage) -> Density:
    """Return the density of a scene."""
    match density:
        case Uniform():
            return Density(lambda x, _: np.ones_like(x), np.inf, _terms(uniform=1.0))
        case Gaussian():
            return _gaussian(density)
        case Boundary():
            return _boundary(density, stage)
        case Image():
            return _image(density, stage)
        case Sum():  # pragma: no branch - there is no other
            return _sum(density, stage)


def _terms(uniform: float = 0.0, ridges: Sequence[Ridge] = (), peaks: Sequence[Peak] = ()) -> Gaussians:
    return Gaussians(uniform, np.array(ridges).reshape(-1, 5), np.array(peaks).reshape(-1, 7))


def _gaussian(density: Gaussian) -> Density:
    """exp(-|q - center|^2 / 2 sigma^2), the density of anger."""
    factor, x_0, y_0 = -0.5 / density.sigma**2, density.centre.x, density.centre.y
    peak = Peak(1.0, x_0, y_0, 1 / density.sigma, 0.0, 0.0, 1 / density.sigma)
    return Density(lambda x, y: np.exp(factor * ((x - x_0) ** 2 + (y - y_0) ** 2)), density.sigma, _terms(peaks=[peak]))


def _boundary(density: Boundary, stage: Stage) -> Density:
    """1 - prod (1 - g) over the edges, g = exp(-(d - inset)^2 / 2 width^2), d the distance from the edge: disgust's.

    It is 1 along all crests, corners included. A sum of the ridges would be twice as dense in corners; the distance
    from the nearest edge has creases where two edges are equally near. The paper draws the density, on a rectangle,
    without a formula (Fig. 16b).
    """
    factor = -0.5 / density.width**2
    crests = [(edge.x, edge.y, edge.offset - density.inset) for edge in stage.edges]

    def phi(x: Array, y: Array) -> Array:
        total = np.zeros_like(x)
        for n_x, n_y, crest in crests:
            total = total + (1 - total) * np.exp(factor * (n_x * x + n_y * y - crest) ** 2)
        return total

    return Density(phi, density.width, _products(crests, density.width))


def _products(crests: Sequence[tuple[float, float, float]], width: float) -> Gaussians | None:
    """Return 1 - prod (1 - g) of ridges g as a sum over subsets of them; None for more than `_MAX_TERMS`.

    The product of ridges is a Gaussian again: a ridge for parallel edges, else a peak. Products that are negligible
    beside their factors are left out.
    """
    ridges: list[Ridge] = []
    peaks: list[Peak] = []
    subsets: list[tuple[int, ...]] = [(i,) for i in range(len(crests))]
    for subset in subsets:
        if len(subsets) > _MAX_TERMS:
            return None
        sign = (-1.0) ** (len(subset) + 1)
        term = _product([crests[i] for i in subset], width, sign)
        if abs(term.weight) < _NEGLIGIBLE:
            continue
        if isinstance(term, Ridge):
            ridges.append(term)
        else:
            peaks.append(term)
        subsets += [(*subset, i) for i in range(subset[-1] + 1, len(crests))]
    return _terms(0.0, ridges, peaks)


def _product(crests: Sequence[tuple[float, float, float]], width: float, sign: float) -> Ridge | Peak:
    """Return the product of ridges: with A = sum n n^T, its exponent is -(q - c)^T A (q - c) / 2 width^2 - const."""
    (n_x, n_y, _), count = crests[0], len(crests)
    a, b = sum(x * x for x, _, _ in crests), sum(x * y for x, y, _ in crests)
    c = sum(y * y for _, y, _ in crests)
    if a * c - b * b < _PARALLEL:
        # All along one axis: normals with, or against, the first.
        along = [(crest if n_x * x + n_y * y > 0 else -crest) for x, y, crest in crests]
        middle = sum(along) / count
        spread = sum((crest - middle) ** 2 for crest in along)
        return Ridge(sign * float(np.exp(-0.5 * spread / width**2)), n_x, n_y, middle, width / count**0.5)
    p, q = sum(x * crest for x, _, crest in crests), sum(y * crest for _, y, crest in crests)
    x_0, y_0 = (c * p - b * q) / (a * c - b * b), (a * q - b * p) / (a * c - b * b)
    spread = sum((x * x_0 + y * y_0 - crest) ** 2 for x, y, crest in crests)
    weight, root = sign * float(np.exp(-0.5 * spread / width**2)), a**0.5
    return Peak(weight, x_0, y_0, root / width, b / root / width, 0.0, ((c - b * b / a) ** 0.5) / width)


def _sum(density: Sum, stage: Stage) -> Density:
    parts = [(part.weight, density_of(part.density, stage)) for part in density.parts]

    def phi(x: Array, y: Array) -> Array:
        return sum((weight * part.phi(x, y) for weight, part in parts), np.zeros_like(x))

    found = [(weight, part.gaussians) for weight, part in parts]
    scale, gaussians = min(part.scale for _, part in parts), None
    if all(part is not None for _, part in found):
        gaussians = Gaussians(
            sum(weight * part.uniform for weight, part in found if part),
            np.concatenate([part.ridges * ([weight] + 4 * [1]) for weight, part in found if part]),
            np.concatenate([part.peaks * ([weight] + 6 * [1]) for weight, part in found if part]),
        )
    return Density(phi, scale, gaussians)


@lru_cache(maxsize=8)  # a law needs its density in every period
def _image(density: Image, stage: Stage) -> Density:
    """A picture over the upright rectangle around the stage, 1 where it is black and 0 where it is white, smoothed."""
    weights, x_peaks, y_peaks = picture_peaks(density, stage)
    factor = -0.5 / density.smoothing**2

    def phi(x: Array, y: Array) -> Array:
        along_x = np.exp(factor * (x.reshape(-1, 1) - x_peaks) ** 2)
        along_y = np.exp(factor * (y.reshape(-1, 1) - y_peaks) ** 2)
        # In a fixed order; products by BLAS differ between processors.
        return np.sum(np.einsum("kx,xy->ky", along_x, weights) * along_y, axis=1).reshape(x.shape)

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
    dark = 1 - grey[::-1].T / 255  # x, then y upward
    columns, rows = (int(np.ceil(extent / density.smoothing)) for extent in (right - left, top - bottom))
    across = np.einsum("cx,xy->cy", _averaging(columns, picture.width), dark)
    cells = np.einsum("cy,ry->cr", across, _averaging(rows, picture.height))
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
