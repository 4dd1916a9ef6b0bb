"""Robots: what a robot's file says of it, and the keys of `robot` in a scene.

Lengths in metres, in the robot's own frame: x forward, y left, the origin its pose, midway between the wheels.
"""

from math import hypot
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from emovid.scene.fields import MAX_LENGTH, Keys, Length, inconsistent, most

MIN_L = 1e-6  # m; a robot with a shorter look-ahead only spins
MAX_CORNERS = 256

Offset = Annotated[float, Field(ge=-MAX_LENGTH, le=MAX_LENGTH)]
Corner = Annotated[tuple[Offset, Offset], Field(strict=False)]


class CircularShape(Keys):
    """A disc."""

    kind: Literal["circle"] = Field(description="a disc")
    radius: Length = Field(description="[m]")
    ahead: Offset = Field(0.0, description="how far its centre lies ahead of the pose [m]")

    @property
    def box(self) -> tuple[float, float]:
        """Extent along x and along y [m]."""
        return 2 * self.radius, 2 * self.radius

    def reach(self, x: float) -> float:
        """Return the distance [m] of its farthest point from (x, 0)."""
        return abs(self.ahead - x) + self.radius


class RectangularShape(Keys):
    """A rectangle, its corners round or not."""

    kind: Literal["rectangle"] = Field(description="a rectangle")
    length: Length = Field(description="extent along the heading [m]")
    width: Length = Field(description="extent across it [m]")
    corner: Annotated[float, Field(ge=0, le=MAX_LENGTH)] = Field(0.0, description="radius of its corners [m]")
    ahead: Offset = Field(0.0, description="how far its centre lies ahead of the pose [m]")

    @model_validator(mode="after")
    def _round(self) -> "RectangularShape":
        if 2 * self.corner > min(self.box):
            raise inconsistent("corner", f"{self.corner:g}: expected at most half a side, {most(min(self.box) / 2)}")
        return self

    @property
    def box(self) -> tuple[float, float]:
        """Extent along x and along y [m]."""
        return self.length, self.width

    def reach(self, x: float) -> float:
        """Return the distance [m] of its farthest point from (x, 0)."""
        along = abs(self.ahead - x) + self.length / 2 - self.corner
        return hypot(along, self.width / 2 - self.corner) + self.corner


class PolygonalShape(Keys):
    """Any polygon."""

    kind: Literal["polygon"] = Field(description="a polygon, convex or not")
    corners: Annotated[tuple[Corner, ...], Field(strict=False, min_length=3, max_length=MAX_CORNERS)] = Field(
        description="[x, y] of each [m] in order around it, x ahead of the pose and y to its left"
    )

    @property
    def ahead(self) -> float:
        """How far the middle of its box lies ahead of the pose [m]."""
        x = [corner[0] for corner in self.corners]
        return (min(x) + max(x)) / 2

    @property
    def box(self) -> tuple[float, float]:
        """Extent along x and along y [m]."""
        x, y = zip(*self.corners, strict=True)
        return max(x) - min(x), max(y) - min(y)

    def reach(self, x: float) -> float:
        """Return the distance [m] of its farthest point from (x, 0)."""
        return max(hypot(corner[0] - x, corner[1]) for corner in self.corners)


Shape = CircularShape | RectangularShape | PolygonalShape


class Wheels(Keys):
    """Two wheels, their axle through the robot's pose."""

    radius: Length = Field(description="of a wheel [m]")
    width: Length = Field(description="of a tyre [m]")
    base: Length = Field(description="distance of the tyres' middles [m]")


class Light(Keys):
    """A round light on top of the body."""

    x: Offset = Field(description="of its middle, ahead of the pose [m]")
    y: Offset = Field(description="to the left of it [m]")
    radius: Length = Field(description="[m]")


class Limits(Keys):
    """What the motors can do. A command beyond a limit is scaled as a whole, so the curvature stays."""

    v_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest linear speed [m/s]")
    omega_max: Annotated[float, Field(gt=0, le=1000)] | None = Field(None, description="largest turning rate [rad/s]")
    wheel_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest speed of a wheel [m/s]")


