import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from emovid.scene.load import load_robot, shipped_robots
from emovid.scene.robots import Body
from emovid.scene.video import Aim
from emovid.video.cameras import PinholeCamera
from emovid.video.robots import RobotColours, robot_solids
from tests.helpers.pinholes import PINHOLES

POSES = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-4, 4))
BLACK, WHITE = np.array([0.0, 0.0, 0.0, 1.0]), np.array([1.0, 1.0, 1.0, 1.0])
PLAIN = Body.model_validate(
    {"kinematics": "single_integrator", "shape": {"kind": "rectangle", "length": 0.3, "width": 0.2}, "height": 0.15}
)


def colouring(robots: int) -> RobotColours:
    """Each body in its own shade of red and green."""
    bodies = np.array([[1.0, i / robots, 0.0, 1.0] for i in range(robots)])
    return RobotColours(bodies, BLACK, WHITE)


def area_of(paths: list) -> shapely.Geometry:
    return shapely.union_all([shapely.Polygon(piece) for path in paths for piece in path.to_polygons()])


@given(PINHOLES, POSES)
def test_prism_outline_is_the_convex_hull_of_its_projected_corners(camera, pose) -> None:
    seen = robot_solids(camera, PLAIN, np.array([pose]), colouring(1))
    solid = [path for path, colour in zip(seen.paths, seen.colours, strict=True) if colour[3] == 1]
    x, y, heading = pose
    flat = np.exp(1j * heading) * (np.array([1, -1, -1, 1]) * 0.15 + 1j * np.array([1, 1, -1, -1]) * 0.1)
    corners = [[x + c.real, y + c.imag, up] for c in flat for up in (0.0, 0.15)]
    hull = shapely.MultiPoint(camera.project(np.array(corners))).convex_hull
    assert area_of(solid).symmetric_difference(hull).area < 1e-6 * hull.area


@given(PINHOLES, POSES)
def test_top_face_is_the_outline_at_body_height_in_the_body_color(camera, pose) -> None:
    seen = robot_solids(camera, PLAIN, np.array([pose]), colouring(1))
    x, y, heading = pose
    flat = np.exp(1j * heading) * (np.array([1, -1, -1, 1]) * 0.15 + 1j * np.array([1, 1, -1, -1]) * 0.1)
    top = shapely.Polygon(camera.project(np.array([[x + c.real, y + c.imag, 0.15] for c in flat])))
    assert seen.colours[-1].tolist() == [1.0, 0.0, 0.0, 1.0]
    assert area_of(seen.paths[-1:]).symmetric_difference(top).area < 1e-6 * top.area
    assert (seen.colours[1:-1, 0] < 0.9).all()  # sides are darker


@given(PINHOLES, st.lists(POSES, min_size=1, max_size=6), st.sampled_from(shipped_robots()))
def test_robots_of_every_kind_have_valid_outlines_and_colors(camera, poses, name) -> None:
    seen = robot_solids(camera, load_robot(name), np.array(poses), colouring(len(poses)))
    assert len(seen.paths) == len(seen.colours)
    assert all(np.isfinite(path.vertices).all() for path in seen.paths)
    assert ((seen.colours >= 0) & (seen.colours <= 1)).all()


@given(PINHOLES, st.permutations([(0.0, -0.6, 0.4), (0.3, 0.0, 1.0), (-0.2, 0.5, 0.0), (0.1, 0.9, 2.0)]))
def test_robots_are_painted_from_far_to_near(camera, poses) -> None:
    seen = robot_solids(camera, PLAIN, np.array(poses), colouring(4))
    order = list(dict.fromkeys(round(4 * green / red) for red, green, _, _ in seen.colours[4:]))  # after the shadows
    distance = [np.hypot(poses[i][0] - camera.aim.x, poses[i][1] - camera.aim.y) for i in order]
    assert len(order) == 4
    assert distance == sorted(distance, reverse=True)


@pytest.mark.parametrize("name", shipped_robots())
def test_every_shipped_robot_fits_in_its_spacing_disk(name) -> None:
    body = load_robot(name)
    above = PinholeCamera(
        1000, 1000, Aim(0.0, 0.0, 1000.0, np.pi / 2, 1e6), (0.0, 0.0), (0.1, 0.1)
    )  # as if from overhead
    seen = robot_solids(above, body, np.array([[0.0, 0.0, 0.3]]), colouring(1))
    solid = [path for path, colour in zip(seen.paths, seen.colours, strict=True) if colour[3] == 1]
    reach = np.hypot(*(np.concatenate([np.asarray(path.vertices) for path in solid]) - 500).T).max() / 1000
    assert reach == pytest.approx(body.radius, rel=0.03)  # wheels have round corners
    assert reach < 1.001 * body.radius
