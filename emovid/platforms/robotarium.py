"""A scene as a script for the Robotarium: one flat file for its simulator and its testbed, of either interface.

The laws in the script are the source of the functions that simulate scenes here, so that they are tested once.
docs/export-robotarium.md has the demands of the testbed and the simulators, with sources.
"""

import ast
import re
from collections.abc import Callable, Mapping
from importlib.metadata import version
from inspect import getsource
from pathlib import Path
from textwrap import indent, wrap
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from emovid.scene.behaviour import (
    AnyDensity,
    Boundary,
    CircularSinusoid,
    Contour,
    ContourKeys,
    Coverage,
    ExpandingCircle,
    Gaussian,
    Image,
    Sum,
    Uniform,
)
from emovid.scene.load import scene_digest
from emovid.scene.model import Scene
from emovid.scene.robots import Barrier, spacing_of
from emovid.scene.stage import Stage, StageKeys
from emovid.scene.video import THEMES
from emovid.swarm import densities, line_integrals, quadrature, voronoi
from emovid.swarm.arrays import Array
from emovid.swarm.densities import density_of, picture_peaks
from emovid.swarm.laws import expanding_radius
from emovid.swarm.start import start_poses
from emovid.swarm.unicycle import look_ahead
from emovid.video.trails import trailed_robots

STEP = 0.033  # s; of the testbed and its simulators
MAX_ROBOTS = 20
MAX_SECONDS = 15 * 60.0  # of an experiment: its guide
WHEEL_SPEED = 0.2  # m/s
_HALF_BASE = 0.055  # m; half the wheel base of the GTernal, the larger of the two robots that the testbed has had
COLLISION_AHEAD, COLLISION = 0.025, 0.135  # m; its simulators count points so far ahead of the axles, so near
_MARGIN = 0.003  # m; beyond that
_CLOSE, _PARKED_APART = 0.3, 0.45  # m; the simulator 2.x sets robots down with a barrier of 0.25 m, to 0.05 m
_PARKED_INSIDE = 0.15  # m; from the edges of the arena
_APPROACH = 60.0  # s
_TRAILS = 4  # robots with a trail in Fig. 13
_TEMPLATE = Path(__file__).with_name("robotarium_script.py.in")


class Arena(NamedTuple):
    """An arena of the Robotarium, its center the origin [m]."""

    width: float
    height: float

    def __str__(self) -> str:
        return f"{self.width} m x {self.height} m"

    def holds(self, stage: StageKeys) -> bool:
        """Return whether a stage lies within it."""
        return all(abs(x) <= self.width / 2 + 1e-9 and abs(y) <= self.height / 2 + 1e-9 for x, y in stage.outline)


ARENAS: Mapping[str, Arena] = {"3.2x2.0": Arena(3.2, 2.0), "4.3x3.6": Arena(4.3, 3.6)}


def robotarium_script(scene: Scene, name: str, arena: Arena, *, trails: bool = False) -> str:
    """Return the script that runs a scene on the Robotarium.

    Args:
        scene: what to run.
        name: of the scene, for the script's header.
        arena: that it must fit in.
        trails: whether it draws the scene's trails in the figure that the testbed projects.

    Raises:
        SourceError: for a scene that the Robotarium cannot run, or would refuse.
    """
    _check(scene, arena)
    poses = start_poses(scene, np.random.default_rng(scene.seed))
    _check_spacing(scene, poses)
    law = scene.behaviour
    sections = {
        "trails": trails,
        "coverage": isinstance(law, Coverage),
        "contour": not isinstance(law, Coverage),
        "expanding": isinstance(law, ExpandingCircle),
    }
    parts = {"header": _header(scene, name, arena), "imports": ""}
    constants = [f'POSES_FILE = "{_plain(name)}-poses.csv"', *_common(scene, poses, arena)]
    if trails:
        constants.append(_trails(scene, poses))
    if isinstance(law, Coverage):
        constants += _coverage(scene, law)
        parts |= _copied_integrals(scene, law)
    elif isinstance(law, ContourKeys):  # recorded motion has no start
        constants += _contour(law)
        parts |= {"radius": indent(_radius(law), "    ")}
        if isinstance(law, ExpandingCircle):
            imports = "from math import cos, pi\nfrom types import SimpleNamespace\n\n"
            copied = getsource(expanding_radius).rstrip().replace("ExpandingCircle", "SimpleNamespace")
            parts |= {"expanding": f"\n{copied}", "imports": imports}
    parts["scene"] = "\n".join(constants)
    text = "\n".join(_chosen(_TEMPLATE.read_text(encoding="utf-8").splitlines(), sections))
    for key, value in parts.items():
        text = text.replace(f"{{{{{key}}}}}", value)
    return re.sub(r"\n{4,}", "\n\n\n", text) + "\n"  # text between omitted sections


