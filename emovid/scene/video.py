"""The keys of `video`: appearance of a run, and the camera of the perspective view. Nothing here changes the motion.

The camera stands on the middle line of the stage, outside its lower edge or above it, and looks along y: up in the
overhead view is away from it.
"""

from collections.abc import Iterator
from math import atan, atan2, cos, degrees, inf, radians, sin, tan
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from emovid.scene.fields import MAX_DURATION, MAX_LENGTH, MAX_ROBOTS, Colour, Length
from emovid.scene.stage import Stage
from emovid.yaml_models import Keys

MAX_FPS = 240
MAX_GIF_FPS = 50  # browsers show a faster GIF at 10 frames a second
MIN_SIDE, MAX_SIDE = 64, 8192  # pixels; H.264 level 6.2 ends at 8192
MAX_TILT, MAX_DEFAULT_FIELD = 60.0, 120.0  # degrees, of the default camera: beyond, bodies look flat or stretched
MAX_FIELD_OF_VIEW = 150.0  # degrees; beyond, the edges of a flat picture are stretched fifteen times

FormatName = Literal["mp4", "webm", "gif", "png-sequence"]
ThemeName = Literal["light", "dark"]
ViewName = Literal["overhead", "perspective"]
OwnColour = Annotated[str, Field(pattern=r"^(#[0-9a-fA-F]{6}|theme)$")]
TrailColour = Annotated[str, Field(pattern=r"^(#[0-9a-fA-F]{6}|theme|body)$")]


class CameraKeys(Keys):
    """The camera of the perspective view: a pinhole on the stage's middle line, before its lower edge."""

    height: Length = Field(1.7, description="above the floor [m]; the paper's camera was at 1.70 m")
    distance: Annotated[float, Field(ge=0, le=MAX_LENGTH)] | None = Field(
        None,
        description="along the floor to the middle of the stage [m]; null: so that the stage fills the picture, or "
        "(with a tilt or a field of view) its own height from the near edge",
    )
    tilt: Annotated[float, Field(ge=0, le=90)] | None = Field(
        None,
        description="angle of its axis below the horizontal [deg]; null: toward the middle of the stage",
    )
    field_of_view: Annotated[float, Field(ge=1, le=MAX_FIELD_OF_VIEW)] | None = Field(
        None, description="across the width of the picture [deg]; null: the stage fills the picture"
    )


class Trails(Keys):
    """The traces that robots leave."""

    robots: Annotated[int, Field(ge=0, le=MAX_ROBOTS)] | None = Field(
        5, description="number of robots with a trail, evenly spaced by angle at the start; null: all"
    )
    width: Annotated[float, Field(gt=0, le=1)] = Field(0.004, description="width of the line [m on the stage]")
    seconds: Annotated[float, Field(gt=0, le=MAX_DURATION)] | None = Field(
        None, description="duration of a trail [s]; null: permanent"
    )
    fade: bool = Field(False, description="whether a trail fades with its age; needs seconds")


class Overlays(Keys):
    """Further parts of a picture. The study's videos have none of them."""

    density: bool = Field(False, description="the density of a coverage behavior, below everything else")
    cells: bool = Field(False, description="the robots' Voronoi cells")
    targets: bool = Field(False, description="the targets of the robots: points on the contour, or centroids")
    clock: bool = Field(False, description="the time, in the upper left corner [s]")


class Colours(Keys):
    """All colors of a picture, as "#rrggbb"; by default the light theme.

    The trails of a theme are color-blind-safe and differ from its stage in luminance.
    """

    surround: Colour = "#e3e4e8"
    stage: Colour = "#fafaf7"
    boundary: Colour = "#9a9ea8"
    body: Colour = "#4a5160"
    wheels: Colour = "#14161b"
    front: Colour = "#ffffff"
    trails: tuple[Colour, ...] = ("#1684ea", "#e15319", "#005432", "#c25d96", "#3d00e4")
    density: Colour = "#b3bdd8"
    overlay: Colour = "#14161b"


THEMES: dict[ThemeName, Colours] = {
    "light": Colours(),
    "dark": Colours(
        surround="#0c0d10",
        stage="#1b1d22",
        boundary="#565c68",
        body="#a9b0bf",
        wheels="#eceef2",
        front="#1b1d22",
        trails=("#067ff9", "#e09952", "#cbf6e0", "#e05281", "#d8a8f0"),
        density="#47527a",
        overlay="#eceef2",
    ),
}


class OwnColours(Keys):
    """The colors of a scene: its own as "#rrggbb", and those of its theme as "theme"."""

    surround: OwnColour = Field("theme", description="around the stage")
    stage: OwnColour = Field("theme", description="the stage")
    boundary: OwnColour = Field("theme", description="the stage's edge")
    body: OwnColour = Field("theme", description="robots without a trail")
    wheels: OwnColour = Field("theme", description="wheels")
    front: OwnColour = Field("theme", description="the mark at the front of a robot")
    trails: Annotated[tuple[TrailColour, ...], Field(strict=False, min_length=1)] = Field(
        5 * ("theme",),
        description="trails and the bodies that leave them, in turn; body: the color of robots without a trail",
    )
    density: OwnColour = Field("theme", description="the density overlay, at the largest density")
    overlay: OwnColour = Field("theme", description="the other overlays: cells, targets and clock")

    def over(self, theme: Colours) -> Colours:
        """Return all colors: these, and the theme's for the word theme."""
        own = {name: colour for name, colour in self if colour != "theme"}
        words = {"body": own.get("body", theme.body)}
        trails = [
            theme.trails[i % len(theme.trails)] if colour == "theme" else words.get(colour, colour)
            for i, colour in enumerate(self.trails)
        ]
        return theme.model_copy(update=own | {"trails": tuple(trails)})


