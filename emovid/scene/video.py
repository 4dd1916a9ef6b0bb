"""The keys of `video`: how a run is shown. Nothing here changes the motion."""

from typing import Annotated

from pydantic import Field

from emovid.scene.fields import MAX_DURATION, MAX_ROBOTS, Colour, Keys

MAX_FPS = 240
MIN_SIDE, MAX_SIDE = 64, 8192  # pixels; H.264 level 6.2 ends at 8192


class Trails(Keys):
    """The lines some robots leave behind."""

    robots: Annotated[int, Field(ge=0, le=MAX_ROBOTS)] = Field(
        5, description="how many robots leave a trail, evenly spread through the swarm; all, if there are fewer"
    )
    width: Annotated[float, Field(gt=0, le=1)] = Field(0.004, description="width of the line [m on the stage]")
    seconds: Annotated[float, Field(gt=0, le=MAX_DURATION)] | None = Field(
        None, description="how long a trail stays [s]; null: for ever"
    )


class Colours(Keys):
    """All as "#rrggbb". The trails' set is colour-blind-safe and darker than the stage in luminance."""

    surround: Colour = Field("#e3e4e8", description="around the stage")
    stage: Colour = Field("#fafaf7", description="the stage")
    boundary: Colour = Field("#9a9ea8", description="the stage's edge")
    body: Colour = Field("#4a5160", description="robots without a trail")
    wheels: Colour = Field("#14161b", description="wheels")
    front: Colour = Field("#ffffff", description="the mark that shows a robot's front")
    trails: Annotated[tuple[Colour, ...], Field(strict=False, min_length=1)] = Field(
        ("#1684ea", "#e15319", "#005432", "#c25d96", "#3d00e4"),
        description="trails and the bodies that leave them, in turn",
    )


class Video(Keys):
    """How a run is shown."""

    size: Annotated[str, Field(pattern=r"^[1-9][0-9]{1,4}x[1-9][0-9]{1,4}$")] = Field(
        "1280x720", description="width x height [pixels], both even"
    )
    fps: Annotated[int, Field(ge=1, le=MAX_FPS)] = Field(30, description="frames per second")
    trails: Trails = Field(Trails(), description="the lines some robots leave")
    colours: Colours = Field(Colours(), description="the look")

    @property
    def width(self) -> int:
        """Columns of a frame [pixels]."""
        return int(self.size.split("x")[0])

    @property
    def height(self) -> int:
        """Rows of a frame [pixels]."""
        return int(self.size.split("x")[1])
