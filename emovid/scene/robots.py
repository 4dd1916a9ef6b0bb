"""The keys of `robot` and `safety`: the robot file, its limits, and collision avoidance.

Lengths are in meters, in the robot's own frame: x forward, y left, the origin at its pose, midway between the wheels.
"""

from math import hypot
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from emovid.scene.fields import MAX_LENGTH, Length, most
from emovid.yaml_models import Keys, inconsistent

MIN_L = 1e-6  # m; a robot with a shorter look-ahead only spins
MAX_CORNERS = 256

Offset = Annotated[float, Field(ge=-MAX_LENGTH, le=MAX_LENGTH)]
Corner = Annotated[tuple[Offset, Offset], Field(strict=False)]


class CircularShape(Keys):
    """A disk."""

    kind: Literal["circle"] = Field(description="a disk")
    radius: Length = Field(description="[m]")
    ahead: Offset = Field(0.0, description="distance of its center ahead of the pose [m]")

    @property
    def box(self) -> tuple[float, float]:
        """Extent along x and along y [m]."""
        return 2 * self.radius, 2 * self.radius

    def reach(self, x: float) -> float:
        """Return the distance [m] of its farthest point from (x, 0)."""
        return abs(self.ahead - x) + self.radius


class RectangularShape(Keys):
    """A rectangle, with round corners or not."""

    kind: Literal["rectangle"] = Field(description="a rectangle")
    length: Length = Field(description="extent along the heading [m]")
    width: Length = Field(description="extent across it [m]")
    corner: Annotated[float, Field(ge=0, le=MAX_LENGTH)] = Field(0.0, description="radius of its corners [m]")
    ahead: Offset = Field(0.0, description="distance of its center ahead of the pose [m]")

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
    width: Length = Field(description="of a tire [m]")
    base: Length = Field(description="distance between the centers of the tires [m]")


class Light(Keys):
    """A round light on top of the body."""

    x: Offset = Field(description="of its middle, ahead of the pose [m]")
    y: Offset = Field(description="to the left of it [m]")
    radius: Length = Field(description="[m]")


class Limits(Keys):
    """Limits of the motors. A command beyond a limit is scaled, v and omega together, so the curvature is unchanged."""

    v_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest linear speed [m/s]")
    omega_max: Annotated[float, Field(gt=0, le=1000)] | None = Field(None, description="largest turning rate [rad/s]")
    wheel_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest speed of a wheel [m/s]")


class Body(Keys):
    """A robot as its file describes it: for motion, spacing, staying on the stage, and drawing."""

    name: Annotated[str, Field(min_length=1, max_length=200)] = Field(
        "robot", description="name in messages; by default the name of its file"
    )
    kinematics: Literal["unicycle", "single_integrator"] = Field(
        description="unicycle: moves along its heading; single_integrator: moves in any direction"
    )
    shape: Annotated[Shape, Field(discriminator="kind")] = Field(description="outline of its body from above")
    height: Length = Field(description="height of the body above the floor [m]; for pictures only")
    wheels: Wheels | None = Field(None, description="its two wheels, or null")
    limits: Limits | None = Field(None, description="limits of its motors, for scenes with `robot.limits: model`")
    front: Length | None = Field(
        None, description="size of the mark at its front [m], drawn as for a body of this width; or null"
    )
    lights: Annotated[tuple[Light, ...], Field(strict=False, max_length=64)] = Field(
        (), description="lights on its top, in the color of that mark; for pictures only"
    )

    @model_validator(mode="after")
    def _wheeled(self) -> "Body":
        if self.limits is not None and self.limits.wheel_max is not None and self.wheels is None:
            raise inconsistent("limits.wheel_max", f"a {self.name} has no wheels")
        return self

    @property
    def steers(self) -> bool:
        """True if the robot moves only along its heading."""
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
        """Radius [m] of the smallest disk about the pose that holds the whole outline, wheels included.

        Robots whose disks stay apart cannot touch, whatever their headings: this is the body for random starts and the
        edge of the stage.
        """
        return self._reach(0.0)

    @property
    def disc(self) -> tuple[float, float]:
        """Distance [m] of the body's middle ahead of the pose, and radius [m] of the disk about it that holds the body.

        A tighter measure than `radius` if the wheels are not in the middle: these disks must stay apart.
        """
        return self.shape.ahead, self._reach(self.shape.ahead)

    @property
    def guarded(self) -> tuple[float, float]:
        """The disk that a barrier keeps apart: `disc`, or the disk about the pose of an omnidirectional robot."""
        return self.disc if self.steers else (0.0, self.radius)

    def _reach(self, x: float) -> float:
        wheel = hypot(abs(x) + self.wheels.radius, (self.wheels.base + self.wheels.width) / 2) if self.wheels else 0.0
        return max(self.shape.reach(x), wheel)


