"""Integrals of Gaussian densities over Voronoi cells, as closed line integrals round the cells (Green's theorem).

A ridge changes along one axis: with u across it in standard deviations, v along it, and phi = exp(-u^2 / 2),

    mass = -loop of v phi du,   moments = -loop of v u phi du  and  -loop of v^2 / 2 phi du.

A peak is exp(-r^2 / 2), r in standard deviations from its center. For an edge q + t d, t from 0 to 1, and c = q x d,

    mass = sum of c times the integral of (near - exp(-r^2 / 2)) / r^2 dt,
    moment = i times the sum of d times the integral of exp(-r^2 / 2) dt,

with near = 1 for cells near the center and 0 for others: since the integral of c / r^2 dt is the angle of the edge seen
from the center, and the angles of a cell without the center add up to 0, cells far out in a tail keep their digits.

Each border between two cells is integrated once. An edge counts where the density is not negligible, with a Gauss rule
of an order that follows from the change of log phi along it. All sums have a fixed order, without matrix products:
coverage is chaotic, and the kernel of a matrix product must not decide where a swarm goes.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from emovid.swarm.arrays import Array, Complex, Indices
from emovid.swarm.densities import Gaussians
from emovid.swarm.voronoi import Fans

# Nodes of a rule, and the largest measure of an edge for which it is exact to 1e-7 of the edge's integral, the worst of
# 12 000 random edges: the change of log phi plus an eighth of the squared length in standard deviations. What counts of
# an edge measures 40 at most.
_NODES = (4, 6, 8, 10, 12, 16, 20, 24, 32)
_LIMITS = np.array([0.3, 1.25, 3.8, 5.9, 8.8, 14.3, 20.5, 30.0])
_NEGLIGIBLE = 20.0  # exponents below the largest on a cell: 2e-9 of its density
_NEAR = 2.0  # standard deviations from a peak
_NO_ANGLE = 1e-9  # rad: rounding


_Places = tuple[Complex, Complex, Array, Array]


class _Edges(NamedTuple):
    """Borders of two cells, and edges of the stage, each once; `right` is of the borders only, which come first.

    Attributes:
        left, right: the cells (E,) and (B,).
        begin, side: of an edge (E,) [m], counter-clockwise round its left cell.
    """

    left: Indices
    right: Indices
    begin: Complex
    side: Complex


class _Clipped(NamedTuple):
    """The parts of edges (P,) where a term of the density is not negligible, in its standard deviations.

    Attributes:
        term, edge: of each pair (P,).
        begin, side: of the whole edge; across a ridge, these have no imaginary part.
        first, last: places on the edge, from 0 to 1, where the part begins and ends.
        closest: distance from the crest or center.
    """

    term: Indices
    edge: Indices
    begin: Complex
    side: Complex
    first: Array
    last: Array
    closest: Array


def line_integrals(fans: Fans, density: Gaussians) -> tuple[Array, Complex]:
    """Return the mass of each cell (cells,) and its first moment about the robot (cells,)."""
    cells, borders = len(fans.robot), fans.borders
    once = np.concatenate([np.arange(borders), np.arange(2 * borders, len(fans.cell))])
    left, right = fans.cell[once], fans.cell[borders : 2 * borders]
    begin, side = fans.robot[left] + fans.a[once], (fans.b - fans.a)[once]
    edges = _Edges(left, right, begin, side)
    mass, moment = np.zeros(cells), np.zeros(cells, dtype=complex)
    if density.uniform:  # a triangle's centroid is the mean of its corners
        area = density.uniform / 2 * (fans.a.conj() * fans.b).imag
        mass += np.bincount(fans.cell, area, cells)
        arm = area / 3 * (fans.a + fans.b)
        moment += _complex_sums(fans.cell, arm, cells)
    families = [(family, add) for family, add in ((density.ridges, _ridges), (density.peaks, _peaks)) if len(family)]
    if not families:
        return mass, moment
    places = [_standardized(family.T[..., None], edges) for family, _ in families]
    least = np.full(cells, np.inf)  # exponent on each cell
    for (family, _), (*_, closest) in zip(families, places, strict=True):
        exponent = (closest**2 / 2 - np.log(np.abs(family[:, :1]))).min(axis=0)
        np.minimum.at(least, left, exponent)
        np.minimum.at(least, right, exponent[:borders])
    limit = least[left]
    limit[:borders] = np.maximum(limit[:borders], least[right])
    for (family, integrals), place in zip(families, places, strict=True):
        square = 2 * (limit + _NEGLIGIBLE + np.log(np.abs(family[:, :1])))
        added = integrals(family.T, edges, place, _clipped(place, np.sqrt(np.maximum(square, 0.0))), cells)
        mass += added[0]
        moment += added[1] - added[0] * fans.robot
    return mass, moment


def _standardized(terms: Array, edges: _Edges) -> _Places:
    """Return begin, side, place of the closest point and its distance (F, E) in terms (fields, F, 1)."""
    if len(terms) == 5:
        _, n_x, n_y, crest, width = terms
        begin = (n_x * edges.begin.real + n_y * edges.begin.imag - crest) / width + 0j
        side = (n_x * edges.side.real + n_y * edges.side.imag) / width + 0j
    else:
        _, x_0, y_0, xx, xy, yx, yy = terms
        x, y = edges.begin.real - x_0, edges.begin.imag - y_0
        begin = xx * x + xy * y + 1j * (yx * x + yy * y)
        side = xx * edges.side.real + xy * edges.side.imag + 1j * (yx * edges.side.real + yy * edges.side.imag)
    square = side.real**2 + side.imag**2
    foot = -(begin.real * side.real + begin.imag * side.imag) / np.where(square > 0, square, 1.0)
    foot = np.minimum(np.maximum(foot, 0.0), 1.0)
    return begin, side, foot, np.abs(begin + foot * side)


def _clipped(place: _Places, reach: Array) -> _Clipped:
    """Return the parts of the edges within `reach` (F, E) of each term."""
    term, edge = np.nonzero(place[3] < reach)
    begin, side = place[0][term, edge], place[1][term, edge]
    foot, closest = place[2][term, edge], place[3][term, edge]
    square = side.real**2 + side.imag**2
    toward = begin.real * side.real + begin.imag * side.imag
    # |begin + t side| = reach at t = (-toward -+ root) / square.
    root = np.sqrt(np.maximum(toward**2 - square * (begin.real**2 + begin.imag**2 - reach[term, edge] ** 2), 0.0))
    square = np.where(square > 0, square, 1.0)
    endless = side == 0
    first = np.where(endless, 0.0, np.minimum(np.maximum((-toward - root) / square, 0.0), foot))
    last = np.where(endless, 1.0, np.maximum(np.minimum((-toward + root) / square, 1.0), foot))
    return _Clipped(term, edge, begin, side, first, last, closest)


def _ridges(ridges: Array, edges: _Edges, _: _Places, part: _Clipped, cells: int) -> tuple[Array, Complex]:
    """Return masses and moments about the origin of all cells, of ridges (fields, F)."""
    weight, n_x, n_y, crest, width = ridges[:, part.term]
    axis = n_x + 1j * n_y  # across the ridge; i times it is along
    along, dv = ((axis.conj() * values[part.edge]).imag for values in (edges.begin, edges.side))
    pair, t, dt = _nodes(part)
    u, v = part.begin.real[pair] + t * part.side.real[pair], along[pair] + t * dv[pair]
    value = -dt * v * np.exp(-0.5 * u * u)
    scale = weight * width * part.side.real
    mass, across, sideways = (
        scale * np.bincount(pair, values, len(scale)) for values in (value, value * u, value * v / 2)
    )
    return _by_cell(edges, part.edge, mass, axis * (mass * crest + width * across + 1j * sideways), cells)


def _peaks(peaks: Array, edges: _Edges, places: _Places, part: _Clipped, cells: int) -> tuple[Array, Complex]:
    """Return masses and moments about the origin of all cells, of peaks (fields, F)."""
    weight, x, y, xx, xy, yx, yy = peaks[:, part.term]
    pair, t, dt = _nodes(part)
    place_x = part.begin.real[pair] + t * part.side.real[pair]
    place_y = part.begin.imag[pair] + t * part.side.imag[pair]
    square = place_x**2 + place_y**2
    tail = np.exp(-0.5 * square)
    near = part.closest < _NEAR
    share = np.where(near[pair], -np.expm1(-0.5 * square), -tail) / np.where(square > 0, square, 1.0)
    cross = _cross(part.begin, part.side)
    mass = cross * np.bincount(pair, dt * share, len(cross))
    first, last = (part.begin + place * part.side for place in (part.first, part.last))
    angle = np.arctan2(cross * (part.last - part.first), first.real * last.real + first.imag * last.imag)
    determinant = xx * yy - xy * yx  # of areas in standard deviations; below 0 they are mirrored
    scale = weight / determinant
    mass = scale * np.where(near, mass - angle, mass)
    push = scale / determinant * np.bincount(pair, dt * tail, len(cross))
    a, b = -part.side.imag, part.side.real  # i times the side; and the inverse of the matrix
    moment = mass * (x + 1j * y) + push * ((yy * a - xy * b) + 1j * (xx * b - yx * a))
    mass, moment = _by_cell(edges, part.edge, mass, moment, cells)
    turned = _angles(edges, places, cells)
    term, cell = np.nonzero(turned)
    weight, x, y, xx, xy, yx, yy = peaks[:, term]
    whole = turned[term, cell] * weight / (xx * yy - xy * yx)
    return mass + np.bincount(cell, whole, cells), moment + _complex_sums(cell, whole * (x + 1j * y), cells)


def _angles(edges: _Edges, places: _Places, cells: int) -> Array:
    """Return the angle (F, cells) [rad] that a cell fills around the center of each peak: 0 for all but one, if any."""
    begin, side, *_ = places
    end = begin + side
    angle = np.arctan2(_cross(begin, side), begin.real * end.real + begin.imag * end.imag)
    total = np.zeros((len(begin), cells))
    borders = len(edges.right)
    np.add.at(total.T, edges.left, angle.T)
    np.subtract.at(total.T, edges.right, angle.T[:borders])
    return np.where(np.abs(total) < _NO_ANGLE, 0.0, total)


def _cross(a: Complex, b: Complex) -> Array:
    """Return the cross products, 0.0 and never -0.0: the sign decides which cell a center on an edge belongs to."""
    return a.real * b.imag - a.imag * b.real + 0.0


def _by_cell(edges: _Edges, edge: Indices, mass: Array, moment: Complex, cells: int) -> tuple[Array, Complex]:
    """Return the sums over cells of what edges give to the cells on their left, and take from those on their right."""
    border = np.flatnonzero(edge < len(edges.right))
    left, right = edges.left[edge], edges.right[edge[border]]

    def total(values: Array) -> Array:
        return np.bincount(left, values, cells).astype(float) - np.bincount(right, values[border], cells)

    return total(mass), total(moment.real) + 1j * total(moment.imag)


def _complex_sums(cell: Indices, values: Complex, cells: int) -> Complex:
    return np.bincount(cell, values.real, cells) + 1j * np.bincount(cell, values.imag, cells)


def _nodes(part: _Clipped) -> tuple[Indices, Array, Array]:
    """Return for all nodes of all parts (P,): the pair, the place on its edge from 0 to 1, and the weight."""
    length = part.last - part.first
    square = part.side.real**2 + part.side.imag**2
    ends = [np.abs(part.begin + place * part.side) for place in (part.first, part.last)]
    measure = (np.maximum(*ends) ** 2 - part.closest**2) / 2 + square * length**2 / 8
    rule = np.searchsorted(_LIMITS, measure)
    places, weights, first, counts = _rules()
    count = counts[rule]
    pair = np.repeat(np.arange(len(rule)), count)
    node = np.arange(len(pair)) + (first[rule] - np.cumsum(count) + count)[pair]
    stretch = length[pair]
    return pair, part.first[pair] + stretch * places[node], stretch * weights[node]


@cache
def _rules() -> tuple[Array, Array, Indices, Indices]:
    """Return the nodes of all rules from 0 to 1, their weights, and the first node of each rule and their number."""
    rules = [np.polynomial.legendre.leggauss(nodes) for nodes in _NODES]
    places, weights = (np.concatenate([rule[k] for rule in rules]) / 2 for k in (0, 1))
    counts = np.array(_NODES)
    return places + 0.5, weights, np.cumsum(counts) - counts, counts
