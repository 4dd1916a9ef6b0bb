import sys
from pathlib import Path

import pandas as pd
import pytest

from emovid.errors import SourceError
from emovid.responses.export_files import open_table, short_names
from emovid.responses.read import read_responses
from tests.helpers.exports import COUNTS, KEY, generic_wide, workbook

NUMBERS = pd.DataFrame({"id": [1, 2], "age": [20.0, 30.5], "note": ["x, y", None]})


def book(path: Path, **sheets: pd.DataFrame) -> Path:
    with pd.ExcelWriter(path) as writer:
        for name, frame in sheets.items():
            frame.to_excel(writer, sheet_name=name, index=False)
    return path


@pytest.mark.parametrize("ending", ["xlsx", "ods"])
def test_workbook_is_read_from_the_first_or_the_named_sheet(tmp_path, ending) -> None:
    path = book(tmp_path / f"a.{ending}", Data=NUMBERS, Other=pd.DataFrame({"b": ["c"]}))
    table, digest = open_table(path)
    assert table.names == ("id", "age", "note")
    assert table.cells.to_numpy().tolist() == [["1", "20", "x, y"], ["2", "30.5", ""]]
    assert table.lines.tolist() == [2, 3]
    assert len(digest) == 64
    other, _ = open_table(Path(f"{path}#Other"))
    assert (other.file, other.cells.to_numpy().tolist()) == (f"{path}#Other", [["c"]])
    with pytest.raises(SourceError, match=r"no sheet Othr \(did you mean Other\?\); expected one of Data, Other"):
        open_table(Path(f"{path}#Othr"))


def test_workbook_gives_the_same_matrix_as_its_csv(tmp_path) -> None:
    (tmp_path / "key.csv").write_text(KEY)
    (tmp_path / "a.xlsx").write_bytes(workbook().files["answers.xlsx"])
    (tmp_path / "b.csv").write_bytes(generic_wide().files["wide.csv"])
    for name in ("a.xlsx", "a.xlsx#Sheet1", "b.csv"):
        assert read_responses(tmp_path / name, tmp_path / "key.csv").counts().tolist() == COUNTS


@pytest.mark.parametrize(
    ("data", "message"),
    [(b"", "not a workbook"), (b"PK\x03\x04", "not a workbook"), (b"a,b\n1,2\n", "not a workbook")],
)
def test_file_with_a_workbook_suffix_but_other_content_is_refused(tmp_path, data, message) -> None:
    (tmp_path / "a.xlsx").write_bytes(data)
    with pytest.raises(SourceError, match=message):
        open_table(tmp_path / "a.xlsx")


def test_an_empty_sheet_is_refused(tmp_path) -> None:
    with pytest.raises(SourceError, match="an empty sheet; expected a header and rows"):
        open_table(book(tmp_path / "a.xlsx", Data=pd.DataFrame()))


def test_missing_workbook_reader_is_named(tmp_path, monkeypatch) -> None:
    path = book(tmp_path / "a.xlsx", Data=NUMBERS)
    monkeypatch.setitem(sys.modules, "python_calamine", None)
    with pytest.raises(SourceError, match=r'expected CSV, or python-calamine.*: pip install "emovid\[workbooks\]"'):
        open_table(path)


def test_path_line_above_an_e_dataaid_header_is_skipped(tmp_path) -> None:
    (tmp_path / "a.txt").write_bytes("C:\\Data\\merged.emrg3\r\nSubject\tVideo\r\n1\tx\r\n".encode("utf-16"))
    table, _ = open_table(tmp_path / "a.txt")
    assert (table.names, table.lines.tolist()) == (("Subject", "Video"), [3])


def test_short_file_names_include_distinguishing_folders() -> None:
    assert short_names(["/a/01/s.csv", "/a/02/s.csv"]) == {"/a/01/s.csv": "01/s", "/a/02/s.csv": "02/s"}
    assert short_names(["/a/x.csv", "/a/y.csv"]) == {"/a/x.csv": "x", "/a/y.csv": "y"}
    assert short_names(["/a/x.csv", "/a/x.tsv"]) == {"/a/x.csv": "x.csv", "/a/x.tsv": "x.tsv"}