class Robot(Keys):
    """The robot and its two parameters of the near-identity diffeomorphism, Appendix B."""

    model: Body = Field(
        description="a shipped robot by its name, a file that ends in .yaml (relative to the scene's file), or the "
        "keys of such a file"
    )
    l: Annotated[float, Field(gt=0, le=1)] | None = Field(
        None, description="distance of the look-ahead point [m]: small is angular, large is smooth; a unicycle needs it"
    )
    K: Annotated[float, Field(gt=0, le=1000)] = Field(description="proportional gain: larger is faster")
    limits: Limits | None = Field(
        None, description="actuator limits: null for none, model for the robot's own, or keys"
    )
    saturation: Literal["scale", "clip"] = Field(
        "scale",
        description="treatment of a command beyond the limits: scale keeps its curvature; clip limits each wheel "
        "separately, as the Robotarium's simulator does",
    )

    @property
    def body(self) -> Body:
        """The robot's description."""
        return self.model


def schema_with(names: list[str], robot: dict[str, Any]) -> None:
    """Add to the JSON Schema of `Robot` the values that a scene may have in place of the keys of a robot's file."""
    model, limits = robot["properties"]["model"], robot["properties"]["limits"]
    inline = model.pop("$ref", None)
    model["anyOf"] = [{"enum": names}, {"type": "string", "pattern": r"\.ya?ml$"}, {"$ref": inline}]
    limits["anyOf"].append({"const": "model"})


MAX_PERIOD = 0.04  # s; default of a barrier: about the control period of robots


class NoSafety(Keys):
    """The paper's study: only the edge of the stage, and a coverage law's `separation`."""

    kind: Literal["none"] = Field("none", description="only the edge of the stage changes commands")


class Barrier(Keys):
    """Control barrier certificates, for the paper's Sec. V: a quadratic program changes unsafe commands."""

    kind: Literal["barrier"] = Field(description="control barrier certificates for all pairs of robots and all walls")
    spacing: Length | None = Field(
        None,
        description="distance between the centers of two bodies [m], half of it to a wall; null: bodies just apart",
    )
    gamma: Annotated[float, Field(gt=0, le=1000)] = Field(
        5.0,
        description="largest rate at which robots use up their distance beyond the spacing [1/s], at most 1 / period",
    )
    period: Annotated[float, Field(ge=1e-6, le=60)] | None = Field(
        None,
        description="time between solutions [s], a fraction 1/n of the control period; null: the longest "
        "such part of at most 0.04 s",
    )


def _by_its_kind(keys: Any) -> Any:
    """Accept `safety: barrier` for a group of that kind with all defaults."""
    return {"kind": keys} if isinstance(keys, str) else keys


Safety = Annotated[
    Annotated[NoSafety | Barrier, Field(discriminator="kind")],
    BeforeValidator(
        _by_its_kind,
        json_schema_input_type=Literal["none", "barrier"] | Annotated[NoSafety | Barrier, Field(discriminator="kind")],
    ),
]


def spacing_of(safety: Barrier, robot: Robot) -> float:
    """Return the distance D [m] that the barrier keeps between the middles of two bodies."""
    return 2 * robot.body.guarded[1] if safety.spacing is None else safety.spacing
