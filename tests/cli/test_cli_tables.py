"""The output of commands is complete on narrow terminals and in files."""

import shlex
from collections import Counter
from pathlib import Path

import pytest
from rich.table import Table

from emovid.cli.main import main
from emovid.cli.terminal import show_table
from emovid.scene.emotions import EMOTIONS
from tests.helpers.terminal import on_a_screen

STUDIES = Path(__file__).parents[2] / "studies"
COUNTS = STUDIES / "santos-egerstedt" / "counts.csv"
PRINTING = [
    "measure --all --set duration=0.3 --gate",
    "measure fear anger disgust sadness --set duration=0.3",
    f"study analyze --counts {COUNTS}",
    "study audit kit --unblind",
    f"study compare {COUNTS} {COUNTS}",
    "study power",
    "scene list",
    "scene robots",
    "scene check anger --set duration=0.3",
    "scene diff anger fear",
    "check-platform anger --set duration=1",
    "figures --list",
]


@pytest.fixture(scope="module", autouse=True)
def _folder(tmp_path_factory) -> None:
    """Work in a folder with a kit."""
    text = (STUDIES / "example" / "study.yaml").read_text()
    for large, small in (("size: 1280x720", "size: 160x90"), ("fps: 30", "fps: 5"), ("duration: 15", "duration: 1")):
        text = text.replace(large, small)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("narrow"))
        Path("study.yaml").write_text(text)
        assert main(["study", "build", "study.yaml", "-o", "kit", "--quiet"]) == 0
        yield


@pytest.mark.parametrize("command", PRINTING)
def test_narrow_terminal_shows_every_word_of_the_output(command, monkeypatch, capsys) -> None:
    monkeypatch.setenv("COLUMNS", "40")  # of a terminal, which does not apply to a pipe
    main(shlex.split(command))
    words = Counter(capsys.readouterr().out.replace("─", "").split())
    for columns in (80, 60):
        shown = on_a_screen(columns, shlex.split(command), monkeypatch)
        assert words - Counter(shown.split()) == Counter(), columns


def test_tables_are_not_split_in_files(monkeypatch, capsys) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    assert main(["measure", "--all", "--set", "duration=0.3"]) == 0
    heads = [line for line in capsys.readouterr().out.splitlines() if "descriptor" in line]
    assert [line.split() for line in heads] == [["descriptor", "unit", *EMOTIONS]]


@pytest.mark.parametrize(("columns", "parts"), [(120, [6]), (100, [3, 3]), (80, [3, 3]), (60, [1] * 6)])
def test_wide_tables_are_split_into_the_fewest_parts(columns, parts, monkeypatch) -> None:
    shown = on_a_screen(columns, ["measure", "--all", "--set", "duration=0.3"], monkeypatch).splitlines()
    assert [len(line.split()) - 2 for line in shown if "descriptor" in line] == parts
    assert max(map(len, shown)) <= columns


def test_long_names_are_wrapped_to_the_width_of_the_terminal(monkeypatch) -> None:
    name = "a-scene-whose-name-is-longer-than-the-terminal-is-wide.yaml"
    assert main(["scene", "new", name, "--quiet"]) == 0
    shown = on_a_screen(50, ["measure", name, "--set", "duration=0.3"], monkeypatch)
    assert max(map(len, shown.splitlines())) <= 50
    head = shown.split("speed")[0].splitlines()
    letters = "".join("".join(line.split()) for line in head)
    for part in ("descriptor", "unit"):
        letters = letters.replace(part, "")
    assert name in letters


def test_prose_in_a_table_is_wrapped_between_words(monkeypatch, capsys) -> None:
    sentence = "a warning of more words than a line of this terminal has room for"
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "30")
    monkeypatch.setenv("TERM", "xterm")
    table = Table("warnings")
    table.add_row(sentence)
    show_table(table)
    assert set(sentence.split()) <= set(capsys.readouterr().out.split())
