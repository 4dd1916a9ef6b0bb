"""Voronoi cells by cutting, slow and obvious: a cell is the stage, cut with the bisectors to the other robots.

Places and vectors are complex numbers, as in `voronoi`.
"""

import numpy as np

from emovid.swarm.arrays import Complex


def cut_cells(robots: Complex, outline: Complex) -> list[Complex]:
    """Return the corners of each robot's cell [m] from the robot, counter-clockwise.

    Args:
        robots: (N,) [m], no two at one place.
        outline: corners of the convex stage (C,) [m], counter-clockwise.
    """
    return [_cut_cell(robots - robot, outline - robot) for robot in robots]


def _cut_cell(others: Complex, cell: Complex) -> Complex:
    """Cut with the bisectors to the others, nearest first, until they are twice as far as the farthest corner."""
    nearest_first = np.argsort(np.abs(others), kind="stable")[1:]  # the first is the robot itself
    for other in others[nearest_first]:
        if np.abs(other) >= 2 * np.max(np.abs(cell), initial=0.0):
            break
        cell = _cut(cell, other)
    return cell


def _cut(cell: Complex, other: complex) -> Complex:
    """Return the part of a convex polygon that is no nearer to `other` than to the origin."""
    beyond = (np.conj(other) * cell).real - abs(other) ** 2 / 2
    out = beyond > 0
    crossed = out != np.roll(out, -1)
    share = beyond / np.where(crossed, beyond - np.roll(beyond, -1), 1.0)
    crossing = cell + share * (np.roll(cell, -1) - cell)
    return np.stack([cell, crossing], axis=1)[np.stack([~out, crossed], axis=1)]
