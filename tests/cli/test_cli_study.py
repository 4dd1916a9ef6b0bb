import json
import shutil
from pathlib import Path

import pytest
from jsonschema import validate

from emovid.cli.main import main

ROOT = Path(__file__).parents[2]
REFERENCE = ROOT / "studies" / "santos-egerstedt"
EMOTIONS = ["happiness", "surprise", "anger", "fear", "disgust", "sadness"]
FILES = {
    *("results.json", "report.html", "responses_tidy.csv", "rejected.csv", "tests.csv", "tests.tex", "files.sha256"),
    *(f"confusion_matrix.{suffix}" for suffix in ("csv", "md", "tex")),
    *(
        f"{name}.{suffix}"
        for name in ("participant-flow", "confusion-matrix", "circumplex")
        for suffix in ("pdf", "png")
    ),
    *(f"accuracy-{name}.{suffix}" for name in ("gender", "robotics-background") for suffix in ("pdf", "png")),
}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def reference(tmp_path_factory) -> Path:
    """Analyze the reference study as the paper did."""
    folder = tmp_path_factory.mktemp("reference") / "results"
    groups = ["--by", "gender", "--by", "robotics_background"]
    assert main(["study", "analyze", str(REFERENCE / "responses.csv"), *groups, "-o", str(folder), "--quiet"]) == 0
    return folder


@pytest.fixture
def blank_figures(monkeypatch) -> None:
    """Write empty files in place of figures, where a test looks at other results."""
    monkeypatch.setattr("emovid.workflows.analysis.encoded", lambda _, kind, __: b"<svg/>" if kind == "svg" else b"")


def test_results_folder_has_the_documented_files(reference) -> None:
    assert {path.name for path in reference.iterdir()} == FILES


def test_analysis_of_the_reference_study_gives_table_iii(reference) -> None:
    results = json.loads((reference / "results.json").read_text())
    expected = [
        [64.44, 17.78, 8.89, 4.44, 4.44, 13.33],
        [11.11, 57.78, 8.89, 2.22, 0.00, 0.00],
        [8.89, 0.00, 55.56, 13.33, 15.56, 4.44],
        [6.67, 13.33, 20.00, 40.00, 35.56, 15.56],
        [6.67, 4.44, 4.44, 26.67, 40.00, 2.22],
        [2.22, 6.67, 2.22, 13.33, 4.44, 64.44],
    ]
    assert [[round(share, 2) for share in row] for row in results["percent"]] == expected
    statistics = [round(results["goodness_of_fit"][name]["statistic"], 3) for name in EMOTIONS]
    assert statistics == [75.133, 60.2, 54.067, 27.667, 39.933, 79.133]
    assert results["n_participants"] == 45
    assert set(results["groups"]) == {"gender", "robotics_background"}
    assert results["groups"]["gender"]["female"]["n_participants"] == 13
    provenance = results["provenance"]
    assert (len(provenance["inputs"][0]["sha256"]), provenance["key_sha256"]) == (64, None)


def test_two_analyzes_give_identical_bytes(reference, tmp_path) -> None:
    groups = ["--by", "gender", "--by", "robotics_background"]
    assert main(["study", "analyze", str(REFERENCE / "responses.csv"), *groups, "-o", "again", "--quiet"]) == 0
    for name in FILES:
        assert (tmp_path / "again" / name).read_bytes() == (reference / name).read_bytes(), name


@pytest.mark.usefixtures("blank_figures")
def test_the_terminal_shows_matrix_tests_and_warnings(capsys, tmp_path) -> None:
    deep = tmp_path / ("a long folder " * 8)  # wider than a terminal: a line must stay a line
    shutil.copytree(REFERENCE, deep)
    assert main(["study", "analyze", str(deep / "responses.csv")]) == 0
    said = capsys.readouterr().out
    for words in ("45 participants", "64.44", "75.13", "absolute", "warnings", "results in results: report.html"):
        assert words in said


