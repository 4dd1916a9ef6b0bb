"""All figures and tables of the paper by name: where it has them, what each shows, and what makes it.

To add one, write a function that returns a `Figure` and takes its `width`, and an `Entry` for it here and in
`docs/figures.md`. What comes from another room reaches it as a table of `Material`, which the command line fills.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from emovid.figures.accuracy import accuracy_figure
from emovid.figures.attributes import ATTRIBUTES, BEHAVIOURS, Table
from emovid.figures.circumplex import circumplex_figure
from emovid.figures.confusion import confusion_figure
from emovid.figures.densities import converged, densities_figure
from emovid.figures.descriptors import descriptors_figure
from emovid.figures.diffeomorphism import clearest_step, diffeomorphism_figure
from emovid.figures.following import LARGE_L, PATH, SMALL_L, follow, following_figure
from emovid.figures.frames import frames_figure, traces_figure
from emovid.figures.interaction import interaction_figure
from emovid.figures.robot import robot_figure
from emovid.figures.robotarium import overhead_figure, perspective_figure
from emovid.figures.run_cache import Material
from emovid.figures.shapes import shapes_figure
from emovid.figures.study import answers_of, placed_answers_of, recognition_of
from emovid.figures.style import DOUBLE_COLUMN, FORMATS, SINGLE_COLUMN, encoded
from emovid.figures.tables import table_figure, table_latex, table_markdown
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_robot

WIDTHS = {"one-column": SINGLE_COLUMN, "two-column": DOUBLE_COLUMN}  # in
TEXTS: Mapping[str, Callable[[Table], str]] = MappingProxyType({"tex": table_latex, "md": table_markdown})
STUDY = "study"  # the table that holds the results of a study
MEASURES = "measures"  # the one that holds the descriptors of the six emotions


class Entry(NamedTuple):
    """A figure.

    Attributes:
        name: of the figure and of its files.
        paper: its number in the paper, as in "Fig. 8"; empty for one that the paper does not have.
        caption: what it shows, in a line.
        draw: what makes it, of the parts and a width [in].
        parts: what it is made of.
        width: that it has by default [in].
        emotions: whose scenes it needs.
        tables: that it needs of `Material`.
        data: what it is as text too, if it is a table.
    """

    name: str
    paper: str
    caption: str
    draw: Callable[..., Figure]
    parts: Callable[[Material], Sequence[Any]]
    width: float
    emotions: tuple[str, ...] = ()
    tables: tuple[str, ...] = ()
    data: Table | None = None

    @property
    def formats(self) -> tuple[str, ...]:
        """The formats it can be written in."""
        return FORMATS + (tuple(TEXTS) if self.data else ())

    def figure(self, material: Material, width: float | None = None) -> Figure:
        """Return the figure, of its own width or another [in]."""
        return self.draw(*self.parts(material), width=width or self.width)

    def files(self, material: Material, formats: Sequence[str], width: float | None = None) -> Iterator[bytes]:
        """Yield the figure as a file of each format."""
        figure = self.figure(material, width) if set(formats) & set(FORMATS) else None
        for format in formats:
            if format in FORMATS:
                assert figure is not None
                yield encoded(figure, format)
            else:
                assert self.data is not None  # see `formats`
                yield TEXTS[format](self.data).encode()


_SEEN = {
    "happiness": "a circle with small ripples",
    "surprise": "an expanding circle, which makes a spiral",
    "sadness": "a small circle, of which an eighth is gone in 8 s",
    "fear": "an even spread, slow and angular",
    "disgust": "a spread to the boundary, slow and angular",
    "anger": "a crowd at the centre, fast and the most angular",
}
_ROUND, _SPREAD = ("happiness", "surprise", "sadness"), ("anger", "disgust", "fear")
_BOTH_LAWS = ("happiness", "fear")


def _frames(emotion: str, number: int) -> Entry:
    times = EMOTIONS[emotion].snapshot_times
    said = f"Snapshots of {emotion} at {', '.join(f'{t:g}' for t in times)} s with trails: {_SEEN[emotion]}"
    return Entry(
        f"{emotion}-frames",
        f"Fig. {number}",
        said,
        frames_figure,
        lambda material: (material.run(emotion), times),
        DOUBLE_COLUMN,
        (emotion,),
    )


def _robotarium(view: str, number: int, said: str, draw: Callable[..., Figure]) -> Entry:
    scenes = {emotion: f"robotarium/{emotion}" for emotion in EMOTIONS}

    def parts(material: Material) -> Sequence[Any]:
        runs = {emotion: material.run(scene) for emotion, scene in scenes.items()}
        times = [material.scene(scene).snapshot_times or () for scene in scenes.values()]
        return runs, [of_scene[-1] for of_scene in times]

    caption = f"Six emotions by twelve GRITSBots X on the Robotarium, {said}"
    return Entry(f"robotarium-{view}", f"Fig. {number}", caption, draw, parts, DOUBLE_COLUMN, tuple(scenes.values()))


def _interaction(material: Material) -> Sequence[Any]:
    runs = [material.run(emotion) for emotion in _BOTH_LAWS]
    emotions = [EMOTIONS[emotion] for emotion in _BOTH_LAWS]
    return runs, [emotion.snapshot_times[1] for emotion in emotions], [emotion.behaviour for emotion in emotions]


def _shapes(material: Material) -> Sequence[Any]:
    return [material.run(emotion) for emotion in _ROUND], [EMOTIONS[emotion].snapshot_times[1] for emotion in _ROUND]


def _densities(material: Material) -> Sequence[Any]:
    scenes = [material.scene(emotion) for emotion in _SPREAD]
    return scenes, [converged(scene) for scene in scenes]


def _diffeomorphism(material: Material) -> Sequence[Any]:
    robot = material.scene("happiness").robot
    return *clearest_step(material.run("happiness")), robot.body, robot.l


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
                "How interactions, information and control law make a swarm's behaviour: a contour law and coverage",
                interaction_figure,
                _interaction,
                DOUBLE_COLUMN,
                _BOTH_LAWS,
            ),
            *(_frames(emotion, number) for number, emotion in enumerate(EMOTIONS, 3)),
            Entry(
                "diffeomorphism-trajectory",
                "Fig. 9",
                "A dashed path followed by a single integrator, and by unicycles with small and with large l",
                following_figure,
                lambda _: ([follow(PATH, l) for l in (None, SMALL_L, LARGE_L)],),
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
            _robotarium("perspective", 14, "seen by a camera 1.70 m up", perspective_figure),
            Entry(
                "shapes",
                "Fig. 15",
                "Contours of happiness, surprise (at two radii) and sadness: agents, the points they follow, arrows",
                shapes_figure,
                _shapes,
                DOUBLE_COLUMN,
                _ROUND,
            ),
            Entry(
                "densities",
                "Fig. 16",
                "Densities of anger, disgust and fear, darker where denser, with robots after convergence",
                densities_figure,
                _densities,
                DOUBLE_COLUMN,
                _SPREAD,
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
                table_figure,
                lambda _: (ATTRIBUTES,),
                DOUBLE_COLUMN,
                data=ATTRIBUTES,
            ),
            Entry(
                "behaviours",
                "Table II",
                "Swarm behaviour and robot control selected for each emotion",
                table_figure,
                lambda _: (BEHAVIOURS,),
                SINGLE_COLUMN,
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
                "Full traces of all robots, emotion beside emotion",
                traces_figure,
                lambda material: ({emotion: material.run(emotion) for emotion in EMOTIONS},),
                DOUBLE_COLUMN,
                tuple(EMOTIONS),
            ),
            Entry(
                "descriptors",
                "",
                "Descriptors of the six emotions, each axis from the least to the largest value",
                descriptors_figure,
                lambda material: (material.table(MEASURES),),
                DOUBLE_COLUMN,
                tuple(EMOTIONS),
                (MEASURES,),
            ),
        )
    }
)
