"""The keys of `stage`, in two forms. Both answer what the rest of the project asks: outline, edges, room."""

from functools import cached_property
from typing import Annotated, Any

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from emovid.errors import nearest
from emovid.scene.convex import Edge, Outline, edges_of, first_fault, inradius_of, outline_of
from emovid.scene.fields import MAX_LENGTH, Keys, Point, inconsistent

MAX_CORNERS = 64

Side = Annotated[float, Field(ge=1e-6, le=MAX_LENGTH)]  # corners of a polygon are as far apart, too


class StageKeys(Keys):
    """What both forms of a stage have."""

    @property
    def outline(self) -> Outline:
        """The corners (x, y) [m], counter-clockwise from the leftmost, lowest one."""
        raise NotImplementedError

    @cached_property
    def edges(self) -> tuple[Edge, ...]:
        """The lines of the edges: see `edges_of` for their order."""
        return edges_of(self.outline)

    @property
    def inradius(self) -> float:
        """Radius [m] of the largest circle inside."""
        return inradius_of(self.outline)

    @property
    def box(self) -> tuple[float, float, float, float]:
        """The upright rectangle around it: smallest x and y, largest x and y [m]."""
        x, y = zip(*self.outline, strict=True)
        return min(x), min(y), max(x), max(y)

    def room(self, x: float, y: float) -> float:
        """Return the radius [m] of the largest disc about a point that is inside; negative for a point outside."""
        return min(edge.offset - (edge.x * x + edge.y * y) for edge in self.edges)


class Rectangle(StageKeys):
    """A rectangle, its centre the origin of all coordinates."""

    width: Side = Field(description="extent along x [m]")
    height: Side = Field(description="extent along y [m]")

    @property
    def outline(self) -> Outline:
        """As `StageKeys` says."""
        x, y = self.width / 2, self.height / 2
        return (-x, -y), (x, -y), (x, y), (-x, y)

    def __str__(self) -> str:
        return f"{self.width:g} m x {self.height:g} m"


def _outlined(corners: tuple[Point, ...]) -> tuple[Point, ...]:
    """Return the corners as an outline, so that equal polygons are equal stages.

    Raises:
        PydanticCustomError: if they are not those of a convex polygon.
    """
    pairs = [(corner.x, corner.y) for corner in corners]
    if fault := first_fault(pairs):
        i, message = fault
        raise inconsistent(f"{i}", f"({pairs[i][0]:g}, {pairs[i][1]:g}): {message}")
    return tuple(Point(x=x, y=y) for x, y in outline_of(pairs))


class Polygon(StageKeys):
    """Any convex polygon; its corners say where the origin of all coordinates is."""

    corners: Annotated[
        tuple[Point, ...],
        Field(strict=False, min_length=3, max_length=MAX_CORNERS),
        AfterValidator(_outlined),
    ] = Field(description="in order around a convex polygon, either way, each once; instead of width and height")

    @model_validator(mode="before")
    @classmethod
    def _without_sides(cls, keys: Any) -> Any:
        for side in Rectangle.model_fields:
            if isinstance(keys, dict) and side in keys:
                raise inconsistent(side, "given beside corners: expected width and height, or corners")
        return keys

    @property
    def outline(self) -> Outline:
        """As `StageKeys` says."""
        return tuple((corner.x, corner.y) for corner in self.corners)

    def __str__(self) -> str:
        left, bottom, right, top = self.box
        return f"{len(self.corners)} corners within {right - left:g} m x {top - bottom:g} m"


def _form(stage: Any) -> str:
    """Return the form a stage is given in: a polygon if one of its keys is `corners`, or is meant to be."""
    keys = stage if isinstance(stage, dict) else type(stage).model_fields if isinstance(stage, StageKeys) else ()
    return Polygon.__name__ if any(nearest(str(key), Polygon.model_fields) for key in keys) else Rectangle.__name__


Stage = Annotated[
    Annotated[Rectangle, Tag(Rectangle.__name__)] | Annotated[Polygon, Tag(Polygon.__name__)], Discriminator(_form)
]
