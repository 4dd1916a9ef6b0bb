"""A picture that matplotlib's Agg draws into one buffer, and the pixels that differ from the picture before.

Everything goes through `draw_path_collection`: unlike markers it does not snap to whole pixels, which would make slow
robots jerk, and unlike lines it neither simplifies paths nor reads the user's matplotlibrc.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_rgba
from matplotlib.path import Path
from matplotlib.transforms import IdentityTransform
from numpy.typing import NDArray

from emovid.swarm.arrays import Array

Pixels = NDArray[np.uint8]

_AS_IS, _NONE, _NO_TURNS, _NO_PLACES = IdentityTransform(), np.empty((0, 4)), np.empty((0, 3, 3)), np.empty((0, 2))


class Change(NamedTuple):
    """The pixels in which two pictures of one size differ.

    Attributes:
        where: index of each such pixel, row by row (P,).
        pixels: the new pixels (P,): red + 2^8 green + 2^16 blue + 2^24 alpha.
    """

    where: NDArray[np.intp]
    pixels: NDArray[np.uint32]


class Layer(NamedTuple):
    """An outline and its filling.

    Attributes:
        path: the outline, in units of its own.
        face: colors (1, 4) or one for each place (N, 4), RGBA from 0 to 1.
    """

    path: Path
    face: Array


class Canvas:
    """A picture with a background.

    Drawings cover the background until `restore` brings it back; `keep` makes them part of the background. Positions
    are in pixels from the lower left corner, y upward.

    Args:
        width, height: picture size [pixels].
        colour: of the background.

    Attributes:
        pixels: the picture (height, width, 4): RGBA, row 0 on top.
    """

    def __init__(self, width: int, height: int, colour: str) -> None:
        # At 72 dots per inch a point is a pixel. Any: matplotlib's stubs lack some arguments of its Agg renderer.
        agg: Any = RendererAgg
        self._renderer = agg(width, height, 72)
        self._style = self._renderer.new_gc()
        self._style.set_snap(False)
        self._style.set_antialiased(True)
        self._style.set_capstyle("round")
        self._style.set_joinstyle("round")
        self.pixels: Pixels = np.asarray(self._renderer.buffer_rgba())
        self.pixels[:] = np.round(255 * np.array(to_rgba(colour)))
        self._background = self.pixels.copy()
        self._flat = self.pixels.reshape(-1).view("<u4")
        self._last = ~self._flat  # differs everywhere

    def stamp(self, layers: Sequence[Layer], turns: Array, places: Array) -> None:
        """Draw outlines at several places, layer by layer.

        Args:
            layers: the first at the bottom.
            turns: rotation and scale (N, 3, 3) from the outlines' units to pixels.
            places: positions of their origins (N, 2).
        """
        for layer in layers:
            self._collection([layer.path], layer.face, _NONE, 0.0, turns, places)

    def lines(self, lines: Sequence[Array], colours: Array, width: float) -> None:
        """Draw open lines, each (P, 2) with P > 1, one over the other, with round joins and caps.

        Args:
            lines: at least one.
            colours: (1, 4), or one for each line.
            width: [pixels].
        """
        self.strokes([Path(line) for line in lines], colours, width)

    def polygon(self, corners: Array, face: str, edge: str, width: float) -> None:
        """Draw a polygon (C, 2) with a line of `width` [pixels] around it, all of it outside."""
        outline = Path(np.concatenate([corners, corners[:1]]), closed=True)
        self._collection([outline], _NONE, rgba([edge]), 2 * width)
        self._collection([outline], rgba([face]), _NONE, 0.0)

    def strokes(self, paths: Sequence[Path], colours: Array, width: float) -> None:
        """Draw paths [pixels] as `lines` does its lines."""
        self._collection(paths, _NONE, colours, width)

    def fill(self, outlines: Sequence[Path], colours: Array) -> None:
        """Fill outlines [pixels], at least one, one over the other; colors are (1, 4), or one for each outline."""
        self._collection(outlines, colours, _NONE, 0.0)

    def restore(self) -> None:
        """Bring back the background."""
        np.copyto(self.pixels, self._background)

    def keep(self) -> None:
        """Make the picture the background."""
        np.copyto(self._background, self.pixels)

    def replace(self, picture: Pixels) -> None:
        """Make `picture` the background and the picture."""
        np.copyto(self._background, picture)
        np.copyto(self.pixels, picture)

    def changed(self) -> Change:
        """Return the pixels changed since the last call, at the first call all."""
        where = np.flatnonzero(self._flat != self._last)
        pixels = self._flat[where]
        self._last[where] = pixels
        return Change(where, pixels)

    def _collection(
        self,
        paths: Sequence[Path],
        face: Array,
        edge: Array,
        width: float,
        turns: Array = _NO_TURNS,
        places: Array = _NO_PLACES,
    ) -> None:
        """Draw paths, anti-aliased at sub-pixel positions, with round joins and caps."""
        self._renderer.draw_path_collection(
            self._style,
            _AS_IS,
            paths,
            turns,
            places,
            _AS_IS,
            face,
            edge,
            np.array([width]),
            [(0, None)],
            np.array([True]),
            None,
            "screen",
        )


def rgba(colours: Sequence[str]) -> Array:
    """Return colors as (N, 4), RGBA from 0 to 1."""
    return np.array([to_rgba(colour) for colour in colours])
