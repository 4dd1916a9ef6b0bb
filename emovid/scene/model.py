"""A whole scene: its keys, and the conditions between them.

Every `Scene` object is valid: besides the bounds of each key, `_faults` checks the conditions between keys. Editors
show the field descriptions (`emovid scene schema`).
"""

from collections.abc import Iterator
from math import ceil
from typing import Annotated, Any, Self

from pydantic import Field, PrivateAttr, model_validator

from emovid.errors import SourceError
from emovid.scene.behaviour import (
    AnyDensity,
    Behaviour,
    Boundary,
    CircularSinusoid,
    ContourKeys,
    Coverage,
    ExpandingCircle,
    Gaussian,
    Image,
    Recorded,
    Sum,
)
from emovid.scene.emotions import EMOTIONS, EmotionName
from emovid.scene.fields import MAX_DURATION, MAX_ROBOTS, Point, least, most
from emovid.scene.picture import picture_of
from emovid.scene.robots import MAX_PERIOD, MIN_L, Barrier, Limits, NoSafety, Robot, Safety
from emovid.scene.stage import AtPoses, AtRandom, InRegion, OnContour, Stage, Start
from emovid.scene.video import MAX_GIF_FPS, MAX_SIDE, MIN_SIDE, Video, view_faults
from emovid.yaml_models import Keys, inconsistent
from emovid.yaml_source import Places, key_path, place_of

MAX_POSES = 200_000_000  # robots times control periods held in memory: 24 h of 77 robots at 30 Hz
MAX_SNAPSHOTS = 24
_ROUNDING = 1e-9  # m
_CIRCLE = "the radius of the largest circle on the stage"

Time = Annotated[float, Field(ge=0, le=MAX_DURATION)]


class Scene(Keys):
    """One swarm, one behavior, one video."""

    emotion: EmotionName | None = Field(description="the emotion that it expresses; null for none of the six")
    behaviour: Behaviour = Field(description="the law that every robot follows")
    robot: Robot = Field(description="the robot and how it follows the law")
    robots: Annotated[int, Field(ge=1, le=MAX_ROBOTS)] = Field(description="number of robots")
    stage: Stage = Field(description="the area they move in: width and height, or corners")
    start: Start = Field(description="positions of the robots at t = 0")
    control_period: Annotated[float, Field(gt=0, le=60)] = Field(
        description="time for which a command is held [s], independent of the frame rate of the video"
    )
    duration: Annotated[float, Field(gt=0, le=MAX_DURATION)] = Field(description="length of run and video [s]")
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = Field(description="random seed")
    safety: Safety = Field(NoSafety(), description="none or barrier: method that keeps bodies apart under any law")
    snapshots: Annotated[tuple[Time, ...], Field(strict=False, min_length=1, max_length=MAX_SNAPSHOTS)] | None = Field(
        None,
        description="times of its figure [s], increasing; measurements end at the last; null: as in the paper",
    )
    video: Video = Field(Video(), description="appearance in videos and figures")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for key, message in _faults(self):
            raise inconsistent(key, message)
        return self

    # File and line of each key, for faults that only the simulator finds (robots that do not fit).
    _places: Places = PrivateAttr(default_factory=dict)

    def remember(self, places: Places) -> None:
        """Keep the places (``file:line``) of the keys."""
        self._places = places

    def __repr__(self) -> str:
        law = self.behaviour.__class__.__name__
        return f"Scene({self.emotion or law}, {self.robots} robots, {self.duration:g} s, seed {self.seed})"

    @property
    def warning(self) -> str:
        """A warning about valid values that hardly anyone intends; "" if there is none."""
        if self.control_period < self.duration:
            return ""
        period = f"control_period: {self.control_period:g} s is as long as the run"
        return f"{period}: every robot keeps its first command"

    def fault(self, key: str, message: str) -> SourceError:
        """Return the error for a fault of `key`, with its place in the file."""
        return SourceError(place_of(key_path(key), self._places), message, key=key)

    @property
    def step(self) -> float:
        """Time for which one command is held [s]: the control period, or the barrier's if that is shorter."""
        if not isinstance(self.safety, Barrier):
            return self.control_period
        return self.safety.period or self.control_period / ceil(self.control_period / MAX_PERIOD)

    @property
    def steps_held(self) -> int:
        """Number of steps with the same nominal command."""
        return max(1, round(self.control_period / self.step))

    @property
    def snapshot_times(self) -> tuple[float, ...] | None:
        """The times [s] of its figure: its own, or the paper's for its emotion; None without either."""
        return self.snapshots or (EMOTIONS[self.emotion].snapshot_times if self.emotion else None)

    @property
    def window(self) -> tuple[float, float]:
        """The times of the run [s] at which the video begins and ends."""
        return self.video.begin, self.duration if self.video.end is None else self.video.end

    @property
    def frames(self) -> int:
        """Frames of the video: the seconds that it lasts times fps, to the nearest whole one."""
        begin, end = self.window
        return max(1, round((end - begin) / self.video.speed * self.video.fps))

    def resolved(self) -> dict[str, Any]:
        """Every key with its value, defaults included, in plain types."""
        return self.model_dump(mode="json")


