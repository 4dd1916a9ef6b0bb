"""The keys of `stage` and `start`: convex polygons, their edges and largest circle, and start positions on them.

Corners are pairs (x, y) [m], and an outline is all corners, counter-clockwise. All of this works on plain numbers, so
that reading a scene needs no arrays.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property
from math import atan2, hypot, pi
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from emovid.errors import nearest
from emovid.scene.fields import MAX_LENGTH, ORIGIN, Length, Point
from emovid.yaml_models import Keys, inconsistent

Corner = tuple[float, float]
Outline = tuple[Corner, ...]

_SAME = 1e-6  # m; a corner so near to its neighbor, or to the line past it, does not count as one


class Edge(NamedTuple):
    """The line of an edge: points (p, q) on it and inside have x p + y q <= offset.

    Attributes:
        x, y: its unit normal, outward.
        offset: its distance from the origin [m], negative if the origin is outside.
    """

    x: float
    y: float
    offset: float


def first_fault(corners: Sequence[Corner]) -> tuple[int, str] | None:
    """Return the first corner that is impossible in a convex polygon, and the reason.

    Args:
        corners: three or more, in order around the polygon, in either direction.
    """
    sides = [_from_to(a, b) for a, b in _pairs(corners)]
    doubled_area = sum(_cross(a, b) for a, b in _pairs(corners))
    for i, side in enumerate(sides):
        if hypot(*side) <= _SAME:
            return max(
                i, (i + 1) % len(sides)
            ), "the same position as the neighboring corner: expected each corner once"
    whole_turn = 0.0
    for i, after in enumerate(sides):
        before = sides[i - 1]
        turn = _cross(before, after)
        if abs(turn) <= _SAME * hypot(before[0] + after[0], before[1] + after[1]):
            return i, "on the line between the neighboring corners: expected corners only"
        whole_turn += atan2(turn, _dot(before, after))
        if turn * doubled_area <= 0 or abs(whole_turn) > 3 * pi:
            return i, "not convex here: expected the corners of a convex stage, in order around it"
    return None


def outline_of(corners: Sequence[Corner]) -> Outline:
    """Return the corners of a convex polygon, counter-clockwise from the leftmost, lowest one."""
    clockwise = sum(_cross(a, b) for a, b in _pairs(corners)) < 0
    ring = tuple(reversed(corners)) if clockwise else tuple(corners)
    first = ring.index(min(ring))
    return ring[first:] + ring[:first]


def edges_of(outline: Outline) -> tuple[Edge, ...]:
    """Return the lines of the edges; of an upright rectangle right, left, top, bottom.

    They are in order of their directions, so that a sum over them has the same last digit for any order of corners.
    """
    edges = []
    for a, b in _pairs(outline):
        along = _from_to(a, b)
        length = hypot(*along)
        x, y = along[1] / length, -along[0] / length
        edges.append(Edge(x, y, x * a[0] + y * a[1]))
    return tuple(sorted(edges, key=lambda edge: (-abs(edge.x), -edge.x, -edge.y)))


def inradius_of(outline: Outline) -> float:
    """Return the radius [m] of the largest circle inside.

    All edges move inward at the same speed. An edge of length L between corners that turn by a and b shrinks to a
    point after L / (tan(a/2) + tan(b/2)), and its neighbors meet. If these are parallel, or diverge, nothing is left.
    """
    sides = [_from_to(a, b) for a, b in _pairs(outline)]
    lengths = [hypot(*side) for side in sides]
    ways = [(x / length, y / length) for (x, y), length in zip(sides, lengths, strict=True)]
    radius = 0.0
    while True:
        ends = [_half_tangent(a, b) for a, b in _pairs(ways)]
        losses = [ends[i - 1] + end for i, end in enumerate(ends)]
        lives = [length / loss for length, loss in zip(lengths, losses, strict=True)]
        shortest = min(lives)
        gone = lives.index(shortest)
        radius += shortest
        if _cross(ways[gone - 1], ways[(gone + 1) % len(ways)]) <= 0:
            return radius
        lengths = [length - shortest * loss for length, loss in zip(lengths, losses, strict=True)]
        del lengths[gone], ways[gone]


def _half_tangent(a: Corner, b: Corner) -> float:
    """Return tan(angle / 2) of the angle from one unit vector to another, in a form that is exact up to pi."""
    return _cross(a, b) / (1 + _dot(a, b)) if _dot(a, b) >= 0 else (1 - _dot(a, b)) / _cross(a, b)


def _pairs(ring: Sequence[Corner]) -> Iterator[tuple[Corner, Corner]]:
    """Yield each corner with the next, and the last with the first."""
    return zip(ring, [*ring[1:], ring[0]], strict=True)


def _from_to(a: Corner, b: Corner) -> Corner:
    return b[0] - a[0], b[1] - a[1]


def _dot(a: Corner, b: Corner) -> float:
    return a[0] * b[0] + a[1] * b[1]


def _cross(a: Corner, b: Corner) -> float:
    return a[0] * b[1] - a[1] * b[0]


MAX_CORNERS = 64

Side = Annotated[float, Field(ge=1e-6, le=MAX_LENGTH)]  # corners of a polygon are as far apart, too


class StageKeys(Keys):
    """Properties of both forms of a stage."""

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

    def distances(self, x: Any, y: Any) -> list[Any]:
        """Return the distances [m] of a point from the edges, or of arrays of points; negative beyond an edge."""
        return [edge.offset - (edge.x * x + edge.y * y) for edge in self.edges]

    def room(self, x: float, y: float) -> float:
        """Return the radius [m] of the largest disk about a point that is inside; negative for a point outside."""
        return min(self.distances(x, y))


class Rectangle(StageKeys):
    """A rectangle with its center at the origin of all coordinates."""

    width: Side = Field(description="extent along x [m]")
    height: Side = Field(description="extent along y [m]")

    @property
    def outline(self) -> Outline:
        """See `StageKeys`."""
        x, y = self.width / 2, self.height / 2
        return (-x, -y), (x, -y), (x, y), (-x, y)

    def __str__(self) -> str:
        return f"{self.width:g} m x {self.height:g} m"


def _outlined(corners: tuple[Point, ...]) -> tuple[Point, ...]:
    """Return the corners as an outline, so that equal polygons are equal stages.

    Raises:
        PydanticCustomError: if they do not form a convex polygon.
    """
    pairs = [(corner.x, corner.y) for corner in corners]
    if fault := first_fault(pairs):
        i, message = fault
        raise inconsistent(f"{i}", f"({pairs[i][0]:g}, {pairs[i][1]:g}): {message}")
    return tuple(Point(x=x, y=y) for x, y in outline_of(pairs))


class Polygon(StageKeys):
    """Any convex polygon; its corners define the origin of all coordinates."""

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
                raise inconsistent(side, "given together with corners: expected width and height, or corners")
        return keys

    @property
    def outline(self) -> Outline:
        """See `StageKeys`."""
        return tuple((corner.x, corner.y) for corner in self.corners)

    def __str__(self) -> str:
        left, bottom, right, top = self.box
        return f"{len(self.corners)} corners within {right - left:g} m x {top - bottom:g} m"


def _form(stage: Any) -> str:
    """Return the form of a stage: a polygon if one of its keys is `corners`, or nearly so."""
    keys = stage if isinstance(stage, dict) else type(stage).model_fields if isinstance(stage, StageKeys) else ()
    return Polygon.__name__ if any(nearest(str(key), Polygon.model_fields) for key in keys) else Rectangle.__name__


Stage = Annotated[
    Annotated[Rectangle, Tag(Rectangle.__name__)] | Annotated[Polygon, Tag(Polygon.__name__)], Discriminator(_form)
]


class Pose(Point):
    """A position and a direction."""

    heading: Annotated[float, Field(ge=-1000, le=1000)] = Field(0.0, description="radians, counter-clockwise from x")


class Region(Keys):
    """A rectangle inside the stage."""

    centre: Point = Field(ORIGIN, description="its center [m]")
    width: Length = Field(description="extent along x [m]")
    height: Length = Field(description="extent along y [m]")

    @property
    def corners(self) -> Outline:
        """Its corners (x, y) [m]."""
        x, y, half_width, half_height = self.centre.x, self.centre.y, self.width / 2, self.height / 2
        return tuple((x + i * half_width, y + j * half_height) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1)))


class OnContour(Keys):
    """A start for laws that follow a contour."""

    place: Literal["contour"] = Field(description="spread evenly along the contour at t = 0, heading along it")
    settled: bool = Field(
        False,
        description="whether robots start with their steady lag behind the followed points; false: on the "
        "contour itself",
    )


class AtRandom(Keys):
    """Keys of random starts."""

    min_spacing: Length | None = Field(
        None, description="smallest distance between two centers [m]; null: bodies just apart"
    )


class InStage(AtRandom):
    """A random start, anywhere."""

    place: Literal["stage"] = Field(description="at random on the whole stage")


class InRegion(AtRandom):
    """A random start in a rectangle."""

    place: Literal["region"] = Field(description="at random on a part of the stage")
    region: Region = Field(description="the part, for the centers of the robots")


class AtPoses(Keys):
    """A start at given poses."""

    place: Literal["poses"] = Field(description="at the poses listed in the scene")
    poses: Annotated[tuple[Pose, ...], Field(strict=False, min_length=1)] = Field(description="one pose for each robot")


Start = Annotated[OnContour | InStage | InRegion | AtPoses, Field(discriminator="place")]
