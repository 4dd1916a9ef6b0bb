import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from emovid.cli.main import main
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene, shipped_scene
from emovid.swarm.simulate import simulate
from emovid.swarm.summary import summarize
from tests.helpers.terminal import on_a_terminal

EMOVID = [sys.executable, "-m", "emovid"]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


# --- emovid simulate -------------------------------------------------------------------------------------------------


def test_simulate_writes_the_run_of_a_scene(capsys) -> None:
    assert main(["simulate", "--emotion", "fear", "-o", "runs/fear.npz", "--seed", "4", "--set", "duration=2"]) == 0
    assert capsys.readouterr().err == "runs/fear.npz: 15 robots, 9 samples in 2 s\n"
    with np.load("runs/fear.npz") as arrays:
        poses, scene = arrays["poses"], str(arrays["scene"])
    assert "seed: 4" in scene
    Path("again.yaml").write_text(scene)
    assert np.array_equal(simulate(load_scene("again.yaml")).poses, poses)


def test_simulate_names_its_file_by_the_scene() -> None:
    main(["scene", "new", "mine.yaml"])
    assert main(["simulate", "mine.yaml", "--quiet", "--set", "duration=1"]) == 0
    assert main(["simulate", "mine.yaml", "--quiet", "--set", "duration=1", "-o", "folder"]) == 0
    assert Path("mine.npz").read_bytes() == Path("folder/mine.npz").read_bytes()


def test_simulate_reports_as_json(capsys) -> None:
    assert main(["simulate", "sadness", "-o", "x.csv", "--json", "--set", "duration=1"]) == 0
    said = capsys.readouterr()
    facts = json.loads(said.out)
    assert facts["file"] == "x.csv"
    assert facts["trajectory_sha256"] == simulate(load_scene("sadness").model_copy(update={"duration": 1.0})).digest()
    assert said.err == ""


def test_simulate_refuses_files_it_cannot_write(tmp_path, capsys) -> None:
    for suffix in (".mat", ".xlsx", ".yaml"):
        assert main(["simulate", "sadness", "-o", f"x{suffix}"]) == 2
        assert capsys.readouterr().err == f"-o x{suffix}: cannot write {suffix}; expected .npz or .csv, or a folder\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["scene check", "scene show", "simulate", "preview", "check-platform"])
def test_a_finished_run_in_place_of_a_scene_is_reported(command, capsys) -> None:
    Path("run.npz").write_bytes(b"PK")
    assert main([*command.split(), "run.npz"]) == 2
    assert capsys.readouterr().err == "run.npz: is a finished run; expected a scene (.yaml) or an emotion\n"
    assert main([*command.split(), "none.npz"]) == 2
    assert capsys.readouterr().err.startswith("none.npz: no such file")


# --- emovid scene ----------------------------------------------------------------------------------------------------


