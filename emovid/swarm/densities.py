"""The densities phi of fear, disgust and anger (Appendix A, Fig. 16): plain functions of points.

Each is smooth inside the stage, so that its integrals over Voronoi cells converge fast.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from emovid.scene.behaviour import Boundary, Gaussian, Uniform
from emovid.scene.model import Stage
from emovid.swarm.arrays import Array


class Density(NamedTuple):
    """A density over the stage.

    Attributes:
        phi: from x and y [m], arrays of one shape, to values >= 0 of that shape; only ratios of values matter.
        scale: the length [m] over which it changes, a standard deviation; infinite for a constant.
    """

    phi: Callable[[Array, Array], Array]
    scale: float


def density_of(density: Uniform | Boundary | Gaussian, stage: Stage) -> Density:
    """Return the density that a scene names."""
    match density:
        case Uniform():
            return Density(lambda x, _: np.ones_like(x), np.inf)
        case Gaussian():
            return _gaussian(density)
        case Boundary():
            return _boundary(density, stage)


def _gaussian(density: Gaussian) -> Density:
    """exp(-|q - centre|^2 / 2 sigma^2), the density of anger."""
    factor, x_0, y_0 = -0.5 / density.sigma**2, density.centre.x, density.centre.y
    return Density(lambda x, y: np.exp(factor * ((x - x_0) ** 2 + (y - y_0) ** 2)), density.sigma)


def _boundary(density: Boundary, stage: Stage) -> Density:
    """The sum over the four edges of exp(-(d - inset)^2 / 2 width^2), d the distance from the edge: disgust's.

    A sum, not the distance from the nearest edge, since that has creases along the diagonals. The paper draws the
    density without a formula (Fig. 16b).
    """
    factor = -0.5 / density.width**2
    x_crest, y_crest = stage.width / 2 - density.inset, stage.height / 2 - density.inset

    def phi(x: Array, y: Array) -> Array:
        ridges = ((x, x_crest), (x, -x_crest), (y, y_crest), (y, -y_crest))
        return sum((np.exp(factor * (along - crest) ** 2) for along, crest in ridges), np.zeros_like(x))

    return Density(phi, density.width)
