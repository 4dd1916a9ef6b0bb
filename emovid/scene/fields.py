"""Types and bounds that the groups of keys share."""

from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import Annotated

from pydantic import Field

from emovid.yaml_models import Keys

# Larger numbers are typing errors: a stage of a football pitch, a run of more than a day.
MAX_LENGTH = 100.0  # m
MAX_ROBOTS = 100_000
MAX_DURATION = 86_400.0  # s

Length = Annotated[float, Field(gt=0, le=MAX_LENGTH)]
Coordinate = Annotated[float, Field(ge=-MAX_LENGTH, le=MAX_LENGTH)]
Colour = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]


class Point(Keys):
    """A point on the stage."""

    x: Coordinate = Field(description="meters to the right of the origin, which is the center of a rectangular stage")
    y: Coordinate = Field(description="meters above the origin, which is the center of a rectangular stage")


ORIGIN = Point(x=0.0, y=0.0)


def least(bound: float) -> str:
    """Return a lower bound for a message: four digits, rounded up, so that it is a valid value."""
    return _four_digits(bound, ROUND_CEILING)


def most(bound: float) -> str:
    """Return an upper bound for a message: four digits, rounded down, so that it is a valid value."""
    return _four_digits(bound, ROUND_FLOOR)


def _four_digits(number: float, rounding: str) -> str:
    return f"{float(Context(prec=4, rounding=rounding).create_decimal(repr(number))):g}"