def _faults(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield (key, message) for errors that involve several keys."""
    yield from _video_faults(scene.video)
    yield from _window_faults(scene)
    if scene.video.overlays.density and not isinstance(scene.behaviour, Coverage):
        yield "video.overlays.density", f"true: a {scene.behaviour.law} behavior has no density to show"
    if scene.video.overlays.targets and isinstance(scene.behaviour, Recorded):
        yield "video.overlays.targets", "true: recorded motion has no targets to show"
    if scene.video.view == "perspective":
        yield from view_faults(scene.video, scene.stage, scene.robot.body.height)
    yield from _robot_faults(scene)
    yield from _behaviour_faults(scene)
    yield from _start_faults(scene)
    if isinstance(scene.safety, Barrier):
        yield from _barrier_faults(scene, scene.safety)
    yield from _snapshot_faults(scene)
    poses = scene.robots * scene.duration / scene.step
    if poses > MAX_POSES:
        yield (
            "control_period",
            (f"{scene.robots} robots for {scene.duration:g} s make {poses:.1e} poses; at most {MAX_POSES:.0e}"),
        )


def _video_faults(video: Video) -> Iterator[tuple[str, str]]:
    for side in (video.width, video.height):
        if side % 2 or not MIN_SIDE <= side <= MAX_SIDE:
            yield "video.size", f"{video.size}: expected two even numbers from {MIN_SIDE} to {MAX_SIDE}, as in 1280x720"
    if video.format == "gif" and video.fps > MAX_GIF_FPS:
        yield "video.fps", f"{video.fps}: expected at most {MAX_GIF_FPS} in a gif: browsers show a faster one slowly"
    if video.trails.fade and video.trails.seconds is None:
        yield "video.trails.fade", "true: a permanent trail cannot fade; expected a number for seconds"


def _window_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    begin, end = scene.window
    if end > scene.duration:
        yield "video.end", f"{end:g}: expected at most the duration of the run, {scene.duration:g}"
    elif begin >= end:
        yield "video.begin", f"{begin:g}: expected less than the end of the video, {end:g}"


def _robot_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    robot, body = scene.robot, scene.robot.body
    if body.steers and robot.l is None:
        yield "robot.l", f"missing: a {body.name} needs a look-ahead distance l [m]"
    if robot.l is not None and robot.l < MIN_L:
        yield "robot.l", f"{robot.l:g}: expected at least a micrometer, {MIN_L:g}"
    if robot.limits is not None and robot.limits == Limits():
        yield "robot.limits", "empty: expected v_max, omega_max or wheel_max, or null for no limits"
    if robot.saturation == "clip" and (robot.limits is None or robot.limits.wheel_max is None):
        yield (
            "robot.saturation",
            "clip: there is no limit of the wheels' speed; expected scale, or robot.limits of wheel_max",
        )
    if robot.limits is not None and robot.limits.wheel_max is not None and not body.wheel_base:
        yield "robot.limits.wheel_max", f"a {body.name} has no wheels"
    if scene.stage.inradius <= body.radius:
        yield "stage", f"{scene.stage}: a {body.name} of {_mm(2 * body.radius)} does not fit in"


def _behaviour_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    law, stage, radius = scene.behaviour, scene.stage, scene.robot.body.radius
    if isinstance(law, CircularSinusoid) and law.A >= law.R:
        yield "behaviour.A", f"{law.A:g}: expected less than R, {law.R:g}"
    if isinstance(law, ExpandingCircle) and law.R_max <= law.R_min:
        yield "behaviour.R_max", f"{law.R_max:g}: expected more than R_min, {law.R_min:g}"
    if isinstance(law, ContourKeys):
        yield from _centre_faults("behaviour.centre", law.centre, stage)
        room = stage.room(law.centre.x, law.centre.y)
        if law.extent + radius > room:
            key = "R_max" if isinstance(law, ExpandingCircle) else "R"
            yield (
                f"behaviour.{key}",
                (
                    f"the contour leaves the stage: it reaches {law.extent:g} m from its center, plus a body of radius "
                    f"{_mm(radius)}, and the edge is {room:g} m away"
                ),
            )
    if isinstance(law, Coverage):
        yield from _density_faults("behaviour.density", law.density, stage)


def _density_faults(key: str, density: AnyDensity, stage: Stage) -> Iterator[tuple[str, str]]:
    # The integrals of finer densities would take too long, and a peak would be invisible; a picture is many peaks.
    match density:
        case Sum():
            for i, part in enumerate(density.parts):
                yield from _density_faults(f"{key}.parts.{i}.density", part.density, stage)
        case Gaussian():
            yield from _centre_faults(f"{key}.centre", density.centre, stage)
            yield from _scale_faults(f"{key}.sigma", density.sigma, stage, 50, "a fiftieth")
        case Boundary():
            if density.inset > stage.inradius:
                yield f"{key}.inset", f"{density.inset:g}: expected at most {most(stage.inradius)}, {_CIRCLE}"
            yield from _scale_faults(f"{key}.width", density.width, stage, 50, "a fiftieth")
        case Image():
            yield from _picture_faults(key, density)
            yield from _scale_faults(f"{key}.smoothing", density.smoothing, stage, 20, "a twentieth")


def _scale_faults(key: str, scale: float, stage: Stage, parts: int, share: str) -> Iterator[tuple[str, str]]:
    if scale < stage.inradius / parts:
        yield key, f"{scale:g}: expected at least {least(stage.inradius / parts)}, {share} of {_CIRCLE}"


def _picture_faults(key: str, density: Image) -> Iterator[tuple[str, str]]:
    picture = picture_of(density.pixels) if density.pixels else None
    if picture is None:
        yield f"{key}.pixels", "not the contents of a picture; expected null, so that the file is read"
    elif not picture.is_dark:
        yield f"{key}.file", f"{density.file}: white all over; expected something darker"


def _centre_faults(key: str, centre: Point, stage: Stage) -> Iterator[tuple[str, str]]:
    if stage.room(centre.x, centre.y) < -_ROUNDING:
        yield key, f"({centre.x:g}, {centre.y:g}) is outside the stage of {stage}"


def _start_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    start, stage, radius = scene.start, scene.stage, scene.robot.body.radius
    if isinstance(start, OnContour) and not isinstance(scene.behaviour, ContourKeys):
        yield "start.place", f"contour: a {scene.behaviour.law} behavior has none; expected stage, region or poses"
    if isinstance(start, AtRandom) and start.min_spacing is not None and start.min_spacing < 2 * radius:
        yield "start.min_spacing", f"{start.min_spacing:g}: expected at least the robot's size, {least(2 * radius)}"
    if isinstance(start, InRegion):
        region, x, y = start.region, start.region.centre.x, start.region.centre.y
        if min(stage.room(*corner) for corner in region.corners) < radius - _ROUNDING:
            yield (
                "start.region",
                (
                    f"{region.width:g} m x {region.height:g} m at ({x:g}, {y:g}) leaves the stage of {stage} less a "
                    f"body of radius {_mm(radius)}"
                ),
            )
    if isinstance(start, AtPoses):
        if len(start.poses) != scene.robots:
            yield "start.poses", f"{len(start.poses)} poses for {scene.robots} robots"
        for i, pose in enumerate(start.poses):
            if stage.room(pose.x, pose.y) < radius - _ROUNDING:
                yield f"start.poses.{i}", f"({pose.x:g}, {pose.y:g}): the body is not on the stage"


def _barrier_faults(scene: Scene, barrier: Barrier) -> Iterator[tuple[str, str]]:
    limits, body = scene.robot.limits or Limits(), scene.robot.body
    size = 2 * body.guarded[1]
    if barrier.spacing is not None and barrier.spacing < size:
        yield "safety.spacing", f"{barrier.spacing:g}: expected at least a {body.name}'s size, {least(size)}"
    if barrier.gamma * scene.step > 1 + _ROUNDING:
        yield "safety.gamma", f"{barrier.gamma:g}: expected at most {most(1 / scene.step)}, one over its period"
    if abs(scene.steps_held * scene.step - scene.control_period) > _ROUNDING:
        yield "safety.period", f"{barrier.period:g}: expected a whole number of times in the control period"
    if isinstance(scene.behaviour, Coverage) and scene.behaviour.separation is not None:
        yield "behaviour.separation", f"{scene.behaviour.separation:g}: expected null with a barrier, which does more"
    if body.steers and limits.wheel_max is None and (limits.v_max is None or limits.omega_max is None):
        yield (
            "safety.kind",
            "barrier: it needs the limits of the motors; expected robot.limits of wheel_max, or v_max and omega_max",
        )
    if not body.steers and limits.v_max is None:
        yield "safety.kind", "barrier: it needs the limits of the motors; expected robot.limits of v_max"


def _snapshot_faults(scene: Scene) -> Iterator[tuple[str, str]]:
    times = scene.snapshots or ()
    for i, t in enumerate(times):
        if t > scene.duration:
            yield f"snapshots.{i}", f"{t:g}: expected at most the duration, {scene.duration:g}"
        if i and t <= times[i - 1]:
            yield f"snapshots.{i}", f"{t:g}: expected more than the one before, {times[i - 1]:g}"


def _mm(length: float) -> str:
    return f"{1000 * length:.3g} mm"
