"""Start poses of the robots."""

from itertools import product

import numpy as np

from emovid.scene.behaviour import ContourKeys, Coverage, Recorded
from emovid.scene.model import Scene
from emovid.scene.robots import Barrier, spacing_of
from emovid.scene.stage import AtPoses, InRegion, InStage, OnContour, Rectangle
from emovid.swarm.arrays import Array
from emovid.swarm.clearance import room_on_stage
from emovid.swarm.laws import followed_points, settled_points, start_angles, start_headings
from emovid.swarm.unicycle import look_ahead, wrapped
from emovid.swarm.voronoi import pairs_within

# Trial points on the stage for each robot before giving up: random disks cover at most 54.7 % of the plane, and
# reaching that takes without end. Most points miss a stage that is thin and lies diagonally in its box.
_TRIALS_PER_ROBOT = 300
_ROUNDS = 100 * _TRIALS_PER_ROBOT
_ROUNDING = 1e-9  # m


def start_poses(scene: Scene, rng: np.random.Generator) -> Array:
    """Return the poses (N, 3) at t = 0.

    Raises:
        SourceError: if bodies would overlap, leave the stage, or find no room at random.
    """
    if isinstance(scene.behaviour, Recorded):
        raise scene.fault("behaviour.law", "recorded: motion that was recorded elsewhere cannot be simulated")
    match scene.start:
        case OnContour():
            poses = _on_contour(scene)
        case InStage() | InRegion():
            poses = _at_random(scene, scene.start, rng)
        case AtPoses():  # pragma: no branch - there is no other
            poses = np.array([[pose.x, pose.y, pose.heading] for pose in scene.start.poses])
    poses[:, 2] = wrapped(poses[:, 2])
    _check_stage(scene, poses)
    _check_spacing(scene, poses)
    return poses


def _on_contour(scene: Scene) -> Array:
    """Put the look-ahead points on the contour, heading along it, and the centers `l` behind them.

    With the centers on the contour instead, v(0) = -K l: every robot would start backward.
    """
    contour = scene.behaviour
    assert isinstance(contour, ContourKeys)  # a valid scene has a contour to start on
    theta_0 = start_angles(scene.robots)
    heading = start_headings(contour, theta_0)
    points = followed_points(contour, theta_0, 0.0)
    if isinstance(scene.start, OnContour) and scene.start.settled:
        ahead = points - (points := settled_points(contour, theta_0, scene.robot.K))
        heading = np.where((ahead != 0).any(axis=1), np.arctan2(ahead[:, 1], ahead[:, 0]), heading)
    behind = scene.robot.l if scene.robot.body.steers and scene.robot.l else 0.0
    return np.column_stack([points - behind * np.stack([np.cos(heading), np.sin(heading)], axis=-1), heading])


def _at_random(scene: Scene, start: InStage | InRegion, rng: np.random.Generator) -> Array:
    """Draw points uniformly over the region; those off the stage or too near an earlier one are drawn again."""
    radius = scene.robot.body.radius
    spacing = 2 * radius + _separation(scene) if start.min_spacing is None else start.min_spacing
    left, bottom, right, top = scene.stage.box
    low, high = np.array([left, bottom]) + radius, np.array([right, top]) - radius
    if isinstance(start, InRegion):
        low, high = np.array(start.region.corners)[[0, 2]]
    grid = _Grid(spacing)
    max_trials = _TRIALS_PER_ROBOT * min(scene.robots, _most(high - low, spacing))
    on_stage = 0
    for _ in range(_ROUNDS):
        trials = rng.uniform(low, high, (scene.robots, 2))
        trials = trials[room_on_stage(trials, scene.stage) >= _room_needed(scene) - _ROUNDING]
        for x, y in trials.tolist():
            if grid.is_free(x, y):
                grid.add(x, y)
                if len(grid.points) == scene.robots:
                    return np.column_stack([grid.points, rng.uniform(-np.pi, np.pi, scene.robots)])
        on_stage += len(trials)
        if on_stage >= max_trials:
            break
    width, height = high - low
    upright = isinstance(start, InRegion) or isinstance(scene.stage, Rectangle)
    where = f"{width:.3g} m x {height:.3g} m" if upright else f"a stage of {scene.stage}"
    raise scene.fault(
        "robots",
        f"{scene.robots} robots do not fit into {where} at random with {1000 * spacing:g} mm between centers: "
        f"room was found for {len(grid.points)}",
    )


