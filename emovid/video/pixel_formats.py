"""From RGBA frames to the pixel formats of encoders, converted only where a frame has changed.

Y, U and V (yuv420p): a block of 2 x 2 pixels has four lumas and one pair of chromas. It is sixteen numbers in and six
out, by one linear map, so that a picture is a matrix product; and since no block depends on its neighbors, converting
some blocks gives the same result as converting all of them.

Luma is that of ITU-R BT.709-6, items 3.2 to 3.5, at 8 bits, to within half a level and a rounding; chroma is that of
the mean of the block. ffmpeg's own conversion gives the same luma to one level, and the same chroma where the color is
even; at edges it also weighs rows outside the block.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from emovid.video.canvas import Change, Pixels

Levels = NDArray[np.float32]
Colours24 = NDArray[np.uint32]  # red + 2^8 green + 2^16 blue

PALETTE_SIZE = 255  # of the 256 colors of a GIF: one is needed for pixels that do not change
_PARTS = 65536  # of a level: the maps' coefficients are multiples of 1 / 65536
_BATCH = 16384  # blocks converted at once: with their results they fit into the processor's cache
_RGB = 0xFFFFFF


class Yuv420:
    """Planes of Y, U and V that follow a picture.

    Args:
        width, height: picture size [pixels], both even.

    Attributes:
        planes: (3 / 2 width height,): Y (height, width), then U and V (height / 2, width / 2), as yuv420p; 16 to 235
            and 16 to 240.
    """

    def __init__(self, width: int, height: int) -> None:
        size = width * height
        self.planes: Pixels = np.zeros(size * 3 // 2, np.uint8)
        self._y = self.planes[:size].view(np.uint16)  # of two pixels side by side
        self._u, self._v = self.planes[size:].reshape(2, size // 4)
        self._stale = np.zeros(size // 4, dtype=bool)  # blocks to convert
        across, down = np.arange(width, dtype=np.int32) // 2, np.arange(height, dtype=np.int32) // 2
        self._block = (width // 2 * down[:, None] + across).reshape(-1)  # of each pixel
        # Indices of each block's upper and lower pair among all pairs: a row of blocks is two rows of pairs.
        rows = np.arange(size // 2).reshape(height // 2, 2, width // 2)
        self._pairs = np.stack([rows[:, 0].reshape(-1), rows[:, 1].reshape(-1)], axis=1)

    def convert(self, picture: Pixels, changed: Change) -> Pixels:
        """Return the planes of a picture (height, width, 4) that differs from the last one in changed pixels only."""
        self._stale[self._block[changed.where]] = True
        pairs = picture.reshape(-1).view(np.uint64)  # of pixels side by side, as in self._y
        blocks = np.flatnonzero(self._stale)
        for first in range(0, len(blocks), _BATCH):
            block = blocks[first : first + _BATCH]
            both = self._pairs.take(block, axis=0)
            luma, chroma = yuv_of_blocks(pairs[both].view(np.uint8))
            self._y[both] = luma.view(np.uint16)
            self._u[block], self._v[block] = chroma[:, 0], chroma[:, 1]
        self._stale[:] = False
        return self.planes


def yuv_of_blocks(blocks: Pixels) -> tuple[Pixels, Pixels]:
    """Return Y of the four pixels (B, 4), and U and V (B, 2), of blocks (B, 16): four times RGBA, row by row.

    All products and sums are multiples of 2^-16 below 2^8, which single precision holds exactly: the result does not
    depend on the order in which a processor adds them.
    """
    values = blocks.astype(np.float32)
    luma, chroma = values @ _LUMA, values @ _CHROMA
    luma += np.float32(16.5)  # black, and half a level for rounding
    chroma += np.float32(128.5)  # gray, likewise
    return luma.astype(np.uint8), chroma.astype(np.uint8)


def _block_maps() -> tuple[Levels, Levels]:
    """Return the maps to Y (16, 4) and to U and V (16, 2), rounded so that white has Y 235 and grays no chroma."""
    red, blue = 0.2126, 0.0722  # weights of the primaries in luma: BT.709
    weights = np.array([red, 1 - red - blue, blue])
    luma = np.round(_PARTS * 219 / 255 * weights)
    luma[1] += round(_PARTS * 219 / 255) - luma.sum()
    differences = np.stack([([0, 0, 1] - weights) / (2 - 2 * blue), ([1, 0, 0] - weights) / (2 - 2 * red)])
    chroma = np.round(_PARTS * 224 / 255 / 4 * differences)  # a quarter from each pixel
    chroma[:, 1] -= chroma.sum(axis=1)
    to_luma, to_chroma = np.zeros((4, 4, 4)), np.zeros((4, 4, 2))  # pixel, RGBA, result
    for pixel in range(4):
        to_luma[pixel, :3, pixel] = luma
        to_chroma[pixel, :3] = chroma.T
    return (to_luma.reshape(16, 4) / _PARTS).astype(np.float32), (to_chroma.reshape(16, 2) / _PARTS).astype(np.float32)


_LUMA, _CHROMA = _block_maps()


class PaletteIndices:
    """Indices into a palette that follow a picture, for a GIF.

    Args:
        width, height: picture size [pixels].
        colours: of the palette (C,), at most 256.

    Attributes:
        data: as ffmpeg's pal8: for each pixel, row by row, the index of the nearest color in RGB; then 256 colors as
            BGRA.
    """

    def __init__(self, width: int, height: int, colours: Colours24) -> None:
        size = width * height
        self.data: Pixels = np.zeros(size + 4 * 256, np.uint8)
        self._index = self.data[:size]
        self._colours = _channels(colours)
        self.data[size:].reshape(256, 4)[: len(colours)] = np.insert(self._colours[:, ::-1], 3, 255, axis=1)
        self._nearest = np.full(_RGB + 1, -1, np.int16)  # index by color, -1 for a color not met yet

    def convert(self, picture: Pixels, changed: Change) -> Pixels:  # noqa: ARG002 - as Yuv420 does
        """Return the data of a picture (height, width, 4) that differs from the last one in changed pixels only."""
        colours = changed.pixels & _RGB
        new = np.unique(colours[self._nearest[colours] < 0])
        if len(new):
            self._nearest[new] = _nearest(_channels(new), self._colours)
        self._index[changed.where] = self._nearest[colours]
        return self.data


def frequent_colours(pictures: Iterable[Pixels]) -> Colours24:
    """Return the most frequent colors of pictures (height, width, 4), at most `PALETTE_SIZE`."""
    found = [np.unique(picture.view(np.uint32) & _RGB, return_counts=True) for picture in pictures]
    colours, place = np.unique(np.concatenate([colours for colours, _ in found]), return_inverse=True)
    counts = np.bincount(place, np.concatenate([counts for _, counts in found]))
    return colours[np.argsort(-counts, kind="stable")[:PALETTE_SIZE]]


def _channels(colours: Colours24) -> NDArray[np.int32]:
    return (colours[:, None] >> np.array([0, 8, 16], np.uint32) & 0xFF).astype(np.int32)


def _nearest(wanted: NDArray[np.int32], colours: NDArray[np.int32]) -> NDArray[np.int16]:
    """Return the index (N,) of the color in (C, 3) nearest to each of (N, 3)."""
    index = np.empty(len(wanted), np.int16)
    for first in range(0, len(wanted), 4096):  # a table of all distances could be large
        part = wanted[first : first + 4096, None]
        index[first : first + 4096] = ((part - colours) ** 2).sum(axis=-1).argmin(axis=1)
    return index
