"""Slow and obvious: what the fast routines of the video room must equal."""

import numpy as np

RED, BLUE = 0.2126, 0.0722  # ITU-R BT.709-6, item 3.2
GREEN = 1 - RED - BLUE


def luma_and_colour(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return Y, C_B and C_R (...) of R'G'B' (..., 3) from 0 to 255, not rounded: items 3.2, 3.3 and 3.4 at 8 bits."""
    red, green, blue = np.moveaxis(rgb / 255, -1, 0)
    y = RED * red + GREEN * green + BLUE * blue
    return 219 * y + 16, 224 * (blue - y) / 1.8556 + 128, 224 * (red - y) / 1.5748 + 128


def exact_planes(picture: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the planes of a picture (height, width, 4), not rounded: colour from the mean of each 2 x 2 pixels."""
    rgb = picture[..., :3].astype(float)
    mean = (rgb[0::2, 0::2] + rgb[0::2, 1::2] + rgb[1::2, 0::2] + rgb[1::2, 1::2]) / 4
    return luma_and_colour(rgb)[0], luma_and_colour(mean)[1], luma_and_colour(mean)[2]


def whole_frame(picture: np.ndarray) -> np.ndarray:
    """Return the planes of a picture, (3 / 2 width height,), converted in one piece with whole numbers."""
    # In 65536ths of a level: the numbers that the fast routine documents, a line each.
    r, g, b = np.moveaxis(picture[..., :3].astype(np.int64), -1, 0)
    y = (11966 * r + 40254 * g + 4064 * b + 16 * 65536 + 32768) // 65536
    r, g, b = (c[0::2, 0::2] + c[0::2, 1::2] + c[1::2, 0::2] + c[1::2, 1::2] for c in (r, g, b))
    u = (-1649 * r - 5547 * g + 7196 * b + 128 * 65536 + 32768) // 65536
    v = (7196 * r - 6536 * g - 660 * b + 128 * 65536 + 32768) // 65536
    return np.concatenate([plane.reshape(-1) for plane in (y, u, v)]).astype(np.uint8)


def inside(picture: np.ndarray, boxes: list[tuple[int, int, int, int]]) -> np.ndarray:
    """Return which pixels (height, width) of a picture lie in a box."""
    mask = np.zeros(picture.shape[:2], dtype=bool)
    for top, bottom, left, right in boxes:
        mask[top:bottom, left:right] = True
    return mask
