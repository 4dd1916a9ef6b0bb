"""The confusion matrix as a file: CSV to compute with, Markdown and LaTeX to print, laid out as the paper's Table III.

Rows are the perceived labels, columns the signalled ones.
"""

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emovid.errors import nearest
from emovid.study.cells import csv_text
from emovid.study.errors import StudyError
from emovid.whole_files import reason

Counts = NDArray[np.int64]

_CORNER = "perceived"
_PERCENT = "_percent"


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
    lines = [
        "| Response | " + " | ".join(map(str.capitalize, signalled)) + " |",
        "|---|" + "--:|" * len(signalled),
    ]
    for label, row in zip(labels, _cells(counts, labels, signalled, "**{}**"), strict=True):
        lines.append(f"| {label.capitalize()} | " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n"


def matrix_latex(counts: Counts, labels: Sequence[str], signalled: Sequence[str]) -> str:
    """Return the matrix as a booktabs table, the diagonal bold."""
    heads = " & ".join(map(str.capitalize, signalled))
    body = "\n".join(
        f"  {label.capitalize()} & " + " & ".join(row) + r" \\"
        for label, row in zip(labels, _cells(counts, labels, signalled, r"\textbf{{{}}}"), strict=True)
    )
    return "\n".join(
        (
            r"\begin{tabular}{l" + "r" * len(signalled) + "}",
            r"  \toprule",
            rf"  & \multicolumn{{{len(signalled)}}}{{c}}{{Signaled Emotion}} \\",
            rf"  Response (\%) & {heads} \\",
            r"  \midrule",
            body,
            r"  \bottomrule",
            r"\end{tabular}",
            "",
        )
    )


def read_matrix(path: Path) -> tuple[Counts, tuple[str, ...], tuple[str, ...]]:
    """Return the counts, the perceived labels and the signalled ones of a file laid out as `matrix_csv` writes it.

    Raises:
        StudyError: for a file that is none, with the line and the cell.
    """
    try:
        rows = [row for row in csv.reader(io.StringIO(path.read_text(encoding="utf-8-sig"))) if any(row)]
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {reason(error)}") from None
    except (UnicodeDecodeError, csv.Error):
        raise StudyError(f"{path}: not a confusion matrix: expected CSV text") from None
    if len(rows) < 3 or rows[0][0].strip().lower() != _CORNER:
        raise StudyError(
            f"{path}:1: not a confusion matrix: expected the heading {_CORNER},happiness,... and a row a label"
        )
    signalled = tuple(name.strip().lower() for name in rows[0][1:] if not name.endswith(_PERCENT))
    labels = tuple(row[0].strip().lower() for row in rows[1:])
    for name in signalled:
        if name not in labels:
            raise StudyError(f"{path}:1: {name}: no row has this label{nearest(name, labels)}")
    counts = [
        [_count(path, line, cell) for cell in row[1 : len(signalled) + 1]] for line, row in enumerate(rows[1:], 2)
    ]
    if any(len(row) != len(signalled) for row in counts):
        raise StudyError(f"{path}: a row has fewer cells than the heading")
    return np.array(counts, dtype=np.int64), labels, signalled


def read_results(path: Path) -> tuple[Counts, tuple[str, ...], tuple[str, ...]]:
    """Return the matrix of an analysis: of its folder, its results.json, or its confusion_matrix.csv.

    Raises:
        StudyError: as `read_matrix`.
    """
    file = path / "results.json" if path.is_dir() else path
    if file.suffix.lower() != ".json":
        return read_matrix(file)
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        counts = np.array(found["counts"], dtype=np.int64)
        labels, signalled = tuple(map(str, found["labels"])), tuple(map(str, found["emotions"]))
        if counts.shape != (len(labels), len(signalled)):
            raise ValueError
    except OSError as error:
        raise StudyError(f"{file}: cannot be read: {reason(error)}") from None
    except (ValueError, KeyError, TypeError):
        raise StudyError(f"{file}: no results; expected the results.json of emovid study analyze") from None
    return counts, labels, signalled


def _count(path: Path, line: int, cell: str) -> int:
    if not cell.strip().isdecimal() or len(cell.strip()) > 9:
        raise StudyError(f"{path}:{line}: {cell!r}: expected a count, a whole number")
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
