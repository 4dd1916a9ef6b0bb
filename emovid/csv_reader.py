"""Reader of delimited text files: encoding, delimiter, rows, and the line of each row.

Rows as long as the header are located by numpy and parsed by pandas, which is fast. Ragged rows, and files whose quotes
do not pair (PsychoPy writes such files), go row by row through `_lenient_rows`.
"""

import codecs
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.errors import SourceError, reason

_DELIMITERS = (",", ";", "\t")
_SAMPLE = 100_000  # bytes from which the delimiter is inferred
_MOST_COLUMNS = 20_000
_LONGEST_CELL = 20_000  # characters
_MOST_RETRIES = 200  # rows in which the reader searches later lines for a closing quote in vain; each search is slow
_NOT_TEXT = {b"PK\x03\x04": "a spreadsheet or a zip archive", b"%PDF": "a PDF", b"\x1f\x8b": "a gzip archive"}

_Row = tuple[int, list[str]]  # line and cells


@dataclass(frozen=True)
class Rejected:
    """A row or a cell that could not be used.

    Attributes:
        file: its name.
        row: line in the file, counted from 1, header included; 0 for the whole file.
        cell: name of the column, or "" for the whole row.
        value: content of the cell.
        reason: a few words.
    """

    file: str
    row: int
    cell: str
    value: str
    reason: str


@dataclass(frozen=True, eq=False)
class Table:
    """A file as rows of text.

    Attributes:
        file: its name.
        names: the header, stripped; one name for each column, possibly repeated.
        texts: question texts, if the file has a second header row; otherwise the names.
        cells: the rows below the header as stripped text; columns 0, 1, ...
        lines: line of each row, counted from 1.
        rejected: ragged rows.
        files: names of the files that were joined; empty for a single one.
        origins: index into `files` of each row; None for a single file.
    """

    file: str
    names: tuple[str, ...]
    texts: tuple[str, ...]
    cells: pd.DataFrame
    lines: NDArray[np.int64]
    rejected: tuple[Rejected, ...] = ()
    files: tuple[str, ...] = ()
    origins: NDArray[np.int64] | None = None

    def rows(self, kept: NDArray[np.bool_]) -> "Table":
        """Return the table with the rows of a mask only."""
        origins = None if self.origins is None else self.origins[kept]
        return replace(self, cells=self.cells[kept].reset_index(drop=True), lines=self.lines[kept], origins=origins)

    def with_column(self, name: str, cells: "pd.Series[str]") -> "Table":
        """Return the table with one more column, the last."""
        frame = self.cells.assign(new=cells).set_axis(range(len(self.names) + 1), axis=1)
        return replace(self, names=(*self.names, name), texts=(*self.texts, name), cells=frame)

    def replaced(self, place: int, cells: "pd.Series[str]") -> "Table":
        """Return the table with other cells in one column."""
        return replace(self, cells=pd.DataFrame({i: cells if i == place else self.cells[i] for i in self.cells}))

    def with_texts(self, headers: int, row: int = 0) -> "Table":
        """Return the table without its first `headers` rows; row `row` of them (from 0) holds the question texts."""
        return replace(self.rows(np.arange(len(self.lines)) >= headers), texts=tuple(self.row(row)))

    def row(self, number: int) -> list[str]:
        """Return one row below the header, or [] if there is none."""
        return [str(cell) for cell in self.cells.iloc[number]] if number < len(self.cells) else []


def coded(column: "pd.Series[str]") -> tuple[NDArray[np.intp], list[str]]:
    """Return the place of each cell's text among the different texts of a column, and these texts."""
    codes, words = pd.factorize(column)
    return codes, np.asarray(words, dtype=object).tolist()


def translated(column: "pd.Series[str]", translate: Callable[[str], str]) -> "pd.Series[str]":
    """Return a column with each text translated; a text that occurs in many cells is translated once."""
    codes, words = coded(column)
    texts = pd.array([translate(word) for word in words], dtype="str")
    return pd.Series(texts.take(codes) if words else [], index=column.index, dtype="str")


