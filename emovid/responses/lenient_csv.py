"""The careful reader of delimited text: rows whose quotes do not pair, as PsychoPy writes them, or that are ragged."""

import re
from collections.abc import Iterator
from functools import cache

_LONGEST = 20_000  # characters of a cell
_PATIENCE = 200  # rows that may look for their closing quote beyond their line in vain, since each of them costs time


def read_rows(text: str, delimiter: str, width: int = 0) -> Iterator[tuple[int, list[str]]]:
    """Yield the line, counted from 1, and the cells of each row that is not blank.

    A quote within quotes that is not doubled belongs to the cell, unless a delimiter or the line's end follows; in a
    cell that opens a list or an object, unless its brackets are closed. A row of several lines has as many cells as the
    header; where it would not, it is one line.

    Args:
        text: with newlines alone at the ends of lines.
        delimiter: one character.
        width: of the header; 0 where the text starts with it.
    """
    position, line, patience = 0, 1, _PATIENCE
    while position < len(text):
        end = text.find("\n", position) + 1 or len(text)
        row = text[position:end]
        found = None
        if patience and row.count('"') % 2:  # a cell may go on below
            found = _cells(text, position, delimiter)
            if found[0] <= end or width not in (0, len(without_surplus(found[1], width))):
                found, patience = None, patience - 1
        end, cells = found or (end, _cells(row, 0, delimiter)[1])
        if any(cell.strip() for cell in cells):
            width = width or len(cells)
            yield line, cells
        line += text.count("\n", position, end)
        position = end


def without_surplus(cells: list[str], width: int) -> list[str]:
    """Return the cells without empty ones beyond `width`."""
    while len(cells) > width and not cells[-1].strip():
        cells = cells[:-1]
    return cells


def _cells(text: str, position: int, delimiter: str) -> tuple[int, list[str]]:
    """Return the place after the row that starts at `position`, and its cells."""
    cells: list[str] = []
    while True:
        cell, position = _cell(text, position, delimiter)
        cells.append(cell)
        if position >= len(text) or text[position] == "\n":
            return min(position + 1, len(text)), cells
        position += 1


def _cell(text: str, position: int, delimiter: str) -> tuple[str, int]:
    """Return the cell that starts at `position`, and the place after it."""
    quoted, bare = _patterns(delimiter)
    found = quoted.match(text, position)
    end = _closed(text, position, delimiter) if text.startswith(('"[', '"{'), position) else 0
    if end and not (found and found.end() == end):
        return text[position + 1 : end - 1], end
    if found:
        return found[1].replace('""', '"'), found.end()
    rest = bare.match(text, position)
    assert rest is not None  # it matches nothing, too
    return rest[0], rest.end()


def _closed(text: str, start: int, delimiter: str) -> int:
    """Return the place after the quote that follows the bracket which closes a cell's first one; 0 if there is none."""
    depth = 0
    for found in re.compile(r"[\[{\]}]").finditer(text, start, start + _LONGEST):
        depth += 1 if found[0] in "[{" else -1
        if depth == 0:
            after = found.end() + 1
            closed = text[found.end() : after] == '"' and text[after : after + 1] in ("", "\n", delimiter)
            return after if closed else 0
    return 0


@cache
def _patterns(delimiter: str) -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Return the patterns of a cell in quotes and of one without."""
    mark = re.escape(delimiter)
    end = rf"(?=[{mark}\n]|\Z)"
    quoted = rf' *"((?:[^"]|""|"(?![{mark}\n]|\Z)){{0,{_LONGEST}}}+)"{end}'
    return re.compile(quoted), re.compile(rf"[^{mark}\n]*")
