"""Conventions of all commands: option names, help, exit codes, colors, completion."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from emovid.cli.main import all_commands, app, main
from emovid.scene.emotions import EMOTIONS
from tests.helpers.terminal import on_a_terminal

EMOVID = [sys.executable, "-m", "emovid"]
# Like the installed script: completion needs the name of the program.
LAUNCH = [sys.executable, "-c", "import sys; sys.argv[0] = 'emovid'; from emovid.cli.main import run; run()"]
DOCS = Path(__file__).parent.parent.parent / "docs"
ANSI_COLOUR = re.compile(rb"\x1b\[[0-9;]*3[0-9]")


def walk(command: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Yield every command with its name, as in "scene diff"."""
    if hasattr(command, "commands"):
        for name, inner in command.commands.items():
            yield from walk(inner, (*path, name))
    else:
        yield " ".join(path), command


COMMANDS = dict(walk(all_commands()))
OPTIONS = [
    (name, option)
    for name, command in COMMANDS.items()
    for option in command.params
    if option.param_type_name == "option" and option.name != "help"
]
each_command = pytest.mark.parametrize(("name", "command"), COMMANDS.items(), ids=list(COMMANDS))

# Each short option has one meaning in all commands.
SHORT = {
    "--all": "-a",
    "--dry-run": "-n",
    "--emotion": "-e",
    "--force": "-f",
    "--jobs": "-j",
    "--list": "-l",
    "--output": "-o",
    "--platform": "-p",
    "--quiet": "-q",
    "--watch": "-w",
}
# Options shared by commands have the same help text.
SHARED = ("--force", "--jobs", "--set", "--emotion")


def test_command_list_shows_the_help_line_of_each_command() -> None:
    listed = dict(walk(get_command(app)))
    assert {name: command.help for name, command in listed.items()} == {
        name: " ".join(command.help.split("\n\n")[0].split()) for name, command in COMMANDS.items()
    }


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["study", "--help"], ["rendr"]])
def test_command_list_imports_no_command_module(arguments) -> None:
    program = f"import sys; from emovid.cli.main import main; main({arguments}); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    ours = {name for name in done.stdout.splitlines()[-1].split() if name.startswith("emovid")}
    assert ours - {"emovid.version"} == {
        *("emovid", "emovid.cli", "emovid.cli.environment", "emovid.cli.main", "emovid.errors")
    }


def options(command: Any) -> set[str]:
    return {name for option in command.params for name in option.opts if name.startswith("--")}


# --- options and help -------------------------------------------------------------------------------------------------


def test_options_have_one_long_name_and_a_consistent_short_name() -> None:
    for name, option in OPTIONS:
        long, *short = sorted(option.opts, key=len, reverse=True)
        assert short == [SHORT[long]] if long in SHORT else short == [], (name, option.opts)


@pytest.mark.parametrize("shared", SHARED)
def test_shared_options_have_the_same_help_text(shared) -> None:
    assert len({option.help for _, option in OPTIONS if shared in option.opts}) == 1


def test_json_quiet_and_force_are_flags() -> None:
    for name, option in OPTIONS:
        if {"--json", "--quiet", "--force"} & set(option.opts):
            assert option.is_flag, name
        if "--quiet" in option.opts:
            assert option.help.startswith("Print only "), name


@each_command
def test_every_command_that_writes_has_quiet(name, command) -> None:
    if "--output" in options(command) or "--force" in options(command):
        assert "--quiet" in options(command)


@each_command
def test_every_command_documents_purpose_options_and_examples(name, command) -> None:
    summary = command.help.split("\n\n")[0]
    assert re.fullmatch(r"[A-Z].*[.]", " ".join(summary.split()))
    for option in command.params:
        if option.name != "help":
            assert re.fullmatch(r"[A-Za-z0-9].*[.:)]", option.help), (name, option.name)
    assert examples(command), name


def examples(command: Any) -> list[str]:
    found = re.search(r"Examples?: (.*)", command.help, re.DOTALL)
    return [" ".join(example.split()) for example in found[1].split(" · ")] if found else []


@each_command
def test_examples_of_a_command_call_it_and_parse(name, command) -> None:
    for example in examples(command):
        words = shlex.split(example.partition(" > ")[0])
        own = ["emovid", *name.split()]
        assert words[: len(own)] == own
        command.make_context(name, words[len(own) :])


@each_command
def test_help_has_a_long_and_a_short_option(name, command, capsys) -> None:
    shown = []
    for flag in ("--help", "-h"):
        assert main([*name.split(), flag]) == 0
        shown.append(capsys.readouterr().out)
    assert shown[0] == shown[1]
    assert f"Usage: emovid {name}" in shown[0]


