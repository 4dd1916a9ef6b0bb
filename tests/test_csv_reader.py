import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.csv_reader import read_table
from emovid.errors import SourceError

ROWS = [["näme", "b"], ["Zoë", "x, y"], ["2", 'say "hi"']]


def cells(data: bytes) -> list[list[str]]:
    table = read_table(data, "f.csv")
    return [list(table.names), *table.cells.to_numpy().tolist()]


def written(rows, **how) -> str:
    out = io.StringIO(newline="")
    csv.writer(out, **how).writerows(rows)
    return out.getvalue()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("eol", ["\n", "\r\n", "\r"])
def test_every_encoding_delimiter_and_line_end_is_read(encoding, delimiter, eol) -> None:
    rows = [*ROWS, *[["filler", "text"]] * 20]
    assert cells(written(rows, delimiter=delimiter, lineterminator=eol).encode(encoding)) == rows


def test_rows_in_two_encodings_are_read() -> None:
    assert cells("a,b\nZoë,1\n".encode() + "Zoë,2\n".encode("cp1252")) == [["a", "b"], ["Zoë", "1"], ["Zoë", "2"]]


def test_sep_line_overrides_the_detected_delimiter() -> None:
    table = read_table(b"sep=;\r\na,x;b\r\n1,2;3\r\n", "f.csv")
    assert table.names == ("a,x", "b")
    assert table.lines.tolist() == [3]


@pytest.mark.parametrize("first", ["SEP=;", '"sep=;"', "sep=;;;", "\ufeffsep=; "])
def test_sep_line_is_recognized_in_all_spreadsheet_variants(first) -> None:
    table = read_table(f"{first}\n1,5;b\n1,2;3\n".encode(), "f.csv")
    assert (table.names, table.lines.tolist()) == (("1,5", "b"), [3])


def test_line_numbers_refer_to_the_file() -> None:
    table = read_table(b'\na,b\n\n"1\n1",2\n3,4\n,\n5,6\n', "f.csv")
    assert table.cells.to_numpy().tolist() == [["1\n1", "2"], ["3", "4"], ["5", "6"]]
    assert table.lines.tolist() == [4, 6, 8]


def test_trailing_delimiters_are_ignored() -> None:
    assert cells(b"a,b,\n1,2,\n3,4,\n") == [["a", "b"], ["1", "2"], ["3", "4"]]
    assert cells(b"a,b\n1,2,,\n3,4\n") == [["a", "b"], ["1", "2"], ["3", "4"]]


def test_ragged_rows_are_rejected_with_their_line() -> None:
    table = read_table(b"a,b,c\n1,2,3\n4,5\n6,7,8,9\n,,\n1,2,4\n", "f.csv")
    assert table.cells.to_numpy().tolist() == [["1", "2", "3"], ["1", "2", "4"]]
    assert [(row.row, row.value, row.reason) for row in table.rejected] == [
        (3, "4 | 5", "ragged row: 2 cells where the header has 3"),
        (4, "6 | 7 | 8 | 9", "ragged row: 4 cells where the header has 3"),
    ]


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        (b'"["x","y"]",2', ['["x","y"]', "2"]),
        (b'"{"a":"b","c":[1,2]}",2', ['{"a":"b","c":[1,2]}', "2"]),
        (b'"[""x"",""y""]",2', ['["x","y"]', "2"]),
        (b'"he said "no" to it, twice",2', ['he said "no" to it, twice', "2"]),
        (b'5" disk,2', ['5" disk', "2"]),
        (b'"",""', None),
        (b'"a""b",""', ['a"b', ""]),
        (b'say "hi","2"', ['say "hi"', "2"]),
    ],
)
def test_quoting_styles_of_tools_are_read(row, expected) -> None:
    found = cells(b'a,b\n"1",5" disk\n' + row + b"\n9,9\n")
    assert found == [["a", "b"], ["1", '5" disk'], *([expected] if expected else []), ["9", "9"]]