def _check(scene: Scene, arena: Arena) -> None:
    """Raise the `SourceError` of a scene that the Robotarium cannot run, or would refuse."""
    robot, longest = scene.robot, MAX_SECONDS - _APPROACH
    for key, fault, message in (
        ("robots", scene.robots > MAX_ROBOTS, f"{scene.robots}: the Robotarium has at most {MAX_ROBOTS}"),
        ("duration", scene.duration > longest, f"{scene.duration:g}: expected at most {longest:g} s"),
        ("robot.model", not robot.body.steers, f"a {robot.body.name}: expected a unicycle, such as gritsbot_x"),
        ("robot.saturation", robot.saturation == "clip", "clip: expected scale; what is clipped counts as an error"),
        (
            "stage",
            not arena.holds(scene.stage),
            f"{scene.stage}: does not fit in the arena of {arena}; --arena names another",
        ),
        ("safety", not isinstance(scene.safety, Barrier), "none: expected barrier; a collision there is an error"),
    ):
        if fault:
            raise scene.fault(key, message)


def _check_spacing(scene: Scene, poses: Array) -> None:
    """Raise the `SourceError` of robots that start nearer to each other than the Robotarium lets them be."""
    apart = _apart(look_ahead(poses, COLLISION_AHEAD))
    if apart <= COLLISION:
        near = f"two would start {1000 * apart:.0f} mm apart; a collision there is at {1000 * COLLISION:g}"
        raise scene.fault("robots", near)


def _apart(points: Array) -> float:
    """Return the smallest distance [m] between two of some points (N, 2)."""
    distance = np.hypot(*(points[:, None] - points).T) + np.where(np.eye(len(points)), np.inf, 0.0)
    return float(distance.min())


def _header(scene: Scene, name: str, arena: Arena) -> str:
    name = _plain(name)
    first = f"{name}: {scene.robots} robots for {scene.duration:g} s on the Robotarium."
    lines = [
        f"Scene: {name}, SHA-256 {scene_digest(scene)}",
        f"Emotion: {scene.emotion or 'none of the six'}",
        f"Seed: {scene.seed}",
        f"Arena: {arena}",
        f"Written by: emovid {version('emovid')}",
    ]
    about = (
        "It needs numpy and rps alone, and runs with the Robotarium's Python simulator 1.x and 2.x and on its testbed. "
        "The laws are of M. Santos and M. Egerstedt, Int. J. Social Robotics 2021, doi 10.1007/s12369-020-00665-6."
    )
    return "\n".join(['"""' + first, "", *lines, "", *wrap(about, 118), '"""'])


def _plain(name: str) -> str:
    """Return a name that is safe in code, since a file can have any."""
    return re.sub(r"[^\w .+-]", "_", name)


def _common(scene: Scene, poses: Array, arena: Arena) -> list[str]:
    robot, safety, limits = scene.robot, scene.safety, scene.robot.limits
    assert isinstance(safety, Barrier)
    assert limits is not None  # a valid scene with a barrier has them
    assert robot.l is not None
    own = (limits.wheel_max, limits.v_max, limits.omega_max and limits.omega_max * _HALF_BASE)
    ahead = robot.body.guarded[0]
    spacing = max(
        spacing_of(safety, robot), COLLISION + _MARGIN + 2 * abs(COLLISION_AHEAD - ahead)
    )  # so none is counted
    most = min(WHEEL_SPEED, *(limit for limit in own if limit is not None))
    edges = "".join(f"    ({_n(edge.x)}, {_n(edge.y)}, {_n(edge.offset)}),\n" for edge in scene.stage.edges)
    return [
        f"N = {scene.robots}",
        f"STEPS = {max(round(scene.duration / STEP), 1)}  # {scene.duration:g} s",
        f"PERIOD = {_n(scene.control_period)}  # for which a wanted command is held",
        f"SAFE_PERIOD = {_n(scene.step)}  # for which a safe one is",
        f"K = {_n(robot.K)}  # proportional gain",
        f"L = {_n(robot.l)}  # distance of the look-ahead points",
        f"MOST = {_n(most * (1 - 1e-6))}  # speed of a wheel [m/s]",
        f"AHEAD = {_n(ahead)}  # of the axle is the middle of a body",
        f"SPACING = {_n(spacing)}  # kept between the middles of two; half of it to an edge",
        f"GAMMA = {_n(safety.gamma)}  # how fast robots may use up what is left beyond it [1/s]",
        f"START = {_table(poses)}",
        f"PARKED = {_table(_parked(poses, arena))}",
        f"APPROACH = {round(_APPROACH / STEP)}  # steps from there to START at most",
        f"EDGES = [  # of the stage: outward normal, and its distance from the origin along it\n{edges}]",
    ]


