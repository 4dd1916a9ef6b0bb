"""Cells of written CSV files: formulas are escaped, so that spreadsheets show them as text."""

import csv
import io
from collections.abc import Iterable, Sequence

# A cell that starts with one of these is a formula to spreadsheets (OWASP, "CSV Injection").
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def csv_text(head: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a table as CSV text, every cell safe."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(safe, head))
    writer.writerows([safe(cell) for cell in row] for row in rows)
    return text.getvalue()


def csv_of_columns(head: Sequence[str], columns: Iterable[Iterable[object]]) -> str:
    """Return columns of few different cells as CSV text, each different cell made safe once."""
    return csv_text(head, zip(*map(_safe_column, columns), strict=True))


def _safe_column(cells: Iterable[object]) -> list[str]:
    texts = list(map(str, cells))
    known = {text: safe(text) for text in set(texts)}
    return [known[text] for text in texts]


def safe(cell: object) -> str:
    """Return a cell's text, with an apostrophe before formulas."""
    text = str(cell)
    return f"'{text}" if text.startswith(_FORMULA) and not _is_number(text) else text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text