class Video(Keys):
    """Appearance of a run."""

    size: Annotated[str, Field(pattern=r"^[1-9][0-9]{1,4}x[1-9][0-9]{1,4}$")] = Field(
        "1280x720", description="width x height [pixels], both even"
    )
    fps: Annotated[int, Field(ge=1, le=MAX_FPS)] = Field(30, description="frames per second")
    speed: Annotated[float, Field(ge=0.01, le=100)] = Field(
        1.0, description="playback speed: 2 shows the run in half its time"
    )
    begin: Annotated[float, Field(ge=0, le=MAX_DURATION)] = Field(
        0.0, description="time of the run at which the video begins [s]"
    )
    end: Annotated[float, Field(gt=0, le=MAX_DURATION)] | None = Field(
        None, description="time of the run at which the video ends [s]; null: the end of the run"
    )
    format: FormatName = Field("mp4", description="mp4 (H.264), webm (VP9), gif, or png-sequence: a folder of pictures")
    view: ViewName = Field("overhead", description="overhead: from straight above; perspective: from the camera")
    camera: CameraKeys = Field(CameraKeys(), description="position and direction of the camera of the perspective view")
    trails: Trails = Field(Trails(), description="the trails of robots")
    overlays: Overlays = Field(Overlays(), description="further parts of the picture")
    theme: ThemeName = Field("light", description="light or dark: the colors that the scene does not set itself")
    colours: OwnColours = Field(OwnColours(), description="colors that differ from the theme's")

    @property
    def width(self) -> int:
        """Columns of a frame [pixels]."""
        return int(self.size.split("x")[0])

    @property
    def height(self) -> int:
        """Rows of a frame [pixels]."""
        return int(self.size.split("x")[1])

    @property
    def palette(self) -> Colours:
        """All colors: the scene's own, and the theme's where it sets none."""
        return self.colours.over(THEMES[self.theme])


MARGIN = 0.035  # free space around the stage, as a share of the frame's smaller side


class Aim(NamedTuple):
    """A pinhole camera without roll.

    Attributes:
        x, y, z: its position [m]; z above the floor.
        tilt: angle of its axis below the horizontal [rad].
        focal: its focal length [pixels].
    """

    x: float
    y: float
    z: float
    tilt: float
    focal: float


def aim_of(video: Video, stage: Stage, tallest: float) -> Aim:
    """Return the camera of a perspective view; keys that are null are chosen to fit the stage.

    Args:
        video: with the camera's keys.
        stage: in view as a whole.
        tallest: height of the robots on it [m].
    """
    camera = video.camera
    left, bottom, right, top = stage.box
    distance = _default_distance(video, stage, tallest) if camera.distance is None else camera.distance
    x, y, z = (left + right) / 2, (bottom + top) / 2 - distance, camera.height
    tilt = _default_tilt(y, z, stage, tallest) if camera.tilt is None else radians(camera.tilt)
    if camera.field_of_view is None:
        free = MARGIN * min(video.width, video.height)
        across, along = _extent(x, y, z, tilt, stage, tallest)
        focal = min((video.width / 2 - free) / across, (video.height / 2 - free) / along)
    else:
        focal = video.width / 2 / tan(radians(camera.field_of_view) / 2)
    return Aim(x, y, z, tilt, focal)


def _default_tilt(y: float, z: float, stage: Stage, tallest: float) -> float:
    """Return the angle below the horizontal of the middle between the stage's near and far edges [rad]."""
    _, bottom, _, top = stage.box
    below = [atan2(z - up, edge - y) for edge in (bottom, top) for up in (0.0, tallest)]
    return (min(below) + max(below)) / 2


def _default_distance(video: Video, stage: Stage, tallest: float) -> float:
    """Return the smallest distance [m] at which the stage fills the width of a picture that is not distorted.

    It is at most the distance at which the camera sees the near edge 45 degrees below the horizontal, and no camera
    stands over the stage.
    """
    left, bottom, right, top = stage.box
    height, near = video.camera.height, (top - bottom) / 2
    far = near + height
    if video.camera.tilt is not None or video.camera.field_of_view is not None:
        return far
    free = MARGIN * min(video.width, video.height)
    for _ in range(40):  # to 1e-12 of the interval
        distance = (near + far) / 2
        y = (bottom + top) / 2 - distance
        tilt = _default_tilt(y, height, stage, tallest)
        across, along = _extent((left + right) / 2, y, height, tilt, stage, tallest)
        fills = along * (video.width / 2 - free) <= across * (video.height / 2 - free)
        moderate = tilt <= radians(MAX_TILT) and across <= tan(radians(MAX_DEFAULT_FIELD / 2))
        near, far = (near, distance) if fills and moderate else (distance, far)
    return far


def view_faults(video: Video, stage: Stage, tallest: float) -> Iterator[tuple[str, str]]:
    """Yield (key, message) for each fault of a perspective view of robots as high as `tallest` [m]."""
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
    """Return the extent of stage and robots from the middle of the picture, across and along it, at focal length 1.

    It is infinite if a part of them is beside or behind the camera.
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
