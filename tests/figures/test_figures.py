import os
import re
import signal
import subprocess
import sys
from itertools import combinations
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle
from matplotlib.text import Text

from emovid.errors import InputError
from emovid.figures.accuracy import accuracy_figure
from emovid.figures.bubbles import fan
from emovid.figures.circumplex import POSITIONS, Position, circumplex_figure
from emovid.figures.confusion import confusion_figure
from emovid.figures.study import FigureData, study_figures
from emovid.figures.style import (
    DOUBLE_COLUMN,
    EMOTION_COLOURS,
    SINGLE_COLUMN,
    encoded,
    in_style,
    label_colours,
    save,
    text_on,
)
from tests.helpers.pdf import all_fonts_are_embedded_truetype, font_sizes, objects, page_box

EMOTIONS = ("happiness", "surprise", "anger", "fear", "disgust", "sadness")
COUNTS = np.array(
    [
        [29, 8, 4, 2, 2, 6],
        [5, 26, 4, 1, 0, 0],
        [4, 0, 25, 6, 7, 2],
        [3, 6, 9, 18, 16, 7],
        [3, 2, 2, 12, 18, 1],
        [1, 3, 1, 6, 2, 29],
    ]
)
NONE_TOO = np.vstack([COUNTS, [1, 0, 2, 3, 0, 4]])
RATES = np.array([[0.69, 0.69, 0.62, 0.46, 0.54, 0.69], [0.62, 0.53, 0.53, 0.38, 0.34, 0.62]])
LEVELS = ("female (n = 13)", "male (n = 32)")
FORMATS = ("pdf", "png", "svg", "eps")


def confusion() -> Figure:
    return confusion_figure(COUNTS, EMOTIONS)


def circumplex() -> Figure:
    return circumplex_figure(COUNTS, EMOTIONS)


def accuracy() -> Figure:
    return accuracy_figure(RATES, RATES - 0.2, RATES + 0.2, EMOTIONS, LEVELS, 1 / 6)


FIGURES = (confusion, circumplex, accuracy)


def labels(count: int) -> list[str]:
    return [f"feeling {chr(ord('A') + i)}" for i in range(count)]


def texts(figure: Figure) -> list[Text]:
    """Return the texts of a figure."""
    with in_style():
        figure.draw_without_rendering()  # places the ticks
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text()]


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in texts(figure)]


def bubbles(figure: Figure) -> list[Circle]:
    return [circle for circle in figure.axes[0].patches if isinstance(circle, Circle) and circle.get_fill()]


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("figure", FIGURES)
def test_the_same_input_gives_the_same_bytes(figure, format) -> None:
    assert encoded(figure(), format) == encoded(figure(), format)


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("figure", FIGURES)
def test_a_figure_saved_twice_has_the_same_bytes(figure, format) -> None:
    drawn = figure()
    first = encoded(drawn, format)
    encoded(drawn, "png")
    assert encoded(drawn, format) == first == encoded(figure(), format)


@pytest.mark.parametrize("figure", FIGURES)
def test_user_matplotlib_settings_have_no_effect_and_are_restored(figure) -> None:
    plain = [encoded(figure(), format) for format in FORMATS]
    theirs = {
        "font.size": 20,
        "font.family": ["serif"],
        "axes.facecolor": "black",
        "lines.linewidth": 9,
        "savefig.dpi": 50,
        "savefig.bbox": "tight",
        "pdf.fonttype": 3,
        "svg.fonttype": "none",
        "svg.hashsalt": None,
        "figure.constrained_layout.use": True,
        "axes.spines.top": False,
        "text.parse_math": True,
    }
    with matplotlib.rc_context(theirs):
        assert [encoded(figure(), format) for format in FORMATS] == plain
        assert {key: matplotlib.rcParams[key] for key in theirs} == theirs


