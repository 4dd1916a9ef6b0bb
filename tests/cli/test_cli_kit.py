import json
import shutil
from pathlib import Path

import jsonschema
import pytest

from emovid.cli.main import main
from emovid.kit.folder import open_kit
from emovid.kit.load import load_study
from emovid.yaml_source import read_yaml
from tests.helpers.terminal import on_a_terminal

ROOT = Path(__file__).parents[2]
EXAMPLE = (ROOT / "studies" / "example" / "study.yaml").read_text()
SMALL = (
    EXAMPLE.replace("size: 1280x720", "size: 160x90")
    .replace("fps: 30", "fps: 5")
    .replace("duration: 15", "duration: 1")
)


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> None:
    """Work in a folder with a small version of the example study."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.yaml").write_text(SMALL)


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    """Build a kit of that study."""
    folder = tmp_path_factory.mktemp("built")
    (folder / "study.yaml").write_text(SMALL)
    how = ["--seed", "7", "--participants", "12", "--quiet"]
    assert main(["study", "build", str(folder), "-o", str(folder / "kit"), *how]) == 0
    return folder / "kit"


@pytest.fixture
def kit(built, tmp_path) -> Path:
    """Copy that kit to the folder of the test."""
    shutil.copytree(built, tmp_path / "kit")
    return Path("kit")


def test_new_study_copies_the_example_and_prints_next_steps(capsys) -> None:
    assert main(["study", "new", "deep/my-study"]) == 0
    next_step = "edit it, then run emovid study build deep/my-study -o kit/"
    assert capsys.readouterr() == ("", f"deep/my-study/study.yaml: the paper's study; {next_step}\n")
    first, _, rest = Path("deep/my-study/study.yaml").read_text().partition("\n")
    assert (first, rest) == ("# yaml-language-server: $schema=emovid-study.schema.json", EXAMPLE)
    assert main(["study", "schema"]) == 0
    schema = capsys.readouterr().out
    assert Path("deep/my-study/emovid-study.schema.json").read_text() == schema
    jsonschema.validate(read_yaml(EXAMPLE, "study.yaml")[0], json.loads(schema))
    assert main(["study", "new", "deep", "-q"]) == 0  # an existing folder without a study
    assert capsys.readouterr() == ("", "")
    loaded = load_study(Path("deep"))
    assert [item.emotion for item in loaded.exemplars] == list(loaded.study.labels)


def test_new_study_does_not_replace_existing_files(capsys) -> None:
    assert main(["study", "new", "."]) == 2
    assert capsys.readouterr().err == "study.yaml: exists; expected another folder\n"
    assert Path("study.yaml").read_text() == SMALL
    Path("notes").write_text("mine")
    for taken, problem in (
        ("notes", "is a file"),
        ("my.yaml", "cannot write .yaml"),
        ("my.zip", "cannot write .zip"),
        ("-", "writes files only"),
    ):
        assert main(["study", "new", taken]) == 2
        assert capsys.readouterr().err == f"{taken}: {problem}; expected a folder\n"
    assert Path("notes").read_text() == "mine"


def test_build_reports_its_files_and_warns_about_a_guessable_seed(capsys) -> None:
    assert main(["study", "build", "study.yaml", "-o", "one", "--seed", "7"]) == 0
    out, err = capsys.readouterr()
    lines = err.splitlines()
    assert out == ""
    assert [line.split()[-1] for line in lines[:6]] == 6 * ["made"]
    assert lines[5].startswith("[6/6] one/public/videos/")
    assert lines[6] == "one: 6 videos, orders for 45 participants"
    assert lines[8] == "warning: this seed, and with it the key, can be guessed; omit --seed for a real study"
    assert main(["study", "build", "study.yaml", "-o", "one"]) == 0
    assert capsys.readouterr().err.count("up to date") == 6
    assert main(["study", "build", "study.yaml", "-o", "two"]) == 0
    assert "can be guessed" not in capsys.readouterr().err


def test_audit_of_a_new_kit_prints_tables_and_succeeds(kit, capsys) -> None:
    assert main(["study", "audit", str(kit)]) == 0
    out = capsys.readouterr().out
    assert out.count("none") == 13
    assert "Orders: each video 2 to 2 times in each position, 2 to 2 times immediately after each other video" in out
    assert "The bit rate inside follows the motion" in out


def test_audit_finding_is_one_line_with_exit_code_1(kit, capsys) -> None:
    (kit / "public" / "anger.txt").write_text("a note")
    assert main(["study", "audit", str(kit)]) == 1
    out, err = capsys.readouterr()
    assert "files: public/anger.txt: not part of the kit\n" in out
    assert "names: public/anger.txt: names an emotion\n" in out
    assert err == ""
    assert main(["study", "audit", str(kit), "--json"]) == 1
    said = json.loads(capsys.readouterr().out)
    assert {"check": "names", "where": "public/anger.txt", "message": "names an emotion"} in said["findings"]
    assert said["orders"]["places_most"] == 2


def test_audit_hides_the_key_unless_requested(kit, capsys) -> None:
    key = open_kit(kit).key
    code = next(code for code in key if key[code] == "fear")
    (kit / "exports").mkdir()
    (kit / "exports" / "page.html").write_text(f'<video src="{code}.mp4" title="a scared swarm"></video>')

    def said(*options: str) -> str:
        assert main(["study", "audit", str(kit), *options]) == 1
        return capsys.readouterr().out

    for blind in (said(), said("--json")):
        assert f"names an emotion next to {code}" in blind
        assert not [label for label in key.values() if label in blind]
        assert "kbit" not in blind  # motion distinguishes emotions, and bit rates depend on it
    rows = [line.split() for line in said("--unblind").splitlines()]
    assert {row[1]: row[0] for row in rows if len(row) == 5 and row[1] in key} == key
    assert f"pages: exports/page.html: names an emotion next to {code}: fear" in said("--unblind")
    facts = json.loads(said("--unblind", "--json"))
    assert {row["video_code"]: row["emotion"] for row in facts["sizes"]} == key
    assert [finding["emotions"] for finding in facts["findings"]] == [["fear"]]


def test_audit_reports_balance_after_dropouts(kit, capsys) -> None:
    lines = [line.split(",") for line in (kit / "orders.csv").read_text().splitlines()[1:-3]]
    rows = [f"{who},{code},{place},fear" for who, place, code in lines]
    Path("answers.csv").write_text("\n".join(["participant,video,position,response", *rows, ""]))
    assert main(["study", "audit", str(kit), "--responses", "answers.csv"]) == 0
    assert "Answers: 12 participants, 11 with all videos, 69 answers" in capsys.readouterr().out


def test_every_export_writes_its_files(kit, capsys) -> None:
    for tool in ("jspsych", "psychopy", "qualtrics", "limesurvey", "psych-ds", "prereg", "checklist"):
        assert main(["study", "export", str(kit), "--to", tool]) == 0
        assert capsys.readouterr().err.startswith(f"kit/exports/{tool}: ")
        assert main(["study", "export", str(kit), "--to", tool, "-o", f"out-{tool}", "-q"]) == 0
        assert capsys.readouterr().err == ""
        made, there = (sorted(p.name for p in Path(f).rglob("*")) for f in (f"out-{tool}", f"kit/exports/{tool}"))
        assert made == there


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["build", "nowhere"], "nowhere: cannot be read: no such file or directory"),
        (["build", ".", "--seed", "8"], "kit: contains a kit with another seed; expected that seed, another folder, or "
         "--force"),
        (["audit", "nowhere"], "nowhere: no such folder; expected a kit"),
        (["audit", "kit", "--responses", "none.csv"], "none.csv: cannot be read: no such file or directory"),
        (["export", "kit", "--to", "jspych"], "--to jspych: expected one of jspsych, psychopy, qualtrics, limesurvey, "
         "psych-ds, prereg, checklist (did you mean jspsych?)"),
        (["export", "kit", "--to", "jspsych", "-o", "study.yaml"], "-o study.yaml: is a file; expected a folder"),
        (["export", "kit", "--to", "prereg", "--responses", "a.csv"], "--responses: prereg contains no answers; "
         "expected --to psych-ds"),
    ],
)  # fmt: skip
def test_invalid_input_gives_one_line_and_exit_code_2(kit, arguments, message, capsys) -> None:
    assert main(["study", *arguments]) == 2
    assert capsys.readouterr() == ("", message + "\n")


def test_build_shows_frame_progress_on_a_terminal() -> None:
    said = on_a_terminal("study", "build", "study.yaml", "-o", "kit", "--participants", "6").decode()
    assert "frames" in said
    assert "30/30" in said
    assert "kit: 6 videos, orders for 6 participants" in said


def test_audit_without_orders_prints_no_order_table(kit, capsys) -> None:
    (kit / "orders.csv").unlink()
    assert main(["study", "audit", str(kit)]) == 1
    assert "Orders:" not in capsys.readouterr().out
