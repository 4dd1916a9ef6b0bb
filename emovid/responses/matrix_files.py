"""Reading a confusion matrix from a file: a table, or the results of an analysis."""

import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emovid.errors import SourceError, nearest, quoted
from emovid.responses.key import read_bytes
from emovid.responses.tables import read_table

Counts = NDArray[np.int64]

CORNER = "perceived"  # heading of the column of labels
PERCENT = "_percent"  # ending of the headings of percentages
_MOST_DIGITS = 7  # of a count: far beyond any study, and products of sums of such counts are exact


def read_matrix(path: Path) -> tuple[Counts, tuple[str, ...], tuple[str, ...]]:
    """Return the counts, the perceived labels and the signalled ones of a file laid out as `matrix_csv` writes it.

    The file's rows may stand in any order. Those of the signalled labels are returned first, in the order of the
    columns, as everywhere in this room: the right answer to column j stands in row j.

    Raises:
        SourceError: for a file that is none, with the line and the cell.
    """
    table = read_table(read_bytes(path), str(path))
    places = [i for i, name in enumerate(table.names) if i and not name.endswith(PERCENT)]
    if table.rejected:
        raise SourceError(str(path), table.rejected[0].reason, table.rejected[0].row)
    if table.names[0].lower() != CORNER or not places or len(table.lines) < 2:
        message = f"not a confusion matrix; expected the heading {CORNER},happiness,... and a row a label"
        raise SourceError(str(path), message, 1)
    signalled = _different(path, [1] * len(places), [table.names[i] for i in places])
    found = _different(path, table.lines.tolist(), list(table.cells[0]))
    for name in signalled:
        if name not in found:
            raise SourceError(str(path), f"no row has this label{nearest(name, found)}", 1, name)
    counts = [
        [_count(path, line, str(cell)) for cell in row]
        for line, row in zip(table.lines.tolist(), table.cells[places].to_numpy(), strict=True)
    ]
    labels = (*signalled, *(label for label in found if label not in signalled))
    return np.array(counts, dtype=np.int64)[[found.index(label) for label in labels]], labels, signalled


def read_results(path: Path) -> tuple[Counts, tuple[str, ...], tuple[str, ...]]:
    """Return the matrix of an analysis: of its folder, its results.json, or its confusion_matrix.csv.

    Raises:
        SourceError: as `read_matrix`.
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
        raise SourceError(str(file), "no results; expected the results.json of emovid study analyze") from None
    return matrix, labels, signalled


def _different(path: Path, lines: Sequence[int], names: Sequence[str]) -> tuple[str, ...]:
    """Return labels in lower case, of which no two are the same."""
    labels = [name.lower() for name in names]
    for i, (line, label) in enumerate(zip(lines, labels, strict=True)):
        if not label or label in labels[:i]:
            message = "stands twice" if label else "a row without a label"
            raise SourceError(str(path), f"{message}; expected each label once", line, label)
    return tuple(labels)


def _count(path: Path, line: int, cell: str) -> int:
    if not re.fullmatch(rf"[0-9]{{1,{_MOST_DIGITS}}}", cell):
        raise SourceError(str(path), f"{quoted(cell)}; expected a count, a whole number below ten million", line)
    return int(cell)