@pytest.mark.usefixtures("blank_figures")
def test_blinded_codes_are_joined_with_their_key(tmp_path, capsys) -> None:
    codes = {name: f"x{i}q" for i, name in enumerate(EMOTIONS)}
    lines = (REFERENCE / "responses.csv").read_text().splitlines()
    blinded = [lines[0]] + [
        ",".join([row[0], codes[row[1]], *row[2:]]) for row in (line.split(",") for line in lines[1:])
    ]
    (tmp_path / "export.csv").write_text("\n".join(blinded) + "\n")
    (tmp_path / "key.csv").write_text("video_code,true_emotion\n" + "".join(f"{c},{n}\n" for n, c in codes.items()))
    assert main(["study", "analyze", "export.csv", "--key", "key.csv", "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert [results["counts"][i][i] for i in range(6)] == [29, 26, 25, 18, 18, 29]
    assert len(results["provenance"]["key_sha256"]) == 64


@pytest.mark.usefixtures("blank_figures")
def test_published_matrix_is_analyzed_without_answers(tmp_path, capsys) -> None:
    assert main(["study", "analyze", "--counts", str(REFERENCE / "counts.csv"), "-o", "r"]) == 0
    first = json.loads((tmp_path / "r/results.json").read_text())
    assert main(["study", "analyze", "--counts", "r/confusion_matrix.csv", "-o", "again"]) == 0
    again = json.loads((tmp_path / "again/results.json").read_text())
    assert first["counts"] == again["counts"]
    assert {path.name for path in (tmp_path / "r").iterdir()} == {
        name for name in FILES if not name.startswith(("accuracy", "responses", "rejected", "participant"))
    }


@pytest.mark.usefixtures("blank_figures")
def test_simulated_participants_are_analyzed_like_people(tmp_path, capsys) -> None:
    options = [
        "--participants",
        "30",
        "--accuracy",
        "0.7",
        "--elimination",
        "0.3",
        "--dropout",
        "0.05",
        "--bias",
        "fear=3",
    ]
    assert main(["study", "simulate", "-o", "m.csv", *options]) == 0
    assert main(["study", "analyze", "m.csv", "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert results["n_participants"] == 30
    assert results["dependence"]["order"] is not None  # positions are known
    assert main(["study", "simulate", "-o", "n.csv", "--matrix", str(REFERENCE / "counts.csv")]) == 0
    assert len((tmp_path / "n.csv").read_text().splitlines()) == 1 + 45 * 6


@pytest.mark.usefixtures("blank_figures")
def test_replication_is_compared_with_the_original(capsys) -> None:
    main(["study", "simulate", "-o", "m.csv", "--accuracy", "0.2", "--participants", "60"])
    main(["study", "analyze", "m.csv", "-o", "r", "--quiet"])
    capsys.readouterr()
    assert main(["study", "compare", str(REFERENCE / "counts.csv"), "r/confusion_matrix.csv"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [*EMOTIONS, "whole"]
    assert main(["study", "compare", str(REFERENCE / "counts.csv"), "r/confusion_matrix.csv", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["videos"]["happiness"]["rates"]["difference"] < -0.2
    for other in ("r", "r/results.json"):
        assert main(["study", "compare", str(REFERENCE / "counts.csv"), other, "--json"]) == 0
        assert json.loads(capsys.readouterr().out) == found


def test_labels_missing_in_one_study_have_no_value(tmp_path, capsys) -> None:
    (tmp_path / "a.csv").write_text("perceived,fear,anger\nfear,5,1\nanger,1,4\n")
    (tmp_path / "b.csv").write_text("perceived,anger\nfear,2\nanger,3\n")
    assert main(["study", "compare", "a.csv", "b.csv", "--json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)  # NaN is no JSON
    assert found["videos"]["fear"]["rates"]["difference"] is None
    assert found["videos"]["anger"]["rates"]["difference"] == pytest.approx(3 / 5 - 4 / 5)
    assert main(["study", "compare", "a.csv", "b.csv"]) == 0
    assert capsys.readouterr().out.startswith("fear       5/6 and 0/0        no answers to compare\nanger ")


def test_studies_with_different_labels_are_not_compared(tmp_path, capsys) -> None:
    (tmp_path / "a.csv").write_text("perceived,fear,anger\nfear,5,1\nanger,1,4\n")
    (tmp_path / "b.csv").write_text("perceived,fear\nfear,2\nsadness,3\n")
    assert main(["study", "compare", "a.csv", "b.csv"]) == 2
    assert capsys.readouterr().err == "b.csv: other labels than a.csv: expected fear, anger\n"


@pytest.mark.usefixtures("blank_figures")
def test_unusable_answers_are_refused_or_shown_in_groups(tmp_path, capsys) -> None:
    rows = "".join(f"p{i},anger,meh\np{i},fear,{('fear', 'anger')[i % 2]}\n" for i in range(203))
    others = "".join(f"q{i},fear,word{i}\n" for i in range(25))
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "x.csv").write_text(f"participant,video,response\n{rows}{others}p9,fear\n")
    for i in range(25):
        (tmp_path / "in" / f"note{i}.txt").write_text("no table\n")
    assert main(["study", "analyze", "in"]) == 2
    said = capsys.readouterr().err
    assert "x.csv: 229 of 432 answers cannot be used (203 rows: 'meh' not a label; expected happiness," in said
    assert "; 25 rows: 'word0' and 24 other values not a label; expected happiness," in said
    assert "; 1 row: ragged row: 2 cells where the header has 3); expected at most 10 %: correct the key or the" in said
    assert not (tmp_path / "results").exists()
    assert main(["study", "analyze", "in", "--max-rejected", "0.6"]) == 0
    said = capsys.readouterr().out
    assert "\n203 rows: 'meh' not a label; expected happiness," in said
    assert said.count("203 rows: 'meh'") == said.count("answers that are no labels: 'meh' (203)") == 1
    assert "\nin/note0.txt: a header alone; expected a row for each participant or answer\n" in said
    assert "\n... and 8 more in rejected.csv\n" in said
    assert (tmp_path / "results" / "rejected.csv").read_text().count("\n") == 255


@pytest.mark.usefixtures("blank_figures")
def test_analysis_replaces_only_its_own_files(tmp_path, capsys) -> None:
    (tmp_path / "a.csv").write_text("perceived,fear,anger\nfear,5,1\nanger,1,4\n")
    answers = "".join(f"p{i},fear,{('fear', 'anger')[i % 2]},{'fm'[i % 2]}\n" for i in range(6))
    (tmp_path / "x.csv").write_text(f"participant,video,response,gender\n{answers}")
    assert main(["study", "analyze", "x.csv", "-o", "out", "--quiet"]) == 0
    assert (tmp_path / "out" / "accuracy-gender.pdf").exists()
    (tmp_path / "out" / "notes.md").write_text("mine")
    assert main(["study", "analyze", "--counts", "a.csv", "-o", "out", "--quiet"]) == 0
    left = {path.name for path in (tmp_path / "out").iterdir()}
    assert not left & {"accuracy-gender.pdf", "responses_tidy.csv", "rejected.csv"}
    assert (tmp_path / "out" / "notes.md").read_text() == "mine"
    (tmp_path / "out" / "report.html").write_text("edited")
    assert main(["study", "analyze", "x.csv", "-o", "out", "--quiet"]) == 2
    assert "report.html: changed since an analysis wrote it; move it, or choose another fol" in capsys.readouterr().err
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "report.html").write_text("mine")
    assert main(["study", "analyze", "x.csv", "-o", "mine", "--quiet"]) == 2
    assert "report.html: not written by an analysis; move it, or choose another fold" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["report.html"]


def test_the_map_has_a_schema(capsys) -> None:
    assert main(["study", "schema", "--map"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert {"participant", "truth", "rows", "repeats"} <= set(schema["properties"])


@pytest.mark.usefixtures("blank_figures")
def test_results_of_an_analysis_are_not_read_as_exports(tmp_path, capsys) -> None:
    exports = tmp_path / "exports"
    exports.mkdir()
    shutil.copy(REFERENCE / "responses.csv", exports)
    for output in (
        "exports/results",
        "exports/results",
        "exports",
    ):  # the second analysis would read the results of the first, ...
        assert main(["study", "analyze", "exports", "-o", output, "--by", "gender", "--by", "robotics_background"]) == 0
        assert "responses.csv: long table, 45 participants\n" in capsys.readouterr().out
        results = json.loads((tmp_path / output / "results.json").read_text())
        assert (results["n_participants"], len(results["provenance"]["inputs"])) == (45, 1)
        assert (tmp_path / output / "rejected.csv").read_text() == "file,row,cell,value,reason\n"
    shutil.copy(exports / "responses_tidy.csv", tmp_path / "tidy.csv")
    for folder in ("exports", "exports/results"):
        for name in FILES:
            (tmp_path / folder / name).unlink()
    shutil.move(tmp_path / "tidy.csv", exports / "tidy.csv")  # ... and they are recognized in any folder
    assert main(["study", "analyze", "exports", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["n_participants"] == 45
    (exports / "responses.csv").unlink()
    assert main(["study", "analyze", "exports"]) == 2
    said = "exports: no file here, except those of an analysis; expected an export of a survey\n"
    assert capsys.readouterr().err == said
    assert main(["study", "analyze", "exports/tidy.csv", "--json"]) == 0  # a file given by name is read
    assert json.loads(capsys.readouterr().out)["n_participants"] == 45


@pytest.mark.usefixtures("blank_figures")
def test_results_json_of_another_program_does_not_hide_exports(tmp_path, capsys) -> None:
    shutil.copy(REFERENCE / "responses.csv", tmp_path / "tests.csv")
    for text in ("{}", "[1]", "{"):
        (tmp_path / "results.json").write_text(text)
        assert main(["study", "analyze", ".", "--json", "-o", "r"]) == 0
        assert json.loads(capsys.readouterr().out)["n_participants"] == 45


@pytest.mark.usefixtures("blank_figures")
def test_inferred_participant_column_is_reported(tmp_path, capsys) -> None:
    lines = (REFERENCE / "responses.csv").read_text().splitlines()
    (tmp_path / "x.csv").write_text("\n".join([lines[0].replace("participant", "Code"), *lines[1:]]))
    assert main(["study", "analyze", "x.csv"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    note = "x.csv: participants are identified by 'Code': each of its 45 values answers all 6 videos once"
    origin = "RECONSTRUCTED: these are not the answers of real participants"  # the reference study marks its rows so
    assert said.startswith(f"x.csv: long table, 45 participants {note} {origin} signaled emotion")
    assert said.count(note) == 2  # among the warnings, too


def test_columns_command_accepts_custom_labels(tmp_path, capsys) -> None:
    (tmp_path / "x.csv").write_text("participant,video,response\na,awe,calm\na,calm,awe\n")
    assert main(["study", "columns", "x.csv", "--labels", "awe,calm"]) == 0
    said = capsys.readouterr().out
    assert said.startswith(
        "# x.csv: long table\n# participant  participant: 'a'\n# video        video: 'awe', 'calm'\n"
    )
    assert "\nparticipant: participant\nvideo: video\nresponse: response\nanswers:\n" in said


def test_plan_command_prints_a_sample_size(capsys) -> None:
    assert main(["study", "power", "--rate", "0.5", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["n_binomial"] == 24  # 0.5 against 1/6 at 0.05 / 6 with 80 % power
    assert main(["study", "power", "--rate", "0.5"]) == 0
    assert "exact binomial against chance:  24 participants\n" in capsys.readouterr().out
    assert main(["study", "power", "--rate", "0.167"]) == 0
    assert {line[32:] for line in capsys.readouterr().out.splitlines()} == {"more than can be planned"}


def test_plan_command_simulates_a_complete_study(capsys) -> None:
    assert main(["study", "plan", "--rate", "0.6", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert 0.78 < found["power"] < 0.9
    assert main(["study", "plan", "--rate", "0.6"]) == 0
    assert capsys.readouterr().out.startswith(f"{found['participants']} participants in all: power 0.")
    assert main(["study", "plan", "--sequential", "bayes", "--looks", "20,40"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("look after 20: above chance from ")
    assert "\nfalse alarms of one emotion 0.0" in said


def test_groups_are_compared_in_a_mixed_model(tmp_path, capsys) -> None:
    assert main(["study", "model", str(REFERENCE / "responses.csv"), "--by", "gender"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "gender: male: −0.47 (SE 0.30), p = .117, odds ratio 0.62 [0.35, 1.12]"
    assert lines[2:] == [
        "standard deviations in log odds: participants 0.32, videos 0.30",
        "270 answers of 45 participants to 6 videos",
    ]
    assert main(["study", "model", str(REFERENCE / "responses.csv"), "--by", "gender", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["converged"]
    rows = "".join(f"p{i},fear,{('fear', 'anger')[i % 2]},f\n" for i in range(6))
    (tmp_path / "x.csv").write_text(f"participant,video,response,gender\n{rows}")
    assert main(["study", "model", "x.csv", "--by", "gender"]) == 2
    assert capsys.readouterr().err == "gender: one level, f; a model compares two or more\n"


def test_simulated_answers_are_marked_in_all_outputs(tmp_path, capsys) -> None:
    assert main(["study", "simulate", "--participants", "12", "-q"]) == 0
    assert {line.rpartition(",")[2] for line in (tmp_path / "simulated.csv").read_text().splitlines()[1:]} == {
        "simulated"
    }
    assert main(["study", "analyze", "simulated.csv"]) == 0
    assert "\nSIMULATED: these are not the answers of real participants\n" in capsys.readouterr().out
    assert json.loads((tmp_path / "results/results.json").read_text())["flow"]["origin"] == "simulated"
    assert '<p class="origin">SIMULATED</p>' in (tmp_path / "results/report.html").read_text()
    assert b"SIMULATED" in (tmp_path / "results/confusion-matrix.png").read_bytes()
    assert main(["study", "analyze", str(REFERENCE / "responses.csv"), "-o", "r"]) == 0
    assert "\nRECONSTRUCTED: these are not the answers of real participants\n" in capsys.readouterr().out


@pytest.mark.usefixtures("blank_figures")
def test_compare_reports_several_answers_to_an_emotion(tmp_path, capsys) -> None:
    rows = "".join(f"p{i},{v},{('fear', 'anger')[(i + j) % 2]}\n" for i in range(8) for j, v in enumerate("abc"))
    (tmp_path / "x.csv").write_text(f"participant,video,response\n{rows}")
    (tmp_path / "key.csv").write_text("video_code,true_emotion\na,fear\nb,fear\nc,anger\n")
    assert main(["study", "analyze", "x.csv", "--key", "key.csv", "--labels", "fear,anger", "-o", "r", "-q"]) == 0
    assert main(["study", "compare", "r", "r"]) == 0
    assert "participants shuffled over the studies" in capsys.readouterr().out
    assert main(["study", "compare", "r", "r/confusion_matrix.csv"]) == 0
    assert "r: participants gave several answers to an emotion" in capsys.readouterr().out


def test_the_schema_of_results_is_kept(reference, capsys) -> None:
    assert main(["study", "schema", "--results"]) == 0
    schema = json.loads(capsys.readouterr().out)
    results = json.loads((reference / "results.json").read_text())
    validate(results, schema)
    assert results["schema_version"] == schema["properties"]["schema_version"]["const"] == 2
    assert set(schema["properties"]) == set(results)
    assert main(["study", "schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "emovid study"


@pytest.mark.usefixtures("blank_figures")
def test_equivalence_needs_a_margin(tmp_path, capsys) -> None:
    for margin, said in (
        (None, "compatible with differences up to"),
        ("15", "equivalence not shown within ±15.0 points"),
    ):
        options = ["--margin", margin] if margin else []
        source = str(REFERENCE / "responses.csv")
        assert main(["study", "analyze", source, "--by", "gender", "-o", "r", "--quiet", *options]) == 0
        assert said in (tmp_path / "r/report.html").read_text()
    assert main(["study", "compare", "r", "r", "--margin", "50"]) == 0
    assert "equivalent within ±50.0 points" in capsys.readouterr().out


def test_columns_of_an_export_are_shown(capsys) -> None:
    assert main(["study", "columns", str(REFERENCE / "responses.csv")]) == 0
    said = capsys.readouterr().out
    for word in ("participant", "video", "response", "gender", "robotics_background"):
        assert word in said


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["analyze"], "expected exports to analyze, or --counts and a confusion matrix"),
        (["analyze", "x.csv", "--counts", "y.csv"], "expected exports to analyze, or --counts and a confusion matrix"),
        (["analyze", "--counts", "y.csv"], "y.csv: cannot be read: no such file or directory"),
        (["compare", "a.csv", "b.csv"], "a.csv: cannot be read: no such file or directory"),
        (["compare", str(REFERENCE / "counts.csv"), "."], "results.json: cannot be read: no such file or directory"),
        (["power", "--rate", "0.1"], None),
        (
            ["simulate", "--bias", "feer=2"],
            f"--bias feer=2: expected one of {', '.join(EMOTIONS)} (did you mean fear?)",
        ),
        *(
            (
                ["simulate", "--bias", f"fear={weight}"],
                f"--bias fear={weight}: expected LABEL=WEIGHT, a weight from 0 to 1000000",
            )
            for weight in ("x", "", "-1", "nan", "1e7")
        ),
        (["simulate", "--matrix", "m.csv", "--bias", "fear=2"], "--matrix: cannot be combined with --bias"),
        (["simulate", "--matrix", "m.csv", "--accuracy", "0"], "--matrix: cannot be combined with --accuracy"),
        (["analyze", "--counts", "y.csv", "--by", "gender"], "--counts: cannot be combined with --by"),
        (["analyze", "--counts", "y.csv", "--key", "k.csv"], "--counts: cannot be combined with --key"),
        (["analyze", "--counts", "y.csv", "--map", "m.yaml"], "--counts: cannot be combined with --map"),
        (["analyze", "--counts", "y.csv", "--labels", "a,b"], "--counts: cannot be combined with --labels"),
        (
            ["analyze", str(REFERENCE / "responses.csv"), "--labels", ""],
            None,
        ),
        (
            ["analyze", "--counts", str(REFERENCE / "counts.csv"), "-o", str(REFERENCE / "counts.csv")],
            f"-o {REFERENCE / 'counts.csv'}: is a file; expected a folder",
        ),
        (["simulate", "-o", "."], "-o .: is a folder; expected a file"),
        (["analyze", str(REFERENCE / "responses.csv"), "--by", "gendr"], None),
        (["plan", "--goal", "h2"], "--goal h2: expected h1, difference, equivalence"),
        (["plan", "--sequential", "beyes"], "--sequential beyes: expected alpha or bayes (did you mean bayes?)"),
        (["plan", "--sequential", "bayes", "--looks", "x"], "--looks x: expected whole numbers, separated by commas"),
        (["plan", "--rate", "0.1"], "a hit rate of 0.1 is not between the chance of 0.1667 and 1"),
        (["analyze", "nowhere.csv"], None),
        (["columns", "nowhere.csv"], None),
    ],
)
def test_invalid_input_gives_one_line_and_writes_no_file(tmp_path, capsys, arguments, message) -> None:
    assert main(["study", *arguments]) == 2
    said = capsys.readouterr()
    assert len(said.err.splitlines()) == 1
    assert message is None or said.err == message + "\n"
    assert list(tmp_path.iterdir()) == []


def test_quiet_simulation_only_writes_its_file(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["study", "simulate", "-o", "m.csv", "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert (tmp_path / "m.csv").exists()
