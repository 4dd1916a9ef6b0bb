"""What a scene may say: the YAML keys, their types, units and bounds, as frozen pydantic models.

A `Scene` that exists is valid: besides each key's own bounds, `_faults` holds the keys against each other. The
field descriptions are the hover help of editors (`emovid scene schema`).
"""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from emovid.errors import SceneError
from emovid.scene.emotions import EmotionName
from emovid.scene.robots import BODIES, Body, RobotModel

# Beyond these a number is a slip: a stage of a football pitch, a run of more than a day.
MAX_LENGTH = 100.0  # m
MAX_ROBOTS = 100_000
MAX_DURATION = 86_400.0  # s
MAX_FPS = 240
MIN_SIDE, MAX_SIDE = 64, 8192  # pixels; H.264 level 6.2 ends at 8192
MAX_POSES = 200_000_000  # robots times control periods held in memory: 24 h of 77 robots at 30 Hz

Length = Annotated[float, Field(gt=0, le=MAX_LENGTH)]
Coordinate = Annotated[float, Field(ge=-MAX_LENGTH, le=MAX_LENGTH)]
Colour = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]

KeyPath = tuple[str | int, ...]
Places = Mapping[KeyPath, str]


def key_path(key: str) -> KeyPath:
    """Return the path of a dotted key; numbers are places in a list."""
    return tuple(int(part) if part.isdecimal() and len(part) < 10 else part for part in key.split("."))


def place_of(path: KeyPath, places: Places) -> str:
    """Return the place of a key, or of the innermost group around it that was written."""
    return next((places[path[:n]] for n in range(len(path), -1, -1) if path[:n] in places), "")


class _Model(BaseModel):
    # Strict: "15" in quotes is text and true is no number. Whole numbers still count as real ones.
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Point(_Model):
    x: Coordinate = Field(description="metres from the stage's centre, to the right")
    y: Coordinate = Field(description="metres from the stage's centre, upwards")


ORIGIN = Point(x=0.0, y=0.0)


class Stage(_Model):
    """The rectangle the robots move in, its centre the origin of all coordinates."""

    width: Length = Field(description="extent along x [m]")
    height: Length = Field(description="extent along y [m]")


# --- behaviour -------------------------------------------------------------------------------------------------------


class _Contour(_Model):
    law: Literal["contour"] = Field(description="follow a point that runs along a contour")
    angular_rate: float = Field(ge=-100, le=100, description="rate of the followed point about the centre [rad/s]")
    centre: Point = Field(ORIGIN, description="centre of the contour [m]")

    @property
    def extent(self) -> float:
        """Largest distance [m] of the contour from its centre."""
        raise NotImplementedError


class CircularSinusoid(_Contour):
    """Happiness, Appendix A: r(theta) = R + A sin(f theta)."""

    shape: Literal["circular_sinusoid"] = Field(description="a circle with a sinusoid superimposed")
    R: Length = Field(description="radius of the main circle [m]")
    A: Annotated[float, Field(ge=0, le=MAX_LENGTH)] = Field(description="amplitude of the sinusoid [m], below R")
    f: Annotated[int, Field(ge=1, le=100)] = Field(description="ripples around the circle; the paper's is 6")

    @property
    def extent(self) -> float:
        return self.R + self.A


class ExpandingCircle(_Contour):
    """Surprise, Appendix A: R(t) = mod(expansion_rate t, R_max - R_min) + R_min."""

    shape: Literal["expanding_circle"] = Field(description="a circle that grows from R_min to R_max, again and again")
    R_min: Length = Field(description="radius it starts from [m]")
    R_max: Length = Field(description="radius at which it starts again [m], above R_min")
    expansion_rate: Annotated[float, Field(gt=0, le=100)] = Field(description="growth of the radius [m/s]")

    @property
    def extent(self) -> float:
        return self.R_max


class Circle(_Contour):
    """Sadness, Appendix A: a circle of constant radius."""

    shape: Literal["circle"] = Field(description="a plain circle")
    R: Length = Field(description="radius [m]")

    @property
    def extent(self) -> float:
        return self.R


class Uniform(_Model):
    kind: Literal["uniform"] = Field(description="the same density everywhere")


