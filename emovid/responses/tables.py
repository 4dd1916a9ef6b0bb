"""From the bytes of a delimited text file to rows of text that know their lines.

Rows as long as the header are cut out by numpy and read by pandas. Others, and files whose quotes do not pair, go
through the careful reader of `emovid.responses.lenient_csv`, row by row.
"""

import codecs
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.errors import SourceError
from emovid.responses.lenient_csv import read_rows, without_surplus
from emovid.responses.responses import Rejected
from emovid.responses.rows import Rows, rows_of, sniff

_MOST_COLUMNS = 20_000
_NO_TEXT = {b"PK\x03\x04": "a spreadsheet or a zip archive", b"%PDF": "a PDF", b"\x1f\x8b": "a gzip archive"}


@dataclass(frozen=True, eq=False)
class Table:
    """A file as rows of text.

    Attributes:
        file: its name.
        names: the first row, stripped; one for each column, not always different.
        texts: what stands under the names if the file has more header rows (question texts), else the names.
        cells: the rows under the header, stripped text; columns 0, 1, ...
        lines: the line of each row, counted from 1.
        rejected: ragged rows.
    """

    file: str
    names: tuple[str, ...]
    texts: tuple[str, ...]
    cells: pd.DataFrame
    lines: NDArray[np.int64]
    rejected: tuple[Rejected, ...] = ()

    def rows(self, kept: NDArray[np.bool_]) -> "Table":
        """Return the table with those rows only."""
        return replace(self, cells=self.cells[kept].reset_index(drop=True), lines=self.lines[kept])

    def with_texts(self, headers: int, row: int = 0) -> "Table":
        """Return the table without its first `headers` rows, of which `row` (from 0) holds the question texts."""
        return replace(self.rows(np.arange(len(self.lines)) >= headers), texts=tuple(self.row(row)))

    def row(self, number: int) -> list[str]:
        """Return one row under the header, or [] if there is none."""
        return [str(cell) for cell in self.cells.iloc[number]] if number < len(self.cells) else []


def read_table(data: bytes, file: str) -> Table:
    """Return the table in a text file.

    Rows that are shorter or longer than the header are in `rejected`; blank lines, and cells beyond the header that
    are empty, mean nothing.

    Raises:
        SourceError: for an empty file, and for one that is no text.
    """
    text = utf8(data, file)
    if not text.strip():
        raise SourceError(file, "empty; expected a header and rows")
    stated = re.match(rb'(?i)"?sep=(.)\1*"?[ \t]*\n', text)
    above = 1 if stated else 0
    text = text[stated.end() :] if stated else text
    delimiter = stated[1].decode("latin-1") if stated else sniff(text)
    if not text.strip(delimiter.encode() + b' "\t\n'):
        raise SourceError(file, "empty but for delimiters; expected a header and rows")
    rows = rows_of(text, delimiter)
    return _careful(text, delimiter, file, above) if rows is None else _fast(text, delimiter, file, above, rows)


def table_of(file: str, rows: Iterable[tuple[int, Sequence[str]]]) -> Table:
    """Return the table of rows (line, cells) that are there already; the first is the header."""
    (_, names), *rest = rows
    frame = pd.DataFrame([list(cells) for _, cells in rest], columns=range(len(names)), dtype="str")
    lines = np.array([line for line, _ in rest], dtype=np.int64)
    return _finished(file, list(names), frame, lines, [])


