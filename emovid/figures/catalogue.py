"""All figures and tables of the paper by name: number in the paper, caption, and the function that draws it.

To add one, write a function that returns a `Figure` and takes its `width`, and add an `Entry` here and a row in
`docs/figures.md`. Results of other rooms reach it as a table of `Material`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from emovid.figures.accuracy import accuracy_figure
from emovid.figures.circumplex import circumplex_figure
from emovid.figures.confusion import confusion_figure
from emovid.figures.control_laws import converged, densities_figure, shapes_figure
from emovid.figures.interaction import interaction_figure
from emovid.figures.paper_tables import ATTRIBUTES, BEHAVIOURS, Table, table_html, table_latex, table_markdown
from emovid.figures.run_cache import Material
from emovid.figures.runs import (
    descriptors_figure,
    frames_figure,
    overhead_figure,
    perspective_figure,
    traces_figure,
    with_traces,
)
from emovid.figures.study import answers_of, placed_answers_of, recognition_of
from emovid.figures.style import DOUBLE_COLUMN, FORMATS, SINGLE_COLUMN, encoded
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
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_robot

WIDTHS = {"one-column": SINGLE_COLUMN, "two-column": DOUBLE_COLUMN}  # in
TEXTS: Mapping[str, Callable[[Table], str]] = MappingProxyType(
    {"tex": table_latex, "md": table_markdown, "html": table_html}
)
STUDY = "study"  # table with the results of a study
MEASURES = "measures"  # table with the descriptors of the six emotions


class Entry(NamedTuple):
    """A figure, or a table of text.

    Attributes:
        name: of the figure and its files.
        paper: number in the paper, for example "Fig. 8"; empty for a figure that is not in the paper.
        caption: in one line.
        draw: function of the parts and a width [in] that draws the figure.
        parts: function that gives these parts.
        width: default width [in].
        emotions: names of the scenes it needs.
        tables: names of the tables of `Material` it needs.
        data: for a table of text, in place of a drawing.
    """

    name: str
    paper: str
    caption: str
    draw: Callable[..., Figure] | None = None
    parts: Callable[[Material], Sequence[Any]] = lambda _: ()
    width: float = DOUBLE_COLUMN
    emotions: tuple[str, ...] = ()
    tables: tuple[str, ...] = ()
    data: Table | None = None

    @property
    def formats(self) -> tuple[str, ...]:
        """File formats of the figure or table."""
        return tuple(TEXTS) if self.data else FORMATS

    def figure(self, material: Material, width: float | None = None) -> Figure:
        """Return the drawing at its default width or another [in].

        Raises:
            ValueError: for a table of text.
        """
        if self.draw is None:
            raise ValueError(f"{self.name} is a table of text")
        return self.draw(*self.parts(material), width=width or self.width)

    def files(self, material: Material, formats: Sequence[str], width: float | None = None) -> Iterator[bytes]:
        """Yield the contents of a file of each format."""
        if self.data:
            yield from (TEXTS[format](self.data).encode() for format in formats)
        else:
            figure = self.figure(material, width)
            yield from (encoded(figure, format) for format in formats)


_DESCRIPTIONS = {
    "happiness": "a circle with small ripples",
    "surprise": "an expanding circle, which makes a spiral",
    "sadness": "a small circle, an eighth of a turn in 8 s",
    "fear": "an even spread, slow and angular",
    "disgust": "a spread to the boundary, slow and angular",
    "anger": "a crowd at the center, fast and the most angular",
}
_ON_CONTOURS, _COVERAGE = ("happiness", "surprise", "sadness"), ("anger", "disgust", "fear")
_BOTH_LAWS = ("happiness", "fear")
_TRACES, _ROBOTARIUM_TRACES = 5, 4  # robots with a trace in the paper's figures


def _frames(emotion: str, number: int) -> Entry:
    times = EMOTIONS[emotion].snapshot_times
    caption = f"Snapshots of {emotion} at {', '.join(f'{t:g}' for t in times)} s with trails: {_DESCRIPTIONS[emotion]}"
    return Entry(
        f"{emotion}-frames",
        f"Fig. {number}",
        caption,
        frames_figure,
        lambda material: (with_traces(material.run(emotion), _TRACES), times),
        DOUBLE_COLUMN,
        (emotion,),
    )


def _robotarium(view: str, number: int, description: str, draw: Callable[..., Figure]) -> Entry:
    scenes = {emotion: f"robotarium/{emotion}" for emotion in EMOTIONS}

    def parts(material: Material) -> Sequence[Any]:
        runs = {emotion: with_traces(material.run(scene), _ROBOTARIUM_TRACES) for emotion, scene in scenes.items()}
        times = [material.scene(scene).snapshot_times or () for scene in scenes.values()]
        return runs, [of_scene[-1] for of_scene in times]

    caption = f"Six emotions by twelve GRITSBots X on the Robotarium, {description}"
    return Entry(f"robotarium-{view}", f"Fig. {number}", caption, draw, parts, DOUBLE_COLUMN, tuple(scenes.values()))


def _interaction(material: Material) -> Sequence[Any]:
    runs = [with_traces(material.run(emotion), _TRACES) for emotion in _BOTH_LAWS]
    emotions = [EMOTIONS[emotion] for emotion in _BOTH_LAWS]
    return runs, [emotion.snapshot_times[1] for emotion in emotions], [emotion.behaviour for emotion in emotions]


def _shapes(material: Material) -> Sequence[Any]:
    times = [EMOTIONS[emotion].snapshot_times[1] for emotion in _ON_CONTOURS]
    return [material.run(emotion) for emotion in _ON_CONTOURS], times


def _densities(material: Material) -> Sequence[Any]:
    scenes = [material.scene(emotion) for emotion in _COVERAGE]
    return scenes, [converged(scene) for scene in scenes]


def _following(_: Material) -> Sequence[Any]:
    angular = follow(PATH, ANGULAR_L, angular=True)
    return ([follow(PATH, None), follow(PATH, SMALL_L), angular, follow(PATH, LARGE_L)],)


def _diffeomorphism(material: Material) -> Sequence[Any]:
    robot = material.scene("happiness").robot
    return *clearest_step(material.run("happiness")), robot.body, robot.K, robot.l


CATALOGUE: Mapping[str, Entry] = MappingProxyType(
    {
        entry.name: entry
        for entry in (
            Entry(
                "gritsbot",
                "Fig. 1",
                "The GRITSBot from above with its dimensions, as simulated and drawn",
                robot_figure,
                lambda _: (load_robot("gritsbot"),),
                SINGLE_COLUMN,
            ),
            Entry(
                "interaction",
                "Fig. 2",
                "From interactions, information and control law to swarm behavior: a contour law and coverage",
                interaction_figure,
                _interaction,
                DOUBLE_COLUMN,
                _BOTH_LAWS,
            ),
            *(_frames(emotion, number) for number, emotion in enumerate(EMOTIONS, 3)),
            Entry(
                "diffeomorphism-trajectory",
                "Fig. 9",
                "A dashed path followed by a single integrator, and by unicycles with small l, held commands, large l",
                following_figure,
                _following,
                SINGLE_COLUMN,
            ),
            Entry(
                "circumplex",
                "Fig. 10",
                "Answers on the valence-arousal plane; a bubble's diameter is proportional to the answers",
                circumplex_figure,
                lambda material: placed_answers_of(material.table(STUDY)),
                SINGLE_COLUMN,
                tables=(STUDY,),
            ),
            Entry(
                "accuracy-robotics",
                "Fig. 11",
                "Recognition with and without a robotics background, with 95 % Wilson intervals",
                accuracy_figure,
                lambda material: recognition_of(material.table(STUDY), "robotics_background"),
                SINGLE_COLUMN,
                tables=(STUDY,),
            ),
            Entry(
                "accuracy-gender",
                "Fig. 12",
                "Recognition by gender, with 95 % Wilson intervals",
                accuracy_figure,
                lambda material: recognition_of(material.table(STUDY), "gender"),
                SINGLE_COLUMN,
                tables=(STUDY,),
            ),
            _robotarium("overhead", 13, "from overhead, with the trails of four", overhead_figure),
            _robotarium("perspective", 14, "from a camera 1.70 m above the floor", perspective_figure),
            Entry(
                "shapes",
                "Fig. 15",
                "Contours of happiness, surprise (at two radii) and sadness: agents, targets, go-to-goal arrows",
                shapes_figure,
                _shapes,
                DOUBLE_COLUMN,
                _ON_CONTOURS,
            ),
            Entry(
                "densities",
                "Fig. 16",
                "Densities of anger, disgust and fear, darker where denser, with robots after convergence",
                densities_figure,
                _densities,
                DOUBLE_COLUMN,
                _COVERAGE,
            ),
            Entry(
                "diffeomorphism",
                "Fig. 17",
                "The near-identity diffeomorphism: p, p~, l, theta, u, v and omega of a step of happiness",
                diffeomorphism_figure,
                _diffeomorphism,
                SINGLE_COLUMN,
                ("happiness",),
            ),
            Entry(
                "attributes",
                "Table I",
                "Movement and shape attributes of emotions and of valences, each with its source",
                data=ATTRIBUTES,
            ),
            Entry(
                "behaviours",
                "Table II",
                "Swarm behavior and robot control selected for each emotion",
                data=BEHAVIOURS,
            ),
            Entry(
                "confusion-matrix",
                "Table III",
                "Answers to each video: percent, and counts",
                confusion_figure,
                lambda material: answers_of(material.table(STUDY)),
                SINGLE_COLUMN,
                tables=(STUDY,),
            ),
            Entry(
                "trace-sheet",
                "",
                "Full traces of all robots, side by side",
                traces_figure,
                lambda material: ({emotion: material.run(emotion) for emotion in EMOTIONS},),
                DOUBLE_COLUMN,
                tuple(EMOTIONS),
            ),
            Entry(
                "descriptors",
                "",
                "Descriptors of the six emotions, each axis from the smallest to the largest value",
                descriptors_figure,
                lambda material: (material.table(MEASURES),),
                DOUBLE_COLUMN,
                tuple(EMOTIONS),
                (MEASURES,),
            ),
        )
    }
)
