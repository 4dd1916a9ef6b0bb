"""Pictures of at most 256 colours, as a GIF has."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from emovid.video.canvas import Box, Pixels

Colours24 = NDArray[np.uint32]  # red + 2^8 green + 2^16 blue

COLOURS = 255  # of the 256 in a palette: GIF needs one for pixels that stay as they are
_RGB = 0xFFFFFF


class Indexed:
    """Indices of colours that follow a picture.

    Args:
        width, height: of the picture [pixels].
        colours: to choose from (C,), at most 256.

    Attributes:
        data: as ffmpeg's pal8: the index of each pixel, that of the nearest colour in RGB, row by row; and 256 colours
            BGRA.
    """

    def __init__(self, width: int, height: int, colours: Colours24) -> None:
        size = width * height
        self.data: Pixels = np.zeros(size + 4 * 256, np.uint8)
        self._index = self.data[:size].reshape(height, width)
        self._colours = _channels(colours)
        self.data[size:].reshape(256, 4)[: len(colours)] = np.insert(self._colours[:, ::-1], 3, 255, axis=1)
        self._nearest = np.full(_RGB + 1, -1, np.int16)  # of each colour that was met, the index

    def convert(self, picture: Pixels, changed: Iterable[Box]) -> Pixels:
        """Return the data of `picture` (height, width, 4), which differs within the boxes `changed` from the last."""
        packed = picture.view(np.uint32)[..., 0] & _RGB
        for top, bottom, left, right in changed:
            part = packed[top:bottom, left:right]
            known = self._nearest[part] >= 0
            if not known.all():
                new = np.unique(part[~known])
                self._nearest[new] = _nearest(_channels(new), self._colours)
            self._index[top:bottom, left:right] = self._nearest[part]
        return self.data


def frequent_colours(pictures: Iterable[Pixels]) -> Colours24:
    """Return the colours that most pixels of the pictures (height, width, 4) have, at most `COLOURS`."""
    found = [np.unique(picture.view(np.uint32) & _RGB, return_counts=True) for picture in pictures]
    colours, place = np.unique(np.concatenate([colours for colours, _ in found]), return_inverse=True)
    counts = np.bincount(place, np.concatenate([counts for _, counts in found]))
    return colours[np.argsort(-counts, kind="stable")[:COLOURS]]


def _channels(colours: Colours24) -> NDArray[np.int32]:
    return (colours[:, None] >> np.array([0, 8, 16], np.uint32) & 0xFF).astype(np.int32)


def _nearest(wanted: NDArray[np.int32], colours: NDArray[np.int32]) -> NDArray[np.int16]:
    """Return the index (N,) of the colour (C, 3) nearest to each one wanted (N, 3)."""
    index = np.empty(len(wanted), np.int16)
    for first in range(0, len(wanted), 4096):  # a table of all distances could be large
        part = wanted[first : first + 4096, None]
        index[first : first + 4096] = ((part - colours) ** 2).sum(axis=-1).argmin(axis=1)
    return index