# --- exit codes -------------------------------------------------------------------------------------------------------


def test_exit_codes_are_documented_in_the_help_and_in_the_docs(capsys) -> None:
    text = (DOCS / "exit-codes.md").read_text()
    assert re.findall(r"^\| (\d+) \|", text, re.MULTILINE) == ["0", "1", "2", "130", "143"]
    assert main(["--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert all(code in said[said.index("Exit codes") :] for code in ("0", "1", "2", "130", "143"))


def test_every_command_with_findings_is_in_the_exit_code_table() -> None:
    listed = set(
        re.findall(r"^\| `emovid ([a-z -]+?)(?: --\w+)?` \|", (DOCS / "exit-codes.md").read_text(), re.MULTILINE)
    )
    texts = {name: command.help + "".join(o.help or "" for o in command.params) for name, command in COMMANDS.items()}
    assert listed == {name for name, text in texts.items() if re.search("[Ee]xits? with 1", " ".join(text.split()))}


@each_command
def test_unknown_option_gives_one_line_and_exit_code_2(name, command, capsys) -> None:
    assert main([*name.split(), "--no-such-option"]) == 2
    said = capsys.readouterr()
    assert (said.out, len(said.err.splitlines())) == ("", 1)


@pytest.mark.parametrize(
    ("raised", "code", "message"),
    [
        (KeyboardInterrupt, 130, "interrupted: run again to make what is missing\n"),
        (MemoryError, 1, "not enough memory: fewer robots, a longer control_period or a shorter duration need less\n"),
    ],
)
def test_external_causes_of_termination_give_a_one_line_message(
    raised, code, message, tmp_path, monkeypatch, capsys
) -> None:
    def simulate(*_: object) -> None:
        raise raised

    monkeypatch.setattr("emovid.cli.render.simulate_scene", simulate)
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "fear"]) == code
    assert capsys.readouterr().err == message
    assert list(tmp_path.iterdir()) == []


TOO_LONG = 300 * "x"


@pytest.mark.parametrize(
    "command",
    [
        f"render fear -o {TOO_LONG}",
        f"render fear -o {TOO_LONG}.mp4",
        f"preview fear -o {TOO_LONG}",
        f"simulate fear -o {TOO_LONG}",
        f"measure fear -o {TOO_LONG}.csv",
        f"sweep {TOO_LONG}",
        f"sweep look_ahead_and_gain -o {TOO_LONG}",
        f"status {TOO_LONG}",
        f"verify {TOO_LONG}",
        f"figures shapes -o {TOO_LONG}",
        f"figures circumplex --study {TOO_LONG}",
        f"export robotarium anger -o {TOO_LONG}",
        f"scene new {TOO_LONG}",
        f"scene show {TOO_LONG}",
        f"study analyze {TOO_LONG}",
        f"study columns {TOO_LONG}",
        f"study compare {TOO_LONG} {TOO_LONG}",
        f"study simulate -o {TOO_LONG}",
        f"study build {TOO_LONG}",
        f"study audit {TOO_LONG}",
        f"study export {TOO_LONG} --to jspsych",
        f"study serve {TOO_LONG}",
        f"study responses {TOO_LONG}",
    ],
)
def test_invalid_file_name_gives_one_line_and_writes_no_file(command, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(command.split()) in (1, 2)
    said = capsys.readouterr()
    assert re.fullmatch(rf"[^\n]*{TOO_LONG}[^\n]*: file name too long\n", said.err)
    assert said.out == ""
    assert list(tmp_path.iterdir()) == []


def test_file_name_that_is_not_unicode_can_be_shown(tmp_path) -> None:
    name = b"caf\xe9.yaml"
    (tmp_path / os.fsdecode(name)).write_bytes((DOCS.parent / "configs" / "fear.yaml").read_bytes())
    for command in ("scene check", "measure"):
        arguments = [*EMOVID, *command.split(), name, "--set", "duration=1"]
        done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, check=True)
        assert b"caf" in done.stdout


def test_help_can_be_shown_in_any_encoding() -> None:
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    shown = subprocess.run([*EMOVID, "render", "--help"], env=environment, capture_output=True, check=True).stdout
    assert b"--overlay" in shown


# --- colors -----------------------------------------------------------------------------------------------------------


