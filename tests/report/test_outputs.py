import csv
import io
import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from emovid.csv_writer import safe
from emovid.errors import SourceError
from emovid.report.page import methods_text, report_html
from emovid.report.tables import matrix_csv, matrix_latex, matrix_markdown, result_files, tidy_csv
from emovid.responses.responses import EMOTIONS, Rejected, Responses, Source, Synonym
from emovid.responses.results_files import read_matrix, read_results
from emovid.statistics.analyze import analyze, analyze_counts
from emovid.statistics.results import Provenance
from tests.helpers.known import TABLE_III
from tests.statistics.test_analyze import responses


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_written_matrix_reads_back(tmp_path) -> None:
    (tmp_path / "m.csv").write_text(matrix_csv(TABLE_III, EMOTIONS, EMOTIONS))
    counts, labels, signalled = read_matrix(tmp_path / "m.csv")
    assert np.array_equal(counts, TABLE_III)
    assert labels == signalled == EMOTIONS


def test_formula_like_labels_are_escaped_in_matrices() -> None:
    assert matrix_csv(np.eye(2, dtype=int), ("=a", "b"), ("=a", "b")).splitlines()[1].startswith("'=a,")


def test_matrix_rows_may_be_in_any_order(tmp_path) -> None:
    order = [5, 2, 6, 0, 1, 4, 3]
    counts, labels = np.vstack([TABLE_III, np.arange(6)]), (*EMOTIONS, "none")
    (tmp_path / "m.csv").write_text(matrix_csv(counts[order], [labels[i] for i in order], EMOTIONS))
    found = read_matrix(tmp_path / "m.csv")
    assert np.array_equal(found[0], counts)
    assert found[1:] == (labels, EMOTIONS)


def test_matrix_from_a_spreadsheet_is_read(tmp_path) -> None:
    text = "sep=;\r\nPerceived;Fear;Fear_percent;Anger\r\nFear;3;75,00;1\r\nAnger;1;25,00;2\r\n;;;\r\n"
    (tmp_path / "m.csv").write_bytes(text.encode("utf-16"))
    counts, labels, signalled = read_matrix(tmp_path / "m.csv")
    assert counts.tolist() == [[3, 1], [1, 2]]
    assert labels == signalled == ("fear", "anger")


def test_matrix_with_the_largest_counts_is_analyzed(tmp_path) -> None:
    (tmp_path / "m.csv").write_text("perceived,fear,anger\nfear,9999999,1\nanger,9999999,2\nawe,0,9999999\n")
    found = analyze_counts(*read_matrix(tmp_path / "m.csv"))
    assert found.goodness_of_fit["fear"].p_exact < 0.001
    assert found.recognition["fear"].hu == pytest.approx(0.5)  # 9999999^2 / (10000000 * 19999998)


RESULTS = {"counts": [[3, 1], [1, 2], [0, 1]], "labels": ["fear", "anger", "none"], "emotions": ["fear", "anger"]}


def test_matrix_is_read_from_saved_results(tmp_path) -> None:
    (tmp_path / "results.json").write_text(json.dumps(RESULTS))
    for path in (tmp_path, tmp_path / "results.json"):
        counts, labels, signalled = read_results(path)
        assert counts.tolist() == RESULTS["counts"]
        assert (labels, signalled) == (("fear", "anger", "none"), ("fear", "anger"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "not results; expected the results.json of emovid study analyze"),
        ("[1]", "not results; expected the results.json of emovid study analyze"),
        ("\ud800".encode("utf-16", "surrogatepass"), "not results; expected the results.json of emovid study analyze"),
        (RESULTS | {"counts": [[3, 1, 1, 2, 0, 1]]}, "not results; expected the results.json of emovid study analyze"),
        (RESULTS | {"counts": [[3], [1, 2], [0]]}, "not results; expected the results.json of emovid study analyze"),
        (RESULTS | {"labels": ["anger", "fear", "none"]},
         "not results; expected the results.json of emovid study analyze"),
        (RESULTS | {"labels": ["fear", "anger", "fear"]},
         "not results; expected the results.json of emovid study analyze"),
        ({"counts": [], "labels": [], "emotions": []},
         "not results; expected the results.json of emovid study analyze"),
        (RESULTS | {"counts": [[3, -1], [1, 2], [0, 1]]}, "'-1'; expected a count, a whole number below ten million"),
        (RESULTS | {"counts": [[3, 1.5], [1, 2], [0, 1]]}, "'1.5'; expected a count, a whole number below ten million"),
        (RESULTS | {"counts": [[3, 10**30], [1, 2], [0, 1]]},
         f"'{10**30}'; expected a count, a whole number below ten million"),
    ],
)  # fmt: skip
def test_invalid_results_give_a_one_line_message(tmp_path, text, message) -> None:
    text = json.dumps(text) if isinstance(text, dict) else text
    (tmp_path / "r.json").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(SourceError) as failure:
        read_results(tmp_path / "r.json")
    assert str(failure.value) == f"{tmp_path}/r.json: {message}"


