"""Opening exports: text, JSON and workbooks become tables; folders become the files in them."""

import hashlib
import io
import math
import os
import re
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from emovid.csv_reader import Table, read_bytes, read_table, table_of, utf8
from emovid.errors import SourceError, nearest, reason
from emovid.responses.dialects.jspsych import json_table
from emovid.responses.dialects.pcibex import is_pcibex, pcibex_table
from emovid.responses.results_files import is_of_analysis, is_results

WORKBOOKS = (".xlsx", ".xlsm", ".xls", ".ods")
_START = 20_000  # bytes that identify the format
_EPRIME_PATH = re.compile(rb"[^\t\n]*\.(emrg|edat|mrg)\d?\"?\s*\n", re.IGNORECASE)


def open_table(path: Path) -> tuple[Table, str]:
    """Return the table of a file, and the SHA-256 of its bytes.

    Args:
        path: CSV or other delimited text, JSON of jsPsych, or a workbook; `FILE.xlsx#Sheet` names its sheet.

    Raises:
        SourceError: for any other file, and for one without rows.
    """
    file, sheet = split_sheet(path)
    data = read_bytes(file)
    table = _workbook(data, path, sheet) if file.suffix.lower() in WORKBOOKS else _text(data, str(path))
    if not len(table.lines):
        found = table.rejected[0].reason if table.rejected else "a header alone"
        raise SourceError(str(path), f"{found}; expected a row for each participant or answer", 1)
    return table, hashlib.sha256(data).hexdigest()


def split_sheet(path: Path) -> tuple[Path, str]:
    """Return the file and the sheet of `FILE.xlsx#Sheet`; the sheet is "" if none is named."""
    name, _, sheet = path.name.partition("#")
    return (path.with_name(name), sheet) if Path(name).suffix.lower() in WORKBOOKS else (path, "")


def _text(data: bytes, file: str) -> Table:
    start = utf8(data[:_START], file)
    if start.lstrip()[:1] in (b"[", b"{"):
        return json_table(data, file)
    if is_pcibex(start):
        return pcibex_table(utf8(data, file).decode(), file)
    if start.startswith(b"*** Header Start ***"):
        raise SourceError(file, "the log of one run of E-Prime; expected the text that E-DataAid or E-Merge exports")
    above = _EPRIME_PATH.match(start)  # E-DataAid writes the path of the data file above the header
    return read_table(b"\n" + utf8(data, file)[above.end() :] if above else data, file)


def _workbook(data: bytes, path: Path, sheet: str) -> Table:
    try:
        book = pd.ExcelFile(io.BytesIO(data), engine="calamine")
    except ImportError:
        message = 'a workbook; expected CSV, or python-calamine to read it: pip install "emovid[workbooks]"'
        raise SourceError(str(path), message) from None
    except Exception as error:
        raise SourceError(str(path), f"not a workbook: {str(error).splitlines()[0]}") from None
    with book:
        names = [str(name) for name in book.sheet_names]
        if sheet and sheet not in names:
            hint = nearest(sheet, names)
            raise SourceError(str(path), f"no sheet {sheet}{hint}; expected one of {', '.join(names)}")
        frame = pd.read_excel(book, sheet_name=sheet or names[0], header=None, dtype=object)
        if not sheet:
            _check_only_sheet(book, frame, names, path)
    rows = [(line, [_cell(value) for value in row]) for line, row in enumerate(frame.itertuples(index=False), start=1)]
    filled = [row for row in rows if any(row[1])]
    if not filled:
        raise SourceError(str(path), "an empty sheet; expected a header and rows")
    return table_of(str(path), filled)


def _check_only_sheet(book: pd.ExcelFile, first: pd.DataFrame, names: list[str], path: Path) -> None:
    """Raise SourceError if another sheet has the header of the first one."""
    for name in names[1:]:
        header = pd.read_excel(book, sheet_name=name, header=None, dtype=object, nrows=1)
        if len(first) and len(header) and [*map(_cell, header.iloc[0])] == [*map(_cell, first.iloc[0])]:
            message = (
                f"sheets {names[0]} and {name} have the same columns; expected {path.name}#{name}: one sheet for each "
                "file that is named, or all rows in one sheet"
            )
            raise SourceError(str(path), message)


def _cell(value: object) -> str:
    """Return a cell of a workbook as text: whole numbers without decimals, nothing for an empty cell."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def files_in(folder: Path) -> list[Path]:
    """Return the files of a folder and its subfolders by name, without hidden files and those of an analysis."""
    try:
        files = sorted(file for file in folder.rglob("*") if file.is_file() and not file.name.startswith("."))
        analysed = {file.parent for file in files if file.name == "results.json" and is_results(file)}
        return [file for file in files if not is_of_analysis(file, file.parent in analysed)]
    except OSError as error:
        raise SourceError(str(folder), f"cannot be read: {reason(error)}") from None


def short_names(files: Iterable[str]) -> dict[str, str]:
    """Return a name for each file: its path below the folder that all share, without the ending if that is enough."""
    paths = {file: Path(file).absolute() for file in files}
    if not paths:
        return {}
    root = os.path.commonpath([path.parent for path in paths.values()])
    names = {file: path.relative_to(root) for file, path in paths.items()}
    bare = {file: name.with_suffix("").as_posix() for file, name in names.items()}
    counts = list(bare.values())
    return {file: bare[file] if counts.count(bare[file]) == 1 else names[file].as_posix() for file in names}
