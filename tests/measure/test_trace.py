from itertools import pairwise
from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.measure.trace import near_corner, trace, turning, turns, visible_steps
from emovid.measure.window import Window, window_of
from emovid.scene.emotions import EMOTIONS
from emovid.swarm.simulate import simulate
from tests.helpers.driven import driven, refined

STEP = 0.005  # of a GRITSBot


def of(run) -> dict[str, float]:
    return trace(Window(run, 0.0, float(run.t[-1])))


@pytest.fixture(scope="module")
def one(make_scene):
    """Return the descriptors of one robot from the origin along x: one((v, omega), ..., seconds=1)."""
    scene = make_scene("fear", {"robots": 1})
    return lambda *commands, seconds=1.0: driven(scene, [[0, 0, 0]], np.array(commands)[:, None], seconds)


def polyline(angles: list[float], leg: float) -> np.ndarray:
    """Return the corners of a path of equal legs that turns by `angles` [degrees]."""
    heading = np.radians(np.cumsum([0, *angles]))
    return leg * np.concatenate([[[0, 0]], np.cumsum(np.stack([np.cos(heading), np.sin(heading)], -1), axis=0)])


# --- the walk with dividers -------------------------------------------------------------------------------------------


@given(seed=st.integers(0, 10_000), step=st.floats(0.1, 0.6))
def test_each_step_ends_where_the_path_first_leaves_the_circle_about_its_start(seed, step) -> None:
    corners = np.random.default_rng(seed).uniform(-1, 1, (5, 2))
    share = np.linspace(0, 1, 4001)[1:, None]
    fine = np.concatenate([corners[:1], *(a + share * (b - a) for a, b in pairwise(corners))])
    place = 0
    ends = visible_steps(corners, step)
    for start, end in pairwise(ends):
        assert np.hypot(*(end - start)) == pytest.approx(step)
        place += int(np.argmax(np.hypot(*(fine[place:] - start).T) >= step))
        assert np.hypot(*(fine[place] - end)) < 0.05  # the spacing, and more where the path leaves at a slant
    assert np.hypot(*(fine[place:] - ends[-1]).T).max() < step


# --- known answers ----------------------------------------------------------------------------------------------------


def test_a_straight_line_does_not_turn(one) -> None:
    found = of(one((0.2, 0), (0.1, 0), (0.3, 0)))
    assert found["trace_length"] == pytest.approx(0.6, abs=1.1 * STEP)
    assert (found["turning_per_metre"], found["sharp_corner_share"], found["cusps"]) == (0, 0, 0)


@given(r=st.floats(0.02, 1), period=st.floats(0.01, 1), way=st.sampled_from([1, -1]), drive=st.sampled_from([1, -1]))
def test_turning_of_a_circle_is_one_over_its_radius_for_all_commands(one, r, period, way, drive) -> None:
    v = 2 * r  # a third of a turn in a second
    found = of(one(*[(drive * v, way * 2)] * round(4 / period), seconds=period))
    assert found["turning_per_metre"] == pytest.approx(1 / r, rel=0.005)
    assert found["sharp_corner_share"] == found["cusps"] == 0


@pytest.mark.parametrize("angles", [[90, 90, 90], [60, -60, 60], [120, 120], [-45, 100, 30]])
@pytest.mark.parametrize("leg", [0.06, 0.0617, 0.0583])
def test_turning_of_a_polygon_is_the_sum_of_its_corner_angles(angles, leg) -> None:
    turned = turns(visible_steps(polyline(angles, leg), STEP))
    assert turning(turned) == pytest.approx(np.radians(np.abs(angles).sum()), abs=1e-6)


@pytest.mark.parametrize("leg", [0.06, 0.0617, 0.0583])
@pytest.mark.parametrize(("angle", "corners"), [(0, 0), (50, 0), (61, 3), (90, 3), (150, 3), (179, 3)])
def test_a_corner_is_a_turn_of_more_than_60_degrees_and_reaches_half_a_body(angle, corners, leg) -> None:
    sharp = near_corner(turns(visible_steps(polyline([angle, -angle, angle], leg), STEP)))
    assert abs(sharp.sum() * STEP - corners * 0.03) <= corners * STEP


@pytest.mark.parametrize(("radius", "sharp"), [(0.02, False), (0.011, False), (0.007, True), (0.004, True)])
def test_a_bend_is_a_corner_if_it_is_tighter_than_a_third_of_a_body(one, radius, sharp) -> None:
    bend = (radius * np.pi, np.pi)  # half a circle
    assert (of(one((0.06, 0), bend, (0.06, 0)))["sharp_corner_share"] > 0) == sharp


def test_reversals_are_counted(one) -> None:
    found = of(one((0.06, 0), (-0.04, 2), (0.05, 2), (-0.07, -3), (0.06, 1), (0.06, -1)))
    assert found["cusps"] == 4
    assert found["cusps_per_metre"] == pytest.approx(4 / 0.34, rel=0.1)  # up to a step is lost at each tip
    assert found["cusps_per_second"] == pytest.approx(4 / 6)


@pytest.mark.parametrize("leg", [0.04, 0.0413, 0.0377])
@pytest.mark.parametrize(("angle", "cusps"), [(115, 0), (-115, 0), (151, 3), (180, 3)])
def test_cusps_below_thirty_degrees_are_found_at_any_step_offset(angle, cusps, leg) -> None:
    turned = turns(visible_steps(polyline([angle, -angle, angle], leg), STEP))
    assert np.sum(np.abs(turned) > np.radians(120)) == cusps


