"""Tables in print: as booktabs LaTeX, as Markdown, and as a picture."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from emovid.figures.attributes import Cell, Table, cited, named
from emovid.figures.style import DOUBLE_COLUMN, INK, POINTS, QUIET, TEXT, heading, in_style, text_width, wrapped
from emovid.swarm.arrays import Array

_MARKS = ("†", "‡", "§")
_LATEX_MARKS = (r"\textsuperscript{\dag}", r"\textsuperscript{\ddag}", r"\textsuperscript{\S}")
_LATEX_ESCAPES = str.maketrans(
    {c: f"\\{c}" for c in "&%$#_{}"} | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}"}
)
_RULES = {"toprule": 0.8, "midrule": 0.5, "bottomrule": 0.8}  # widths [pt], as those of booktabs
_LINE = 1.22 * TEXT  # from one line to the next [pt]
_ABOVE, _GAP, _EDGE = 3.5, 10.0, 2.0  # over a row, between columns, beside the outer ones [pt]
_STEP = 4.0  # between widths of columns that are tried [pt]
_SHARE = 0.9  # height of the letters above and below their line's middle, of the distance of lines


def table_latex(table: Table) -> str:
    r"""Return a table as LaTeX for the booktabs package, its sources as `\cite`, listed in comments at the end."""
    columns = len(table.columns)
    lines = [
        rf"\begin{{tabular}}{{{'l' * columns}}}",
        r"  \toprule",
        "  " + " & ".join(map(_escaped, table.columns)) + r" \\",
    ]
    for title, rows in table.groups:
        lines.append(r"  \midrule")
        if title:
            lines.append(rf"  \multicolumn{{{columns}}}{{l}}{{\emph{{{_escaped(title)}}}}} \\")
        for name, cells in rows:
            lines.append("  " + " & ".join([_escaped(heading(name)), *map(_latex_cell, cells)]).rstrip() + r" \\")
    lines.append(r"  \bottomrule")
    for mark, note in zip(_LATEX_MARKS, table.notes, strict=False):
        lines.append(rf"  \multicolumn{{{columns}}}{{l}}{{{mark} {_escaped(note)}}} \\")
    lines.append(r"\end{tabular}")
    lines += [f"% {key}: {source.full}" for key, source in cited(table).items()]
    return "\n".join(lines) + "\n"


def table_markdown(table: Table) -> str:
    """Return a table as Markdown, each cell with its source in brackets, and the sources in full under it."""
    lines = ["| " + " | ".join(table.columns) + " |", "|---" * len(table.columns) + "|"]
    for title, rows in table.groups:
        if title:
            lines.append(f"| *{title}* |" + " |" * (len(table.columns) - 1))
        for name, cells in rows:
            lines.append("| " + " | ".join([heading(name), *map(_markdown_cell, cells)]) + " |")
    lines += [line for mark, note in zip(_MARKS, table.notes, strict=False) for line in ("", f"{mark} {note}")]
    lines += ["", *(f"- {source.name}: {source.full}." for source in cited(table).values())]
    return "\n".join(lines) + "\n"


class _Line(NamedTuple):
    """A line of text in a picture: what, where from [pt], in which colour, whether slanted."""

    text: str
    x: float
    y: float
    colour: str = INK
    slanted: bool = False


@in_style()
def table_figure(table: Table, *, width: float = DOUBLE_COLUMN) -> Figure:
    """Draw a table, each cell over its source, text wrapped to the columns.

    Args:
        table: what to draw.
        width: of the figure [in].
    """
    left, right, widths = _EDGE, width * POINTS - _EDGE, _column_widths(table, width * POINTS - 2 * _EDGE)
    starts = left + np.concatenate([[0], np.cumsum(widths + _GAP)[:-1]])
    written: list[_Line] = []
    rules: list[tuple[float, str]] = [(0.0, "toprule")]

    def row(columns: Sequence[Sequence[tuple[str, str]]], y: float, *, slanted: bool = False) -> float:
        for start, lines in zip(starts, columns, strict=False):
            for i, (text, colour) in enumerate(lines):
                written.append(_Line(text, float(start), y + _ABOVE + i * _LINE, colour, slanted))
        return y + _ABOVE + max(map(len, columns)) * _LINE

    y = row([[(text, INK) for text in wrapped(name, w)] for name, w in zip(table.columns, widths, strict=True)], 0.0)
    for title, rows in table.groups:
        y += _ABOVE
        rules.append((y, "midrule"))
        if title:
            y = row([[(title, INK)]], y, slanted=True)
        for name, cells in rows:
            y = row([[(heading(name), INK)], *map(_lines_of, cells, widths[1:])], y)
    y += _ABOVE
    rules.append((y, "bottomrule"))
    for mark, note in zip(_MARKS, table.notes, strict=False):
        y = row([[(text, INK) for text in wrapped(f"{mark} {note}", right - left)]], y)
    return _drawn(written, rules, width, y)


def _drawn(written: Sequence[_Line], rules: Sequence[tuple[float, str]], width: float, depth: float) -> Figure:
    height = depth + 2 * _EDGE
    figure = Figure(figsize=(width, height / POINTS))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width * POINTS), ylim=(height - _EDGE, -_EDGE))
    axes.set_axis_off()
    for y, rule in rules:
        axes.plot([_EDGE, width * POINTS - _EDGE], [y, y], color=INK, linewidth=_RULES[rule], snap=False)
    for line in written:
        style = "italic" if line.slanted else "normal"
        axes.text(line.x, line.y + _SHARE * TEXT, line.text, color=line.colour, style=style, va="baseline")
    return figure


def _column_widths(table: Table, room: float) -> Array:
    """Return the widths [pt] of the columns: as their text needs, or those that make the fewest lines."""
    names = [heading(name) for _, rows in table.groups for name, _ in rows]
    first = text_width([table.columns[0], *names, *(title for title, _ in table.groups)]) + 1
    room -= first + _GAP * (len(table.columns) - 1)
    columns = [[cells[j] for _, rows in table.groups for _, cells in rows] for j in range(len(table.columns) - 1)]
    texts = [
        [name, *(text for cell in cells for text in (_marked(cell, _MARKS), _source(cell)))]
        for name, cells in zip(table.columns[1:], columns, strict=True)
    ]
    widths = np.array([text_width(column) + 1 for column in texts])
    if widths.sum() > room:
        narrowest = [text_width(word for text in column for word in text.split(" ")) + 1 for column in texts]
        widths = _fewest_lines(columns, narrowest, widths, room)
    return np.concatenate([[first], widths + (room - widths.sum()) / len(widths)])


def _fewest_lines(columns: Sequence[Sequence[Cell]], narrowest: Sequence[float], widest: Array, room: float) -> Array:
    """Return the widths [pt], from `narrowest` to `widest`, in which columns of cells have the fewest lines in all."""
    tried = [np.arange(least, most + _STEP, _STEP) for least, most in zip(narrowest, widest, strict=True)]
    heights = [
        {width: [len(_lines_of(cell, width)) for cell in cells] for width in widths}
        for cells, widths in zip(columns, tried, strict=True)
    ]

    def lines(widths: Sequence[float]) -> int:
        return int(np.max([made[width] for made, width in zip(heights, widths, strict=True)], axis=0).sum())

    fit = [widths for widths in product(*tried) if sum(widths) <= room] or [tuple(narrowest)]
    return np.array(min(fit, key=lines))


def _lines_of(cell: Cell, width: float) -> list[tuple[str, str]]:
    """Return the lines of a cell: its text and, quieter, its source."""
    source = _source(cell)
    parts = [source] if text_width([source]) <= width else source.split("; ")  # one to a line, then
    quiet = [(line, QUIET) for part in parts for line in wrapped(part, width)]
    return [*((line, INK) for line in wrapped(_marked(cell, _MARKS), width)), *quiet] or [("–", QUIET)]


def _source(cell: Cell) -> str:
    """Return the source of a cell, held together from "et al." to its year."""
    return named(cell).replace("et al. ", "et\N{NO-BREAK SPACE}al.\N{NO-BREAK SPACE}")


def _marked(cell: Cell, marks: Sequence[str]) -> str:
    return cell.text + (marks[cell.note - 1] if cell.note else "")


def _latex_cell(cell: Cell) -> str:
    if not cell.text:
        return ""
    text = _escaped(cell.text) + (_LATEX_MARKS[cell.note - 1] if cell.note else "")
    place = f"[{_escaped(cell.place)}]" if cell.place else ""
    return rf"{text} \cite{place}{{{','.join(cell.sources)}}}"


def _markdown_cell(cell: Cell) -> str:
    return f"{_marked(cell, _MARKS)} ({named(cell)})" if cell.text else ""


def _escaped(text: str) -> str:
    return text.translate(_LATEX_ESCAPES)
