"""Commands in special environments: notebooks, containers without a home, closed streams, existing files."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from emovid.cli.main import main
from emovid.scene.load import load_scene, moved_scene

CASES = Path(__file__).parent / "cases"
EMOVID = [sys.executable, "-m", "emovid"]
SMALL = ["--size", "96x64", "--fps", "5", "--duration", "0.4"]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in a folder with a small scene."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(CASES / "ring.yaml", tmp_path)
    return tmp_path


def run(*arguments: str, **options: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([*EMOVID, *arguments], capture_output=True, text=True, check=False, **options)


# --- processes --------------------------------------------------------------------------------------------------------


def test_notebook_backend_is_ignored() -> None:
    environment = os.environ | {"MPLBACKEND": "module://matplotlib_inline.backend_inline"}
    for arguments in (["render", "ring.yaml", "-q"], ["figures", "frames", "ring.yaml", "-q"]):
        done = run(*arguments, env=environment)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("home", ["a file", "missing"])
def test_unwritable_home_gives_no_messages(home, tmp_path) -> None:
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("XDG_", "MPL", "HOME"))}
    environment |= {"TMPDIR": str(tmp_path)}
    (tmp_path / "file").touch()  # which even root cannot use as a folder
    environment["HOME"] = str(tmp_path / "file") if home == "a file" else "/proc/none"
    done = run("figures", "gritsbot", "--format", "png", "-q", env=environment)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    (cache,) = tmp_path.glob("emovid-*")
    assert cache.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("closed", ["2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_closed_standard_streams_do_not_corrupt_files(closed, tmp_path) -> None:
    command = " ".join([*EMOVID, "render", "ring.yaml", "-o", "x.mp4", *SMALL])
    done = subprocess.run(["/bin/sh", "-c", f"{command} {closed}"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert run("render", "ring.yaml", "-o", "y/x.mp4", *SMALL).returncode == 0
    assert Path("x.mp4").read_bytes() == Path("y/x.mp4").read_bytes()


def test_command_continues_after_its_message_reader_exits() -> None:
    ours, theirs = os.pipe()
    os.close(ours)
    done = subprocess.run([*EMOVID, "render", "ring.yaml", "-o", "x.mp4", *SMALL], stderr=theirs, check=False)
    os.close(theirs)
    assert done.returncode == 0
    assert Path("x.mp4").stat().st_size > 0
    ours, theirs = os.pipe()
    os.close(ours)
    done = subprocess.run([*EMOVID, "render", "none.yaml"], stderr=theirs, check=False)
    os.close(theirs)
    assert done.returncode == 2


def test_wrong_ffmpeg_environment_variable_is_named() -> None:
    done = run("render", "ring.yaml", "-o", "a.mp4", env=os.environ | {"IMAGEIO_FFMPEG_EXE": "/opt/gone/ffmpeg"})
    assert done.returncode == 1
    assert (
        "/opt/gone/ffmpeg: no such file or directory: IMAGEIO_FFMPEG_EXE names it: unset this variable" in done.stderr
    )


def test_system_limits_are_not_reported_as_ffmpeg_errors() -> None:
    command = " ".join([*EMOVID, "render", "ring.yaml", "-o", "a.mp4"])
    done = subprocess.run(["/bin/sh", "-c", f"ulimit -n 8; {command}"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "too many open files" in done.stderr
    assert "imageio" not in done.stderr.partition("too many open files")[2]


@pytest.mark.parametrize(
    "arguments",
    [
        ["scene", "check", "closed/ring.yaml"],
        ["render", "ring.yaml", "-o", "closed/x.mp4"],
        ["simulate", "ring.yaml", "-o", "closed/x.csv"],
        ["figures", "gritsbot", "-o", "closed/figures"],
    ],
)
def test_missing_permissions_give_the_same_exit_code(arguments, tmp_path, monkeypatch, capsys) -> None:
    def deny(path: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    (tmp_path / "closed").mkdir()
    shutil.copy("ring.yaml", "closed")
    for method in ("open", "read_bytes", "read_text") if "check" in arguments else ("mkdir",):
        monkeypatch.setattr(Path, method, deny)
    assert main(arguments) == 1
    assert "permission denied" in capsys.readouterr().err


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_manifest_of_a_web_page_is_kept(capsys) -> None:
    Path("site").mkdir()
    Path("site/manifest.json").write_text('{"short_name": "App", "start_url": "."}\n')
    assert main(["render", "ring.yaml", "-o", "site/clip.mp4"]) == 2
    problem = "was not written by emovid; move it, or choose another folder"
    assert capsys.readouterr().err == f"site/manifest.json: {problem}\n"
    assert Path("site/manifest.json").read_text() == '{"short_name": "App", "start_url": "."}\n'
    assert [path.name for path in Path("site").iterdir()] == ["manifest.json"]


def test_image_sequence_follows_a_symbolic_link(tmp_path) -> None:
    (tmp_path / "disk" / "ring").mkdir(parents=True)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "ring").symlink_to("../disk/ring")
    for force in ([], ["--force"]):
        assert main(["render", "ring.yaml", "-o", "out", "--format", "png-sequence", "-q", *force]) == 0
        assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["manifest.json", "ring"]
        assert (tmp_path / "out" / "ring").is_symlink()
        assert len(list((tmp_path / "disk" / "ring").iterdir())) == 5


@pytest.mark.parametrize(
    ("command", "name"),
    [
        ("render ring.yaml", "x.ogv"), ("render ring.yaml", "x.jpg"), ("render ring.yaml", "x.zip"),
        ("preview ring.yaml", "x.pdf"), ("simulate ring.yaml", "x.parquet"), ("export robotarium anger", "x.m"),
        ("figures gritsbot", "x.tiff"), ("sweep look_ahead_and_gain", "x.csv"), ("render ring.yaml", "-"),
        ("study build study.yaml", "x.zip"), ("study analyze x.csv", "x.pdf"), ("study simulate", "x.xlsx"),
        ("study export kit --to jspsych", "x.html"), ("study responses kit", "x.json"), ("study build study.yaml", "-"),
        ("study analyze x.csv", "-"), ("study export kit --to jspsych", "-"), ("preview ring.yaml", "-"),
        ("sweep look_ahead_and_gain", "-"), ("figures gritsbot", "-"),
    ],
)  # fmt: skip
def test_output_that_is_not_a_folder_is_refused_before_writing(command, name, capsys) -> None:
    assert main([*command.split(), "-o", name]) == 2
    assert capsys.readouterr().err.startswith(f"-o {name}: ")
    assert sorted(path.name for path in Path().iterdir()) == ["ring.yaml"]


def test_folder_that_cannot_be_written_to_is_named(monkeypatch, capsys) -> None:
    make = Path.mkdir

    def deny(path: Path, *given: object, **options: object) -> None:
        if path.name.startswith("."):  # the folder of unfinished results
            raise PermissionError(13, "Permission denied", str(path))
        make(path, *given, **options)

    monkeypatch.setattr(Path, "mkdir", deny)
    assert main(["render", "ring.yaml", "-o", "out/x.mp4", *SMALL]) == 1
    assert capsys.readouterr().err == "out: cannot be written to: permission denied: choose another folder\n"


@pytest.mark.parametrize("name", ["results.v2", "2024.11.30", "a.b c"])
def test_folder_names_may_contain_a_dot(name) -> None:
    assert main(["simulate", "ring.yaml", "-o", name, "-q"]) == 0
    assert Path(name, "ring.npz").is_file()


def test_dash_as_output_prints_tables(capsysbinary) -> None:
    assert main(["simulate", "ring.yaml", "-o", "ring.csv", "-q"]) == 0
    assert main(["simulate", "ring.yaml", "-o", "-", "-q"]) == 0
    assert capsysbinary.readouterr().out == Path("ring.csv").read_bytes()
    assert main(["study", "simulate", "-o", "answers.csv", "-q"]) == 0
    assert main(["study", "simulate", "-o", "-", "-q"]) == 0
    assert capsysbinary.readouterr().out == Path("answers.csv").read_bytes()
    assert main(["measure", "ring.yaml", "--only", "speed", "-o", "speeds.csv", "-q"]) == 0
    assert main(["measure", "ring.yaml", "--only", "speed", "-o", "-"]) == 0
    assert capsysbinary.readouterr().out == Path("speeds.csv").read_bytes()
    assert main(["scene", "new", "-", "--from", "ring.yaml"]) == 0
    assert capsysbinary.readouterr().out == Path("ring.yaml").read_bytes()


@pytest.mark.parametrize(
    ("command", "other", "name"),
    [
        ("simulate ring.yaml -o x.csv", "--duration 0.4", "x.csv exists with other content"),
        ("simulate ring.yaml -o x.npz", "--duration 0.4", "x.npz exists with other settings (duration)"),
        ("study simulate -o x.csv --participants 3", "--seed 2", "x.csv exists with other content"),
        ("export robotarium anger -o x.py", "--seed 5", "x.py exists with other content"),
        ("preview ring.yaml -o x.gif", "--set robots=4", "x.gif exists with other content"),
        ("measure ring.yaml --only speed_mean -o x.csv -q", "--set robots=4", "x.csv exists with other content"),
    ],
)
def test_file_with_other_content_is_replaced_only_with_force(command, other, name, capsys) -> None:
    target = Path(name.partition(" ")[0])
    assert main(command.split()) == 0
    assert main(command.split()) == 0
    before = target.read_bytes()
    capsys.readouterr()
    assert main([*command.split(), *other.split()]) == 2
    assert capsys.readouterr().err == f"{name}; use --force to overwrite it, or -o\n"
    assert target.read_bytes() == before
    assert main([*command.split(), *other.split(), "--force"]) == 0
    assert target.read_bytes() != before


def test_a_file_that_is_not_a_trajectory_is_kept(capsys) -> None:
    Path("x.npz").write_bytes(b"mine")
    assert main(["simulate", "ring.yaml", "-o", "x.npz"]) == 2
    expected = "x.npz: was not written by emovid; use --force to overwrite it, or -o\n"
    assert capsys.readouterr().err == expected
    assert Path("x.npz").read_bytes() == b"mine"


@pytest.mark.parametrize(
    ("part", "problem"),
    [(slice(8, None), "t begins at 0.264, expected 0"), (slice(0, -4), "t ends at 0.396, expected the duration, 0.5")],
)
def test_truncated_run_is_refused_by_name(part, problem, capsys) -> None:
    assert main(["simulate", "ring.yaml", "-o", "run.npz", "-q"]) == 0
    with np.load("run.npz") as arrays:
        kept = {name: array[part] if array.ndim else array for name, array in arrays.items()}
    np.savez("cut.npz", **kept)
    assert main(["render", "cut.npz", "-o", "cut.mp4"]) == 2
    assert capsys.readouterr().err == f"cut.npz: not a complete run: {problem}\n"


def test_csv_of_a_run_is_not_read_as_a_scene(capsys) -> None:
    assert main(["simulate", "ring.yaml", "-o", "run.csv", "-q"]) == 0
    assert main(["render", "run.csv", "-o", "a.mp4"]) == 2
    expected = "run.csv: is a table; expected a scene (.yaml), or a run as emovid simulate -o RUN.npz\n"
    assert capsys.readouterr().err == expected


# --- scenes -----------------------------------------------------------------------------------------------------------


def test_tab_before_a_comment_is_accepted() -> None:
    assert load_scene(CASES / "tab.yaml").seed == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["yes.yaml"], "yes.yaml:24: video.overlays.clock: 'yes': expected true or false (did you mean true?)"),
        (["ring.yaml", "--set", "video.overlays.clock=1"], "--set video.overlays.clock=1: video.overlays.clock: 1: "
                                                           "expected true or false (did you mean true?)"),
        (["ring.yaml", "--set", "l=0.02"], "--set l=0.02: l: unknown key (did you mean robot.l?)"),
        (["ring.yaml", "--set", "fps=5"], "--set fps=5: fps: unknown key (did you mean video.fps?)"),
        (["ring.yaml", "--set", "robot.l=0.5"], "--set robot.l=0.5: robot.l: 0.5: robot 2 would start at (0.0916, "
                                                "0.551), off the stage, this far behind its point on the contour"),
        (["ring.yaml", "--seed", "1e3"], "--seed 1e3: expected a whole number (did you mean 1000?)"),
        (["ring.yaml", "--seed", "-1"], "--seed -1: expected a whole number, at least 0 (did you mean 0?)"),
    ],
)  # fmt: skip
def test_error_in_a_scene_names_a_valid_value(arguments, message, capsys) -> None:
    shutil.copy(CASES / "yes.yaml", ".")
    assert main(["scene", "check", *arguments]) == 2
    assert capsys.readouterr().err == message + "\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("render ring.yaml --fps 29.97", "--fps 29.97: expected a whole number (did you mean 30?)"),
        ("study power --rate 50", "--rate 50: expected a number, at least 0 and at most 1 (did you mean 0.5?)"),
        ("study power --rate half", "--rate half: expected a number, at least 0 and at most 1"),
        (
            "study power --choices 1",
            "--choices 1: expected a whole number, at least 2 and at most 12 (did you mean 2?)",
        ),
        ("figures anger", "anger: no such figure (did you mean anger-frames?); --list shows them"),
        ("render ring.yaml -o foo.mov", "-o foo.mov: cannot write .mov; expected .mp4, or a folder"),
    ],
)  # fmt: skip
def test_error_in_an_option_names_a_valid_value(arguments, message, capsys) -> None:
    assert main(arguments.split()) == 2
    assert capsys.readouterr().err == message + "\n"


def test_control_period_as_long_as_the_run_gives_a_warning(capsys) -> None:
    assert main(["scene", "check", "ring.yaml", "--set", "control_period=0.5"]) == 0
    expected = "warning: control_period: 0.5 s is as long as the run: every robot keeps its first command\n"
    assert capsys.readouterr().err == expected
    assert main(["scene", "check", "ring.yaml", "--set", "control_period=0.4"]) == 0
    assert capsys.readouterr().err == ""


def test_a_copied_scene_finds_its_robot(capsys) -> None:
    shutil.copy(CASES / "own.yaml", ".")
    shutil.copy(CASES / "puck.yaml", ".")
    assert main(["scene", "new", "sub/copy.yaml", "--from", "own.yaml"]) == 0
    assert main(["scene", "new", "beside.yaml", "--from", "own.yaml"]) == 0
    assert main(["scene", "diff", "sub/copy.yaml", "own.yaml"]) == 0
    assert Path("beside.yaml").read_bytes().partition(b"\n")[2] == Path("own.yaml").read_bytes()
    moved = moved_scene(Path("own.yaml").read_text(), Path("own.yaml"), Path("sub/copy.yaml"))
    assert moved == Path("own.yaml").read_text().replace("puck.yaml", "../puck.yaml", 1)


def test_robot_path_in_an_option_is_relative_to_the_working_folder() -> None:
    shutil.copy(CASES / "puck.yaml", ".")
    Path("sub").mkdir()
    shutil.copy("ring.yaml", "sub")
    assert main(["scene", "check", "sub/ring.yaml", "--set", "robot.model=puck.yaml"]) == 0
