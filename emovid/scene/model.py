"""A whole scene: its keys, and what they demand of each other.

A `Scene` that exists is valid: besides each key's own bounds, `_faults` holds the keys against each other. The
field descriptions are the hover help of editors (`emovid scene schema`).
"""

from collections.abc import Iterator
from typing import Annotated, Any, Self

from pydantic import Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from emovid.errors import SceneError
from emovid.places import Places, key_path, place_of
from emovid.scene.behaviour import (
    Behaviour,
    Boundary,
    CircularSinusoid,
    ContourKeys,
    Coverage,
    ExpandingCircle,
    Gaussian,
    Uniform,
)
from emovid.scene.emotions import EmotionName
from emovid.scene.fields import MAX_DURATION, MAX_ROBOTS, Keys, Length
from emovid.scene.robots import MIN_L, Limits, Robot
from emovid.scene.start import AtPoses, AtRandom, InRegion, OnContour, Region, Start
from emovid.scene.video import MAX_SIDE, MIN_SIDE, Video

MAX_POSES = 200_000_000  # robots times control periods held in memory: 24 h of 77 robots at 30 Hz


class Stage(Keys):
    """The rectangle the robots move in, its centre the origin of all coordinates."""

    width: Length = Field(description="extent along x [m]")
    height: Length = Field(description="extent along y [m]")


class Scene(Keys):
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
    if robot.l is not None and robot.l < MIN_L:
        yield "robot.l", f"{robot.l:g}: expected at least a micrometre, {MIN_L:g}"
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
    if isinstance(law, ContourKeys):
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
    if isinstance(start, AtRandom) and start.min_spacing is not None and start.min_spacing < 2 * radius:
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