def cells_that(column: "pd.Series[str]", test: Callable[[str], bool]) -> "pd.Series[bool]":
    """Return the cells (True) of a column whose text passes a test; each different text is tested once."""
    codes, words = coded(column)
    return pd.Series(np.array([test(word) for word in words], dtype=bool)[codes], index=column.index)


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises:
        SourceError: for a file that cannot be read.
    """
    try:
        return path.read_bytes()
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else str(error)
        raise SourceError(str(path), f"cannot be read: {why}") from None


def read_table(data: bytes, file: str) -> Table:
    """Return the table in a text file.

    Rows shorter or longer than the header are returned in `rejected`. Blank lines and empty cells beyond the header are
    ignored.

    Raises:
        SourceError: for an empty file, and for a file that is not text.
    """
    text = utf8(data, file)
    if not text.strip():
        raise SourceError(file, "empty; expected a header and rows")
    stated = re.match(_SEP, text)
    above = 1 if stated else 0
    text = text[stated.end() :] if stated else text
    delimiter = stated[1].decode("latin-1") if stated else _delimiter_of(text)
    if not text.strip(delimiter.encode() + b' "\t\n'):
        raise SourceError(file, "empty except for delimiters; expected a header and rows")
    rows = _rows_of(text, delimiter)
    return _lenient(text, delimiter, file, above) if rows is None else _fast(text, delimiter, file, above, rows)


def table_of(file: str, rows: Iterable[tuple[int, Sequence[str]]]) -> Table:
    """Return a table of rows (line, cells) that are already parsed; the first is the header."""
    (_, names), *rest = rows
    frame = pd.DataFrame([list(cells) for _, cells in rest], columns=range(len(names)), dtype="str")
    lines = np.array([line for line, _ in rest], dtype=np.int64)
    return _finished(file, list(names), frame, lines, [])


def joined_table(tables: Sequence[Table]) -> Table:
    """Return the rows of several tables as one; a column that a table lacks is empty in its rows.

    Tables that repeat a name must have the same header.
    """
    if len(tables) == 1:
        return tables[0]
    names = tables[0].names
    if any(table.names != names for table in tables) and all(len(set(t.names)) == len(t.names) for t in tables):
        names = tuple(dict.fromkeys(name for table in tables for name in table.names))
        frames = [table.cells.set_axis(list(table.names), axis=1).reindex(columns=list(names)) for table in tables]
    else:
        frames = [table.cells.set_axis(range(len(names)), axis=1) for table in tables]
    cells = pd.concat(frames, ignore_index=True).fillna("").astype("str").set_axis(range(len(names)), axis=1)
    return Table(
        tables[0].file,
        names,
        tables[0].texts if names == tables[0].names else names,
        cells,
        np.concatenate([table.lines for table in tables]),
        tuple(row for table in tables for row in table.rejected),
        tuple(table.file for table in tables),
        np.repeat(np.arange(len(tables)), [len(table.lines) for table in tables]),
    )


def utf8(data: bytes, file: str) -> bytes:
    r"""Return text as UTF-8 without a byte order mark; lines end in \n.

    Bytes that are not UTF-8 are decoded as Windows-1252 one by one, since concatenated files can mix both. A lone
    carriage return ends a line only if it ends the header; elsewhere it belongs to a cell and becomes a space.

    Raises:
        SourceError: for data that is not text.
    """
    for mark, name in _NOT_TEXT.items():
        if data.startswith(mark):
            raise SourceError(file, f"{name}; expected text: save or export it as CSV")
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", errors="replace").encode()
    elif data[1:40:2].count(0) > 10 or data[:40:2].count(0) > 10:  # UTF-16 without its mark
        data = data.decode("utf-16-le" if data[1:2] == b"\0" else "utf-16-be", errors="replace").encode()
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        data.decode()
    except UnicodeDecodeError:
        data = data.decode(errors="emovid-cp1252").encode()
    if b"\0" in data:
        raise SourceError(file, "not text; expected CSV")
    data = data.replace(b"\r\n", b"\n")
    header_end = _HEADER_END.match(data) if b"\r" in data else None
    return data.replace(b"\r", b" " if header_end and header_end[1] == b"\n" else b"\n")


_SEP = rb'(?i:"?sep=(.)\1*"?[ \t]*)\n'  # first line with which spreadsheets state the delimiter
_HEADER_END = re.compile(rb'\s*(?:(?i:"?sep=.[^\r\n]*)[\r\n])?\s*(?:"[^"]*"|[^"\r\n])*+([\r\n])')


def _cp1252(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    wrong = error.object[error.start : error.end]
    return "".join(_CP1252[byte] for byte in wrong), error.end


_CP1252 = [bytes([byte]).decode("cp1252", errors="ignore") or "\ufffd" for byte in range(256)]
codecs.register_error("emovid-cp1252", _cp1252)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of a text: from `starts` to before `stops`, with `widths` cells, on `lines` counted from 1."""

    starts: NDArray[np.int64]
    stops: NDArray[np.int64]
    widths: NDArray[np.int64]
    lines: NDArray[np.int64]


