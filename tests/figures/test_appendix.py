"""The figures of the appendices: shapes, densities, and the diffeomorphism with its effect."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text
from scipy.spatial import Voronoi

from emovid.figures import control_laws
from emovid.figures.control_laws import (
    arrows_of,
    centroids,
    converged,
    densities_figure,
    density_map,
    expanded,
    shapes_figure,
)
from emovid.figures.interaction import interaction_figure, neighbours
from emovid.figures.unicycle import (
    ANGULAR_L,
    LARGE_L,
    PATH,
    SMALL_L,
    clearest_step,
    diffeomorphism_figure,
    follow,
    following_figure,
    robot_figure,
)
from emovid.scene.load import load_robot
from emovid.scene.robots import Body
from emovid.swarm.laws import corners_of, followed_points, start_angles
from emovid.swarm.simulate import simulate
from emovid.swarm.start import start_poses
from emovid.swarm.unicycle import look_ahead, near_identity
from emovid.swarm.voronoi import voronoi_cells


def sharpness(points: np.ndarray, length: float = 0.01) -> float:
    """Return the largest turn [rad] of a trace (P, 2) [m] within a `length` [m]."""
    steps = np.diff(points, axis=0)
    moved = np.hypot(*steps.T) > 0
    angle = np.unwrap(np.arctan2(steps[moved, 1], steps[moved, 0]))
    turned = np.concatenate([[0], np.cumsum(np.abs(np.diff(angle)))])
    gone = np.cumsum(np.hypot(*steps[moved].T))
    return float((np.interp(gone + length, gone, turned) - turned).max())


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


def discs(axes: Axes, name: str) -> list[np.ndarray]:
    return [drawn.get_offsets() for drawn in axes.collections if drawn.get_label() == name]


def arrows(axes: Axes, colour: tuple[float, ...] | None = None) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return tail and tip of each straight arrow, optionally only of one color."""
    found = [patch for patch in axes.patches if isinstance(patch, FancyArrowPatch)]
    return [
        tuple(np.array(end) for end in patch._posA_posB)
        for patch in found
        if colour is None or patch.get_edgecolor() == colour
    ]


# --- the robot --------------------------------------------------------------------------------------------------------


def test_the_robot_has_the_dimensions_of_its_model() -> None:
    assert sorted(word for word in words(robot_figure(load_robot("gritsbot"))) if "mm" in word) == [
        *("10 mm", "30 mm", "30 mm", "35 mm")
    ]
    keys = load_robot("gritsbot").model_dump()
    keys["shape"] |= {"length": 0.1, "width": 0.1}
    other = Body.model_validate(keys | {"wheels": {"radius": 0.016, "width": 0.004, "base": 0.105}})
    figure = robot_figure(other)
    assert sorted(word for word in words(figure) if "mm" in word) == ["100 mm", "100 mm", "105 mm", "32 mm"]
    lengths = [1000 * np.linalg.norm(tip - tail) for tail, tip in arrows(figure.axes[0])]
    assert all(any(length == pytest.approx(known) for length in lengths) for known in (100, 105, 32))


# --- the diffeomorphism -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def happiness(make_scene):
    return simulate(make_scene("happiness", {"duration": 3}))


def test_drawn_step_occurs_in_the_run(happiness) -> None:
    pose, command = clearest_step(happiness)
    k, robot = np.argwhere((happiness.poses[:-1] == pose).all(axis=-1))[0]
    assert np.array_equal(happiness.commands[k, robot], command)
    assert 0 < pose[2] < np.pi / 3
    assert command[1] != 0


def test_no_step_is_drawn_for_robots_without_steering_or_motion(make_scene) -> None:
    points = simulate(make_scene("sadness", {"robot.model": "single_integrator", "duration": 0.1}))
    unicycles = simulate(make_scene("sadness", {"duration": 0.1}))
    for run in (points, replace(unicycles, commands=0 * unicycles.commands)):
        with pytest.raises(ValueError, match="no step"):
            clearest_step(run)


