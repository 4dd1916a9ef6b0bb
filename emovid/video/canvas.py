"""A picture that matplotlib's Agg draws into one buffer, with a record of the parts that have changed.

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
Box = tuple[int, int, int, int]  # first row, row after the last, first column, column after the last

_EDGES = 8  # of a line that share a box: fewer take more time, more cover pixels that the line does not touch
_BLUR = 1  # pixels outside an outline that anti-aliasing may touch
_AS_IS, _NONE, _NO_TURNS, _NO_PLACES = IdentityTransform(), np.empty((0, 4)), np.empty((0, 3, 3)), np.empty((0, 2))


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
        self._whole: Box = (0, height, 0, width)
        self._covered: list[Box] = []  # parts in which the picture is not the background
        self._changed: list[Box] = [self._whole]

    def stamp(self, layers: Sequence[Layer], turns: Array, places: Array, reach: float) -> None:
        """Draw outlines at several places, layer by layer.

        Args:
            layers: the first at the bottom.
            turns: rotation and scale (N, 3, 3) from the outlines' units to pixels.
            places: positions of their origins (N, 2).
            reach: largest distance of an outline from its origin [pixels].
        """
        self._cover(places - reach, places + reach)
        for layer in layers:
            self._collection([layer.path], layer.face, _NONE, 0.0, turns, places)

    def lines(self, lines: Sequence[Array], colours: Array, width: float) -> None:
        """Draw open lines, each (P, 2) with P > 1, one over the other, with round joins and caps.

        Args:
            lines: at least one.
            colours: (1, 4), or one for each line.
            width: [pixels].
        """
        points = np.concatenate(lines)
        low, high = np.minimum(points[:-1], points[1:]), np.maximum(points[:-1], points[1:])
        starts: list[int] = []  # of groups of edges
        ours: list[bool] = []  # whether they belong to a line, and not to the gap from one line to the next
        first = 0
        for line in lines:
            last = first + len(line) - 1
            groups = range(first, last, _EDGES)
            starts += [*groups, last]
            ours += [*(True for _ in groups), False]
            first = last + 1
        real, reach = np.array(ours[:-1]), width / 2
        low, high = np.minimum.reduceat(low, starts[:-1])[real], np.maximum.reduceat(high, starts[:-1])[real]
        self._cover(low - reach, high + reach)
        self._collection([Path(line) for line in lines], _NONE, colours, width)

    def polygon(self, corners: Array, face: str, edge: str, width: float) -> None:
        """Draw a polygon (C, 2) with a line of `width` [pixels] around it, all of it outside."""
        outline = Path(np.concatenate([corners, corners[:1]]), closed=True)
        self._cover(corners.min(axis=0)[None] - width, corners.max(axis=0)[None] + width)
        self._collection([outline], _NONE, rgba([edge]), 2 * width)
        self._collection([outline], rgba([face]), _NONE, 0.0)

    def fill(self, outlines: Sequence[Path], colours: Array, low: Array, high: Array) -> None:
        """Fill outlines [pixels], one over the other.

        Args:
            outlines: at least one.
            colours: (1, 4), or one for each outline.
            low: lower left corners of boxes (B, 2) that together hold them [pixels].
            high: their upper right corners.
        """
        self._cover(low, high)
        self._collection(outlines, colours, _NONE, 0.0)

    def restore(self) -> None:
        """Bring back the background wherever something covers it."""
        for top, bottom, left, right in self._covered:
            self.pixels[top:bottom, left:right] = self._background[top:bottom, left:right]
        self._changed += self._covered
        self._covered = []

    def keep(self) -> None:
        """Make the picture the background."""
        for top, bottom, left, right in self._covered:
            self._background[top:bottom, left:right] = self.pixels[top:bottom, left:right]
        self._changed += self._covered
        self._covered = []

    def replace(self, picture: Pixels) -> None:
        """Make `picture` the background and the picture."""
        np.copyto(self._background, picture)
        np.copyto(self.pixels, picture)
        self._covered, self._changed = [], [self._whole]

    def changed(self) -> list[Box]:
        """Return boxes that hold all pixels changed since the last call; they may overlap."""
        boxes = self._compact(self._changed + self._covered)
        self._changed = []
        return boxes

    def _cover(self, low: Array, high: Array) -> None:
        """Record a drawing inside the rectangles from `low` (B, 2) to `high` (B, 2)."""
        _, height, _, width = self._whole
        left, bottom = np.clip(np.floor(low) - _BLUR, 0, [width, height]).astype(int).T
        right, top = np.clip(np.ceil(high) + _BLUR, 0, [width, height]).astype(int).T
        boxes = zip((height - top).tolist(), (height - bottom).tolist(), left.tolist(), right.tolist(), strict=True)
        self._covered = self._compact([*self._covered, *boxes])

    def _compact(self, boxes: list[Box]) -> list[Box]:
        """Return the boxes, or the whole picture where they would take more work."""
        area = sum((bottom - top) * (right - left) for top, bottom, left, right in boxes)
        _, height, _, width = self._whole
        return [self._whole] if 2 * area > height * width else boxes

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