def _rows_of(text: bytes, delimiter: str) -> _Rows | None:
    """Return the rows, or None if a quote within a cell is unpaired or not doubled."""
    marks = np.frombuffer(text, dtype=np.uint8)
    newline, cut = marks == ord("\n"), marks == ord(delimiter)
    all_newlines = np.flatnonzero(newline)
    quote = marks == ord('"')
    if quote.any():
        inside = np.logical_xor.accumulate(quote)
        if inside[-1] or not _paired(quote, inside, newline | cut | quote):
            return None
        newline, cut = newline & ~inside, cut & ~inside
    stops = np.flatnonzero(newline)
    if not newline[-1]:
        stops = np.append(stops, len(marks))
    starts = np.concatenate([[0], stops[:-1] + 1])
    cuts = np.searchsorted(np.flatnonzero(cut), np.column_stack([starts, stops]))
    return _Rows(starts, stops, cuts[:, 1] - cuts[:, 0] + 1, np.searchsorted(all_newlines, starts) + 1)


def _paired(quote: NDArray[np.bool_], inside: NDArray[np.bool_], border: NDArray[np.bool_]) -> bool:
    """Return whether a border (delimiter, newline, quote) precedes each opening quote and follows each closing one."""
    edge = np.ones(1, dtype=bool)
    opens_within = quote & inside & ~np.concatenate([edge, border[:-1]])
    closes_within = quote & ~inside & ~np.concatenate([border[1:], edge])
    return not (opens_within.any() or closes_within.any())


def _delimiter_of(text: bytes) -> str:
    """Return the delimiter that splits most of the first rows into as many cells as the header."""
    sample = text[:_SAMPLE]
    if len(text) > _SAMPLE:
        sample = sample[: sample.rfind(b"\n") + 1] or sample
    return max(_DELIMITERS, key=lambda delimiter: _agreement(sample, delimiter))


def _agreement(sample: bytes, delimiter: str) -> tuple[float, int]:
    rows = _rows_of(sample, delimiter)
    if rows is not None:
        widths = rows.widths[rows.stops > rows.starts].tolist()
    else:
        widths = [line.count(delimiter.encode()) + 1 for line in sample.split(b"\n") if line.strip()]
    if not widths or widths[0] == 1:
        return 0.0, 0
    return widths.count(widths[0]) / len(widths), widths[0]


def _fast(text: bytes, delimiter: str, file: str, above: int, rows: _Rows) -> Table:
    filled = np.flatnonzero(rows.stops > rows.starts)
    header = next(i for i in filled if text[rows.starts[i] : rows.stops[i]].strip(delimiter.encode() + b' "\t\n'))
    width = int(rows.widths[header])
    regular = (rows.widths == width) & (rows.stops > rows.starts)
    regular[:header] = False
    frame = _parsed(text, delimiter, width, rows, regular, file)
    lines = rows.lines[regular] + above
    names = [str(cell) for cell in frame.iloc[0]]
    others = filled[(filled > header) & ~regular[filled]]
    chunks = ((int(rows.lines[i]) + above, text[rows.starts[i] : rows.stops[i]].decode()) for i in others)
    pairs = ((line, cells) for line, chunk in chunks for _, cells in _lenient_rows(chunk, delimiter, width))
    extra, rejected = _split_ragged(pairs, width, file)
    frame, lines = frame.iloc[1:], lines[1:]
    if extra:
        more = pd.DataFrame([cells for _, cells in extra], columns=range(width), dtype="str")
        lines = np.append(lines, [line for line, _ in extra])
        frame = pd.concat([frame, more])
        order = np.argsort(lines, kind="stable")
        frame, lines = frame.iloc[order], lines[order]
    return _finished(file, names, frame, lines, rejected)


def _parsed(
    text: bytes, delimiter: str, width: int, rows: _Rows, regular: NDArray[np.bool_], file: str
) -> pd.DataFrame:
    if width > _MOST_COLUMNS:
        raise SourceError(file, f"{width} columns; expected a table of at most {_MOST_COLUMNS}")
    if not regular.all():
        ends = np.append(rows.starts[1:], len(text))
        kept = np.repeat(regular, ends - rows.starts)
        text = np.frombuffer(text, dtype=np.uint8)[kept].tobytes()
    return pd.read_csv(
        BytesIO(text),
        sep=delimiter,
        names=range(width),
        header=None,
        index_col=False,
        dtype="str",
        na_filter=False,
        skip_blank_lines=False,
        encoding="utf-8",
    )


def _lenient(text: bytes, delimiter: str, file: str, above: int) -> Table:
    rows = _lenient_rows(text.decode(), delimiter)
    _, names = next(rows, (0, [""]))
    kept, rejected = _split_ragged(((line + above, cells) for line, cells in rows), len(names), file)
    frame = pd.DataFrame([cells for _, cells in kept], columns=range(len(names)), dtype="str")
    return _finished(file, names, frame, np.array([line for line, _ in kept], dtype=np.int64), rejected)