# --- ignored details --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("leg", [0.0001, 0.0004, 0.0007])
def test_a_zigzag_below_the_resolution_is_a_straight_line(leg) -> None:
    path = polyline([90, -90] * round(0.2 / leg), leg)
    turned = turns(visible_steps(path, STEP))
    assert turning(turned) == 0
    assert not near_corner(turned).any()


@pytest.mark.parametrize(("v", "omega"), [(0, 30), (1e-4, 30), (0.004, 8)])
def test_a_robot_that_spins_leaves_no_trace(one, v, omega) -> None:
    found = of(one(*[(v, omega)] * 10))
    assert found["trace_length"] == found["cusps"] == 0
    assert isnan(found["turning_per_metre"])
    assert isnan(found["sharp_corner_share"])


def test_robot_that_oscillates_by_less_than_a_step_leaves_no_trace(one) -> None:
    assert of(one(*[(0.1, 0.3), (-0.1, 0.2)] * 50, seconds=0.04))["trace_length"] == 0


def test_small_oscillations_along_the_way_are_ignored(one) -> None:
    ways = [(0.1, 0)] * 20 + [(-0.1, 0), (0.1, 0)] * 20 + [(0.1, 0)] * 20
    found = of(one(*ways, seconds=0.02))
    assert found["trace_length"] == pytest.approx(0.08, abs=1.1 * STEP)
    assert (found["turning_per_metre"], found["cusps"]) == (0, 0)


# --- invariance -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("emotion", "tolerance"), [("happiness", 0.005), ("fear", 0.01), ("anger", 0.01)])
def test_finer_control_periods_hardly_change_the_result(make_scene, emotion, tolerance) -> None:
    run = simulate(make_scene(emotion))  # of its whole length: one cusp of 66 in 6 s would be more than 1 %
    coarse, fine = of(run), of(refined(run, 5))
    assert fine == pytest.approx(coarse, rel=tolerance, abs=1e-12)


@given(seed=st.integers(0, 10_000), angle=st.floats(-np.pi, np.pi), x=st.floats(-10, 10), y=st.floats(-10, 10))
def test_results_are_invariant_to_rotation_translation_and_mirroring(make_scene, seed, angle, x, y) -> None:
    scene = make_scene("fear", {"robots": 3})
    commands = np.random.default_rng(seed).uniform([-0.1, -8], [0.2, 8], (12, 3, 2))
    found = of(driven(scene, np.zeros((3, 3)), commands, 0.3))
    moved = of(driven(scene, np.tile([x, y, angle], (3, 1)), commands * [1, -1], 0.3))
    assert moved == pytest.approx(found, rel=1e-6, nan_ok=True)


@given(seed=st.integers(0, 10_000), scale=st.floats(0.1, 10))
def test_turning_scales_with_the_size_of_the_trace_in_steps(seed, scale) -> None:
    points = np.cumsum(np.random.default_rng(seed).normal(0, 0.01, (60, 2)), axis=0)
    plain, scaled = (turns(visible_steps(s * points, s * STEP)) for s in (1, scale))
    assert turning(scaled) == pytest.approx(turning(plain), abs=1e-6)


# --- shipped scenes ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_shipped_scenes_that_look_angular_have_sharp_corners(make_scene, emotion) -> None:
    found = trace(window_of(simulate(make_scene(emotion))))
    if emotion in ("fear", "disgust", "anger"):
        assert found["sharp_corner_share"] > 1 / 3
        assert found["cusps_per_metre"] > 5
    else:
        assert found["sharp_corner_share"] == found["cusps"] == 0
        assert found["turning_per_metre"] < 10


@pytest.mark.parametrize("share", [1 / 12, 1 / 3])
@pytest.mark.parametrize("emotion", EMOTIONS)
def test_half_and_double_steps_also_separate_the_shipped_scenes(make_scene, monkeypatch, emotion, share) -> None:
    monkeypatch.setattr("emovid.measure.window._STEP", share)
    found = trace(window_of(simulate(make_scene(emotion))))
    if emotion in ("fear", "disgust", "anger"):
        assert found["sharp_corner_share"] > 1 / 3
        assert found["turning_per_metre"] > 50
    else:
        assert found["sharp_corner_share"] == 0
        assert found["turning_per_metre"] < 10


def test_the_folds_of_surprise_are_its_only_corners(make_scene) -> None:
    run = simulate(make_scene("surprise", {"behaviour.return_time": None}))
    assert trace(Window(run, 0.0, 4.2))["sharp_corner_share"] == 0  # the radius starts again at 4.25 s
    assert 0 < trace(Window(run, 0.0, 15.0))["sharp_corner_share"] < 0.05


def test_surprise_that_returns_smoothly_has_no_corners(make_scene) -> None:
    assert trace(Window(simulate(make_scene("surprise")), 0.0, 15.0))["sharp_corner_share"] == 0


def test_happiness_turns_along_its_ripples_and_sadness_along_its_ring(make_scene) -> None:
    sadness = simulate(make_scene("sadness"))
    radius = np.hypot(*sadness.poses[-1, 0, :2])
    settled = trace(Window(sadness, 3.0, 15.0))  # it starts with a heading for a slightly larger ring
    assert settled["turning_per_metre"] == pytest.approx(1 / radius, rel=0.02)
    happiness = simulate(make_scene("happiness"))
    assert trace(window_of(happiness))["turning_per_metre"] > 1.5 / 0.275  # more than that of a circle
