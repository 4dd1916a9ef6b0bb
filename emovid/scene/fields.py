"""What the keys of all groups share: bounds, units, and how strictly values are read."""

from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

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

    x: Coordinate = Field(description="metres to the right of the origin, which is a rectangular stage's centre")
    y: Coordinate = Field(description="metres above the origin, which is a rectangular stage's centre")


ORIGIN = Point(x=0.0, y=0.0)


def inconsistent(key: str, message: str) -> PydanticCustomError:
    """Return the error, for a validator to raise, of what is wrong beyond its own bounds with a dotted key inside."""
    return PydanticCustomError("inconsistent", "{message}", {"key": key, "message": message})


def least(bound: float) -> str:
    """Return a lower bound for a message: four digits, rounded up, so that what is named is allowed."""
    return _four_digits(bound, ROUND_CEILING)


def most(bound: float) -> str:
    """Return an upper bound for a message: four digits, rounded down, so that what is named is allowed."""
    return _four_digits(bound, ROUND_FLOOR)


def _four_digits(number: float, rounding: str) -> str:
    return f"{float(Context(prec=4, rounding=rounding).create_decimal(repr(number))):g}"