@pytest.mark.parametrize("turn", [1, -1])
def test_the_velocity_of_the_look_ahead_point_is_drawn_with_its_parts(turn) -> None:
    pose, u, K, l = np.array([0.3, -0.2, 0.5]), np.array([0.05, 0.04]), 3.0, 0.025
    u = u if turn > 0 else np.array([0.06, -0.01])
    command = near_identity(u[None], pose[None, 2], K, l)[0]
    assert np.sign(command[1]) == turn
    figure = diffeomorphism_figure(pose, command, load_robot("gritsbot"), K, l)
    ahead = look_ahead(np.array([[0, 0, pose[2]]]), l)[0]
    drawn = [tip - tail for tail, tip in arrows(figure.axes[0]) if np.allclose(tail, ahead)]
    v, across, whole = drawn
    beside = [tip - tail for tail, tip in arrows(figure.axes[0]) if np.allclose(tip - tail, whole / K)]
    assert len(beside) == 1  # u itself, to the scale of K u
    assert v + across == pytest.approx(whole)
    assert v @ across == pytest.approx(0)
    assert whole / np.linalg.norm(whole) == pytest.approx(u / np.linalg.norm(u))
    assert v / np.linalg.norm(v) == pytest.approx(ahead / l)
    assert {"$p$", r"$\tilde{p}$", "$l$", r"$\theta$", "$K u$", "$u$", "$v$", r"$\omega$"} <= set(words(figure))


# --- its effect -------------------------------------------------------------------------------------------------------