class Boundary(_Model):
    kind: Literal["boundary"] = Field(description="a ridge of density along every edge of the stage")
    width: Length = Field(description="standard deviation of the ridge's Gaussian profile [m]")
    inset: Annotated[float, Field(ge=0, le=MAX_LENGTH)] = Field(
        0.0, description="distance of its crest from the edge [m]"
    )


class Gaussian(_Model):
    kind: Literal["gaussian"] = Field(description="a round peak of density")
    centre: Point = Field(ORIGIN, description="where it peaks [m]")
    sigma: Length = Field(description="standard deviation [m]")


class Coverage(_Model):
    """Fear, disgust and anger, Appendix A: each robot heads for the centroid of its Voronoi cell."""

    law: Literal["coverage"] = Field(description="spread over a density: u = kappa (c - p)")
    kappa: Annotated[float, Field(gt=0, le=1000)] = Field(description="proportional gain [1/s]")
    u_max: Annotated[float, Field(gt=0, le=1000)] | None = Field(
        None, description="cap on |u| [m/s]; null is the paper's law without one"
    )
    density: Annotated[Uniform | Boundary | Gaussian, Field(discriminator="kind")] = Field(
        description="where the robots gather"
    )
    separation: Annotated[float, Field(ge=0, le=1)] | None = Field(
        None,
        description="clearance [m] kept between bodies: v is cut where the body would leave its own Voronoi cell; "
        "null is the paper's law, which lets bodies touch",
    )


Contour = CircularSinusoid | ExpandingCircle | Circle
Behaviour = Annotated[
    Annotated[Contour, Field(discriminator="shape")] | Coverage,
    Field(discriminator="law"),
]


# --- robots ----------------------------------------------------------------------------------------------------------


class Limits(_Model):
    """What the motors can do. A command beyond a limit is scaled as a whole, so the curvature stays."""

    v_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest linear speed [m/s]")
    omega_max: Annotated[float, Field(gt=0, le=1000)] | None = Field(None, description="largest turning rate [rad/s]")
    wheel_max: Annotated[float, Field(gt=0, le=100)] | None = Field(None, description="largest speed of a wheel [m/s]")


class Robot(_Model):
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


class Pose(_Model):
    x: Coordinate = Field(description="metres from the stage's centre, to the right")
    y: Coordinate = Field(description="metres from the stage's centre, upwards")
    heading: Annotated[float, Field(ge=-1000, le=1000)] = Field(0.0, description="radians, counter-clockwise from x")


class Region(_Model):
    """A rectangle inside the stage."""

    centre: Point = Field(ORIGIN, description="its centre [m]")
    width: Length = Field(description="extent along x [m]")
    height: Length = Field(description="extent along y [m]")


class OnContour(_Model):
    place: Literal["contour"] = Field(description="spread evenly along the contour at t = 0, heading along it")


class _Random(_Model):
    min_spacing: Length | None = Field(
        None, description="smallest distance of two centres [m]; null: bodies just apart"
    )


class InStage(_Random):
    place: Literal["stage"] = Field(description="at random in the whole stage")


class InRegion(_Random):
    place: Literal["region"] = Field(description="at random in a part of the stage")
    region: Region = Field(description="the part, for the robots' centres")


class AtPoses(_Model):
    place: Literal["poses"] = Field(description="where the scene lists")
    poses: Annotated[tuple[Pose, ...], Field(strict=False, min_length=1)] = Field(description="one pose for each robot")


Start = Annotated[OnContour | InStage | InRegion | AtPoses, Field(discriminator="place")]


# --- video -----------------------------------------------------------------------------------------------------------


class Trails(_Model):
    robots: Annotated[int, Field(ge=0, le=MAX_ROBOTS)] = Field(
        5, description="how many robots leave a trail, evenly spread through the swarm; all, if there are fewer"
    )
    width: Annotated[float, Field(gt=0, le=1)] = Field(0.004, description="width of the line [m on the stage]")
    seconds: Annotated[float, Field(gt=0, le=MAX_DURATION)] | None = Field(
        None, description="how long a trail stays [s]; null: for ever"
    )