def test_scene_list_shows_the_six_emotions(capsys) -> None:
    assert main(["scene", "list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(EMOTIONS)
    assert main(["scene", "list", "--json"]) == 0
    assert [row["emotion"] for row in json.loads(capsys.readouterr().out)] == list(EMOTIONS)


def test_scene_show_prints_the_file_with_comments(capsys) -> None:
    assert main(["scene", "show", "anger"]) == 0
    assert capsys.readouterr().out == shipped_scene("anger").read_text()
    assert main(["scene", "show", "anger", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == load_scene("anger").resolved()


EDITOR_LINE = "# yaml-language-server: $schema=emovid-scene.schema.json\n"


def test_scene_new_copies_and_never_overwrites(capsys) -> None:
    assert main(["scene", "new", "deep/my.yaml", "--from", "disgust"]) == 0
    assert Path("deep/my.yaml").read_text() == EDITOR_LINE + shipped_scene("disgust").read_text()
    Path("deep/my.yaml").write_text("mine")
    capsys.readouterr()
    assert main(["scene", "new", "deep/my.yaml"]) == 2
    assert capsys.readouterr().err == "deep/my.yaml: exists; use --force to overwrite it\n"
    assert Path("deep/my.yaml").read_text() == "mine"
    assert main(["scene", "new", "deep/my.yaml", "--force"]) == 0
    assert Path("deep/my.yaml").read_text() == EDITOR_LINE + shipped_scene("happiness").read_text()


def test_scene_new_can_be_quiet(capsys) -> None:
    assert main(["scene", "new", "my.yaml", "--quiet"]) == 0
    assert Path("my.yaml").read_text() == EDITOR_LINE + shipped_scene("happiness").read_text()
    assert capsys.readouterr() == ("", "")


def test_scene_new_refuses_a_missing_folder(tmp_path, capsys) -> None:
    (tmp_path / "folder").mkdir()
    for options in ([], ["--force"]):
        assert main(["scene", "new", "folder", *options]) == 2
        assert capsys.readouterr().err == "folder: is a folder; expected a file\n"


def test_a_scene_from_a_pipe_is_shown_and_copied() -> None:
    text = shipped_scene("fear").read_bytes()
    for command, shown in (
        (["scene", "show", "/dev/stdin"], text),
        (["scene", "new", "x.yaml", "--from", "/dev/stdin"], b""),
    ):
        assert subprocess.run([*EMOVID, *command], input=text, stdout=subprocess.PIPE, check=True).stdout == shown
    assert Path("x.yaml").read_bytes() == EDITOR_LINE.encode() + text


def test_scene_check_reports_the_run(capsys) -> None:
    assert main(["scene", "check", "anger", "--json", "--set", "duration=3"]) == 0
    found = json.loads(capsys.readouterr().out)
    expected = summarize(simulate(load_scene("anger").model_copy(update={"duration": 3.0})))
    assert found["body_distance"] == expected.body_distance
    assert found["stage_cut_share"] == expected.stage_cut_share
    assert main(["scene", "check", "anger", "--set", "duration=3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "anger: valid"
    assert f"{1000 * expected.body_distance:.1f} mm" in lines[3]


def test_scene_check_reports_overlapping_bodies(capsys) -> None:
    keys = ["--set", "behaviour.separation=null", "--set", "duration=10", "--seed", "1"]
    assert main(["scene", "check", "anger", *keys]) == 0
    assert "(they overlap)" in capsys.readouterr().out


def test_a_new_scene_comes_with_the_schema_that_its_first_line_names(capsys) -> None:
    assert main(["scene", "new", "deep/my.yaml"]) == 0
    first, _, rest = Path("deep/my.yaml").read_text().partition("\n")
    schema = Path("deep", first.partition("$schema=")[2])
    assert main(["scene", "schema"]) == 0
    assert schema.read_text() == capsys.readouterr().out
    assert main(["scene", "new", "deep/copy.yaml", "--from", "deep/my.yaml"]) == 0
    assert Path("deep/copy.yaml").read_text() == f"{first}\n{rest}"  # one line for the editor, not two


@pytest.mark.parametrize("content", ['{"title": "other"}', "[]", "not JSON"])
def test_a_schema_of_another_program_is_never_replaced(content, capsys) -> None:
    schema = Path("emovid-scene.schema.json")
    schema.write_text(content)
    assert main(["scene", "new", "my.yaml", "--force"]) == 2
    expected = f"{schema}: was not written by emovid; move it, or choose another folder\n"
    assert capsys.readouterr().err == expected
    assert (schema.read_text(), Path("my.yaml").exists()) == (content, False)


def test_a_schema_of_an_older_version_is_replaced() -> None:
    schema = Path("emovid-scene.schema.json")
    schema.write_text('{"title": "emovid scene"}')
    assert main(["scene", "new", "my.yaml"]) == 0
    assert "properties" in json.loads(schema.read_text())


def test_scene_schema_accepts_the_shipped_scenes(capsys) -> None:
    assert main(["scene", "schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    jsonschema.validate(load_scene("anger").resolved(), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(load_scene("anger").resolved() | {"colour": 1}, schema)


# --- the command -----------------------------------------------------------------------------------------------------


def test_version_option_and_python_m_emovid(capsys) -> None:
    assert main(["--version"]) == 0
    said = capsys.readouterr().out
    module = subprocess.run([*EMOVID, "--version"], capture_output=True, text=True, check=True)
    assert said == module.stdout == "emovid 0.1.0\n"


def test_help_imports_no_slow_packages() -> None:
    for command in ([], ["scene"], ["study"]):
        shown = subprocess.run(
            [sys.executable, "-X", "importtime", "-m", "emovid", *command, "--help"],
            capture_output=True,
            text=True,
            check=True,
        )
        modules = {line.split("|")[-1].strip().split(".")[0] for line in shown.stderr.splitlines()}
        assert "typer" in modules
        assert not modules & {"numpy", "scipy", "matplotlib", "pandas", "yaml", "imageio_ffmpeg"}


@pytest.mark.parametrize(
    "command",
    [
        ["render"],
        ["simulate"],
        ["scene", "list"],
        ["scene", "show"],
        ["scene", "check"],
        ["scene", "new"],
        ["scene", "schema"],
    ],
)
def test_every_command_has_help(capsys, command) -> None:
    assert main([*command, "--help"]) == 0
    assert "Usage: emovid " + " ".join(command) in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [["foo"], ["scene", "foo"], ["scene", "show"], ["render", "--fps", "x"]])
def test_wrong_usage_gives_a_one_line_message(capsys, arguments) -> None:
    assert main(arguments) == 2
    said = capsys.readouterr()
    assert len(said.err.splitlines()) == 1
    assert said.out == ""


def test_closed_output_pipe_is_not_an_error() -> None:
    with subprocess.Popen([*EMOVID, "scene", "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stderr
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 1


def test_terminal_shows_a_bar_and_the_same_last_lines(tmp_path) -> None:
    size = ["--size", "320x180", "--set", "duration=6"]
    text = on_a_terminal("render", "sadness", "-o", str(tmp_path), *size).decode()
    assert "/180" in text  # the bar counts frames
    assert f"[1/1] {tmp_path}/sadness.mp4: 180 frames" in text.replace("\r\n", "")
    assert "rendered 1 in" in text