def _table(poses: Array) -> str:
    rows = "".join(f"        ({x:.6f}, {y:.6f}, {heading:.6f}),\n" for x, y, heading in poses.tolist())
    return f"np.array(\n    [  # x, y, heading\n{rows}    ]\n).T"


def _parked(poses: Array, arena: Arena) -> Array:
    """Return poses (N, 3) wider apart, from which all can drive straight, backward, to the given ones.

    Both coordinates grow from the middle of the swarm: on their way back, robots get no nearer than they will be.
    """
    points = poses[:, :2]
    apart = _apart(points)
    if apart >= _CLOSE:
        return poses
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    room = np.array([arena.width, arena.height]) / 2 - _PARKED_INSIDE - np.abs(middle)
    most = room / np.maximum(np.abs(points - middle).max(axis=0), 1e-9)
    away = (points - middle) * (np.clip(_PARKED_APART / apart, 1.0, np.maximum(most, 1.0)) - 1.0)
    heading = np.where(np.hypot(*away.T) > 0, np.arctan2(away[:, 1], away[:, 0]), poses[:, 2])
    return np.column_stack([points + away, heading])


def _trails(scene: Scene, poses: Array) -> str:
    """Return the robots that leave a trail: the scene's if its trails are permanent, else four, as in the paper."""
    colours, look = scene.video.palette.trails, scene.video.trails
    if look.seconds is not None:
        colours, look = THEMES[scene.video.theme].trails, look.model_copy(update={"robots": _TRAILS})
    robots = trailed_robots(poses, look.robots).tolist()
    listed = ", ".join(f'{robot}: "{colours[i % len(colours)]}"' for i, robot in enumerate(robots))
    return f"TRAILS = {{{listed}}}  # robots that leave one, and their colors"


def _contour(law: Contour) -> list[str]:
    constants = [
        f"ANGULAR_RATE = {_n(law.angular_rate)}  # of the followed points [rad/s]",
        f"CENTRE = np.array([{_n(law.centre.x)}, {_n(law.centre.y)}])",
    ]
    if isinstance(law, ExpandingCircle):
        keys = {name: getattr(law, name) for name in ("R_min", "R_max", "expansion_rate", "return_time")}
        constants.append(f"CIRCLE = SimpleNamespace({', '.join(f'{name}={value!r}' for name, value in keys.items())})")
    return constants


def _copied_integrals(scene: Scene, law: Coverage) -> dict[str, str]:
    """Return the parts of the template with the functions that compute centroids here, and the scene's density."""
    density = density_of(law.density, scene.stage)
    copied: list[Callable[..., Any]] = [voronoi.Fans, voronoi.clipped_cells, voronoi._clipped_cell, voronoi._clip]
    sources = [getsource(each) for each in copied]
    if density.gaussians:
        terms = density.gaussians
        values = f"{terms.uniform!r}, {_rows(terms.ridges)}, {_rows(terms.peaks)}"
        sources += [getsource(densities.Gaussians), _body(line_integrals), f"DENSITY = Gaussians({values})"]
        integrals = "line_integrals"
    else:
        say = '"""Return the density at positions x, y (arrays of one shape); only ratios matter."""'
        phi = f"def phi(x, y):\n    {say}\n    return {density_source(law.density, scene.stage).expression}"
        made = f"DENSITY = Density(phi, {float(density.scale)!r})"
        sources += [getsource(densities.Density), _body(quadrature), phi, made]
        integrals = "mass_and_moment"
    imports = "from functools import cache\n" + ("" if density.gaussians else "from itertools import pairwise\n")
    parts = {"imports": f"{imports}from typing import NamedTuple\n\n"}
    return parts | {"copied": "\n\n\n".join(source.strip() for source in sources), "integrals": integrals}


def _rows(terms: Array) -> str:
    """Return terms (F, fields) as source."""
    listed = "".join(f"        {row},\n" for row in terms.tolist())
    return f"np.array(\n    [\n{listed}    ],\n    dtype=float,\n).reshape(-1, {terms.shape[1]})"


