"""The keys of `video`: how a run is shown. Nothing here changes the motion."""

from typing import Annotated, Literal

from pydantic import Field

from emovid.scene.fields import MAX_DURATION, MAX_LENGTH, MAX_ROBOTS, Colour, Keys, Length

MAX_FPS = 240
MAX_GIF_FPS = 50  # browsers show a faster GIF at 10 frames a second
MIN_SIDE, MAX_SIDE = 64, 8192  # pixels; H.264 level 6.2 ends at 8192
MAX_FIELD_OF_VIEW = 150.0  # degrees; beyond, a flat picture shows its edges stretched fifteen times

FormatName = Literal["mp4", "webm", "gif", "png-sequence"]
ThemeName = Literal["light", "dark"]
ViewName = Literal["overhead", "perspective"]
OwnColour = Annotated[str, Field(pattern=r"^(#[0-9a-fA-F]{6}|theme)$")]


class CameraKeys(Keys):
    """The camera of the perspective view: a pinhole on the stage's middle line, before its lower edge."""

    height: Length = Field(1.7, description="above the floor [m]; the paper's camera was at 1.70 m")
    distance: Annotated[float, Field(ge=0, le=MAX_LENGTH)] | None = Field(
        None,
        description="along the floor to the middle of the stage [m]; null: its own height from the stage's near edge",
    )
    tilt: Annotated[float, Field(ge=0, le=90)] | None = Field(
        None, description="of its axis below the horizontal [deg]; null: the stage is in the middle of the picture"
    )
    field_of_view: Annotated[float, Field(ge=1, le=MAX_FIELD_OF_VIEW)] | None = Field(
        None, description="across the width of the picture [deg]; null: the stage fills the picture"
    )


class Trails(Keys):
    """The lines some robots leave behind."""

    robots: Annotated[int, Field(ge=0, le=MAX_ROBOTS)] | None = Field(
        5, description="how many robots leave a trail, evenly spread through the swarm; null: all"
    )
    width: Annotated[float, Field(gt=0, le=1)] = Field(0.004, description="width of the line [m on the stage]")
    seconds: Annotated[float, Field(gt=0, le=MAX_DURATION)] | None = Field(
        None, description="how long a trail stays [s]; null: for ever"
    )
    fade: bool = Field(False, description="whether a trail fades with its age until it is gone; needs seconds")


class Overlays(Keys):
    """What a picture can show besides stage, robots and trails. None of it is in the study's videos."""

    density: bool = Field(False, description="the density that coverage spreads over, under all else")
    cells: bool = Field(False, description="the robots' Voronoi cells")
    targets: bool = Field(False, description="the points that the robots head for: on the contour, or centroids")
    clock: bool = Field(False, description="the time, in the upper left corner [s]")


class Colours(Keys):
    """All colours of a picture, as "#rrggbb"; by default the light theme.

    A theme's trails are colour-blind-safe and stand out from its stage in luminance.
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
    """The colours that a scene sets itself, as "#rrggbb", and those that are its theme's, by the word theme."""

    surround: OwnColour = Field("theme", description="around the stage")
    stage: OwnColour = Field("theme", description="the stage")
    boundary: OwnColour = Field("theme", description="the stage's edge")
    body: OwnColour = Field("theme", description="robots without a trail")
    wheels: OwnColour = Field("theme", description="wheels")
    front: OwnColour = Field("theme", description="the mark that shows a robot's front")
    trails: Annotated[tuple[OwnColour, ...], Field(strict=False, min_length=1)] = Field(
        5 * ("theme",), description="trails and the bodies that leave them, in turn"
    )
    density: OwnColour = Field("theme", description="the overlay of the density, where that is highest")
    overlay: OwnColour = Field("theme", description="the other overlays: cells, targets and clock")

    def over(self, theme: Colours) -> Colours:
        """Return all colours: these, and the theme's where these name it."""
        own = {name: colour for name, colour in self if colour != "theme"}
        trails = [theme.trails[i % len(theme.trails)] if c == "theme" else c for i, c in enumerate(self.trails)]
        return theme.model_copy(update=own | {"trails": tuple(trails)})


class Video(Keys):
    """How a run is shown."""

    size: Annotated[str, Field(pattern=r"^[1-9][0-9]{1,4}x[1-9][0-9]{1,4}$")] = Field(
        "1280x720", description="width x height [pixels], both even"
    )
    fps: Annotated[int, Field(ge=1, le=MAX_FPS)] = Field(30, description="frames per second")
    format: FormatName = Field("mp4", description="mp4 (H.264), webm (VP9), gif, or png-sequence: a folder of pictures")
    view: ViewName = Field("overhead", description="overhead: from straight above; perspective: from the camera")
    camera: CameraKeys = Field(CameraKeys(), description="where the camera of the perspective view stands and looks")
    trails: Trails = Field(Trails(), description="the lines some robots leave")
    overlays: Overlays = Field(Overlays(), description="what else is shown")
    theme: ThemeName = Field("light", description="light or dark: the colours that are not set themselves")
    colours: OwnColours = Field(OwnColours(), description="the colours, where they are not the theme's")

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
        """All colours: the scene's own, and the theme's where it sets none."""
        return self.colours.over(THEMES[self.theme])
