import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.text import Text

from emovid.figures.runs import frames_figure, traces_figure, with_traces
from emovid.figures.style import DOUBLE_COLUMN, SINGLE_COLUMN
from emovid.scene.video import THEMES
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.trails import Span, Trails, spans, trailed_robots

TIMES = (0, 0.7, 2.5)


@pytest.fixture(scope="module")
def run(make_scene) -> Trajectory:
    return with_traces(simulate(make_scene("fear", {"duration": 3})), 5)


def part(axes: Axes, name: str) -> PathCollection:
    (found,) = [drawn for drawn in axes.collections if drawn.get_label() == name]
    return found


def trails(axes: Axes) -> list[np.ndarray]:
    drawn = [lines for lines in axes.collections if isinstance(lines, LineCollection)]
    return [segment for lines in drawn for segment in lines.get_segments()]


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


def test_every_robot_is_drawn_with_its_position_and_heading(run) -> None:
    figure = frames_figure(run, TIMES)
    for axes, t in zip(figure.axes, TIMES, strict=True):
        poses = run.at(np.array([t]))[0]
        bodies, fronts = ([path.vertices for path in part(axes, name).get_paths()] for name in ("body", "front"))
        centres = np.array([(body.min(axis=0) + body.max(axis=0)) / 2 for body in bodies])
        assert centres == pytest.approx(poses[:, :2], abs=1e-3)
        ahead = np.array([front[:3].mean(axis=0) for front in fronts]) - poses[:, :2]
        assert np.arctan2(ahead[:, 1], ahead[:, 0]) == pytest.approx(poses[:, 2])
        assert len(part(axes, "wheels").get_paths()) == len(part(axes, "rim").get_paths()) == 15
    assert [word for word in words(figure) if "$t$" in word] == ["(a) $t$ = 0 s", "(b) $t$ = 0.7 s", "(c) $t$ = 2.5 s"]


def test_five_robots_have_trails_from_start_to_current_position(run) -> None:
    figure = frames_figure(run, TIMES)
    assert trails(figure.axes[0]) == []
    robots = trailed_robots(run.poses[0], 5)
    for axes, t in list(zip(figure.axes, TIMES, strict=True))[1:]:
        lines = trails(axes)
        pieces = len(lines) // 5
        assert pieces == np.ceil(t)
        starts, ends = (run.at(np.array([moment]))[0, robots, :2] for moment in (0, t))
        assert np.array([line[0] for line in lines[:5]]) == pytest.approx(starts)
        assert np.array([line[-1] for line in lines[-5:]]) == pytest.approx(ends)


def lines_of(run: Trajectory, robots: list[int], until: float, tolerance: float) -> list[np.ndarray]:
    """Return the complete trails of robots, from joined pieces."""
    trails = Trails(run, np.array(robots), tolerance)
    made = [trails.pieces(span) for span in spans(run.scene.video.trails, until)]
    return [np.concatenate([piece.line for piece in pieces]) for pieces in zip(*made, strict=True)]


def test_joined_trail_pieces_equal_the_trace_of_the_robot(run) -> None:
    _, trace = run.trace(4, 1e-5)
    joined = lines_of(run, [4], 3, 1e-5)[0]
    assert all(np.abs(joined - point).sum(axis=1).min() < 1e-12 for point in trace)
    length = np.hypot(*np.diff(trace, axis=0).T).sum()
    assert np.hypot(*np.diff(joined, axis=0).T).sum() == pytest.approx(length, rel=1e-3)
    part_of_it = np.concatenate([piece.line for piece in Trails(run, np.array([4]), 1e-5).pieces(Span(0.4, 1.3))])
    assert part_of_it[[0, -1]] == pytest.approx(run.at(np.array([0.4, 1.3]))[:, 4, :2])


def test_trail_pieces_have_no_repeated_points(run) -> None:
    # Commands of fear change at whole seconds, where pieces end; the second to last point gives a line its direction.
    trails = Trails(run, np.array([0, 7]), 1e-4)
    for span in spans(run.scene.video.trails, 2.75):
        for piece in trails.pieces(span):
            assert np.hypot(*np.diff(piece.line, axis=0).T).min() > 1e-9


def test_times_are_labeled_to_the_millisecond(run) -> None:
    assert words(frames_figure(run, [0, 1 / 3, 2.125])) == ["(a) $t$ = 0 s", "(b) $t$ = 0.333 s", "(c) $t$ = 2.125 s"]
    assert words(frames_figure(run, [0.5])) == ["$t$ = 0.5 s"]


