"""The confusion matrix as a file: CSV to compute with, Markdown and LaTeX to print, laid out as the paper's Table III.

Rows are the perceived labels, columns the signalled ones.
"""

import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emovid.errors import nearest
from emovid.study.cells import csv_text
from emovid.study.errors import StudyError, quoted
from emovid.study.key import read_bytes
from emovid.study.tables import read_table

Counts = NDArray[np.int64]

_CORNER = "perceived"
_PERCENT = "_percent"
_MOST_DIGITS = 7  # of a count: far beyond any study, and products of sums of such counts are exact


def percent(counts: Counts) -> NDArray[np.float64]:
    """Return each count as a percentage of its column, (k, m); nan where a column is empty."""
    total = counts.sum(axis=0)
    return np.where(total > 0, 100 * counts / np.maximum(total, 1), np.nan)


def matrix_csv(counts: Counts, labels: Sequence[str], signalled: Sequence[str]) -> str:
    """Return the counts, and after them the percentages, as CSV text."""
    shares = percent(counts).tolist()
    rows = (
        [label, *row, *map(_two_decimals, of_column)]
        for label, row, of_column in zip(labels, counts.tolist(), shares, strict=True)
    )
    return csv_text([_CORNER, *signalled, *(name + _PERCENT for name in signalled)], rows)


def matrix_markdown(counts: Counts, labels: Sequence[str], signalled: Sequence[str]) -> str:
    """Return the matrix as a Markdown table: percent, the diagonal bold, and counts in brackets."""
    heads = [name.capitalize().replace("|", r"\|") for name in labels]
    lines = [
        "| Response | " + " | ".join(heads[: len(signalled)]) + " |",
        "|---|" + "--:|" * len(signalled),
    ]
    for head, row in zip(heads, _cells(counts, labels, signalled, "**{}**"), strict=True):
        lines.append(f"| {head} | " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n"


def matrix_latex(counts: Counts, labels: Sequence[str], signalled: Sequence[str]) -> str:
    """Return the matrix as a booktabs table, the diagonal bold."""
    heads = [latex_text(name.capitalize()) for name in labels]
    body = "\n".join(
        f"  {head} & " + " & ".join(row) + r" \\"
        for head, row in zip(heads, _cells(counts, labels, signalled, r"\textbf{{{}}}"), strict=True)
    )
    return "\n".join(
        (
            r"\begin{tabular}{l" + "r" * len(signalled) + "}",
            r"  \toprule",
            rf"  & \multicolumn{{{len(signalled)}}}{{c}}{{Signaled Emotion}} \\",
            rf"  Response (\%) & {' & '.join(heads[: len(signalled)])} \\",
            r"  \midrule",
            body,
            r"  \bottomrule",
            r"\end{tabular}",
            "",
        )
    )


def latex_text(text: str) -> str:
    """Return text as LaTeX shows it, with what it would take for a command escaped."""
    words = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    return "".join(words.get(mark, f"\\{mark}" if mark in "&%$#_{}" else mark) for mark in text)


def read_matrix(path: Path) -> tuple[Counts, tuple[str, ...], tuple[str, ...]]:
    """Return the counts, the perceived labels and the signalled ones of a file laid out as `matrix_csv` writes it.

    The file's rows may stand in any order. Those of the signalled labels are returned first, in the order of the
    columns, as everywhere in this room: the right answer to column j stands in row j.

    Raises:
        StudyError: for a file that is none, with the line and the cell.
    """
    table = read_table(read_bytes(path), str(path))
    places = [i for i, name in enumerate(table.names) if i and not name.endswith(_PERCENT)]
    if table.rejected:
        raise StudyError(str(path), table.rejected[0].reason, table.rejected[0].row)
    if table.names[0].lower() != _CORNER or not places or len(table.lines) < 2:
        message = f"not a confusion matrix; expected the heading {_CORNER},happiness,... and a row a label"
        raise StudyError(str(path), message, 1)
    signalled = _different(path, [1] * len(places), [table.names[i] for i in places])
    found = _different(path, table.lines.tolist(), list(table.cells[0]))
    for name in signalled:
        if name not in found:
            raise StudyError(str(path), f"no row has this label{nearest(name, found)}", 1, name)
    counts = [
        [_count(path, line, str(cell)) for cell in row]
        for line, row in zip(table.lines.tolist(), table.cells[places].to_numpy(), strict=True)
    ]
    labels = (*signalled, *(label for label in found if label not in signalled))
    return np.array(counts, dtype=np.int64)[[found.index(label) for label in labels]], labels, signalled


def _different(path: Path, lines: Sequence[int], names: Sequence[str]) -> tuple[str, ...]:
    """Return labels in lower case, of which no two are the same."""
    labels = [name.lower() for name in names]
    for i, (line, label) in enumerate(zip(lines, labels, strict=True)):
        if not label or label in labels[:i]:
            message = "stands twice" if label else "a row without a label"
            raise StudyError(str(path), f"{message}; expected each label once", line, label)
    return tuple(labels)


def read_results(path: Path) -> tuple[Counts, tuple[str, ...], tuple[str, ...]]:
    """Return the matrix of an analysis: of its folder, its results.json, or its confusion_matrix.csv.

    Raises:
        StudyError: as `read_matrix`.
    """
    file = path / "results.json" if path.is_dir() else path
    if file.suffix.lower() != ".json":
        return read_matrix(file)
    try:
        found = json.loads(read_bytes(file))
        counts = [[_count(file, 0, str(cell)) for cell in row] for row in found["counts"]]
        labels, signalled = tuple(map(str, found["labels"])), tuple(map(str, found["emotions"]))
        matrix = np.array(counts, dtype=np.int64)
        rightly_placed = labels[: len(signalled)] == signalled and len(set(labels)) == len(labels)
        if not matrix.size or matrix.shape != (len(labels), len(signalled)) or not rightly_placed:
            raise ValueError
    except (ValueError, KeyError, TypeError, RecursionError):
        raise StudyError(str(file), "no results; expected the results.json of emovid study analyze") from None
    return matrix, labels, signalled


def _count(path: Path, line: int, cell: str) -> int:
    if not re.fullmatch(rf"[0-9]{{1,{_MOST_DIGITS}}}", cell):
        raise StudyError(str(path), f"{quoted(cell)}; expected a count, a whole number below ten million", line)
    return int(cell)


def _cells(counts: Counts, labels: Sequence[str], signalled: Sequence[str], bold: str) -> list[list[str]]:
    shares = percent(counts)
    return [
        [
            (bold if label == name else "{}").format(_two_decimals(shares[i, j])) + f" ({counts[i, j]})"
            for j, name in enumerate(signalled)
        ]
        for i, label in enumerate(labels)
    ]


def _two_decimals(share: float) -> str:
    return "" if np.isnan(share) else f"{share:.2f}"