def strays(points: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Return the distances (P,) [m] of points (P, 2) from a path with corners (C, 2)."""
    start, edge = path[:-1], np.diff(path, axis=0)
    along = np.einsum("pcd,cd->pc", points[:, None] - start, edge) / np.sum(edge**2, axis=1)
    nearest = start + np.clip(along, 0, 1)[..., None] * edge
    return np.hypot(*np.moveaxis(points[:, None] - nearest, -1, 0)).min(axis=1)


def test_long_control_periods_give_angular_traces_like_those_of_the_scenes() -> None:
    smooth, angular = follow(PATH, SMALL_L), follow(PATH, ANGULAR_L, angular=True)
    assert (smooth.angularity, angular.angularity) == pytest.approx((0.53, 4.6), rel=0.02)
    assert sharpness(angular.poses[:, :2]) > 3 * sharpness(smooth.poses[:, :2])
    assert strays(angular.poses[:, :2], PATH).max() < 0.06
    assert np.linalg.norm(look_ahead(angular.poses[-1:], ANGULAR_L)[0] - PATH[-1]) < 0.06


def test_error_grows_and_turning_falls_from_single_integrator_to_small_to_large_l() -> None:
    points = [follow(PATH, l).poses[:, :2] for l in (None, SMALL_L, LARGE_L)]
    for error in (
        [strays(trace, PATH).max() for trace in points],
        [np.sqrt((strays(trace, PATH) ** 2).mean()) for trace in points],
    ):
        assert error[0] * 1.2 < error[1] < error[2] / 5
    turning = [sharpness(trace) for trace in points]
    assert turning[0] > 1.1 * turning[1] > 2 * turning[2]


def test_a_robot_starts_on_the_path_and_arrives_at_its_end() -> None:
    for l in (None, SMALL_L, LARGE_L):
        poses = follow(PATH, l).poses
        assert poses[0] == pytest.approx([*PATH[0], 0])
        assert np.linalg.norm(look_ahead(poses[-1:], l or 0)[0] - PATH[-1]) < 0.02


def test_distance_from_a_path_is_to_its_nearest_edge() -> None:
    path = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    points = np.array([[1.0, 0.5], [3.0, 0.5], [-3.0, 4.0], [2.0, 1.0], [1.9, 0.2]])
    assert strays(points, path) == pytest.approx([0.5, 1.0, 5.0, 0.0, 0.1])


def test_sharpness_of_a_circle_and_a_corner_by_hand() -> None:
    angle = np.linspace(0, np.pi, 2001)
    circle = 0.05 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    assert sharpness(circle) == pytest.approx(0.01 / 0.05, rel=0.01)
    along = np.linspace(0, 1, 501)[:, None]
    corner = np.concatenate([along * [1, 0], [1, 0] + along[1:] * [0, 1]])
    assert sharpness(corner) == pytest.approx(np.pi / 2)


def test_runs_are_stacked_over_the_same_path() -> None:
    figure = following_figure([follow(PATH, l) for l in (None, SMALL_L, LARGE_L)])
    assert [word for word in words(figure) if word] == [
        "single integrator",
        "unicycle, $l$ = 5 mm, $K|u|T/l$ up to 0.53",
        "unicycle, $l$ = 80 mm, $K|u|T/l$ up to 0.033",
    ]
    places = [axes.get_position() for axes in figure.axes]
    assert places[0].y0 > places[1].y1 > places[1].y0 > places[2].y1
    assert len({place.x0 for place in places}) == 1
    for axes in figure.axes:
        (path,) = [line for line in axes.lines if line.get_label() == "path"]
        assert path.get_xydata() == pytest.approx(PATH)
        assert path.get_linestyle() == "--"


# --- shapes and densities ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def round_runs(make_scene):
    return [simulate(make_scene(name, {"duration": 5})) for name in ("happiness", "surprise", "sadness")]


def test_shapes_show_all_agents_their_targets_and_three_arrows(round_runs) -> None:
    figure = shapes_figure(round_runs, [1, 1, 2])
    blue = (31 / 255, 111 / 255, 180 / 255, 1.0)
    surprise = round_runs[1]
    moments = ([1.0], [0.0, expanded(surprise.scene.behaviour, surprise)], [2.0])
    for axes, run, times in zip(figure.axes, round_runs, moments, strict=True):
        assert all(isinstance(drawn, EllipseCollection) for drawn in axes.collections)
        for agents, targets, t in zip(discs(axes, "agents"), discs(axes, "targets"), times, strict=True):
            assert agents == pytest.approx(run.at(np.array([t]))[0, :, :2])
            assert targets == pytest.approx(followed_points(run.scene.behaviour, start_angles(15), t))
        ends = np.concatenate([arrows_of(run, t) for t in times])
        drawn = arrows(axes, blue)
        assert len(drawn) == 3 * len(times)
        for arrow in drawn:
            assert np.abs(ends - np.array(arrow)).sum(axis=(1, 2)).min() == pytest.approx(0)
    assert {"Happiness", "Surprise", "Sadness", "$R$", "$A$", r"$R_{\min}$", r"$R_{\max}$"} <= set(words(figure))


def test_surprise_is_shown_at_both_radii(round_runs) -> None:
    run = round_runs[1]
    law = run.scene.behaviour
    contours = [
        np.hypot(*line.get_xydata().T)
        for line in shapes_figure([run], [1]).axes[0].lines
        if line.get_label() == "contour"
    ]
    assert contours[0] == pytest.approx(law.R_min)
    assert law.R_max - 0.01 * law.R_min < contours[1].max() <= law.R_max
    assert contours[1].min() == pytest.approx(contours[1].max())


def test_only_arrows_too_short_to_see_are_enlarged(round_runs) -> None:
    insets = [len(axes.child_axes) for axes in shapes_figure(round_runs, [2, 2, 2]).axes]
    assert insets == [0, 0, 1]


def test_robots_that_never_converge_are_drawn_after_the_last_step(make_scene, monkeypatch) -> None:
    scene = make_scene("anger")
    start = start_poses(scene, np.random.default_rng(scene.seed))[:, :2]
    monkeypatch.setattr(control_laws, "_MAX_STEPS", 2)
    assert converged(scene) == pytest.approx(centroids(scene, centroids(scene, start)))


def test_contour_figure_refuses_a_density(make_scene) -> None:
    with pytest.raises(ValueError, match="a coverage behavior has no contour"):
        shapes_figure([simulate(make_scene("fear", {"duration": 0.5}))], [0.0])


def test_converged_robots_are_at_the_centroids_of_their_cells(make_scene) -> None:
    for emotion in ("fear", "disgust", "anger"):
        scene = make_scene(emotion)
        points = converged(scene)
        assert points.shape == (15, 2)
        assert centroids(scene, points) == pytest.approx(points, abs=2e-5)
    with pytest.raises(ValueError, match="only coverage"):
        converged(make_scene("happiness", {"start": {"place": "stage"}}))


def test_high_densities_are_dark(make_scene) -> None:
    maps = {name: density_map(make_scene(name), 100) for name in ("anger", "disgust", "fear")}
    assert all(shares.shape == (80, 120) and shares.max() == pytest.approx(1, abs=0.01) for shares in maps.values())
    assert (maps["fear"] == 1).all()
    middle, corner = (40, 60), (6, 6)
    assert [maps["anger"][place] for place in (middle, corner)] == pytest.approx([1, 0], abs=0.02)
    assert [maps["disgust"][place] for place in (middle, corner)] == pytest.approx([0, 1], abs=0.1)
    figure = densities_figure([make_scene("anger")], [np.zeros((1, 2))])
    (image,) = figure.axes[0].images
    light = [np.sum(image.cmap(share)[:3]) for share in np.linspace(0, 1, 9)]
    assert light == sorted(light, reverse=True)
    assert light[0] > light[-1] + 0.5


def test_robots_on_a_density_are_drawn_at_their_stated_positions(make_scene) -> None:
    points = np.array([[0.1, 0.2], [-0.3, 0.0]])
    figure = densities_figure([make_scene("fear")], [points])
    (drawn,) = discs(figure.axes[0], "robots")
    assert drawn == pytest.approx(points)
    assert words(figure) == ["Fear"]


# --- interactions -----------------------------------------------------------------------------------------------------


def test_neighbors_agree_with_a_voronoi_diagram_with_mirrored_robots(make_scene) -> None:
    stage = make_scene("fear").stage
    points = np.random.default_rng(5).uniform([-0.55, -0.35], [0.55, 0.35], (20, 2))
    mirrored = [
        points * np.array(sign) + [2 * dx, 2 * dy]
        for sign, dx, dy in (([-1, 1], 0.6, 0), ([-1, 1], -0.6, 0), ([1, -1], 0, 0.4), ([1, -1], 0, -0.4))
    ]
    ridges = Voronoi(np.concatenate([points, *mirrored])).ridge_points
    expected = {tuple(sorted(pair)) for pair in ridges.tolist() if max(pair) < 20}
    found = neighbours(points, voronoi_cells(points, corners_of(stage)))
    assert {tuple(pair) for pair in found.tolist()} == expected


def test_contours_need_no_communication_and_coverage_needs_neighbors(make_scene) -> None:
    runs = [simulate(make_scene(name, {"duration": 2})) for name in ("happiness", "fear")]
    figure = interaction_figure(runs, [1, 1], ["a ring", "a scatter"])
    lines = [
        [line for line in axes.lines if line.get_label() == "interaction"] for axes in (figure.axes[0], figure.axes[4])
    ]
    points = runs[1].at(np.array([1.0]))[0, :, :2]
    pairs = neighbours(points, voronoi_cells(points, corners_of(runs[1].scene.stage)))
    assert [len(found) for found in lines] == [0, len(pairs)]
    assert {"none", "Voronoi neighbors", "a ring", "a scatter"} <= set(words(figure))
    assert [words(figure).count(heading) for heading in ("Interactions", "Swarm behavior")] == [1, 1]
    known = discs(figure.axes[5], "neighbours")[0]
    (me,) = discs(figure.axes[5], "agent")[0]
    robot = int(np.argmin(np.linalg.norm(points - me, axis=1)))
    assert len(known) == (pairs == robot).sum()
