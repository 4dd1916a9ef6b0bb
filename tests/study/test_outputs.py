import csv
import io
import json

import numpy as np
import pandas as pd
import pytest
from known import TABLE_III
from test_analyze import responses

from emovid.study.analyze import analyze, analyze_counts
from emovid.study.cells import safe
from emovid.study.errors import StudyError
from emovid.study.matrix import matrix_csv, matrix_latex, matrix_markdown, read_matrix
from emovid.study.outputs import result_files
from emovid.study.report import report_html
from emovid.study.responses import EMOTIONS, Rejected, Responses


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_a_matrix_comes_back_from_its_file(tmp_path) -> None:
    (tmp_path / "m.csv").write_text(matrix_csv(TABLE_III, EMOTIONS, EMOTIONS))
    counts, labels, signalled = read_matrix(tmp_path / "m.csv")
    assert np.array_equal(counts, TABLE_III)
    assert labels == signalled == EMOTIONS


def test_labels_that_a_spreadsheet_would_run_are_text_in_a_matrix_too() -> None:
    assert matrix_csv(np.eye(2, dtype=int), ("=a", "b"), ("=a", "b")).splitlines()[1].startswith("'=a,")


def test_a_matrix_may_have_an_extra_row(tmp_path) -> None:
    counts = np.vstack([TABLE_III, np.arange(6)])
    (tmp_path / "m.csv").write_text(matrix_csv(counts, (*EMOTIONS, "none"), EMOTIONS))
    assert np.array_equal(read_matrix(tmp_path / "m.csv")[0], counts)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "m.csv:1: not a confusion matrix: expected the heading perceived,happiness,... and a row a label"),
        ("perceived,fear,anger\nfear,1,2\nangr,3,4\n", "m.csv:1: anger: no row has this label (did you mean angr?)"),
        ("perceived,fear,anger\nfear,1,x\nanger,3,4\n", "m.csv:2: 'x': expected a count, a whole number"),
        ("perceived,fear,anger\nfear,1\nanger,3,4\n", "m.csv: a row has fewer cells than the heading"),
        ("perceived,fear,anger\nfear,-1,2\nanger,3,4\n", "m.csv:2: '-1': expected a count, a whole number"),
    ],
)
def test_a_file_that_is_no_matrix_is_one_line(tmp_path, monkeypatch, text, message) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(StudyError) as failure:
        read_matrix((tmp_path / "m.csv").relative_to(tmp_path))
    assert str(failure.value) == message


def test_table_iii_in_markdown_and_latex() -> None:
    assert "| Happiness | **64.44** (29) | 17.78 (8) |" in matrix_markdown(TABLE_III, EMOTIONS, EMOTIONS)
    latex = matrix_latex(TABLE_III, EMOTIONS, EMOTIONS)
    assert r"Happiness & \textbf{64.44} (29) & 17.78 (8)" in latex
    assert latex.count(r"\\") == 8  # two headings and six rows


@pytest.mark.parametrize("cell", ["=1+1", "+cmd", "-x", "@sum", "\tx", "\rx"])
def test_what_a_spreadsheet_would_run_is_text(cell) -> None:
    assert safe(cell) == "'" + cell


@pytest.mark.parametrize("cell", ["-1.5", "+3", "fear", "", "a=b"])
def test_numbers_and_words_stay_as_they_are(cell) -> None:
    assert safe(cell) == cell


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    study = responses(TABLE_III)
    groups = study.participants.assign(note=["=cmd()"] + ["x"] * 44)
    reject = Rejected("a.csv", 7, "video 3", "@happy", "no label")
    study = Responses(EMOTIONS, EMOTIONS, study.answers, groups, rejected=(reject,))
    return result_files(analyze(study, by=["hand"]), study)


def test_the_tidy_table_has_a_row_for_each_answer(files) -> None:
    table = rows(files["responses_tidy.csv"])
    assert len(table) == 270
    assert set(table[0]) == {"participant", "video", "signalled", "perceived", "position", "hand", "note", "correct"}
    assert sum(int(row["correct"]) for row in table) == np.trace(TABLE_III)
    assert {row["note"] for row in table} == {"x", "'=cmd()"}


def test_rejected_cells_are_listed(files) -> None:
    assert rows(files["rejected.csv"]) == [
        {"file": "a.csv", "row": "7", "cell": "video 3", "value": "'@happy", "reason": "no label"}
    ]


def test_the_tests_are_listed_for_the_whole_and_each_group(files) -> None:
    table = pd.read_csv(io.StringIO(files["tests.csv"]))
    assert len(table) == 6 * 3
    assert table["chi_squared"][:6].round(3).tolist() == [75.133, 60.2, 54.067, 27.667, 39.933, 79.133]
    assert r"Happiness & 29/45 & 64.4 [49.8, 76.8] & 75.13" in files["tests.tex"]


def test_results_are_json(files) -> None:
    assert json.loads(files["results.json"])["counts"] == TABLE_III.tolist()


def test_the_report_needs_nothing_else() -> None:
    study = responses(TABLE_III)
    page = report_html(analyze(study), study, {"A <picture>": ("png", b"data")})
    for foreign in ("http:", "https:", "<script", "<link", "@import"):
        assert foreign not in page
    assert "A &lt;picture&gt;" in page
    assert "absolute majority" in page
    assert "is supported: 6 of 6" in page


def test_a_report_of_a_matrix_alone_says_so() -> None:
    page = report_html(analyze_counts(TABLE_III, EMOTIONS, EMOTIONS), None, {})
    assert "participants are not known" in page


def test_text_in_a_report_is_only_text() -> None:
    study = responses(TABLE_III)
    evil = Responses(EMOTIONS, EMOTIONS, study.answers, study.participants.assign(hand="<script>alert(1)</script>"))
    assert "<script" not in report_html(analyze(evil), evil, {})