def test_two_processes_give_the_same_bytes(tmp_path) -> None:
    script = (
        "import sys; from pathlib import Path; sys.path.insert(0, sys.argv[1])\n"
        "from tests.figures import test_figures as t\n"
        "for figure in t.FIGURES:\n"
        "    for format in t.FORMATS:\n"
        "        t.save(figure(), Path(f'{figure.__name__}.{format}'))\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    made = []
    for seed in ("1", "2"):
        folder = tmp_path / seed
        folder.mkdir()
        (folder / "matplotlibrc").write_text("font.size: 17\naxes.linewidth: 5\n")
        environment = os.environ | {"PYTHONHASHSEED": seed, "SOURCE_DATE_EPOCH": seed}
        command = [sys.executable, "-W", "error", "-c", script, Path(__file__).parents[2]]
        subprocess.run(command, check=True, cwd=folder, env=environment)
        made.append({path.name: path.read_bytes() for path in folder.glob("*.*")})
    assert len(made[0]) == len(FIGURES) * len(FORMATS)
    assert made[0] == made[1]
    assert made[0]["confusion.svg"] == encoded(confusion(), "svg")


@pytest.mark.parametrize("figure", FIGURES)
def test_pdf_is_as_wide_as_a_column_and_embeds_truetype_at_8_points(figure) -> None:
    pdf = encoded(figure(), "pdf")
    assert page_box(pdf)[:3] == [0, 0, SINGLE_COLUMN * 72]
    assert all_fonts_are_embedded_truetype(pdf)
    assert b"DejaVuSans" in objects(pdf)
    assert font_sizes(pdf) == {8.0}
    assert b"CreationDate" not in objects(pdf)


def test_png_has_300_dots_per_inch() -> None:
    png = encoded(confusion(), "png")
    assert int.from_bytes(png[16:20], "big") == SINGLE_COLUMN * 300
    assert b"Software" not in png


def test_svg_has_no_date() -> None:
    assert b"<dc:date>" not in encoded(confusion(), "svg")


@pytest.mark.parametrize("figure", FIGURES)
def test_all_text_is_8_points_in_the_bundled_font(figure) -> None:
    for text in texts(figure()):
        assert text.get_fontsize() == 8.0
        assert Path(findfont(text.get_fontproperties())).is_relative_to(matplotlib.get_data_path())


@pytest.mark.parametrize("figure", FIGURES)
def test_text_stays_on_the_page_and_does_not_overlap(figure) -> None:
    drawn = figure()
    written = texts(drawn)
    renderer = FigureCanvasAgg(drawn).get_renderer()
    boxes = [text.get_window_extent(renderer) for text in written]
    page = drawn.bbox
    for box in boxes:
        assert page.x0 <= box.x0 < box.x1 <= page.x1
        assert page.y0 <= box.y0 < box.y1 <= page.y1
    upright = [box for box, text in zip(boxes, written, strict=True) if text.get_rotation() % 90 == 0]
    assert not any(one.shrunk(0.9, 0.9).overlaps(other.shrunk(0.9, 0.9)) for one, other in combinations(upright, 2))


def test_save_writes_the_format_of_the_suffix_and_refuses_others(tmp_path) -> None:
    for name in ("a.pdf", "a.PNG", "a.svg", "a.eps"):
        save(confusion(), tmp_path / name)
        assert (tmp_path / name).read_bytes() == encoded(confusion(), name[2:].lower())
    with pytest.raises(InputError, match=r"\.pdf, \.png, \.svg or \.eps"):
        save(confusion(), tmp_path / "a.jpeg")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.PNG", "a.eps", "a.pdf", "a.svg"]


def test_signal_during_drawing_is_not_reported_as_a_matplotlib_error() -> None:
    class Interrupted(Artist):
        def draw(self, _) -> None:
            try:
                signal.raise_signal(signal.SIGTERM)
            except SystemExit:  # as compiled code would
                raise ValueError from None

    def end(*_):
        raise SystemExit(143)

    drawn = Figure()
    drawn.add_artist(Interrupted())
    before = signal.signal(signal.SIGTERM, end)
    try:
        with pytest.raises(SystemExit):
            encoded(drawn, "png")
    finally:
        signal.signal(signal.SIGTERM, before)


def test_in_style_restores_settings_after_an_error() -> None:
    before = dict(matplotlib.rcParams)
    with pytest.raises(ZeroDivisionError), in_style():
        raise ZeroDivisionError
    assert dict(matplotlib.rcParams) == before


def lightness(colour: str) -> float:
    """Return CIE L*."""
    channels = np.array(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return 116 * np.cbrt(linear @ [0.2126, 0.7152, 0.0722]) - 16


def test_emotion_colors_differ_in_grayscale() -> None:
    grey = np.sort([lightness(colour) for colour in EMOTION_COLOURS.values()])
    assert np.diff(grey).min() > 10


@pytest.mark.parametrize("colour", [*EMOTION_COLOURS.values(), "#ffffff", "#000000", "#777777"])
def test_text_on_colors_has_sufficient_contrast(colour) -> None:
    luminance = [((lightness(name) + 16) / 116) ** 3 + 0.05 for name in (colour, text_on(colour))]
    assert max(luminance) / min(luminance) > 4  # 4.5 is WCAG's AA for text of any size, 3 for large text


def test_colors_of_custom_labels_are_distinct_and_not_gray() -> None:
    colours = label_colours([*labels(12), "none"])
    assert len(set(colours.values())) == 13
    assert label_colours([*EMOTIONS, "none"]) == EMOTION_COLOURS | {"none": colours["none"]}


def test_confusion_figure_matches_table_iii() -> None:
    said = words(confusion())
    cells = [f"{count / 45:.2%}\n({count})".replace("%", "") for count in COUNTS.flat]
    assert [word for word in said if word[0].isdigit()] == cells
    assert said.count("Signaled Emotion") == said.count("Response\n(%)") == 1
    for emotion in EMOTIONS:
        assert said.count(emotion.capitalize()) == 2


def test_only_the_confusion_diagonal_is_bold() -> None:
    figure = confusion_figure(NONE_TOO, EMOTIONS, [*EMOTIONS, "none"])
    cells = [text for text in texts(figure) if text.get_text()[0].isdigit()]
    bold = np.array([text.get_weight() == "bold" for text in cells]).reshape(7, 6)
    assert np.array_equal(bold, np.eye(7, 6, dtype=bool))
    assert not any(text.get_weight() == "bold" for text in texts(figure) if text not in cells)


def test_confusion_is_drawn_with_rows_perceived_from_the_top() -> None:
    counts = np.zeros((3, 3), dtype=int)
    counts[0, 2] = 5  # perceived first, signalled third
    figure = confusion_figure(counts, labels(3))
    (mesh,) = figure.axes[0].findobj(QuadMesh)
    dark = np.asarray(mesh.get_array())[..., 0] < 0.5
    assert np.argwhere(dark).tolist() == [[0, 2]]
    (cell,) = [text for text in texts(figure) if text.get_text() == "100\n(5)"]
    assert cell.get_position() == (2, 0)
    assert figure.axes[0].yaxis_inverted()
    assert sum(word == "–\n(0)" for word in words(figure)) == 6  # the other two videos have no answers


def test_study_figures_depend_on_the_available_results() -> None:
    # Emotions without a position on the circumplex, and a group without participants.
    counts = np.array([[3, 1], [1, 3]])
    data = FigureData(counts, ("joy", "awe"), ("joy", "awe"), {"age": {}})
    assert list(study_figures(data)) == ["confusion-matrix"]


@pytest.mark.parametrize("count", [2, 6, 12])
def test_any_number_of_labels_is_drawn(count) -> None:
    names = [*labels(count), "none"]
    counts = np.random.default_rng(count).integers(0, 9, (count + 1, count)) + 20 * np.eye(count + 1, count, dtype=int)
    angles = 2 * np.pi * np.arange(count) / count
    places = {
        name: Position(np.cos(angle), np.sin(angle), "even") for name, angle in zip(names[:-1], angles, strict=True)
    }
    rates = np.full((2, count), 0.5)
    drawn = [
        confusion_figure(counts, names[:-1], names),
        circumplex_figure(counts, names[:-1], names, positions=places),
        accuracy_figure(rates, rates, rates, names[:-1], ["a", "b"], 1 / count),
    ]
    for figure in drawn:
        assert {name.replace("f", "F", 1) for name in names[:-1]} <= set(words(figure))
        assert figure.get_figwidth() in (SINGLE_COLUMN, DOUBLE_COLUMN)
    assert drawn[0].get_figwidth() == (DOUBLE_COLUMN if count == 12 else SINGLE_COLUMN)


@pytest.mark.parametrize("label", ["$x$ & $y$", "<b>", "Überraschung", "грусть", "a_b^c", "=1+1"])
def test_labels_are_drawn_verbatim(label) -> None:
    figure = confusion_figure(np.eye(2, dtype=int), [label, "other"])
    assert label[:1].upper() + label[1:] in words(figure)
    for format in FORMATS:
        assert encoded(figure, format)


def test_shapes_that_do_not_match_are_refused() -> None:
    with pytest.raises(ValueError, match="counts"):
        confusion_figure(COUNTS, EMOTIONS[:5])
    with pytest.raises(ValueError, match="counts"):
        circumplex_figure(COUNTS, EMOTIONS[:5])
    with pytest.raises(ValueError, match="rates"):
        accuracy_figure(RATES, RATES[:1], RATES, EMOTIONS, LEVELS, 1 / 6)
    with pytest.raises(ValueError, match=r"no position for .*awe"):
        circumplex_figure(np.eye(2, dtype=int), ["fear", "awe"])


def test_bubbles_have_diameters_proportional_to_the_answers() -> None:
    drawn = bubbles(circumplex())
    given = [count for column in COUNTS.T for count in sorted(column, reverse=True) if count]
    per_answer = np.array([2 * bubble.radius for bubble in drawn]) / given
    assert per_answer == pytest.approx(per_answer[0])
    assert per_answer[0] > 1.1  # points: the smallest is visible, the larger contain their number


def test_bubbles_may_have_areas_proportional_to_the_answers() -> None:
    drawn = bubbles(circumplex_figure(COUNTS, EMOTIONS, proportional="area"))
    given = [count for column in COUNTS.T for count in sorted(column, reverse=True) if count]
    per_answer = np.array([bubble.radius**2 for bubble in drawn]) / given
    assert per_answer == pytest.approx(per_answer[0])


def test_bubbles_have_the_colors_of_the_answers_and_crosses_those_of_the_videos() -> None:
    figure = circumplex()
    order = [np.argsort(-column, kind="stable")[: np.count_nonzero(column)] for column in COUNTS.T]
    expected = [to_rgb(EMOTION_COLOURS[EMOTIONS[answer]]) for answers in order for answer in answers]
    assert [bubble.get_facecolor()[:3] for bubble in bubbles(figure)] == expected
    crosses = [line for line in figure.axes[0].findobj(Line2D) if line.get_marker() == "X"]
    assert [cross.get_markerfacecolor() for cross in crosses] == [EMOTION_COLOURS[emotion] for emotion in EMOTIONS]
    places = np.array([cross.get_xydata()[0] for cross in crosses])
    expected_places = np.array([POSITIONS[emotion][:2] for emotion in EMOTIONS])
    assert places / np.linalg.norm(places[0]) == pytest.approx(expected_places)


def test_bubbles_do_not_overlap_and_stay_on_the_page() -> None:
    for counts, answers in ((COUNTS, EMOTIONS), (NONE_TOO, (*EMOTIONS, "none"))):
        figure = circumplex_figure(counts, EMOTIONS, answers)
        axes = figure.axes[0]
        drawn = [(np.array(bubble.center), bubble.radius) for bubble in bubbles(figure)]
        assert all(np.hypot(*(a - b)) > r + s for (a, r), (b, s) in combinations(drawn, 2))
        for (x, y), radius in drawn:
            assert axes.get_xlim()[0] < x - radius < x + radius < axes.get_xlim()[1]
            assert axes.get_ylim()[0] < y - radius < y + radius < axes.get_ylim()[1]
        assert np.diff(axes.get_xlim()) == pytest.approx(figure.get_figwidth() * 72)
        assert np.diff(axes.get_ylim()) == pytest.approx(figure.get_figheight() * 72)


def test_emotions_at_one_position_keep_visible_bubbles() -> None:
    here = dict.fromkeys(EMOTIONS, Position(0.5, 0.5, "made up"))
    drawn = bubbles(circumplex_figure(COUNTS, EMOTIONS, positions=here))
    assert min(bubble.radius for bubble in drawn) > 0.5


def test_a_video_without_answers_has_a_cross_and_a_name() -> None:
    counts = COUNTS.copy()
    counts[:, 2] = 0
    figure = circumplex_figure(counts, EMOTIONS)
    assert "Anger" in words(figure)
    assert len(bubbles(figure)) == np.count_nonzero(counts)


def test_default_positions_have_sources_and_follow_table_iii() -> None:
    assert all(re.search("Russell", position.source) for position in POSITIONS.values())
    angles = [np.arctan2(POSITIONS[emotion].arousal, POSITIONS[emotion].valence) % (2 * np.pi) for emotion in EMOTIONS]
    assert angles == sorted(angles)


def test_fan_keeps_separate_angles_and_spreads_close_ones_evenly() -> None:
    assert fan(np.array([0.0, 2.0, 4.0]), 0.5) == pytest.approx([0, 2, 4])
    assert fan(np.array([1.0, 1.2]), 0.5) == pytest.approx([0.85, 1.35])
    assert np.diff(fan(np.zeros(12), 1.0)) == pytest.approx(2 * np.pi / 12, abs=1e-3)


def test_bars_show_rates_with_intervals_and_chance_level() -> None:
    figure = accuracy()
    axes = figure.axes[0]
    bars = [bar for bar in axes.patches if isinstance(bar, Rectangle)]
    assert [bar.get_height() for bar in bars] == pytest.approx(100 * RATES.ravel())
    assert len({bar.get_facecolor() for bar in bars}) == 2
    spans = np.array([segment for lines in axes.collections[1::2] for segment in lines.get_segments()])
    assert spans[:, 0, 1] == pytest.approx(100 * RATES.ravel() - 20)
    assert spans[:, 1, 1] == pytest.approx(100 * RATES.ravel() + 20)
    centres = [bar.get_x() + bar.get_width() / 2 for bar in bars]
    assert spans[:, 0, 0] == pytest.approx(centres)
    assert np.sort(centres)[::2] == pytest.approx(
        np.arange(6) - 0.2
    )  # the bars of one group are to the left of the other's
    (chance,) = [line for line in axes.lines if line.get_linestyle() == "--"]
    assert chance.get_ydata() == pytest.approx([100 / 6] * 2)
    assert {*LEVELS, "chance", "Accuracy (%)", *(emotion.capitalize() for emotion in EMOTIONS)} <= set(words(figure))


def test_a_group_without_answers_has_neither_bar_nor_interval() -> None:
    rates = RATES.copy()
    rates[1, 3] = np.nan
    low, high = RATES - 0.1, RATES + 0.1
    low[1, 3], high[1, 3] = 0, 1  # Wilson's interval for 0 of 0
    figure = accuracy_figure(rates, low, high, EMOTIONS, LEVELS, 1 / 6)
    bars = [bar for bar in figure.axes[0].patches if isinstance(bar, Rectangle)]
    assert sum(bar.get_height() == 0 for bar in bars) == 1
    spans = np.array([segment for lines in figure.axes[0].collections for segment in lines.get_segments()])
    assert len(spans) == 2 * 11
    assert np.ptp(spans[..., 1], axis=1) == pytest.approx(20)
    assert encoded(figure, "pdf")


@pytest.mark.parametrize(
    "levels", [LEVELS, [f"{which} {'who have worked with robots for a while ' * 5}" for which in LEVELS]]
)
@pytest.mark.parametrize("emotions", [EMOTIONS, [f"an emotion with a long name such as {k}" for k in range(6)]])
def test_long_names_are_readable_and_bars_keep_their_size(levels, emotions) -> None:
    plain, figure = accuracy(), accuracy_figure(RATES, RATES - 0.2, RATES + 0.2, emotions, levels, 1 / 6)
    page = figure.bbox
    for text in texts(figure):
        box = text.get_window_extent()
        assert page.x0 <= box.x0 < box.x1 <= page.x1, text
        assert page.y0 <= box.y0 < box.y1 <= page.y1, text
    assert figure.axes[0].bbox.height > 0.85 * plain.axes[0].bbox.height
    assert figure.axes[0].bbox.width > 0.95 * plain.axes[0].bbox.width


def test_rates_of_zero_and_one_have_bars_and_intervals() -> None:
    rates = np.array([[0.0, 1.0]])
    figure = accuracy_figure(rates, np.array([[1e-17, 0.8]]), np.array([[0.2, 1 - 1e-16]]), labels(2), ["all"], 0.5)
    assert encoded(figure, "png")
