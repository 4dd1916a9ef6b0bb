"""Slow and simple references for the fast routines of the video package."""

import numpy as np

from emovid.video.canvas import Change

RED, BLUE = 0.2126, 0.0722  # ITU-R BT.709-6, item 3.2
GREEN = 1 - RED - BLUE


def luma_and_colour(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return Y, C_B and C_R (...) of R'G'B' (..., 3) from 0 to 255, not rounded: items 3.2, 3.3 and 3.4 at 8 bits."""
    red, green, blue = np.moveaxis(rgb / 255, -1, 0)
    y = RED * red + GREEN * green + BLUE * blue
    return 219 * y + 16, 224 * (blue - y) / 1.8556 + 128, 224 * (red - y) / 1.5748 + 128


def exact_planes(picture: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the planes of a picture (height, width, 4), not rounded: color from the mean of each 2 x 2 pixels."""
    rgb = picture[..., :3].astype(float)
    mean = (rgb[0::2, 0::2] + rgb[0::2, 1::2] + rgb[1::2, 0::2] + rgb[1::2, 1::2]) / 4
    return luma_and_colour(rgb)[0], luma_and_colour(mean)[1], luma_and_colour(mean)[2]


def whole_frame(picture: np.ndarray) -> np.ndarray:
    """Return the planes of a picture, (3 / 2 width height,), converted in one piece with whole numbers."""
    # In 65536ths of a level: the coefficients documented in the fast routine, one row each.
    r, g, b = np.moveaxis(picture[..., :3].astype(np.int64), -1, 0)
    y = (11966 * r + 40254 * g + 4064 * b + 16 * 65536 + 32768) // 65536
    r, g, b = (c[0::2, 0::2] + c[0::2, 1::2] + c[1::2, 0::2] + c[1::2, 1::2] for c in (r, g, b))
    u = (-1649 * r - 5547 * g + 7196 * b + 128 * 65536 + 32768) // 65536
    v = (7196 * r - 6536 * g - 660 * b + 128 * 65536 + 32768) // 65536
    return np.concatenate([plane.reshape(-1) for plane in (y, u, v)]).astype(np.uint8)


def all_changed(picture: np.ndarray) -> Change:
    """Return the change of every pixel of a picture (height, width, 4)."""
    pixels = np.ascontiguousarray(picture).reshape(-1).view(np.uint32)
    return Change(np.arange(len(pixels)), pixels)


def hits_of_rays(
    eye: tuple[float, float, float],
    tilt: float,
    focal: float,
    size: tuple[int, int],
    prisms: list[np.ndarray],
    top: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Send a ray through the middle of each pixel of a pinhole camera without roll, which looks along y and down.

    Args:
        eye: where it is [m].
        tilt: below the horizontal [rad].
        focal: length [pixels].
        size: width and height of the picture [pixels].
        prisms: corners (M, 2) [m] of convex outlines, counter-clockwise, standing on the floor.
        top: how high they are [m].

    Returns:
        Which prism each ray (height, width) enters first, -1 for none, and the height [m] at which it does.
    """
    width, height = size
    columns, rows = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5)
    away = focal * np.cos(tilt) + rows * np.sin(tilt)
    up = rows * np.cos(tilt) - focal * np.sin(tilt)
    way = np.stack([columns, away, up], axis=-1)
    nearest, first = np.full((height, width), np.inf), np.full((height, width), -1)
    for i, corners in enumerate(prisms):
        enters, leaves = np.zeros((height, width)), np.full((height, width), np.inf)
        ahead = np.roll(corners, -1, axis=0) - corners
        planes = [((dy, -dx, 0.0), dy * x - dx * y) for (x, y), (dx, dy) in zip(corners, ahead, strict=True)]
        for normal, offset in [*planes, ((0, 0, 1), top), ((0, 0, -1), 0.0)]:
            inside, speed = offset - np.dot(eye, normal), way @ np.array(normal)  # in while speed * s <= inside
            with np.errstate(divide="ignore", invalid="ignore"):
                crossing = inside / speed
            enters = np.where(speed < 0, np.maximum(enters, crossing), enters)
            leaves = np.where(speed > 0, np.minimum(leaves, crossing), leaves)
            leaves = np.where((speed == 0) & (inside < 0), -1, leaves)
        hit = (enters < leaves) & (enters < nearest)
        nearest, first = np.where(hit, enters, nearest), np.where(hit, i, first)
    return first, eye[2] + np.where(first >= 0, nearest, 0) * up