def test_robots_have_the_colors_of_their_trails(run) -> None:
    axes = frames_figure(run, TIMES).axes[-1]
    bodies = [to_hex(colour) for colour in part(axes, "body").get_facecolor()]
    (lines,) = [drawn for drawn in axes.collections if isinstance(drawn, LineCollection)]
    assert [to_hex(colour) for colour in lines.get_colors()[:5]] == [
        bodies[robot] for robot in trailed_robots(run.poses[0], 5)
    ]
    assert len(set(bodies)) == 6


def test_dark_stage_is_filled_and_light_stage_is_left_white(make_scene) -> None:
    keys = {"duration": 1, "robots": 3, "video.colours.body": "#112233"}
    for theme, face, rim in (("light", None, "#ffffff"), ("dark", "#1b1d22", "#1b1d22")):
        axes = frames_figure(simulate(make_scene("fear", keys | {"video.theme": theme})), [1]).axes[0]
        (stage,) = [patch for patch in axes.patches if isinstance(patch, Polygon)]
        assert stage.get_fill() == (face is not None)
        assert face in (None, to_hex(stage.get_facecolor()))
        assert to_hex(part(axes, "rim").get_facecolor()[0]) == rim
        assert to_hex(part(axes, "front").get_facecolor()[0]) == THEMES[theme].front
    own = simulate(make_scene("fear", keys | {"video.colours.stage": "#ffeecc"}))
    (stage,) = [patch for patch in frames_figure(own, [1]).axes[0].patches if isinstance(patch, Polygon)]
    assert to_hex(stage.get_facecolor()) == "#ffeecc"


def test_number_and_duration_of_trails_follow_the_scene(make_scene) -> None:
    look = {"video.trails.robots": 2, "video.trails.seconds": 0.5, "video.trails.fade": False}
    run = simulate(make_scene("fear", {"duration": 3} | look))
    lines, robots = trails(frames_figure(run, [2.75]).axes[0]), trailed_robots(run.poses[0], 2)
    assert np.array([line[0] for line in lines]) == pytest.approx(run.at(np.array([2.25]))[0, robots, :2])
    none = simulate(make_scene("fear", {"duration": 1, "video.trails.robots": 0}))
    assert trails(frames_figure(none, [1]).axes[0]) == []


def test_a_time_outside_the_run_is_refused(run) -> None:
    with pytest.raises(ValueError, match="the run is 0 to 3 s"):
        frames_figure(run, [0, 3.1])


@pytest.mark.parametrize(("width", "rows"), [(DOUBLE_COLUMN, 1), (SINGLE_COLUMN, 3)])
def test_panels_have_equal_scales_and_do_not_overlap(run, width, rows) -> None:
    figure = frames_figure(run, TIMES, width=width)
    boxes = [axes.get_position() for axes in figure.axes]
    assert len({round(box.y0, 6) for box in boxes}) == rows
    for axes, box in zip(figure.axes, boxes, strict=True):
        across, up = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
        assert box.width * width / across == pytest.approx(box.height * figure.get_figheight() / up)
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_the_outline_of_any_stage_is_drawn(make_scene) -> None:
    corners = [(-0.5, -0.4), (0.6, -0.3), (0.5, 0.4), (0.0, 0.55)]
    stage = {"corners": [dict(zip("xy", corner, strict=True)) for corner in corners]}
    run = simulate(make_scene("fear", {"stage": stage, "start": {"place": "stage"}, "duration": 0.5}))
    axes = frames_figure(run, [0]).axes[0]
    (outline,) = [patch for patch in axes.patches if isinstance(patch, Polygon)]
    assert {tuple(corner) for corner in outline.get_xy().tolist()} == set(corners)
    assert axes.get_xlim()[0] < -0.5
    assert axes.get_ylim()[1] > 0.55


def test_robots_without_wheels_are_drawn_too(make_scene) -> None:
    run = simulate(make_scene("sadness", {"robot.model": "single_integrator", "robots": 4, "duration": 1}))
    axes = frames_figure(run, [1]).axes[0]
    assert len(part(axes, "body").get_paths()) == 4
    assert {drawn.get_label() for drawn in axes.collections} == {"trails", "rim", "body"}


def test_the_trace_sheet_has_the_whole_trace_of_every_robot(make_scene) -> None:
    runs = {name: simulate(make_scene(name, {"duration": 2, "robots": 7})) for name in ("sadness", "anger")}
    figure = traces_figure(runs)
    assert words(figure) == ["Sadness", "Anger"]
    for axes, run in zip(figure.axes, runs.values(), strict=True):
        lines = trails(axes)
        assert len(lines) == 2 * 7
        assert np.array([line[0] for line in lines[:7]]) == pytest.approx(run.poses[0, :, :2])
        assert np.array([line[-1] for line in lines[7:]]) == pytest.approx(run.poses[-1, :, :2])
