"""`emovid status` and `emovid verify`: their output; tests/batch covers the checks themselves."""

import json
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.errors import EmovidError
from tests.helpers.terminal import on_a_terminal

TINY = ["--size", "96x64", "--fps", "5", "--set", "duration=0.4", "--quiet"]


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch) -> None:
    """Work in a folder with two videos."""
    monkeypatch.chdir(tmp_path)
    for emotion in ("fear", "anger"):
        assert main(["render", emotion, *TINY]) == 0


def test_intact_folder_gives_one_summary_line(capsys) -> None:
    for command in (["status"], ["verify"], ["verify", "--rebuild", "--jobs", "1"]):
        assert main([*command, "videos"]) == 0
        assert capsys.readouterr() == ("2 results: 2 current\n", "")


def test_each_problem_gives_one_line_and_exit_code_1(capsys) -> None:
    Path("videos/fear.mp4").unlink()
    assert main(["status", "videos"]) == 1
    assert capsys.readouterr().out.splitlines() == ["missing: fear.mp4", "2 results: 1 current, 1 missing"]
    assert main(["status", "videos", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["counts"] == {"current": 1, "missing": 1}
    assert [(result["name"], result["state"]) for result in found["results"]] == [("fear.mp4", "missing")]


def test_rebuilding_reports_corrupt_files_as_hashes_do(capsys) -> None:
    Path("videos/fear.mp4").write_bytes(b"damaged")
    assert main(["verify", "videos"]) == 1
    by_hash = capsys.readouterr().out
    assert by_hash.startswith("corrupt: fear.mp4")
    assert main(["verify", "videos", "--rebuild", "--jobs", "1"]) == 1
    assert capsys.readouterr().out == by_hash


def test_results_that_cannot_be_rebuilt_give_a_one_line_message(monkeypatch, capsys) -> None:
    def rebuild(*_: object) -> None:
        raise EmovidError("no room")

    monkeypatch.setattr("emovid.batch.check.rebuild", rebuild)
    assert main(["verify", "videos", "--rebuild", "--jobs", "1"]) == 1
    assert capsys.readouterr() == ("", "no room\n")


def test_rebuilding_shows_a_progress_bar_on_a_terminal() -> None:
    said = on_a_terminal("verify", "videos", "--rebuild", "--jobs", "1").decode()
    assert "2/2" in said
    assert "2 results: 2 current" in said
