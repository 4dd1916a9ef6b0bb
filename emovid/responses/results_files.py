"""Files that an analysis wrote: reading their confusion matrix, and recognizing them among exports."""

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import read_bytes, read_table
from emovid.errors import SourceError, nearest, quoted

Counts = NDArray[np.int64]

CORNER = "perceived"  # heading of the column of labels
PERCENT = "_percent"  # ending of the headings of percentages
_MOST_DIGITS = 7  # of a count: more than any study needs, and few enough for exact products of sums of counts
TIDY = ("participant", "video", "signalled", "perceived", "position")  # the first columns of responses_tidy.csv
_TABLES = ("results.json", "confusion_matrix.csv", "tests.csv", "rejected.csv", "responses_tidy.csv")
_PRINTED = (".html", ".pdf", ".png", ".md", ".tex")
WRITTEN = "files.sha256"  # list of the files of an analysis, in the format of sha256sum


def read_matrix(path: Path) -> tuple[Counts, tuple[str, ...], tuple[str, ...]]:
    """Return the counts, the perceived labels and the signaled labels of a file in the layout of `matrix_csv`.

    The rows of the file can be in any order. The rows of the signaled labels are returned first, in the order of the
    columns, so that the right answer to column j is in row j.

    Raises:
        SourceError: for a file without such a matrix, with the line and the cell.
    """
    table = read_table(read_bytes(path), str(path))
    places = [i for i, name in enumerate(table.names) if i and not name.endswith(PERCENT)]
    if table.rejected:
        raise SourceError(str(path), table.rejected[0].reason, table.rejected[0].row)
    if table.names[0].lower() != CORNER or not places or len(table.lines) < 2:
        message = f"not a confusion matrix; expected the heading {CORNER},happiness,... and one row for each label"
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
    """Return the matrix of an analysis from its folder, its results.json, or its confusion_matrix.csv.

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
        is_ordered = labels[: len(signalled)] == signalled and len(set(labels)) == len(labels)
        if not matrix.size or matrix.shape != (len(labels), len(signalled)) or not is_ordered:
            raise ValueError
    except (ValueError, KeyError, TypeError, RecursionError):
        raise SourceError(str(file), "not results; expected the results.json of emovid study analyze") from None
    return matrix, labels, signalled


def read_participants(path: Path) -> Counts | None:
    """Return how often each participant gave each label to each emotion (participants, labels, signalled).

    None for a confusion matrix alone; else from responses_tidy.csv beside the results, in the order of their labels.

    Raises:
        SourceError: as `read_results`, and if the answers are not those of the results.
    """
    folder = path if path.is_dir() else path.parent
    tidy = folder / "responses_tidy.csv"
    if (not path.is_dir() and path.suffix.lower() != ".json") or not tidy.is_file():
        return None
    matrix, labels, signalled = read_results(path)
    table = read_table(read_bytes(tidy), str(tidy))
    if tuple(table.names[: len(TIDY)]) != TIDY:
        raise SourceError(str(tidy), f"not tidy answers; expected the columns {', '.join(TIDY)}", 1)
    people, names = pd.factorize(table.cells[0])
    rows, columns = pd.Index(labels).get_indexer(table.cells[3]), pd.Index(signalled).get_indexer(table.cells[2])
    uses = np.zeros((len(names), *matrix.shape), dtype=np.int64)
    np.add.at(uses, (people, rows, columns), 1)
    if min(rows.min(initial=0), columns.min(initial=0)) < 0 or (uses.sum(axis=0) != matrix).any():
        raise SourceError(str(tidy), "other answers than those of results.json; expected both from one analysis")
    return uses


def _different(path: Path, lines: Sequence[int], names: Sequence[str]) -> tuple[str, ...]:
    """Return labels in lower case. Raises SourceError if one is empty or repeated."""
    labels = [name.lower() for name in names]
    for i, (line, label) in enumerate(zip(lines, labels, strict=True)):
        if not label or label in labels[:i]:
            message = "given twice" if label else "a row without a label"
            raise SourceError(str(path), f"{message}; expected each label once", line, label)
    return tuple(labels)


def _count(path: Path, line: int, cell: str) -> int:
    if not re.fullmatch(rf"[0-9]{{1,{_MOST_DIGITS}}}", cell):
        raise SourceError(str(path), f"{quoted(cell)}; expected a count, a whole number below ten million", line)
    return int(cell)


def is_results(file: Path) -> bool:
    """Return whether a file is the results.json of an analysis. Raises OSError if it cannot be read."""
    try:
        found = json.loads(file.read_bytes())
    except (ValueError, RecursionError):
        return False
    return isinstance(found, dict) and {"counts", "labels", "emotions", "recognition"} <= set(found)


def is_of_analysis(file: Path, among_results: bool) -> bool:
    """Return whether an analysis wrote a file.

    Args:
        file: its path.
        among_results: whether a results.json is beside it; then the name of the file decides. Elsewhere, only a table
            of tidy answers is recognized.

    Raises:
        OSError: if the file cannot be read.
    """
    if file.name == WRITTEN or (among_results and (file.name in _TABLES or file.suffix in _PRINTED)):
        return True
    return file.suffix.lower() == ".csv" and _is_tidy(file)


def _is_tidy(file: Path) -> bool:
    with file.open("rb") as data:
        header = data.readline(10_000).decode("utf-8-sig", errors="replace").strip()
    return header.startswith(",".join(TIDY)) and header.endswith(",correct")


def list_of_files(files: Mapping[str, bytes]) -> bytes:
    """Return the content of `WRITTEN` for the files of an analysis, by name: a digest and a name on each line."""
    return "".join(f"{hashlib.sha256(data).hexdigest()}  {name}\n" for name, data in sorted(files.items())).encode()


def files_of_analysis(folder: Path) -> dict[str, str]:
    """Return the digest of each file that an analysis wrote into a folder, by name; empty if there was none."""
    listed = folder / WRITTEN
    if not listed.is_file():
        return {}
    lines = read_bytes(listed).decode(errors="replace").splitlines()
    pairs = (line.partition("  ") for line in lines)
    return {
        name: digest for digest, _, name in pairs if re.fullmatch(r"[0-9a-f]{64}", digest) and Path(name).name == name
    }