def test_matrix_file_is_accepted_instead_of_results(tmp_path) -> None:
    (tmp_path / "m.csv").write_text(matrix_csv(TABLE_III, EMOTIONS, EMOTIONS))
    assert read_results(tmp_path / "m.csv")[0].tolist() == TABLE_III.tolist()


def test_a_matrix_may_have_an_extra_row(tmp_path) -> None:
    counts = np.vstack([TABLE_III, np.arange(6)])
    (tmp_path / "m.csv").write_text(matrix_csv(counts, (*EMOTIONS, "none"), EMOTIONS))
    assert np.array_equal(read_matrix(tmp_path / "m.csv")[0], counts)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "m.csv: empty; expected a header and rows"),
        ("perceived,fear,anger\nfear,1,2\n",
         "m.csv:1: not a confusion matrix; expected the heading perceived,happiness,... and one row for each label"),
        ("fear,perceived,anger\nfear,1,2\nanger,1,2\n",
         "m.csv:1: not a confusion matrix; expected the heading perceived,happiness,... and one row for each label"),
        ("perceived\nfear\nanger\n",
         "m.csv:1: not a confusion matrix; expected the heading perceived,happiness,... and one row for each label"),
        ("perceived,fear,anger\nfear,1,2\nangr,3,4\n", "m.csv:1: anger: no row has this label (did you mean angr?)"),
        ("perceived,fear,anger\n\nfear,1,x\nanger,3,4\n",
         "m.csv:3: 'x'; expected a count, a whole number below ten million"),
        ("perceived,fear,anger\nfear,1\nanger,3,4\n", "m.csv:2: ragged row: 2 cells where the header has 3"),
        ("perceived,fear,anger\nfear,-1,2\nanger,3,4\n",
         "m.csv:2: '-1'; expected a count, a whole number below ten million"),
        ("perceived,fear,anger\nfear,10000000,2\nanger,3,4\n",
         "m.csv:2: '10000000'; expected a count, a whole number below ten million"),
        ("perceived,fear,anger\nfear,1,2\nanger,3,4\nFear,5,6\n",
         "m.csv:4: fear: given twice; expected each label once"),
        ("perceived,fear,fear\nfear,1,2\nanger,3,4\n", "m.csv:1: fear: given twice; expected each label once"),
        ("perceived,fear,anger\nfear,1,2\nanger,3,4\n,5,6\n",
         "m.csv:4: a row without a label; expected each label once"),
    ],
)  # fmt: skip
def test_file_that_is_not_a_matrix_gives_a_one_line_message(tmp_path, monkeypatch, text, message) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(SourceError) as failure:
        read_matrix((tmp_path / "m.csv").relative_to(tmp_path))
    assert str(failure.value) == message


def test_table_iii_in_markdown_and_latex() -> None:
    assert "| Happiness | **64.44** (29) | 17.78 (8) |" in matrix_markdown(TABLE_III, EMOTIONS, EMOTIONS)
    latex = matrix_latex(TABLE_III, EMOTIONS, EMOTIONS)
    assert r"Happiness & \textbf{64.44} (29) & 17.78 (8)" in latex
    assert latex.count(r"\\") == 8  # two headings and six rows


def test_special_characters_in_labels_do_not_break_tables() -> None:
    labels = ("r&b_100%", "a|b", "{x}\\~^$#")
    counts = np.eye(3, dtype=int)
    latex = matrix_latex(counts, labels, labels)
    assert r"& R\&b\_100\% & A|b & \{x\}\textbackslash{}\textasciitilde{}\textasciicircum{}\$\# \\" in latex
    assert r"  R\&b\_100\% & \textbf{100.00} (1)" in latex
    assert (
        result_files(analyze_counts(counts, labels, labels), None)["tests.tex"]
        .splitlines()[4]
        .startswith(r"  R\&b\_100\% & 1/1")
    )
    assert matrix_markdown(counts, labels, labels).splitlines()[0] == r"| Response | R&b_100% | A\|b | {x}\~^$# |"


@pytest.mark.parametrize("cell", ["=1+1", "+cmd", "-x", "@sum", "\tx", "\rx"])
def test_spreadsheet_formulas_become_text(cell) -> None:
    assert safe(cell) == "'" + cell


@pytest.mark.parametrize("cell", ["-1.5", "+3", "fear", "", "a=b"])
def test_numbers_and_words_are_unchanged(cell) -> None:
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