def _body(module: ModuleType) -> str:
    """Return the source of a module after its imports."""
    text = getsource(module)
    imports = [node for node in ast.parse(text).body if isinstance(node, ast.Import | ast.ImportFrom)]
    return "".join(text.splitlines(keepends=True)[imports[-1].end_lineno :])


def _radius(law: Contour) -> str:
    match law:
        case CircularSinusoid():
            return f"return {_n(law.R)} + {_n(law.A)} * np.sin({law.f} * theta)"
        case ExpandingCircle():
            return "return np.full_like(theta, expanding_radius(CIRCLE, t))"
        case _:
            return f"return np.full_like(theta, {_n(law.R)})"


def _coverage(scene: Scene, law: Coverage) -> list[str]:
    corners = "".join(f"    ({_n(x)}, {_n(y)}),\n" for x, y in scene.stage.outline)
    source = density_source(law.density, scene.stage)
    return [
        f"KAPPA = {_n(law.kappa)}  # proportional gain [1/s]",
        f"U_MAX = {'np.inf' if law.u_max is None else _n(law.u_max)}  # cap on |u| [m/s]",
        f"STAGE = np.array([\n{corners}], dtype=float)  # its corners, counter-clockwise",
        *source.tables,
    ]


def _n(number: float) -> str:
    """Return a number as Python writes it, shortly."""
    return repr(float(number) + 0.0).removesuffix(".0")  # no -0


def _chosen(lines: list[str], sections: Mapping[str, bool]) -> list[str]:
    """Return the lines of the template without the sections that are not wanted: ``#: name`` starts one."""
    chosen, wanted = [], True
    for line in lines:
        if line.startswith("#: "):
            wanted = sections.get(line[3:], True)
        elif wanted:
            chosen.append(line)
    return chosen


class Source(NamedTuple):
    """A density as source.

    Attributes:
        expression: of x and y, arrays of one shape, and of a list EDGES of (n_x, n_y, offset).
        tables: assignments and functions that it needs, as lines.
    """

    expression: str
    tables: tuple[str, ...] = ()


def density_source(density: AnyDensity, stage: Stage) -> Source:
    """Return the source of a density, as `densities.density_of` has it."""
    return _source(density, stage, "PICTURE")


def _source(density: AnyDensity, stage: Stage, name: str) -> Source:
    match density:
        case Uniform():
            return Source("np.ones_like(x)")
        case Gaussian():
            square = f"(x - {density.centre.x!r}) ** 2 + (y - {density.centre.y!r}) ** 2"
            return Source(f"np.exp(-({square}) / {2 * density.sigma**2!r})")
        case Boundary():
            square = f"(offset - {density.inset!r} - n_x * x - n_y * y) ** 2"
            ridges = f"[1 - np.exp(-({square}) / {2 * density.width**2!r}) for n_x, n_y, offset in EDGES]"
            return Source(f"1 - np.prod({ridges}, axis=0)")
        case Image():
            return _picture(density, stage, name)
        case Sum():  # pragma: no branch - there is no other
            parts = [_source(part.density, stage, f"{name}_{i}") for i, part in enumerate(density.parts, start=1)]
            weights = [part.weight for part in density.parts]
            terms = [f"{weight!r} * {part.expression}" for weight, part in zip(weights, parts, strict=True)]
            tables = tuple(table for part in parts for table in part.tables)
            return Source("(\n    " + "\n    + ".join(terms) + "\n)", tables)


def _picture(density: Image, stage: Stage, name: str) -> Source:
    """A grid of peaks: see `densities.picture_peaks`."""
    weights, x_peaks, y_peaks = picture_peaks(density, stage)
    rows = "".join(f"        [{_numbers(row)}],\n" for row in weights)
    factor = -0.5 / density.smoothing**2
    tables = (
        f"{name} = np.array(\n    [  # heights of the peaks that a picture is made of, by x and then y\n{rows}    ]\n)",
        *(
            f"{name}_{axis} = np.linspace({float(peaks[0])!r}, {float(peaks[-1])!r}, {len(peaks)})"
            for axis, peaks in (("X", x_peaks), ("Y", y_peaks))
        ),
    )
    along_x = f"np.exp({factor!r} * (x.reshape(-1, 1) - {name}_X) ** 2)"
    along_y = f"np.exp({factor!r} * (y.reshape(-1, 1) - {name}_Y) ** 2)"
    return Source(f"np.sum({along_x} @ {name} * {along_y}, axis=1).reshape(x.shape)", tables)


def _numbers(row: Array) -> str:
    return ", ".join(f"{value:.4g}" for value in row.tolist())
