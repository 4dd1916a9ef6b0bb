import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.path import Path

from emovid.scene.video import Aim
from emovid.video.cameras import PinholeCamera
from emovid.video.trails import ribbon
from tests.helpers.pinholes import FLOOR, PINHOLES

TURNS = st.lists(st.floats(-0.12, 0.12), min_size=2, max_size=12).map(np.cumsum)
ARCS = TURNS.map(lambda turns: np.stack([np.cos(turns), np.sin(turns)], axis=-1).cumsum(axis=0) / 15)
LINES = st.lists(FLOOR, min_size=2, max_size=12).map(np.array) | ARCS
WIDTHS = st.floats(0.002, 0.3)


@given(PINHOLES, LINES, WIDTHS, st.integers(0, 2**32))
def test_ribbon_covers_points_within_half_its_width_of_the_line(camera, line, width, seed) -> None:
    path = ribbon(camera, line, width)
    places = np.random.default_rng(seed).normal(line[:, None], width, (len(line), 30, 2)).reshape(-1, 2)
    places = places[places[:, 1] > -1.9]  # before the camera
    distance = shapely.distance(shapely.LineString(line.round(9)), shapely.points(places))
    pieces = [shapely.Polygon(piece) for piece in path.to_polygons()]
    seen = shapely.contains(shapely.union_all(pieces), shapely.points(camera.pixels(places)))
    assert seen[distance < 0.97 * width / 2].all()  # round joints are polygons, 2 % within the circle
    assert not seen[distance > 1.002 * width / 2].any()


@given(PINHOLES, LINES, WIDTHS)
def test_all_pieces_of_a_ribbon_have_the_same_orientation(camera, line, width) -> None:
    for piece in ribbon(camera, line, width).to_polygons():
        x, y = piece[:-1].T
        assert (
            x * np.roll(y, -1) - y * np.roll(x, -1)
        ).sum() > -1e-6  # otherwise the overlap of two pieces would be a hole


@given(PINHOLES, LINES, WIDTHS, st.integers(1, 10))
def test_two_consecutive_ribbons_cover_the_same_area_as_one(camera, line, width, cut) -> None:
    cut = min(cut, len(line) - 2)
    if cut < 1:
        return

    def area(*ribbons: Path) -> shapely.Geometry:
        return shapely.union_all([shapely.Polygon(piece) for made in ribbons for piece in made.to_polygons()])

    whole = area(ribbon(camera, line, width))
    parts = area(ribbon(camera, line[: cut + 1], width), ribbon(camera, line[cut:], width, line[cut - 1]))
    ends = area(ribbon(camera, line[[-1, -1]], width), ribbon(camera, line[[cut, cut]], width))
    assert shapely.area(whole - parts - ends) < 0.01 * whole.area
    assert shapely.area(parts - whole - ends) < 0.01 * whole.area


@given(PINHOLES)
def test_lines_across_the_view_get_thinner_with_distance(camera) -> None:
    lines = [np.array([[-0.1, y], [0.1, y]]) for y in (-0.5, 0.5)]
    near, far = (np.ptp(ribbon(camera, line, 0.02).to_polygons()[0][:, 1]) for line in lines)
    assert far < near


def test_ribbon_width_at_45_degrees_is_full_along_the_view_and_foreshortened_across() -> None:
    camera = PinholeCamera(400, 300, Aim(0.0, -1.0, 1.0, np.pi / 4, 1000.0), (0.0, 0.0), (0.0, 0.0))
    strip = slice(0, 4)  # the path's first piece, before the round joints
    across = np.asarray(ribbon(camera, np.array([[-0.1, 0.0], [0.1, 0.0]]), 0.002).vertices)[strip]
    away = np.asarray(ribbon(camera, np.array([[0.0, -1e-4], [0.0, 1e-4]]), 0.002).vertices)[strip]
    whole = 0.002 * 1000 / np.sqrt(2)  # at a distance of sqrt(2) m
    assert np.ptp(away[:, 0]) == pytest.approx(whole, rel=1e-3)
    assert np.ptp(across[:, 1]) == pytest.approx(whole * np.sin(np.pi / 4), rel=1e-3)


@given(PINHOLES, LINES, st.sampled_from([1e-300, 1e-12]))
def test_very_thin_lines_make_finite_ribbons(camera, line, width) -> None:
    assert np.isfinite(ribbon(camera, line, width).vertices).all()