def _split_ragged(rows: Iterable[_Row], width: int, file: str) -> tuple[list[_Row], list[Rejected]]:
    """Return the rows of that width, without empty cells beyond it, and the others as rejected."""
    kept: list[_Row] = []
    rejected: list[Rejected] = []
    for line, cells in rows:
        fitting = _without_surplus(cells, width)
        if len(fitting) == width:
            kept.append((line, fitting))
        else:
            message = f"ragged row: {len(fitting)} cells where the header has {width}"
            rejected.append(Rejected(file, line, "", " ".join(" | ".join(fitting).split())[:80], message))
    return kept, rejected


def _finished(
    file: str, names: list[str], frame: pd.DataFrame, lines: NDArray[np.int64], rejected: list[Rejected]
) -> Table:
    """Return the table with stripped cells, without blank rows and without unnamed empty columns."""
    stripped = {i: translated(frame[i], str.strip) for i in frame.columns}
    filled = {i: (column != "").to_numpy(dtype=bool) for i, column in stripped.items()}
    kept = [i for i, name in enumerate(names) if name.strip() or filled[i].any()]
    cells = pd.DataFrame({place: stripped[i] for place, i in enumerate(kept)})
    titles = tuple(" ".join(names[i].split()) for i in kept)
    if not kept:
        raise SourceError(file, "empty except for delimiters; expected a header and rows")
    table = Table(file, titles, titles, cells.reset_index(drop=True), lines, tuple(rejected))
    any_filled = np.logical_or.reduce([filled[i] for i in kept])
    return table if any_filled.all() else table.rows(any_filled)


def _lenient_rows(text: str, delimiter: str, width: int = 0) -> Iterator[_Row]:
    r"""Yield the line, counted from 1, and the cells of each row that is not blank.

    A quote that is not doubled belongs to its quoted cell unless a delimiter or the end of the line follows. In a cell
    that opens a JSON list or object, it belongs to the cell until the brackets are closed. A row that spans several
    lines must have as many cells as the header; otherwise it is read as one line.

    Args:
        text: lines end in \n.
        delimiter: one character.
        width: number of cells in the header; 0 if the text starts with the header.
    """
    position, line, retries = 0, 1, _MOST_RETRIES
    while position < len(text):
        end = text.find("\n", position) + 1 or len(text)
        row = text[position:end]
        found = None
        if retries and row.count('"') % 2:  # a cell may continue on the next line
            found = _cells(text, position, delimiter)
            if found[0] <= end or width not in (0, len(_without_surplus(found[1], width))):
                found, retries = None, retries - 1
        end, cells = found or (end, _cells(row, 0, delimiter)[1])
        if any(cell.strip() for cell in cells):
            width = width or len(cells)
            yield line, cells
        line += text.count("\n", position, end)
        position = end


def _without_surplus(cells: list[str], width: int) -> list[str]:
    """Return the cells without empty ones beyond `width`."""
    while len(cells) > width and not cells[-1].strip():
        cells = cells[:-1]
    return cells


def _cells(text: str, position: int, delimiter: str) -> tuple[int, list[str]]:
    """Return the index after the row that starts at `position`, and its cells."""
    cells: list[str] = []
    while True:
        cell, position = _cell(text, position, delimiter)
        cells.append(cell)
        if position >= len(text) or text[position] == "\n":
            return min(position + 1, len(text)), cells
        position += 1


def _cell(text: str, position: int, delimiter: str) -> tuple[str, int]:
    """Return the cell that starts at `position`, and the index after it."""
    quoted, bare = _patterns(delimiter)
    found = quoted.match(text, position)
    end = _closed(text, position, delimiter) if text.startswith(('"[', '"{'), position) else 0
    if end and not (found and found.end() == end):
        return text[position + 1 : end - 1], end
    if found:
        return found[1].replace('""', '"'), found.end()
    rest = bare.match(text, position)
    assert rest is not None  # the pattern also matches nothing
    return rest[0], rest.end()


def _closed(text: str, start: int, delimiter: str) -> int:
    """Return the index after the quote that follows the closing bracket of a JSON cell; 0 if there is none."""
    depth = 0
    for found in re.compile(r"[\[{\]}]").finditer(text, start, start + _LONGEST_CELL):
        depth += 1 if found[0] in "[{" else -1
        if depth == 0:
            after = found.end() + 1
            closed = text[found.end() : after] == '"' and text[after : after + 1] in ("", "\n", delimiter)
            return after if closed else 0
    return 0


@cache
def _patterns(delimiter: str) -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Return the patterns of a quoted cell and of an unquoted one."""
    mark = re.escape(delimiter)
    end = rf"(?=[{mark}\n]|\Z)"
    quoted = rf' *"((?:[^"]|""|"(?![{mark}\n]|\Z)){{0,{_LONGEST_CELL}}}+)"{end}'
    return re.compile(quoted), re.compile(rf"[^{mark}\n]*")
