import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from emovid.scene.load import Setting, load_scene, parse_scene, scene_digest, scene_text
from emovid.scene.stage import Rectangle, edges_of, first_fault, inradius_of, outline_of
from tests.helpers.stages import HEXAGON, THIN, TRIANGLE, convex_corners, keys_of, polygon

BOX = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)]
EITHER_WAY = st.sampled_from([1, -1])


def turned(corners, first, way):
    """Return the same corners from another start, optionally in reverse order."""
    return (corners[first:] + corners[:first])[::way]


# --- corners ---------------------------------------------------------------------------------------------------------


@given(convex_corners(), st.integers(0, 8), EITHER_WAY)
def test_convex_corners_are_accepted_in_any_order_around(corners, first, way):
    assert first_fault(turned(corners, first, way)) is None


@given(convex_corners(), st.integers(0, 8), EITHER_WAY)
def test_outline_is_independent_of_first_corner_and_direction(corners, first, way):
    outline = outline_of(turned(corners, first, way))
    assert outline == outline_of(corners)
    assert outline[0] == min(corners)
    x, y = np.array(outline).T
    assert (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() > 0  # counter-clockwise: a positive area


@given(convex_corners(), st.integers(0, 8), EITHER_WAY)
def test_concave_corner_is_named(corners, before, way):
    i = before % len(corners)
    dent = tuple(0.9 * np.mean(corners, axis=0) + 0.1 * np.array(corners[i]))
    dented = [*corners[: i + 1], dent, *corners[i + 1 :]][::way]
    at, message = first_fault(dented)
    assert dented[at] == dent
    assert "not convex here" in message


@given(convex_corners(), st.integers(0, 8), st.floats(0.1, 0.9))
def test_a_corner_on_an_edge_is_named(corners, before, share):
    i = before % len(corners)
    a, b = np.array(corners[i]), np.array(corners[(i + 1) % len(corners)])
    corners.insert(i + 1, tuple(a + share * (b - a)))
    assert first_fault(corners) == (i + 1, "on the line between the neighboring corners: expected corners only")


def test_star_with_constant_turning_direction_is_not_convex():
    star = [(np.sin(0.8 * np.pi * k), np.cos(0.8 * np.pi * k)) for k in range(5)]
    assert "not convex here" in first_fault(star)[1]


# --- edges and the largest circle ------------------------------------------------------------------------------------


@given(convex_corners())
def test_edges_are_unit_normals_to_the_lines_through_two_corners(corners):
    edges = np.array(edges_of(outline_of(corners)))
    assert np.hypot(edges[:, 0], edges[:, 1]) == pytest.approx(np.ones(len(corners)))
    rooms = edges[:, 2] - np.array(corners) @ edges[:, :2].T
    assert rooms.min() > -1e-12
    assert ((rooms < 1e-12).sum(axis=0) == 2).all()
    assert ((rooms < 1e-12).sum(axis=1) == 2).all()


@pytest.mark.parametrize("stage", [Rectangle(width=1.2, height=0.8), polygon(BOX), polygon(BOX[2:] + BOX[:2])])
def test_rectangle_edges_are_exactly_right_left_top_bottom(stage):
    assert stage.edges == ((1, 0, 0.6), (-1, 0, 0.6), (0, 1, 0.4), (0, -1, 0.4))
    assert stage.outline == tuple(BOX)
    assert stage.inradius == 0.4
    assert stage.box == (-0.6, -0.4, 0.6, 0.4)


def test_inradius_by_hand():
    assert inradius_of([(0, 0), (4, 0), (0, 3)]) == pytest.approx(1, rel=1e-12)  # 3-4-5
    assert inradius_of(HEXAGON) == pytest.approx(0.6 * np.sqrt(3) / 2, rel=1e-12)
    assert inradius_of([(0, 0), (2, 1), (2, 2), (0, 1)]) == pytest.approx(1 / np.sqrt(5), rel=1e-12)  # between lines
    # The inradius of the triangle of the long edges: the small edge that cuts off the tip has no effect.
    assert inradius_of([(0, 0), (3.9, 0), (3.9, 0.075), (0, 3)]) == pytest.approx(1, rel=1e-12)


@given(convex_corners(narrowest=1e-4))
def test_inradius_agrees_with_linear_programming(corners):
    edges = np.array(edges_of(outline_of(corners)))
    # The largest r with n p + r <= offset forevery edge: the Chebyshev center.
    best = linprog([0, 0, -1], np.column_stack([edges[:, :2], np.ones(len(edges))]), edges[:, 2], bounds=(None, None))
    assert inradius_of(outline_of(corners)) == pytest.approx(-best.fun, rel=1e-6, abs=1e-9)


def test_needle_has_a_tiny_inradius():
    assert 0 < inradius_of([(-100, 0), (100, -1e-5), (100, 1e-5)]) < 1e-5


def test_distance_to_the_edges_by_hand():
    hexagon = polygon(HEXAGON)
    apothem = 0.6 * np.sqrt(3) / 2
    assert hexagon.room(0, 0) == pytest.approx(apothem)
    assert hexagon.room(0, 0.5) == pytest.approx(apothem - 0.5)
    assert hexagon.room(0, 1) == pytest.approx(apothem - 1)
    assert polygon(THIN).room(0, 0) < -1


# --- scenes ----------------------------------------------------------------------------------------------------------


def with_stage(corners, **keys):
    settings = {"stage": keys_of(corners), **keys}
    return load_scene("anger", [Setting(key, value, "test") for key, value in settings.items()])


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("way", [1, -1])
def test_scenes_with_the_same_polygon_are_the_same_scene(first, way):
    scene = with_stage(turned(TRIANGLE, first, way))
    assert scene.resolved() == with_stage(TRIANGLE).resolved()
    assert scene_digest(scene) == scene_digest(with_stage(TRIANGLE))


@pytest.mark.parametrize("corners", [HEXAGON, THIN, TRIANGLE])
def test_the_text_of_a_polygon_keeps_every_digit(corners):
    scene = with_stage(corners, **{"behaviour.density": {"kind": "uniform"}})
    again = parse_scene(scene_text(scene), "again.yaml")
    assert again.resolved() == scene.resolved()
    assert again.stage.outline == outline_of(corners)


def test_resolved_stage_has_only_the_keys_of_its_kind():
    assert load_scene("anger").resolved()["stage"] == {"width": 1.2, "height": 0.8}
    assert with_stage(TRIANGLE).resolved()["stage"].keys() == {"corners"}


def test_a_density_may_peak_on_a_corner():
    with_stage(TRIANGLE, **{"behaviour.density.centre": {"x": 0.0, "y": 0.6}})
