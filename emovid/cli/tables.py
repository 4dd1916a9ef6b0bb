"""Tables that lose nothing: as wide as they are for a file or a program, in parts that fit on a terminal."""

from math import ceil
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console
    from rich.table import Column, Table

_FULL = 100_000  # columns of text, for a table that nobody looks at on a terminal


def show_table(table: "Table", heads: int = 1) -> None:
    """Print a table to stdout; on a terminal too narrow for it, its columns in parts under each other.

    Args:
        table: where not even one column fits, its cells are folded.
        heads: how many first columns stand in each part.
    """
    from rich.console import Console

    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=_FULL)
    for column in table.columns:
        column.overflow = "fold"
    for part in _parts(table, heads, console):
        console.print(part)


def _parts(table: "Table", heads: int, console: "Console") -> "list[Table]":
    """Return the fewest parts, of about as many columns each, in which a table fits the console; else a column each."""
    first, others = table.columns[:heads], table.columns[heads:]
    parts = [table]
    for count in range(2, len(others) + 1):
        if all(_width(part, console) <= console.width for part in parts):
            break
        each = ceil(len(others) / count)
        parts = [_part(table, [*first, *others[k : k + each]]) for k in range(0, len(others), each)]
    return parts


def _width(table: "Table", console: "Console") -> int:
    from rich.measure import Measurement

    return Measurement.get(console, console.options.update(max_width=_FULL), table).maximum


def _part(table: "Table", columns: "Sequence[Column]") -> "Table":
    from rich.table import Table

    part = Table(*(column.copy() for column in columns), title=table.title, box=table.box, padding=table.padding)
    for row, cells in zip(table.rows, zip(*(column.cells for column in columns), strict=True), strict=True):
        part.add_row(*cells, end_section=row.end_section)
    return part