def _most(sides: Array, spacing: float) -> float:
    """Return an upper bound on the points `spacing` [m] apart in a rectangle: disks cover at most pi / sqrt(12)."""
    return 2 / np.sqrt(3) * float(np.prod(sides + spacing)) / spacing**2


def _room_needed(scene: Scene) -> float:
    """Return the distance [m] from the edge that a robot needs at the start, for any heading: a barrier keeps it."""
    body = scene.robot.body
    if not isinstance(scene.safety, Barrier):
        return body.radius
    return max(body.radius, spacing_of(scene.safety, scene.robot) / 2 + abs(body.guarded[0]))


class _Grid:
    """Points no nearer to each other than `spacing` [m], in square bins of that size."""

    def __init__(self, spacing: float) -> None:
        self.spacing = spacing
        self.points: list[tuple[float, float]] = []
        self._bins: dict[tuple[int, int], list[tuple[float, float]]] = {}

    def add(self, x: float, y: float) -> None:
        self.points.append((x, y))
        self._bins.setdefault(self._bin(x, y), []).append((x, y))

    def is_free(self, x: float, y: float) -> bool:
        column, row = self._bin(x, y)
        return all(
            (x - other_x) ** 2 + (y - other_y) ** 2 >= self.spacing**2
            for dx, dy in product((-1, 0, 1), repeat=2)
            for other_x, other_y in self._bins.get((column + dx, row + dy), ())
        )

    def _bin(self, x: float, y: float) -> tuple[int, int]:
        return int(x // self.spacing), int(y // self.spacing)


def _separation(scene: Scene) -> float:
    """Return the clearance [m] that the scene keeps between bodies."""
    return (scene.behaviour.separation if isinstance(scene.behaviour, Coverage) else None) or 0.0


def _check_stage(scene: Scene, poses: Array) -> None:
    outside = room_on_stage(poses[:, :2], scene.stage) < scene.robot.body.radius - _ROUNDING
    if outside.any():
        i = int(np.argmax(outside))
        ahead = poses[:, :2] + (scene.robot.l or 0.0) * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=-1)
        if isinstance(scene.start, OnContour) and (room_on_stage(ahead, scene.stage) >= scene.robot.body.radius).all():
            where = f"robot {i + 1} would start at ({poses[i, 0]:.3g}, {poses[i, 1]:.3g}), off the stage"
            raise scene.fault("robot.l", f"{scene.robot.l:g}: {where}, this far behind its point on the contour")
        raise scene.fault(
            "start", f"robot {i + 1} would start at ({poses[i, 0]:.3g}, {poses[i, 1]:.3g}), off the stage"
        )


def _check_spacing(scene: Scene, poses: Array) -> None:
    body = scene.robot.body
    ahead, radius = body.disc
    middles = look_ahead(poses, ahead)
    least = 2 * radius + _separation(scene)
    i, j = pairs_within(middles, least - _ROUNDING)
    # Disks about the axles that are apart suffice: a random start has ensured that.
    apart = np.hypot(*(poses[i] - poses[j])[:, :2].T) >= 2 * body.radius + _separation(scene) - _ROUNDING
    pairs = np.stack([i, j], axis=1)[~apart]
    if len(pairs):
        one = int(pairs[0, 0])
        others = pairs[(pairs == one).any(axis=1)].sum(axis=1) - one
        distance = np.hypot(*(middles[others] - middles[one]).T)
        nearest = int(distance.argmin())
        found, needed = _distinct_mm(float(distance[nearest]), least)
        raise scene.fault(
            "start.poses" if isinstance(scene.start, AtPoses) else "robots",
            f"{scene.robots} robots do not fit: robots {one + 1} and {others[nearest] + 1} would start "
            f"{found} mm apart, and need {needed} mm{_hint_of_l(scene, poses, least)}",
        )


def _distinct_mm(less: float, more: float) -> tuple[str, str]:
    """Return two lengths [m] in mm, with as few digits, but at least three, as show that they differ."""
    digits = next(n for n in range(3, 18) if f"{1000 * less:.{n}g}" != f"{1000 * more:.{n}g}")
    return f"{1000 * less:.{digits}g}", f"{1000 * more:.{digits}g}"


def _hint_of_l(scene: Scene, poses: Array, least: float) -> str:
    """Return a hint if the robots would fit on the contour itself, and not `robot.l` behind it."""
    if not (isinstance(scene.start, OnContour) and scene.robot.body.steers and scene.robot.l):
        return ""
    middles = look_ahead(poses, scene.robot.body.disc[0] + scene.robot.l)
    near, _ = pairs_within(middles, least - _ROUNDING)
    return "" if len(near) else "; all would fit with a robot.l near 0"