class Colours(_Model):
    """All as "#rrggbb". The trails' set is colour-blind-safe and darker than the stage in luminance."""

    surround: Colour = Field("#e3e4e8", description="around the stage")
    stage: Colour = Field("#fafaf7", description="the stage")
    boundary: Colour = Field("#9a9ea8", description="the stage's edge")
    body: Colour = Field("#4a5160", description="robots without a trail")
    wheels: Colour = Field("#14161b", description="wheels")
    front: Colour = Field("#ffffff", description="the mark that shows a robot's front")
    trails: Annotated[tuple[Colour, ...], Field(strict=False, min_length=1)] = Field(
        ("#1684ea", "#e15319", "#005432", "#c25d96", "#3d00e4"),
        description="trails and the bodies that leave them, in turn",
    )


class Video(_Model):
    size: Annotated[str, Field(pattern=r"^[1-9][0-9]{1,4}x[1-9][0-9]{1,4}$")] = Field(
        "1280x720", description="width x height [pixels], both even"
    )
    fps: Annotated[int, Field(ge=1, le=MAX_FPS)] = Field(30, description="frames per second")
    trails: Trails = Field(Trails(), description="the lines some robots leave")
    colours: Colours = Field(Colours(), description="the look")

    @property
    def width(self) -> int:
        """Columns of a frame [pixels]."""
        return int(self.size.split("x")[0])

    @property
    def height(self) -> int:
        """Rows of a frame [pixels]."""
        return int(self.size.split("x")[1])


# --- scene -----------------------------------------------------------------------------------------------------------


class Scene(_Model):
    """One swarm, one behaviour, one video."""

    emotion: EmotionName | None = Field(description="the fundamental emotion it stands for; null for none of the six")
    behaviour: Behaviour = Field(description="the law that every robot follows")
    robot: Robot = Field(description="the robot and how it follows the law")
    robots: Annotated[int, Field(ge=1, le=MAX_ROBOTS)] = Field(description="how many")
    stage: Stage = Field(description="the rectangle they move in")
    start: Start = Field(description="where they are at t = 0")
    control_period: Annotated[float, Field(gt=0, le=60)] = Field(
        description="how long a command is held [s]; apart from the video's frame rate"
    )
    duration: Annotated[float, Field(gt=0, le=MAX_DURATION)] = Field(description="length of run and video [s]")
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = Field(description="of all that is random")
    video: Video = Field(Video(), description="how it is shown")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for key, message in _faults(self):
            raise PydanticCustomError("inconsistent", "{message}", {"key": key, "message": message})
        return self

    # Where each key was written, for faults that only the simulator can find (robots that do not fit).
    _places: Places = PrivateAttr(default_factory=dict)

    def remember(self, places: Places) -> None:
        """Keep the places (``file:line``) the keys were written at."""
        self._places = places

    def fault(self, key: str, message: str) -> SceneError:
        """Return the error for what is wrong with `key`, naming the place it was written at."""
        return SceneError(place_of(key_path(key), self._places), key, message)

    @property
    def frames(self) -> int:
        """Frames of the video: duration times fps, to the nearest whole one."""
        return max(1, round(self.duration * self.video.fps))

    def resolved(self) -> dict[str, Any]:
        """Every key with its value, defaults included, in plain types."""
        return self.model_dump(mode="json")