def test_groups_named_like_tidy_columns_get_their_own_columns() -> None:
    study = responses(TABLE_III)
    groups = study.participants.assign(position="nurse", perceived="x", correct="y", participant="z")
    table = rows(tidy_csv(Responses(EMOTIONS, EMOTIONS, study.answers, groups)))
    assert {row["position (group)"] for row in table} == {"nurse"}
    assert {row["perceived (group)"] + row["correct (group)"] + row["participant (group)"] for row in table} == {"xyz"}
    assert sum(int(row["correct"]) for row in table) == np.trace(TABLE_III)
    assert {row["perceived"] for row in table} == set(EMOTIONS)


def test_rejected_cells_are_listed(files) -> None:
    assert rows(files["rejected.csv"]) == [
        {"file": "a.csv", "row": "7", "cell": "video 3", "value": "'@happy", "reason": "no label"}
    ]


def test_tests_are_listed_for_all_participants_and_each_group(files) -> None:
    table = pd.read_csv(io.StringIO(files["tests.csv"]))
    assert len(table) == 6 * 3
    assert table["chi_squared"][:6].round(3).tolist() == [75.133, 60.2, 54.067, 27.667, 39.933, 79.133]
    assert r"Happiness & 29/45 & 64.4 [49.8, 76.8] & 75.13" in files["tests.tex"]


def test_results_are_json(files) -> None:
    assert json.loads(files["results.json"])["counts"] == TABLE_III.tolist()


def test_report_is_self_contained() -> None:
    study = responses(TABLE_III)
    page = report_html(analyze(study), study, {"confusion-matrix": ("A <picture>", b"data")})
    for foreign in ("http:", "https:", "<script", "<link", "@import"):
        assert foreign not in page
    assert "A &lt;picture&gt;" in page
    assert "absolute majority" in page
    assert "is supported: 6 of 6" in page


def test_report_covers_shown_videos_and_participants_without_answers() -> None:
    study = responses(TABLE_III)
    labels = (*EMOTIONS, "neutral")
    silent = study.participants.assign(hand=["", *study.participants["hand"][1:]])
    offered = Responses(labels, labels, study.answers, silent)
    page = report_html(analyze(offered), offered, {})
    assert "is supported: 6 of 6" in page
    assert r"Neutral & 0/0 & -- & -- & -- & -- & -- & -- & -- \\" in latex_of(offered)
    assert '<td>hand</td><td class="text">not said</td><td>1</td>' in page


def latex_of(study: Responses) -> str:
    return result_files(analyze(study), study)["tests.tex"]


def test_a_report_names_its_sources_its_key_and_its_version() -> None:
    study = responses(TABLE_III)
    known = Provenance((Source("a<b.csv", "long table", "12", 45),), "34", "0.1.0", 7)
    page = report_html(replace(analyze(study), provenance=known), study, {})
    for line in ("a&lt;b.csv: long table, SHA-256 12", "key: SHA-256 34", "emovid 0.1.0, seed 7"):
        assert f"<li>{line}</li>" in page


def test_report_of_a_matrix_says_that_answers_are_missing() -> None:
    page = report_html(analyze_counts(TABLE_III, EMOTIONS, EMOTIONS), None, {})
    assert "participants are not known" in page


def test_text_in_a_report_is_escaped() -> None:
    study = responses(TABLE_III)
    evil = Responses(EMOTIONS, EMOTIONS, study.answers, study.participants.assign(hand="<script>alert(1)</script>"))
    assert "<script" not in report_html(analyze(evil), evil, {})


def test_report_shows_exclusions_and_accepted_labels() -> None:
    study = responses(TABLE_III)
    study = replace(
        study,
        dropped={"preview": 2, "partial": 1},
        left_out={"practice": 9},
        synonyms=(Synonym("joy", "happiness", 4),),
        warnings=("someone looked twice",),
    )
    results = analyze(study)
    assert (results.flow.enrolled, results.flow.analyzed) == (48, 45)
    page = report_html(results, study, {})
    for words in (
        "<td>participants enrolled</td><td>48</td>",
        "<td>excluded: preview</td><td>2</td>",
        "<td>excluded: partial</td><td>1</td>",
        "<td>participants analyzed</td><td>45</td>",
        "<td>rows left out: practice</td><td>9</td>",
        "someone looked",
    ):
        assert words in page
    assert "&ldquo;joy&rdquo; as happiness (4)" in page
    assert page.index("someone looked") < page.index("is supported: 6 of 6") < page.index("Methods, ready to paste")


def test_groups_found_in_the_data_are_marked() -> None:
    study = responses(TABLE_III)
    assert "By hand (exploratory)" in report_html(analyze(study), study, {})
    assert "exploratory" not in report_html(analyze(study, by=["hand"]), study, {})


def test_methods_section_of_a_report_describes_the_analysis() -> None:
    text = methods_text(analyze(responses(TABLE_III), by=["hand"]))
    for words in ("one-sided exact binomial test", "Holm's (1979)", "2,000 bootstrap samples", "named beforehand"):
        assert words in text
    assert "not named beforehand" in methods_text(analyze(responses(TABLE_III)))