def test_unclosed_quote_affects_only_its_row() -> None:
    table = read_table(b'a,b\n1,2\n"3,4\n5,6\n', "f.csv")
    assert table.cells.to_numpy().tolist() == [["1", "2"], ['"3', "4"], ["5", "6"]]
    assert table.lines.tolist() == [2, 3, 4]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "f.csv: empty; expected a header and rows"),
        (b"\xef\xbb\xbf \n\n", "f.csv: empty; expected a header and rows"),
        (b"sep=;\n", "f.csv: empty except for delimiters; expected a header and rows"),
        (b',,\n"",\n', "f.csv: empty except for delimiters; expected a header and rows"),
        (b"PK\x03\x04rest", "f.csv: a spreadsheet or a zip archive; expected text: save or export it as CSV"),
        (b"a,b\n\0\1\2,3\n", "f.csv: not text; expected CSV"),
    ],
)
def test_files_that_are_not_tables_are_refused(data, message) -> None:
    with pytest.raises(SourceError) as error:
        read_table(data, "f.csv")
    assert str(error.value) == message


def test_multiline_cell_is_read_next_to_unpaired_quotes() -> None:
    table = read_table(b'a,b\n5" disk,x\n7,"1\n1"\n3,4\n', "f.csv")
    assert table.cells.to_numpy().tolist() == [['5" disk', "x"], ["7", "1\n1"], ["3", "4"]]
    assert table.lines.tolist() == [2, 3, 5]


def test_too_many_columns_are_refused() -> None:
    with pytest.raises(SourceError, match=r"f.csv: 20001 columns; expected a table of at most 20000"):
        read_table(b"a" + b",a" * 20_000 + b"\n", "f.csv")


def test_stray_quote_in_the_first_row_is_text() -> None:
    assert cells(b'"a,b\n1,2\n3,4\n') == [['"a', "b"], ["1", "2"], ["3", "4"]]


def test_a_header_alone_is_a_table_without_rows() -> None:
    table = read_table(b"a,b\n", "f.csv")
    assert (table.names, len(table.cells), table.lines.tolist()) == (("a", "b"), 0, [])


words = st.text(st.characters(codec="utf-8", exclude_characters="\r\0", exclude_categories=("Cc",)), max_size=6)


@given(st.lists(st.tuples(words, words, words), min_size=1, max_size=8))
def test_output_of_the_csv_module_is_read_unchanged(rows) -> None:
    expected = [[cell.strip() for cell in row] for row in rows if any(cell.strip() for cell in row)]
    for quoting in (csv.QUOTE_MINIMAL, csv.QUOTE_ALL):
        data = written([["one", "two", "three"], *rows], quoting=quoting).encode()
        assert read_table(data, "f.csv").cells.to_numpy().tolist() == expected


@pytest.mark.parametrize("stray", ["", '"x"y,1,2\n'])
def test_a_hundred_thousand_rows_are_read(stray) -> None:
    data = ("a,b,c\n" + "one,two,three\n" * 100_000 + stray).encode()
    assert len(read_table(data, "f.csv").lines) == 100_000 + bool(stray)


def test_stray_quotes_in_every_row_are_read_in_linear_time() -> None:
    table = read_table(b"a,b\n" + b'"x,"y\n' * 30_000, "f.csv")  # hours, if each looked for its end
    assert table.cells.to_numpy().tolist() == 30_000 * [['"x', '"y']]


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_carriage_return_within_a_cell_does_not_end_the_row(end) -> None:
    rows = ["a,b", '1,"two\rlines"', "2,bare\rreturn", "3,4", ""]
    assert cells(end.join(rows).encode()) == [["a", "b"], ["1", "two lines"], ["2", "bare return"], ["3", "4"]]


def test_carriage_returns_alone_end_rows() -> None:
    assert cells(b'a,"b\nc"\r1,2\r3,4\r') == [["a", "b c"], ["1", "2"], ["3", "4"]]
