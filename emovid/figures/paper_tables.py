"""Tables I and II of the paper: their contents with sources, as LaTeX (booktabs), Markdown and HTML.

Facts and sources are those of M. Santos and M. Egerstedt, "From Motions to Emotions: Can the Fundamental Emotions be
Expressed in a Robot Swarm?", Int. J. Social Robotics 2021, doi 10.1007/s12369-020-00665-6.
"""

from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

from emovid.figures.style import heading
from emovid.latex import latex_text
from emovid.scene.emotions import EMOTIONS

PAPER = "Santos2021"
_MARKS = ("†", "‡", "§")
_LATEX_MARKS = (r"\textsuperscript{\dag}", r"\textsuperscript{\ddag}", r"\textsuperscript{\S}")


class Source(NamedTuple):
    """A publication: its short name and its full reference."""

    name: str
    full: str


class Cell(NamedTuple):
    """An entry of a table.

    Attributes:
        text: empty where the paper says nothing.
        sources: keys of `SOURCES`, as in the paper's bibliography.
        place: in the source, for example "Sec. III-A".
        note: number of a note of the table, from 1; 0 for none.
    """

    text: str = ""
    sources: tuple[str, ...] = ()
    place: str = ""
    note: int = 0


class Table(NamedTuple):
    """A table.

    Attributes:
        columns: headings; the first one is over the names of the rows.
        groups: headings of groups and their rows (name, cells); an empty heading is not shown.
        notes: below the table.
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

# Sections of Appendix A with the law of each emotion.
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
    """Return the sources of a table by key."""
    keys = {key for _, rows in table.groups for _, cells in rows for cell in cells for key in cell.sources}
    return {key: source for key, source in SOURCES.items() if key in keys}


def named(cell: Cell) -> str:
    """Return the source of a cell in words: its name, or for the paper itself only the place in it."""
    if cell.sources == (PAPER,):
        return cell.place
    return "; ".join(SOURCES[key].name for key in cell.sources)


def table_latex(table: Table) -> str:
    r"""Return a table as LaTeX for the booktabs package, with `\cite` for sources and their references in comments."""
    columns = len(table.columns)
    lines = [
        rf"\begin{{tabular}}{{{'l' * columns}}}",
        r"  \toprule",
        "  " + " & ".join(map(latex_text, table.columns)) + r" \\",
    ]
    for title, rows in table.groups:
        lines.append(r"  \midrule")
        if title:
            lines.append(rf"  \multicolumn{{{columns}}}{{l}}{{\emph{{{latex_text(title)}}}}} \\")
        for name, cells in rows:
            lines.append("  " + " & ".join([latex_text(heading(name)), *map(_latex_cell, cells)]).rstrip() + r" \\")
    lines.append(r"  \bottomrule")
    for mark, note in zip(_LATEX_MARKS, table.notes, strict=False):
        lines.append(rf"  \multicolumn{{{columns}}}{{l}}{{{mark} {latex_text(note)}}} \\")
    lines.append(r"\end{tabular}")
    lines += [f"% {key}: {source.full}" for key, source in cited(table).items()]
    return "\n".join(lines) + "\n"


def table_markdown(table: Table) -> str:
    """Return a table as Markdown, each cell with its source in brackets, and the references below it."""
    lines = ["| " + " | ".join(table.columns) + " |", "|---" * len(table.columns) + "|"]
    for title, rows in table.groups:
        if title:
            lines.append(f"| *{title}* |" + " |" * (len(table.columns) - 1))
        for name, cells in rows:
            lines.append("| " + " | ".join([heading(name), *map(_markdown_cell, cells)]) + " |")
    lines += [line for mark, note in zip(_MARKS, table.notes, strict=False) for line in ("", f"{mark} {note}")]
    lines += ["", *(f"- {source.name}: {source.full}." for source in cited(table).values())]
    return "\n".join(lines) + "\n"


def table_html(table: Table) -> str:
    """Return a table as HTML, each cell over its source, and the notes under it."""
    lines = ["<table>", "<thead>", _html_row(_html_head(name, "col") for name in table.columns), "</thead>"]
    for title, rows in table.groups:
        lines.append("<tbody>")
        if title:
            lines.append(_html_row([f'<th colspan="{len(table.columns)}" scope="rowgroup">{escape(title)}</th>']))
        lines += [_html_row([_html_head(heading(name), "row"), *map(_html_cell, cells)]) for name, cells in rows]
        lines.append("</tbody>")
    lines.append("</table>")
    lines += [f"<p>{mark} {escape(note)}</p>" for mark, note in zip(_MARKS, table.notes, strict=False)]
    return "\n".join(lines) + "\n"


def _marked(cell: Cell, marks: Sequence[str]) -> str:
    return cell.text + (marks[cell.note - 1] if cell.note else "")


def _latex_cell(cell: Cell) -> str:
    if not cell.text:
        return ""
    text = latex_text(cell.text) + (_LATEX_MARKS[cell.note - 1] if cell.note else "")
    place = f"[{latex_text(cell.place)}]" if cell.place else ""
    return rf"{text} \cite{place}{{{','.join(cell.sources)}}}"


def _markdown_cell(cell: Cell) -> str:
    return f"{_marked(cell, _MARKS)} ({named(cell)})" if cell.text else ""


def _html_row(cells: Iterable[str]) -> str:
    return f"<tr>{''.join(cells)}</tr>"


def _html_head(text: str, scope: str) -> str:
    return f'<th scope="{scope}">{escape(text)}</th>'


def _html_cell(cell: Cell) -> str:
    source = f"<br><small>{escape(named(cell))}</small>" if cell.text else ""
    return f"<td>{escape(_marked(cell, _MARKS))}{source}</td>"
