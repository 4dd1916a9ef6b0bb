"""The keys of `start`: where the robots are at t = 0."""

from typing import Annotated, Literal

from pydantic import Field

from emovid.scene.convex import Outline
from emovid.scene.fields import ORIGIN, Keys, Length, Point


class Pose(Point):
    """A place and a direction."""

    heading: Annotated[float, Field(ge=-1000, le=1000)] = Field(0.0, description="radians, counter-clockwise from x")


class Region(Keys):
    """A rectangle inside the stage."""

    centre: Point = Field(ORIGIN, description="its centre [m]")
    width: Length = Field(description="extent along x [m]")
    height: Length = Field(description="extent along y [m]")

    @property
    def corners(self) -> Outline:
        """Its corners (x, y) [m]."""
        x, y, half_width, half_height = self.centre.x, self.centre.y, self.width / 2, self.height / 2
        return tuple((x + i * half_width, y + j * half_height) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1)))


class OnContour(Keys):
    """A start for the laws that follow a contour."""

    place: Literal["contour"] = Field(description="spread evenly along the contour at t = 0, heading along it")


class AtRandom(Keys):
    """What random starts have."""

    min_spacing: Length | None = Field(
        None, description="smallest distance of two centres [m]; null: bodies just apart"
    )


class InStage(AtRandom):
    """A random start, anywhere."""

    place: Literal["stage"] = Field(description="at random in the whole stage")


class InRegion(AtRandom):
    """A random start in a rectangle."""

    place: Literal["region"] = Field(description="at random in a part of the stage")
    region: Region = Field(description="the part, for the robots' centres")


class AtPoses(Keys):
    """A start from given poses."""

    place: Literal["poses"] = Field(description="where the scene lists")
    poses: Annotated[tuple[Pose, ...], Field(strict=False, min_length=1)] = Field(description="one pose for each robot")


Start = Annotated[OnContour | InStage | InRegion | AtPoses, Field(discriminator="place")]
