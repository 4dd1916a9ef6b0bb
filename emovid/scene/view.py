"""Where the camera of the perspective view stands and looks, and whether it sees the stage.

It stands on the middle line of the stage, outside its lower edge or over it, and looks along y: up in the overhead view
is away from it.
"""

from collections.abc import Iterator
from math import atan, atan2, cos, degrees, inf, radians, sin, tan
from typing import NamedTuple

from emovid.scene.stage import Stage
from emovid.scene.video import MAX_FIELD_OF_VIEW, Video

MARGIN = 0.035  # of the frame's smaller side, left free around the stage


class Aim(NamedTuple):
    """A pinhole camera without roll.

    Attributes:
        x, y, z: where it is [m]; z above the floor.
        tilt: of its axis below the horizontal [rad].
        focal: its focal length [pixels].
    """

    x: float
    y: float
    z: float
    tilt: float
    focal: float


def aim_of(video: Video, stage: Stage, tallest: float) -> Aim:
    """Return the camera of a perspective view, with what its keys leave open as fits the stage.

    Args:
        video: with the keys.
        stage: all of which is in view.
        tallest: height of the robots on it [m].
    """
    camera = video.camera
    left, bottom, right, top = stage.box
    distance = (top - bottom) / 2 + camera.height if camera.distance is None else camera.distance
    x, y, z = (left + right) / 2, (bottom + top) / 2 - distance, camera.height
    if camera.tilt is None:
        below = [atan2(z - up, edge - y) for edge in (bottom, top) for up in (0.0, tallest)]
        tilt = (min(below) + max(below)) / 2
    else:
        tilt = radians(camera.tilt)
    if camera.field_of_view is None:
        free = MARGIN * min(video.width, video.height)
        across, along = _extent(x, y, z, tilt, stage, tallest)
        focal = min((video.width / 2 - free) / across, (video.height / 2 - free) / along)
    else:
        focal = video.width / 2 / tan(radians(camera.field_of_view) / 2)
    return Aim(x, y, z, tilt, focal)


def view_faults(video: Video, stage: Stage, tallest: float) -> Iterator[tuple[str, str]]:
    """Yield (key, message) for what is wrong with a perspective view of robots as high as `tallest` [m]."""
    camera = video.camera
    if camera.height <= tallest:
        yield "video.camera.height", f"{camera.height:g}: expected more than the robots' height, {tallest:g}"
        return
    aim = aim_of(video, stage, tallest)
    across, along = _extent(*aim[:4], stage, tallest)
    needed = 2 * degrees(atan(max(across, along * video.width / video.height)))
    if needed > MAX_FIELD_OF_VIEW and camera.tilt is not None:
        level = camera.model_copy(update={"tilt": None})
        right = degrees(aim_of(video.model_copy(update={"camera": level}), stage, tallest).tilt)
        yield "video.camera.tilt", f"{camera.tilt:g}: the stage is not in view; expected about {right:.0f}, or null"
    elif needed > MAX_FIELD_OF_VIEW:
        yield (
            "video.camera.height",
            f"{camera.height:g}: the stage is not in view: it spans {needed:.0f} degrees, at most "
            f"{MAX_FIELD_OF_VIEW:g} can be shown; expected a larger height or distance",
        )
    elif camera.field_of_view is not None and camera.field_of_view < needed:
        yield (
            "video.camera.field_of_view",
            f"{camera.field_of_view:g}: the stage is not in view; expected at least {needed + 0.05:.1f}, or null",
        )


def _extent(x: float, y: float, z: float, tilt: float, stage: Stage, tallest: float) -> tuple[float, float]:
    """Return how far stage and robots reach from the middle of the picture, across and along it, at focal length 1.

    Infinitely far if some of it is beside or behind the camera.
    """
    across = along = 0.0
    for corner_x, corner_y in stage.outline:
        for up in (0.0, tallest):
            away, below = corner_y - y, z - up
            depth = away * cos(tilt) + below * sin(tilt)
            if depth <= 0:
                return inf, inf
            across = max(across, abs(corner_x - x) / depth)
            along = max(along, abs(away * sin(tilt) - below * cos(tilt)) / depth)
    return across, along