def _faults(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield (key, message) for what no key shows alone."""
    yield from _video_faults(scene.video)
    yield from _robot_faults(scene)
    yield from _behaviour_faults(scene)
    yield from _start_faults(scene)
    poses = scene.robots * scene.duration / scene.control_period
    if poses > MAX_POSES:
        yield (
            "control_period",
            (f"{scene.robots} robots for {scene.duration:g} s make {poses:.1e} poses; at most {MAX_POSES:.0e}"),
        )


def _video_faults(video: Video) -> Iterator[tuple[str, str]]:
    for side in (video.width, video.height):
        if side % 2 or not MIN_SIDE <= side <= MAX_SIDE:
            yield "video.size", f"{video.size}: expected two even numbers from {MIN_SIDE} to {MAX_SIDE}, as in 1280x720"


def _robot_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    robot, body = scene.robot, scene.robot.body
    if body.steers and robot.l is None:
        yield "robot.l", f"missing: a {robot.model} needs a look-ahead distance l [m]"
    if robot.limits is not None and robot.limits == Limits():
        yield "robot.limits", "empty: expected v_max, omega_max or wheel_max, or null for no limits"
    if robot.limits is not None and robot.limits.wheel_max is not None and not body.wheel_base:
        yield "robot.limits.wheel_max", f"a {robot.model} has no wheels"
    if min(scene.stage.width, scene.stage.height) <= 2 * body.radius:
        yield "stage", f"{_rectangle(scene.stage)}: a {robot.model} of {_mm(2 * body.radius)} does not fit in"


def _behaviour_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    law, stage, radius = scene.behaviour, scene.stage, scene.robot.body.radius
    if isinstance(law, CircularSinusoid) and law.A >= law.R:
        yield "behaviour.A", f"{law.A:g}: expected less than R, {law.R:g}"
    if isinstance(law, ExpandingCircle) and law.R_max <= law.R_min:
        yield "behaviour.R_max", f"{law.R_max:g}: expected more than R_min, {law.R_min:g}"
    if isinstance(law, _Contour):
        room = min(stage.width / 2 - abs(law.centre.x), stage.height / 2 - abs(law.centre.y))
        if law.extent + radius > room:
            key = "R_max" if isinstance(law, ExpandingCircle) else "R"
            yield (
                f"behaviour.{key}",
                (
                    f"the contour leaves the stage: it reaches {law.extent:g} m from its centre, plus a body of radius "
                    f"{_mm(radius)}, and the edge is {room:g} m away"
                ),
            )
    if isinstance(law, Coverage) and isinstance(law.density, Gaussian):
        centre = law.density.centre
        if abs(centre.x) > stage.width / 2 or abs(centre.y) > stage.height / 2:
            yield (
                "behaviour.density.centre",
                f"({centre.x:g}, {centre.y:g}) is outside the stage of {_rectangle(stage)}",
            )
    side = min(stage.width, stage.height)
    if isinstance(law, Coverage) and isinstance(law.density, Boundary) and law.density.inset > side / 2:
        yield "behaviour.density.inset", f"{law.density.inset:g}: expected at most half the stage's smaller side"
    if isinstance(law, Coverage) and not isinstance(law.density, Uniform):
        key, scale = ("sigma", law.density.sigma) if isinstance(law.density, Gaussian) else ("width", law.density.width)
        if scale < side / 100:  # its integrals would take for ever, and its peak could not be seen
            yield f"behaviour.density.{key}", f"{scale:g}: expected at least a hundredth of the stage's smaller side"


def _start_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    start, stage, radius = scene.start, scene.stage, scene.robot.body.radius
    half_width, half_height = stage.width / 2 - radius, stage.height / 2 - radius
    if isinstance(start, OnContour) and isinstance(scene.behaviour, Coverage):
        yield "start.place", "contour: a coverage behaviour has none; expected stage, region or poses"
    if isinstance(start, _Random) and start.min_spacing is not None and start.min_spacing < 2 * radius:
        yield "start.min_spacing", f"{start.min_spacing:g}: expected at least the robot's size, {2 * radius:.4f}"
    if isinstance(start, InRegion):
        region, centre = start.region, start.region.centre
        if abs(centre.x) + region.width / 2 > half_width or abs(centre.y) + region.height / 2 > half_height:
            yield (
                "start.region",
                (
                    f"{_rectangle(region)} at ({centre.x:g}, {centre.y:g}) leaves the stage of {_rectangle(stage)} "
                    f"less a body of radius {_mm(radius)}"
                ),
            )
    if isinstance(start, AtPoses):
        if len(start.poses) != scene.robots:
            yield "start.poses", f"{len(start.poses)} poses for {scene.robots} robots"
        for i, pose in enumerate(start.poses):
            if abs(pose.x) > half_width or abs(pose.y) > half_height:
                yield f"start.poses.{i}", f"({pose.x:g}, {pose.y:g}): the body is not on the stage"


def _rectangle(of: Stage | Region) -> str:
    return f"{of.width:g} m x {of.height:g} m"


def _mm(length: float) -> str:
    return f"{1000 * length:.3g} mm"
