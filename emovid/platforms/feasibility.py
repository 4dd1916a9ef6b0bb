"""Feasibility of a scene on a testbed: a simulated run against the rules and the motors of the testbed."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from emovid.platforms.robotarium import (
    ARENAS,
    COLLISION,
    COLLISION_AHEAD,
    MAX_ROBOTS,
    MAX_SECONDS,
    STEP,
    WHEEL_SPEED,
    Arena,
)
from emovid.scene.behaviour import ContourKeys
from emovid.scene.model import Scene
from emovid.swarm.arrays import Array, Mask
from emovid.swarm.clearance import farthest_advance, room_on_stage
from emovid.swarm.laws import followed_points, start_angles
from emovid.swarm.summary import closest_approach
from emovid.swarm.trajectory import Trajectory
from emovid.swarm.unicycle import look_ahead

SPACING = 0.15  # m; between robots: the guide recommends it
_ROUNDING = 1e-6  # m
_ALONG = 720  # moments of a contour's run at which its points are looked at


class Testbed(NamedTuple):
    """A testbed: its arena, and the speed limit of its robots' wheels [m/s]."""

    arena: Arena
    wheel_speed: float = WHEEL_SPEED


TESTBEDS: dict[str, Testbed] = {  # by the names of `scene.emotions.PLATFORMS`
    "robotarium": Testbed(ARENAS["4.3x3.6"]),
    "robotarium-today": Testbed(ARENAS["3.2x2.0"]),
}


@dataclass(frozen=True)
class Check:
    """One line of the report.

    Attributes:
        name: of the check.
        value: the result, in SI units.
        found: the same in words.
        expected: in words; "" if the value is only reported.
        holds: whether it is as expected.
    """

    name: str
    value: float | None
    found: str
    expected: str = ""
    holds: bool = True


def check_platform(run: Trajectory, testbed: Testbed) -> list[Check]:
    """Return all checks of a run on a testbed: rules of the place, room, motors and barrier."""
    return [*_rules(run.scene, testbed), *_room(run), *_motors(run, testbed), *_barrier(run)]


def _rules(scene: Scene, testbed: Testbed) -> list[Check]:
    arena, whole = testbed.arena, scene.step / STEP
    left, bottom, right, top = scene.stage.box
    return [
        Check("robots", scene.robots, str(scene.robots), f"at most {MAX_ROBOTS}", scene.robots <= MAX_ROBOTS),
        Check(
            "duration",
            scene.duration,
            f"{scene.duration:g} s",
            f"at most {MAX_SECONDS:g} s",
            scene.duration <= MAX_SECONDS,
        ),
        Check(
            "stage",
            None,
            f"{right - left:g} m x {top - bottom:g} m",
            f"within the arena of {arena}",
            arena.holds(scene.stage),
        ),
        Check(
            "step of commands",
            scene.step,
            f"{scene.step:g} s",
            f"a multiple of {STEP:g} s",
            round(whole) >= 1 and abs(whole - round(whole)) < 1e-6,
        ),
    ]


def _room(run: Trajectory) -> list[Check]:
    scene = run.scene
    ahead, radius = scene.robot.body.disc
    checks = []
    if (least := contour_spacing(scene)) is not None:
        checks.append(Check("spacing on the contour", least, _mm(least), f"at least {_mm(SPACING)}", least >= SPACING))
    if (middles := closest_approach(run, ahead)) is not None:
        bodies = middles - 2 * radius
        checks.append(Check("between bodies", bodies, _mm(bodies), "above 0 mm", bodies > 0))
        counted = closest_approach(run, COLLISION_AHEAD)
        assert counted is not None  # as many robots as before
        checks.append(Check("collision points", counted, _mm(counted), f"above {_mm(COLLISION)}", counted > COLLISION))
    walls = wall_distance(run)
    return [*checks, Check("from bodies to walls", walls, _mm(walls), "at least 0 mm", walls > -_ROUNDING)]


def _motors(run: Trajectory, testbed: Testbed) -> list[Check]:
    v, omega = np.abs(run.commands[..., 0]), np.abs(run.commands[..., 1])
    wheel = v + run.scene.robot.body.wheel_base / 2 * omega
    most, fastest = testbed.wheel_speed, float(wheel.max())
    share = _share(wheel >= most * (1 - 1e-9), run)
    return [
        Check("fastest wheel", fastest, f"{fastest:.3f} m/s", f"at most {most:g} m/s", fastest <= most * (1 + 1e-9)),
        Check("time with saturated wheels", share, f"{share:.1%}"),
    ]


def _barrier(run: Trajectory) -> list[Check]:
    if run.bend is None or run.relaxed is None:
        return [Check("barrier", None, "none", "safety: barrier", holds=False)]
    bent, most = _share(run.bend > 1e-9, run), float(run.bend.max())
    relaxed = _share(run.relaxed, run)
    return [
        Check("time with commands bent by the barrier", bent, f"{bent:.2%}"),
        Check("farthest that it bent one", most, f"{most:.3f} m/s"),
        Check("time without a solution", relaxed, f"{relaxed:.2%}", "none", relaxed == 0),
    ]


def contour_spacing(scene: Scene) -> float | None:
    """Return the smallest distance [m] of two points that are followed along a contour; None for coverage or one robot.

    The points of the fold of an expanding circle are never nearer than on its smallest circle.
    """
    law = scene.behaviour
    if not isinstance(law, ContourKeys) or scene.robots < 2:
        return None
    theta_0 = start_angles(scene.robots)
    nearest = []
    for t in np.linspace(0, scene.duration, _ALONG):
        points = followed_points(law, theta_0, t)
        nearest.append(cKDTree(points).query(points, k=2)[0][:, 1].min())
    return float(min(nearest))


def wall_distance(run: Trajectory) -> float:
    """Return the smallest distance [m] of a body to the stage's edge at any time, between samples too."""
    stage, seconds = run.scene.stage, np.diff(run.t)
    ahead, radius = run.scene.robot.body.disc
    least = np.inf
    for poses, commands, T in zip(run.poses, run.commands, seconds, strict=False):
        middles = look_ahead(poses, ahead)
        room = room_on_stage(middles, stage)
        speed = np.hypot(commands[:, 0], ahead * commands[:, 1])
        near = room - speed * T < least + radius
        if near.any():
            least = min(least, float(_least_room(poses[near], commands[near], middles[near], run, T)) - radius)
    return least


def _least_room(poses: Array, commands: Array, middles: Array, run: Trajectory, seconds: float) -> float:
    """Return the smallest distance [m] of the bodies' middles to an edge's line within one held command.

    A body's middle moves at one speed in a direction that turns at omega: an arc, as its axle's.
    """
    side = run.scene.robot.body.disc[0] * commands[:, 1]
    speed, course = np.hypot(commands[:, 0], side), poses[:, 2] + np.arctan2(side, commands[:, 0])
    least = np.inf
    for x, y, offset in run.scene.stage.edges:
        advance = speed * farthest_advance(course - np.arctan2(y, x), commands[:, 1], seconds)
        least = min(least, float(np.min(offset - (x * middles[:, 0] + y * middles[:, 1]) - advance)))
    return least


def _share(of: Mask, run: Trajectory) -> float:
    """Return the share of the robots' time in which something is so, (T-1, N)."""
    return float(np.diff(run.t) @ of.mean(axis=1) / (run.t[-1] - run.t[0]))


def _mm(length: float) -> str:
    return f"{1000 * length:.1f} mm"
