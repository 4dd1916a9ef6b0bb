"""The keys of `robot`, and the robots' bodies: one table for spacing, for keeping to the stage and for drawing.

Lengths in metres, in the robot's own frame: x forward, y left, the origin midway between the wheels.
"""

from dataclasses import dataclass
from math import hypot
from typing import Annotated, Literal

from pydantic import Field

from emovid.scene.fields import Keys

MIN_L = 1e-6  # m; a robot with a shorter look-ahead only spins

RobotModel = Literal["gritsbot", "single_integrator"]


@dataclass(frozen=True)
class Body:
    """A robot's outline: a square with rounded corners and, if it has any, two wheels at its sides.

    Attributes:
        width: side of the square [m].
        corner: radius of its corners [m]; half the width makes a disc.
        wheel_radius, wheel_width, wheel_base: of the wheels [m]; 0 for a robot without wheels.
        steers: whether it has a heading that its motion is bound to (a unicycle).
    """

    width: float
    corner: float
    wheel_radius: float
    wheel_width: float
    wheel_base: float
    steers: bool

    @property
    def radius(self) -> float:
        """Radius [m] of the smallest disc about the origin that holds the whole outline, wheels included.

        Robots whose discs stay apart cannot touch, whatever their headings: this is the body that spacing and the
        edge of the stage are measured with.
        """
        half = self.width / 2
        square = hypot(half - self.corner, half - self.corner) + self.corner
        wheel = hypot(self.wheel_radius, (self.wheel_base + self.wheel_width) / 2) if self.wheel_base else 0.0
        return max(square, wheel)


# GRITSBot: body 0.03 m (Fig. 1 of the paper; WIDTH in the robot's firmware), wheels of radius 0.005 m on a base of
# 0.035 m (firmware). The wheels' planes lie outside the body. Tyre width and corner radius are not published:
# 3 mm and 6 mm are our choice, and leave the wheels the outermost part.
_GRITSBOT = Body(width=0.03, corner=0.006, wheel_radius=0.005, wheel_width=0.003, wheel_base=0.035, steers=True)

# The paper's omnidirectional point, drawn as a disc of the GRITSBot's width.
_POINT = Body(width=0.03, corner=0.015, wheel_radius=0.0, wheel_width=0.0, wheel_base=0.0, steers=False)

BODIES: dict[RobotModel, Body] = {"gritsbot": _GRITSBOT, "single_integrator": _POINT}


class Limits(Keys):
    """What the motors can do. A command beyond a limit is scaled as a whole, so the curvature stays."""

    v_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest linear speed [m/s]")
    omega_max: Annotated[float, Field(gt=0, le=1000)] | None = Field(None, description="largest turning rate [rad/s]")
    wheel_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest speed of a wheel [m/s]")


class Robot(Keys):
    """The robot model and its two parameters of the near-identity diffeomorphism, Appendix B."""

    model: RobotModel = Field(description="gritsbot: a unicycle of 3 cm; single_integrator: an omnidirectional point")
    l: Annotated[float, Field(gt=0, le=1)] | None = Field(
        None, description="distance of the look-ahead point [m]: small is angular, large is smooth; a gritsbot needs it"
    )
    K: Annotated[float, Field(gt=0, le=1000)] = Field(description="proportional gain: larger is faster")
    limits: Limits | None = Field(None, description="actuator limits; null is none")

    @property
    def body(self) -> Body:
        """The robot's dimensions."""
        return BODIES[self.model]
