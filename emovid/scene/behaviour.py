"""The keys of `behaviour`: the laws of Appendix A and their parameters."""

from typing import Annotated, Literal

from pydantic import Field

from emovid.scene.fields import MAX_LENGTH, ORIGIN, Length, Point
from emovid.yaml_models import Keys

MAX_PARTS = 64


class ContourKeys(Keys):
    """Keys of all contours."""

    law: Literal["contour"] = Field(description="follow a point that moves along a contour")
    angular_rate: float = Field(
        ge=-100, le=100, description="angular rate of the followed point around the center [rad/s]"
    )
    centre: Point = Field(ORIGIN, description="center of the contour [m]")

    @property
    def extent(self) -> float:
        """Largest distance [m] of the contour from its center."""
        raise NotImplementedError


class CircularSinusoid(ContourKeys):
    """Happiness, Appendix A: r(theta) = R + A sin(f theta)."""

    shape: Literal["circular_sinusoid"] = Field(description="a circle with a sinusoid superimposed")
    R: Length = Field(description="radius of the main circle [m]")
    A: Annotated[float, Field(ge=0, le=MAX_LENGTH)] = Field(description="amplitude of the sinusoid [m], below R")
    f: Annotated[int, Field(ge=1, le=100)] = Field(description="number of ripples around the circle; 6 in the paper")

    @property
    def extent(self) -> float:
        return self.R + self.A


class ExpandingCircle(ContourKeys):
    """Surprise, Appendix A: R(t) = mod(expansion_rate t, R_max - R_min) + R_min, with a smooth return by choice."""

    shape: Literal["expanding_circle"] = Field(description="a circle that grows repeatedly from R_min to R_max")
    R_min: Length = Field(description="radius at the start [m]")
    R_max: Length = Field(description="radius at which it restarts [m], above R_min")
    expansion_rate: Annotated[float, Field(gt=0, le=100)] = Field(description="growth of the radius [m/s]")
    return_time: Annotated[float, Field(gt=0, le=1000)] | None = Field(
        None, description="time of a smooth return to R_min [s], half a cosine; null: at once, as in the paper (mod)"
    )

    @property
    def extent(self) -> float:
        return self.R_max


class Circle(ContourKeys):
    """Sadness, Appendix A: a circle of constant radius."""

    shape: Literal["circle"] = Field(description="a plain circle")
    R: Length = Field(description="radius [m]")

    @property
    def extent(self) -> float:
        return self.R


class Uniform(Keys):
    """The density of fear."""

    kind: Literal["uniform"] = Field(description="the same density everywhere")


class Boundary(Keys):
    """The density of disgust."""

    kind: Literal["boundary"] = Field(description="a ridge of density along every edge of the stage")
    width: Length = Field(description="standard deviation of the ridge's Gaussian profile [m]")
    inset: Annotated[float, Field(ge=0, le=MAX_LENGTH)] = Field(
        0.0, description="distance of the crest from the edge [m]"
    )


class Gaussian(Keys):
    """The density of anger."""

    kind: Literal["gaussian"] = Field(description="a round peak of density")
    centre: Point = Field(ORIGIN, description="position of the peak [m]")
    sigma: Length = Field(description="standard deviation [m]")


class Image(Keys):
    """A density drawn by hand: a grayscale picture over the upright rectangle around the stage."""

    kind: Literal["image"] = Field(description="a picture: darker is denser, white is zero")
    file: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="the picture, a PNG; relative to the scene's file"
    )
    smoothing: Length = Field(description="standard deviation of the Gaussian that smooths it [m]")
    pixels: str | None = Field(None, description="contents of the file, kept with the scene; null: read from the file")


Basic = Uniform | Boundary | Gaussian | Image


class Part(Keys):
    """One density of a sum."""

    weight: Annotated[float, Field(gt=0, le=1e6)] = Field(
        1.0,
        description="factor of the density, which is 1 where uniform, at a peak, on a crest and for black",
    )
    density: Annotated[Basic, Field(discriminator="kind")] = Field(description="any density but a sum")


class Sum(Keys):
    """Several densities at once."""

    kind: Literal["sum"] = Field(description="several densities, added")
    parts: Annotated[tuple[Part, ...], Field(strict=False, min_length=1, max_length=MAX_PARTS)] = Field(
        description="the terms of the sum"
    )


AnyDensity = Basic | Sum


class Coverage(Keys):
    """Fear, disgust and anger, Appendix A: each robot heads for the centroid of its Voronoi cell."""

    law: Literal["coverage"] = Field(description="coverage of a density: u = kappa (c - p)")
    kappa: Annotated[float, Field(gt=0, le=1000)] = Field(description="proportional gain [1/s]")
    u_max: Annotated[float, Field(gt=0, le=1000)] | None = Field(
        None, description="upper limit of |u| [m/s]; null: no limit, as in the paper"
    )
    density: Annotated[AnyDensity, Field(discriminator="kind")] = Field(description="density that the robots cover")
    separation: Annotated[float, Field(ge=0, le=1)] | None = Field(
        None,
        description="clearance [m] kept between bodies: v is cut where the body would leave its own Voronoi cell; "
        "null is the paper's law, which lets bodies touch",
    )


class Recorded(Keys):
    """Motion that was recorded elsewhere: of a testbed, or of a tracker. It cannot be simulated."""

    law: Literal["recorded"] = Field(description="motion recorded elsewhere, which only its file holds")


Contour = CircularSinusoid | ExpandingCircle | Circle
Behaviour = Annotated[
    Annotated[Contour, Field(discriminator="shape")] | Coverage | Recorded,
    Field(discriminator="law"),
]