class Body(Keys):
    """A robot as its file describes it: one table for motion, for spacing, for keeping to the stage and for drawing."""

    name: Annotated[str, Field(min_length=1, max_length=200)] = Field(
        "robot", description="what messages call it; a file's own name if it says none"
    )
    kinematics: Literal["unicycle", "single_integrator"] = Field(
        description="unicycle: it goes where it faces; single_integrator: in any direction"
    )
    shape: Annotated[Shape, Field(discriminator="kind")] = Field(description="its body, seen from above")
    height: Length = Field(description="of the body above the floor [m]; only pictures show it")
    wheels: Wheels | None = Field(None, description="its two wheels; null is none")
    limits: Limits | None = Field(
        None, description="of its motors; they act where a scene says so, by `robot.limits: model`"
    )
    front: Length | None = Field(
        None, description="size of the mark that shows where its front is [m]: of a body as wide; null is none"
    )
    lights: Annotated[tuple[Light, ...], Field(strict=False, max_length=64)] = Field(
        (), description="on its top, in the colour of that mark; only pictures show them"
    )

    @model_validator(mode="after")
    def _wheeled(self) -> "Body":
        if self.limits is not None and self.limits.wheel_max is not None and self.wheels is None:
            raise inconsistent("limits.wheel_max", f"a {self.name} has no wheels")
        return self

    @property
    def steers(self) -> bool:
        """Whether it has a heading that its motion is bound to."""
        return self.kinematics == "unicycle"

    @property
    def width(self) -> float:
        """Extent of the body across the heading [m], without wheels."""
        return self.shape.box[1]

    @property
    def wheel_base(self) -> float:
        """Distance of the wheels [m]; 0 without."""
        return self.wheels.base if self.wheels else 0.0

    @property
    def radius(self) -> float:
        """Radius [m] of the smallest disc about the pose that holds the whole outline, wheels included.

        Robots whose discs stay apart cannot touch, whatever their headings: this is the body that random starts and the
        edge of the stage are measured with.
        """
        return self._reach(0.0)

    @property
    def disc(self) -> tuple[float, float]:
        """How far ahead of the pose [m] the body's middle is, and the radius [m] about it that holds the whole outline.

        A tighter measure than `radius` where the wheels are not in the middle: these discs are what must stay apart.
        """
        return self.shape.ahead, self._reach(self.shape.ahead)

    @property
    def guarded(self) -> tuple[float, float]:
        """The disc that a barrier keeps apart, as `disc`; about the pose where the robot faces anywhere at once."""
        return self.disc if self.steers else (0.0, self.radius)

    def _reach(self, x: float) -> float:
        wheel = hypot(abs(x) + self.wheels.radius, (self.wheels.base + self.wheels.width) / 2) if self.wheels else 0.0
        return max(self.shape.reach(x), wheel)


class Robot(Keys):
    """The robot and its two parameters of the near-identity diffeomorphism, Appendix B."""

    model: Body = Field(
        description="which robot: a shipped one by its name, a file that ends in .yaml (where it is, from the scene's "
        "file), or what such a file holds"
    )
    l: Annotated[float, Field(gt=0, le=1)] | None = Field(
        None, description="distance of the look-ahead point [m]: small is angular, large is smooth; a unicycle needs it"
    )
    K: Annotated[float, Field(gt=0, le=1000)] = Field(description="proportional gain: larger is faster")
    limits: Limits | None = Field(None, description="actuator limits; null is none, model is those of its model")
    saturation: Literal["scale", "clip"] = Field(
        "scale",
        description="what becomes of a command beyond the limits: scale keeps its curvature; clip cuts each wheel's "
        "speed alone, as the Robotarium's simulator does",
    )

    @property
    def body(self) -> Body:
        """The robot's description."""
        return self.model


def schema_with(names: list[str], robot: dict[str, Any]) -> None:
    """Say in the JSON Schema of `Robot` what a scene's file may hold in place of what the file of a robot does."""
    model, limits = robot["properties"]["model"], robot["properties"]["limits"]
    inline = model.pop("$ref", None)
    model["anyOf"] = [{"enum": names}, {"type": "string", "pattern": r"\.ya?ml$"}, {"$ref": inline}]
    limits["anyOf"].append({"const": "model"})