def utf8(data: bytes, file: str) -> bytes:
    r"""Return text as UTF-8 without a byte order mark, with \n at the ends of lines.

    Bytes that are no UTF-8 are taken as Windows-1252, wherever they stand: files pasted together are of both.

    Raises:
        SourceError: if it is no text.
    """
    for mark, name in _NO_TEXT.items():
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
        raise SourceError(file, "no text; expected CSV")
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _cp1252(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    wrong = error.object[error.start : error.end]
    return "".join(_BYTES[byte] for byte in wrong), error.end


_BYTES = [bytes([byte]).decode("cp1252", errors="ignore") or "\ufffd" for byte in range(256)]
codecs.register_error("emovid-cp1252", _cp1252)


def _fast(text: bytes, delimiter: str, file: str, above: int, rows: Rows) -> Table:
    filled = np.flatnonzero(rows.stops > rows.starts)
    header = next(i for i in filled if text[rows.starts[i] : rows.stops[i]].strip(delimiter.encode() + b' "\t\n'))
    width = int(rows.widths[header])
    regular = (rows.widths == width) & (rows.stops > rows.starts)
    regular[:header] = False
    frame = _parsed(text, delimiter, width, rows, regular, file)
    lines = rows.lines[regular] + above
    names = [str(cell) for cell in frame.iloc[0]]
    others = [i for i in filled if i > header and not regular[i]]
    chunks = ((int(rows.lines[i]) + above, text[rows.starts[i] : rows.stops[i]].decode()) for i in others)
    pairs = ((line, cells) for line, chunk in chunks for _, cells in read_rows(chunk, delimiter, width))
    extra, rejected = _sorted_out(pairs, width, file)
    frame, lines = frame.iloc[1:], lines[1:]
    if extra:
        more = pd.DataFrame([cells for _, cells in extra], columns=range(width), dtype="str")
        lines = np.append(lines, [line for line, _ in extra])
        frame = pd.concat([frame, more])
        order = np.argsort(lines, kind="stable")
        frame, lines = frame.iloc[order], lines[order]
    return _finished(file, names, frame, lines, rejected)


def _parsed(text: bytes, delimiter: str, width: int, rows: Rows, regular: NDArray[np.bool_], file: str) -> pd.DataFrame:
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


def _careful(text: bytes, delimiter: str, file: str, above: int) -> Table:
    rows = read_rows(text.decode(), delimiter)
    _, names = next(rows, (0, [""]))
    kept, rejected = _sorted_out(((line + above, cells) for line, cells in rows), len(names), file)
    frame = pd.DataFrame([cells for _, cells in kept], columns=range(len(names)), dtype="str")
    return _finished(file, names, frame, np.array([line for line, _ in kept], dtype=np.int64), rejected)


def _sorted_out(
    rows: Iterable[tuple[int, list[str]]], width: int, file: str
) -> tuple[list[tuple[int, list[str]]], list[Rejected]]:
    """Return the rows of that width, empty cells beyond it left out, and the others as rejected."""
    kept: list[tuple[int, list[str]]] = []
    rejected: list[Rejected] = []
    for line, cells in rows:
        fitting = without_surplus(cells, width)
        if len(fitting) == width:
            kept.append((line, fitting))
        else:
            reason = f"ragged row: {len(fitting)} cells where the header has {width}"
            rejected.append(Rejected(file, line, "", " ".join(" | ".join(fitting).split())[:80], reason))
    return kept, rejected


def _finished(
    file: str, names: list[str], frame: pd.DataFrame, lines: NDArray[np.int64], rejected: list[Rejected]
) -> Table:
    """Return the table without blank rows and without unnamed empty columns, its cells stripped."""
    stripped = {i: _stripped(frame[i]) for i in frame.columns}
    filled = {i: (column != "").to_numpy(dtype=bool) for i, column in stripped.items()}
    kept = [i for i, name in enumerate(names) if name.strip() or filled[i].any()]
    cells = pd.DataFrame({place: stripped[i] for place, i in enumerate(kept)})
    titles = tuple(" ".join(names[i].split()) for i in kept)
    if not kept:
        raise SourceError(file, "empty but for delimiters; expected a header and rows")
    table = Table(file, titles, titles, cells.reset_index(drop=True), lines, tuple(rejected))
    any_filled = np.logical_or.reduce([filled[i] for i in kept])
    return table if any_filled.all() else table.rows(any_filled)


def _stripped(column: "pd.Series[str]") -> "pd.Series[str]":
    codes, words = pd.factorize(column)
    cleaned = np.array([str(word).strip() for word in words], dtype=object)
    return pd.Series(cleaned[codes] if len(cleaned) else [], index=column.index, dtype="str")
