"""What the keys of all groups share: bounds, units, and how strictly values are read."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

# Beyond these a number is a slip: a stage of a football pitch, a run of more than a day.
MAX_LENGTH = 100.0  # m
MAX_ROBOTS = 100_000
MAX_DURATION = 86_400.0  # s

Length = Annotated[float, Field(gt=0, le=MAX_LENGTH)]
Coordinate = Annotated[float, Field(ge=-MAX_LENGTH, le=MAX_LENGTH)]
Colour = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]


class Keys(BaseModel):
    """A group of keys: no others are allowed, and no value can change."""

    # Strict: "15" in quotes is text and true is no number. Whole numbers still count as real ones.
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Point(Keys):
    """A place on the stage."""

    x: Coordinate = Field(description="metres from the stage's centre, to the right")
    y: Coordinate = Field(description="metres from the stage's centre, upwards")


ORIGIN = Point(x=0.0, y=0.0)
