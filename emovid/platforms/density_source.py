"""A density as Python source, for scripts that run without emovid."""

from typing import NamedTuple

import numpy as np

from emovid.scene.behaviour import AnyDensity, Boundary, Gaussian, Image, Sum, Uniform
from emovid.scene.stage import Stage
from emovid.swarm.arrays import Array
from emovid.swarm.densities import density_of, picture_peaks

_LEAST_NODES, _MOST_NODES = 6, 24


class Source(NamedTuple):
    """A density as source.

    Attributes:
        expression: of x and y, arrays of one shape, and of a list EDGES of (n_x, n_y, offset).
        tables: assignments and functions that it needs, as lines.
    """

    expression: str
    tables: tuple[str, ...] = ()


def density_source(density: AnyDensity, stage: Stage) -> Source:
    """Return the source of a density, as `densities.density_of` has it."""
    return _source(density, stage, "PICTURE")


def nodes_for(density: AnyDensity, stage: Stage) -> int:
    """Return how many of Gauss's nodes along an edge of a cell suffice: more for densities that change over less."""
    left, bottom, right, top = stage.box
    across = np.hypot(right - left, top - bottom) / density_of(density, stage).scale
    return int(np.clip(np.ceil(_LEAST_NODES + across / 2), _LEAST_NODES, _MOST_NODES))


def _source(density: AnyDensity, stage: Stage, name: str) -> Source:
    match density:
        case Uniform():
            return Source("np.ones_like(x)")
        case Gaussian():
            square = f"(x - {density.centre.x!r}) ** 2 + (y - {density.centre.y!r}) ** 2"
            return Source(f"np.exp(-({square}) / {2 * density.sigma**2!r})")
        case Boundary():
            square = f"(offset - {density.inset!r} - n_x * x - n_y * y) ** 2"
            return Source(f"sum(np.exp(-({square}) / {2 * density.width**2!r}) for n_x, n_y, offset in EDGES)")
        case Image():
            return _picture(density, stage, name)
        case Sum():  # pragma: no branch - there is no other
            parts = [_source(part.density, stage, f"{name}_{i}") for i, part in enumerate(density.parts, start=1)]
            weights = [part.weight for part in density.parts]
            terms = [f"{weight!r} * {part.expression}" for weight, part in zip(weights, parts, strict=True)]
            tables = tuple(table for part in parts for table in part.tables)
            return Source("(\n    " + "\n    + ".join(terms) + "\n)", tables)


def _picture(density: Image, stage: Stage, name: str) -> Source:
    """A grid of peaks: see `densities.picture_peaks`."""
    weights, x_peaks, y_peaks = picture_peaks(density, stage)
    rows = "".join(f"        [{_numbers(row)}],\n" for row in weights)
    factor = -0.5 / density.smoothing**2
    tables = (
        f"{name} = np.array(\n    [  # heights of the peaks that a picture is made of, by x and then y\n{rows}    ]\n)",
        *(
            f"{name}_{axis} = np.linspace({float(peaks[0])!r}, {float(peaks[-1])!r}, {len(peaks)})"
            for axis, peaks in (("X", x_peaks), ("Y", y_peaks))
        ),
    )
    along_x = f"np.exp({factor!r} * (x.reshape(-1, 1) - {name}_X) ** 2)"
    along_y = f"np.exp({factor!r} * (y.reshape(-1, 1) - {name}_Y) ** 2)"
    return Source(f"np.sum({along_x} @ {name} * {along_y}, axis=1).reshape(x.shape)", tables)


def _numbers(row: Array) -> str:
    return ", ".join(f"{value:.4g}" for value in row.tolist())