def test_colors_are_used_on_terminals_unless_disabled() -> None:
    assert ANSI_COLOUR.search(on_a_terminal("render", "--help"))
    assert not ANSI_COLOUR.search(on_a_terminal("render", "--help", NO_COLOR="1"))
    plain = {key: value for key, value in os.environ.items() if key not in ("FORCE_COLOR", "GITHUB_ACTIONS")}
    piped = subprocess.run([*EMOVID, "render", "--help"], capture_output=True, env=plain, check=True)
    assert b"\x1b" not in piped.stdout


def test_results_on_a_terminal_have_no_colors_when_disabled(tmp_path) -> None:
    render = ["render", "sadness", "--size", "96x64", "--set", "duration=2", "-o", str(tmp_path)]
    for arguments in (render, ["measure", "sadness", "--set", "duration=8"]):
        said = on_a_terminal(*arguments, NO_COLOR="1")
        assert said
        assert not ANSI_COLOUR.search(said), arguments


# --- completion -------------------------------------------------------------------------------------------------------


def completed(line: str, cwd: Path) -> list[str]:
    """Return the completions of bash for the last word of a line."""
    words = line.split(" ")
    said, complained = StringIO(), StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(said), redirect_stderr(complained):
        patch.chdir(cwd)
        patch.setenv("_EMOVID_COMPLETE", "complete_bash")
        patch.setenv("COMP_WORDS", line)
        patch.setenv("COMP_CWORD", str(len(words) - 1))
        with pytest.raises(SystemExit, match="0"):
            main([])
    assert complained.getvalue() == ""
    return said.getvalue().split()


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with two scenes, a run, and other files."""
    folder = tmp_path_factory.mktemp("work")
    (folder / "scenes").mkdir()
    for name in ("angles.yaml", "scenes/mine.yaml", "run.npz", "notes.txt", ".hidden.yaml"):
        (folder / name).touch()
    return folder


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("emovid prev", ["preview"]),
        ("emovid scene d", ["diff"]),
        ("emovid render --emotion ", list(EMOTIONS)),
        ("emovid render --emotion s", ["surprise", "sadness"]),
        ("emovid preview an", ["anger", "angles.yaml"]),
        ("emovid preview s", ["surprise", "sadness", "scenes/"]),
        ("emovid scene diff anger scenes/", ["scenes/mine.yaml"]),
        ("emovid scene new x.yaml --from d", ["disgust"]),
        ("emovid render r", ["run.npz"]),
        ("emovid simulate r", []),
        ("emovid measure run", ["run.npz"]),
        ("emovid measure fear --only hull_area_share_s", ["hull_area_share_start"]),
        ("emovid measure fear --only cusps,spa", ["cusps,sparc"]),
        ("emovid preview nowhere/", []),
        ("emovid preview ~nobody-of-this-name/", []),
        ("emovid render --theme ", ["light", "dark"]),
        ("emovid render fear --overlay c", ["cells", "clock"]),
        ("emovid figures dens", ["densities"]),
        ("emovid figures frames an", ["anger-frames", "anger", "angles.yaml"]),
        ("emovid study export kit --to ps", ["psychopy", "psych-ds"]),
        ("emovid sweep lo", ["look_ahead_and_gain"]),
        ("emovid sweep an", ["angles.yaml"]),
    ],
)
def test_bash_completes_words(folder, line, expected) -> None:
    assert completed(line, folder) == expected


@pytest.mark.parametrize(
    ("shell", "mark"), [("bash", "complete -o default -F"), ("zsh", "#compdef emovid"), ("fish", "complete --command")]
)
def test_completion_scripts_call_emovid(shell, mark) -> None:
    environment = os.environ | {"_EMOVID_COMPLETE": f"source_{shell}"}
    script = subprocess.run(LAUNCH, env=environment, capture_output=True, text=True, check=True).stdout
    assert mark in script
    assert f"_EMOVID_COMPLETE=complete_{shell}" in script


def test_completion_is_installed_where_bash_finds_it(tmp_path) -> None:
    home = os.environ | {
        "HOME": str(tmp_path),
        "SHELL": "/bin/bash",
        "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1",
    }
    subprocess.run([*EMOVID, "--install-completion", "bash"], env=home, capture_output=True, check=True)
    script = tmp_path / ".bash_completions" / "emovid.sh"
    assert f"source '{script}'" in (tmp_path / ".bashrc").read_text()
    assert "_EMOVID_COMPLETE=complete_bash" in script.read_text()


def test_standard_output_may_be_a_stringio() -> None:
    inside = (
        "import io, sys; sys.stdout = io.StringIO(); sys.argv[1:] = ['scene', 'list'];"
        "from emovid.cli.main import run; run()"
    )
    done = subprocess.run([sys.executable, "-c", inside], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
