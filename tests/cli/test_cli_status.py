"""`emovid status` and `emovid verify`: what they print; what they find is tried in tests/batch."""

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


def test_a_folder_that_is_whole_is_one_line(capsys) -> None:
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


def test_rebuilding_adds_to_what_the_hashes_say_and_hides_none_of_it(capsys) -> None:
    Path("videos/fear.mp4").write_bytes(b"spoilt")
    assert main(["verify", "videos"]) == 1
    by_hash = capsys.readouterr().out
    assert by_hash.startswith("corrupt: fear.mp4")
    assert main(["verify", "videos", "--rebuild", "--jobs", "1"]) == 1
    assert capsys.readouterr().out == by_hash


def test_results_that_cannot_be_rebuilt_give_one_line(monkeypatch, capsys) -> None:
    def rebuild(*_: object) -> None:
        raise EmovidError("no room")

    monkeypatch.setattr("emovid.batch.check.rebuild", rebuild)
    assert main(["verify", "videos", "--rebuild", "--jobs", "1"]) == 1
    assert capsys.readouterr() == ("", "no room\n")


def test_rebuilding_has_a_bar_on_a_terminal() -> None:
    said = on_a_terminal("verify", "videos", "--rebuild", "--jobs", "1").decode()
    assert "2/2" in said
    assert "2 results: 2 current" in said
