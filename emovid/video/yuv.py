"""From RGBA to what encoders take: planes of luma and halved chroma, converted where the picture changed.

A block of 2 x 2 pixels has four lumas and one pair of chromas. It is sixteen numbers in and six out, by one linear map,
so a picture is a matrix product; and since no block looks at its neighbours, converting some blocks gives what
converting all of them would.

Luma is that of ITU-R BT.709-6, items 3.2 to 3.5, at 8 bits, to within half a level and a rounding; chroma is that of
the mean of the block. ffmpeg's own conversion gives the same luma to one level and the same chroma where the colour is
even; at edges it weighs rows beyond the block, too.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from emovid.video.canvas import Box, Pixels

Levels = NDArray[np.float32]

_PARTS = 65536  # of a level, in which the maps' numbers are whole
_AT_ONCE = 16384  # blocks converted in one go: they and their results stay within the processor's cache


class Yuv420:
    """Planes that follow a picture.

    Args:
        width, height: of the picture [pixels], both even.

    Attributes:
        planes: (3 / 2 width height,): Y (height, width), then U and V (height / 2, width / 2), as yuv420p; 16 to 235
            and 16 to 240.
    """

    def __init__(self, width: int, height: int) -> None:
        size = width * height
        self.planes: Pixels = np.zeros(size * 3 // 2, np.uint8)
        self._y = self.planes[:size].view(np.uint16)  # of two pixels side by side
        self._u, self._v = self.planes[size:].reshape(2, size // 4)
        self._stale = np.zeros((height // 2, width // 2), dtype=bool)  # blocks to convert
        # Where each block's upper and lower pair are, among all pairs: a row of blocks is two rows of pairs.
        rows = np.arange(size // 2).reshape(height // 2, 2, width // 2)
        self._pairs = np.stack([rows[:, 0].reshape(-1), rows[:, 1].reshape(-1)], axis=1)

    def convert(self, picture: Pixels, changed: Iterable[Box]) -> Pixels:
        """Return the planes of `picture` (height, width, 4), which differs within the boxes `changed` from the last."""
        for top, bottom, left, right in changed:
            self._stale[top // 2 : (bottom + 1) // 2, left // 2 : (right + 1) // 2] = True
        pairs = picture.reshape(-1).view(np.uint64)  # of pixels side by side, as in self._y
        blocks = np.flatnonzero(self._stale)
        for first in range(0, len(blocks), _AT_ONCE):
            block = blocks[first : first + _AT_ONCE]
            both = self._pairs.take(block, axis=0)
            luma, chroma = converted(pairs[both].view(np.uint8))
            self._y[both] = luma.view(np.uint16)
            self._u[block], self._v[block] = chroma[:, 0], chroma[:, 1]
        self._stale[:] = False
        return self.planes


def converted(blocks: Pixels) -> tuple[Pixels, Pixels]:
    """Return Y of the four pixels (B, 4), and U and V (B, 2), of blocks (B, 16): four times RGBA, row by row.

    All products and sums are multiples of 2^-16 below 2^8, which single precision holds exactly: the result does not
    depend on the order in which a processor adds them.
    """
    values = blocks.astype(np.float32)
    luma, chroma = values @ _LUMA, values @ _CHROMA
    luma += np.float32(16.5)  # black, and half a level for rounding
    chroma += np.float32(128.5)  # grey, likewise
    return luma.astype(np.uint8), chroma.astype(np.uint8)


def _block_maps() -> tuple[Levels, Levels]:
    """Return the maps to Y (16, 4) and to U and V (16, 2), rounded so that white has Y 235, and grey no colour."""
    red, blue = 0.2126, 0.0722  # of the primaries, in luma: BT.709
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
