"""Which files an analysis wrote: they are no exports, even if they lie among some."""

import csv
import json
from pathlib import Path

TIDY = ("participant", "video", "signalled", "perceived", "position")  # the first columns of responses_tidy.csv
_TABLES = ("results.json", "confusion_matrix.csv", "tests.csv", "rejected.csv", "responses_tidy.csv")
_PRINTED = (".html", ".pdf", ".png", ".md", ".tex")


def is_results(file: Path) -> bool:
    """Return whether a file is the results.json of an analysis. Raises OSError if it cannot be read."""
    try:
        found = json.loads(file.read_bytes())
    except (ValueError, RecursionError):
        return False
    return isinstance(found, dict) and {"counts", "labels", "emotions", "recognition"} <= set(found)


def is_of_analysis(file: Path, among_results: bool) -> bool:
    """Return whether an analysis wrote a file: by its name `among_results`, elsewhere if it is a table of tidy answers.

    Raises:
        OSError: if it cannot be read.
    """
    if among_results and (file.name in _TABLES or file.suffix in _PRINTED):
        return True
    return file.suffix.lower() == ".csv" and _is_tidy(file)


def _is_tidy(file: Path) -> bool:
    with file.open(encoding="utf-8-sig", errors="replace", newline="") as text:
        first = next(csv.reader([text.readline(10_000)]), [])
    return tuple(first[: len(TIDY)]) == TIDY and first[-1] == "correct"
