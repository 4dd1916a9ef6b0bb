"""Tables I and II of the paper as data, each cell with its source.

Facts and sources are those of M. Santos and M. Egerstedt, "From Motions to Emotions: Can the Fundamental Emotions be
Expressed in a Robot Swarm?", Int. J. Social Robotics 2021, doi 10.1007/s12369-020-00665-6.
"""

from typing import NamedTuple

from emovid.scene.emotions import EMOTIONS

PAPER = "Santos2021"


class Source(NamedTuple):
    """A publication: how it is named in a text, and in full."""

    name: str
    full: str


class Cell(NamedTuple):
    """An entry of a table.

    Attributes:
        text: what it says; empty where the paper says nothing.
        sources: keys of `SOURCES`, those of the paper's bibliography.
        place: where in the source, as in "Sec. III-A".
        note: of the table, by its number from 1; 0 for none.
    """

    text: str = ""
    sources: tuple[str, ...] = ()
    place: str = ""
    note: int = 0


class Table(NamedTuple):
    """A table.

    Attributes:
        columns: headings, the first over the names of the rows.
        groups: rows (name, cells) under a heading each; an empty heading is not shown.
        notes: under the table.
    """

    columns: tuple[str, ...]
    groups: tuple[tuple[str, tuple[tuple[str, tuple[Cell, ...]], ...]], ...]
    notes: tuple[str, ...] = ()


SOURCES = {
    "Aronoff2006": Source(
        "Aronoff 2006",
        "J. Aronoff, How we recognize angry and happy emotion in people, places, and things, Cross-Cultural Research "
        "40(1), 2006",
    ),
    "Collier1996": Source(
        "Collier 1996",
        "G. L. Collier, Affective synesthesia: Extracting emotion space from simple perceptual stimuli, Motivation and "
        "Emotion 20(1), 1996",
    ),
    "DeRooij2013": Source(
        "De Rooij et al. 2013",
        "A. de Rooij, J. Broekens and M. H. Lamers, Abstract expressions of affect, Int. J. Synthetic Emotions 4(1), "
        "2013",
    ),
    "Lee2007": Source(
        "Lee et al. 2007",
        "J.-H. Lee, J.-Y. Park and T.-J. Nam, Emotional Interaction Through Physical Movement, Springer, 2007",
    ),
    "Pollick2001": Source(
        "Pollick et al. 2001",
        "F. E. Pollick, H. M. Paterson, A. Bruderlin and A. J. Sanford, Perceiving affect from arm movement, Cognition "
        "82(2), 2001",
    ),
    "Rime1985": Source(
        "Rimé et al. 1985",
        "B. Rimé, B. Boulanger, P. Laubin, M. Richir and K. Stroobants, The perception of interpersonal emotions "
        "originated by patterns of movement, Motivation and Emotion 9(3), 1985",
    ),
    PAPER: Source(
        "Santos and Egerstedt 2021",
        "M. Santos and M. Egerstedt, From Motions to Emotions: Can the Fundamental Emotions be Expressed in a Robot "
        "Swarm?, Int. J. Social Robotics, 2021",
    ),
}

_NONE = Cell()
_SLOW = Cell("small, slow", ("Pollick2001", "Rime1985"))
_VALENCE = ("Aronoff2006", "Collier1996")

ATTRIBUTES = Table(
    ("", "Shape features", "Size features", "Movement features"),
    (
        (
            "Emotion",
            (
                (
                    "happiness",
                    (
                        Cell("roundness, curvilinearity", ("Collier1996",)),
                        Cell("big", ("DeRooij2013",)),
                        Cell("smoothness", ("Lee2007",)),
                    ),
                ),
                ("surprise", (Cell("roundness", ("Collier1996",)), Cell("very big", ("DeRooij2013",)), _NONE)),
                ("sadness", (Cell("roundness", ("Collier1996",)), Cell("small", ("DeRooij2013",)), _SLOW)),
                ("anger", (_NONE, _NONE, Cell("large, fast, angular", ("Pollick2001",)))),
                ("fear", (Cell("downward pointing triangles", ("Aronoff2006",), note=1), _NONE, _SLOW)),
            ),
        ),
        (
            "Valence",
            (
                ("positive", (Cell("roundness", _VALENCE), _NONE, Cell("rounded movement trace", _VALENCE))),
                (
                    "negative",
                    (Cell("angularity", _VALENCE, note=2), _NONE, Cell("angular movement trace", _VALENCE, note=2)),
                ),
            ),
        ),
    ),
    (
        "Not used in the behaviors.",
        "Not used for sadness, in spite of its valence: the row of sadness decides.",
    ),
)

# Where Appendix A gives the law of each.
_APPENDIX = {"happiness": "A-A", "surprise": "A-B", "sadness": "A-C", "fear": "A-D", "disgust": "A-D", "anger": "A-D"}

BEHAVIOURS = Table(
    ("Emotion", "Swarm behavior", "Robot control"),
    (
        (
            "",
            tuple(
                (
                    name,
                    (
                        Cell(emotion.behaviour, (PAPER,), f"Sec. III-A, App. {_APPENDIX[name]}"),
                        Cell(emotion.control, (PAPER,), "Sec. III-B"),
                    ),
                )
                for name, emotion in EMOTIONS.items()
            ),
        ),
    ),
)


def cited(table: Table) -> dict[str, Source]:
    """Return the sources that a table names, by key."""
    keys = {key for _, rows in table.groups for _, cells in rows for cell in cells for key in cell.sources}
    return {key: source for key, source in SOURCES.items() if key in keys}


def named(cell: Cell) -> str:
    """Return the source of a cell in words: its name, or the place if that is in the paper itself."""
    if cell.sources == (PAPER,):
        return cell.place
    return "; ".join(SOURCES[key].name for key in cell.sources)
