import numpy as np
import pytest
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.text import Text

from emovid.figures.runs import OVERHEAD_VIDEOS, PERSPECTIVE_VIDEOS, frames_figure, overhead_figure, perspective_figure
from emovid.scene.emotions import EMOTIONS
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.cameras import PinholeCamera
from tests.helpers.stages import TRACES


@pytest.fixture(scope="module")
def run(make_scene) -> Trajectory:
    keys = {"duration": 2.5, "video.view": "perspective", "video.trails.width": 0.01, "video.camera.distance": 2.1}
    return simulate(make_scene("happiness", TRACES | keys))


def camera_of(run: Trajectory) -> PinholeCamera:
    return PinholeCamera.framing(run.scene.stage, run.scene.video, run.scene.robot.body.height)


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


def filled(axes: Axes, colour: str) -> shapely.Geometry:
    """Return the shapes filled with a color, in pixels of the camera."""
    pieces = []
    for drawn in (found for found in axes.collections if isinstance(found, PathCollection)):
        for path, face in zip(drawn.get_paths(), drawn.get_facecolors(), strict=True):
            if np.allclose(face, to_rgba(colour)):
                pieces += [shapely.Polygon(piece) for piece in path.to_polygons()]
    return shapely.union_all(pieces)


def test_a_panel_shows_the_whole_stage_from_the_camera(run) -> None:
    axes = frames_figure(run, [0.0, 2.0]).axes[1]
    (outline,) = [patch for patch in axes.patches if isinstance(patch, Polygon)]
    seen = camera_of(run).pixels(np.array(run.scene.stage.outline))
    assert outline.get_xy()[:4] == pytest.approx(seen)
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert left < seen[:, 0].min() < seen[:, 0].max() < right
    assert bottom < seen[:, 1].min() < seen[:, 1].max() < top
    assert seen[:, 0].max() - seen[:, 0].min() > 0.97 * (right - left)


def test_trails_follow_past_positions_and_start_with_the_run(run) -> None:
    first, last = frames_figure(run, [0.0, 2.5]).axes
    colour = run.scene.video.palette.trails[0]
    trail = filled(last, colour)
    for t in np.arange(0.1, 2.4, 0.1):
        assert trail.contains(shapely.Point(camera_of(run).pixels(run.at(np.array([t]))[0, 0, :2]))), t
    assert filled(first, colour).area < trail.area  # the robot alone


def test_trails_have_round_joints_between_slices(make_scene) -> None:
    # Fear turns at each quarter of a second, so at whole ones too, where a slice of its trails ends and another begins.
    keys = TRACES | {"duration": 4.0, "video.view": "perspective", "video.trails.width": 0.01, "video.trails.robots": 1}
    run = simulate(make_scene("fear", keys))
    trail = filled(frames_figure(run, [4.0]).axes[0], run.scene.video.palette.trails[0])
    around = 0.0049 * np.stack([np.cos(angle := np.linspace(0, 2 * np.pi, 60)), np.sin(angle)], axis=-1)
    for corner in run.at(np.array([1.0, 2.0, 3.0]))[:, 0, :2]:
        assert trail.buffer(0.05).contains(shapely.Polygon(camera_of(run).pixels(corner + around)))


def test_the_six_panels_of_the_robotarium_have_emotions_and_videos(run) -> None:
    runs = dict.fromkeys(EMOTIONS, run)
    for draw, videos in ((overhead_figure, OVERHEAD_VIDEOS), (perspective_figure, PERSPECTIVE_VIDEOS)):
        figure = draw(runs, [2.0] * 6)
        assert len(figure.axes) == 6
        for axes, emotion in zip(figure.axes, EMOTIONS, strict=True):
            above, below = words(axes)
            assert above.lower() == emotion
            assert below == f"authors' video: {videos[emotion].removeprefix('https://')}"
    assert len({*OVERHEAD_VIDEOS.values(), *PERSPECTIVE_VIDEOS.values()}) == 12


def test_overhead_figure_has_trails_and_perspective_figure_has_none(run) -> None:
    runs = dict.fromkeys(EMOTIONS, run)
    labels = [drawn.get_label() for drawn in overhead_figure(runs, [2.0] * 6).axes[0].collections]
    assert labels.count("trails") == 1
    bare = perspective_figure(runs, [2.0] * 6).axes[0]
    at = camera_of(run).pixels(run.at(np.array([1.4]))[0, 0, :2])
    assert not filled(bare, run.scene.video.palette.trails[0]).contains(shapely.Point(at))
