"""Every command of every page runs, and prints what the page says it prints."""

import json
import os
import re
import shlex
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.main import get_command

from emovid.cli.main import app, main
from emovid.responses.dialects.registry import DIALECTS
from tests.helpers import exports
from tests.helpers.crowd import Crowd
from tests.helpers.pages import DOCS, ROOT, Keys, agrees, in_tables, mentioned, pages, steps
from tests.helpers.served import serving
from tests.helpers.small_survey import small_kit

ENV = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "COLUMNS": "200",
}
REFERENCE = ROOT / "studies" / "santos-egerstedt" / "responses.csv"
SMALL = {"video.size: 1280x720": "size: 320x180", "size: 1280x720": "size: 320x180", "fps: 30": "fps: 5"}
EXAMPLES = {
    "qualtrics": exports.qualtrics,
    "google-forms": exports.google_sheets,
    "microsoft-forms": exports.microsoft,
    "surveymonkey": exports.surveymonkey,
    "limesurvey": exports.limesurvey,
    "jspsych": exports.jspsych,
    "psychopy": exports.psychopy,
    "labjs": exports.labjs,
    "otree": exports.otree_wide,
    "psiturk": exports.psiturk,
    "pymushra": exports.pymushra,
    "formr": exports.formr,
    "revisit": exports.revisit,
    "any-table": exports.generic_long,
    "index": lambda: exports.Export({"reference.csv": REFERENCE.read_bytes()}, "long table"),
}


def small(source: Path) -> str:
    """Return a scene's or a study's file with a video that is made at once."""
    text = source.read_text()
    for large, little in SMALL.items():
        text = text.replace(large, little)
    return text


def given(page: Path, folder: Path) -> dict[str, str]:
    """Put into the folder what a reader of the page has, and return what stands in a page for something of theirs."""
    (folder / "responses.csv").write_bytes(REFERENCE.read_bytes())
    if page.parent.name == "analyse":
        export = EXAMPLES[page.stem]()
        (folder / "key.csv").write_text(exports.KEY)
        (folder / "exports").mkdir()
        for name, data in export.files.items():
            (folder / "exports" / name).write_bytes(data)
        if len(export.files) == 1:
            (folder / "export.csv").write_bytes(*export.files.values())
        return {}
    (folder / "table.csv").write_text("a,b\n1,2\n")
    scene = "robotarium-today/anger" if page.stem == "export-robotarium" else "anger"
    (folder / "my_scene.yaml").write_text(small(ROOT / "configs" / f"{scene}.yaml"))
    (folder / "sweep.yaml").write_text(
        "only: measure\nscenes: [sadness]\nset: {duration: 1}\ngrid: {robot.K: [2, 3]}\n"
    )
    if page.name != "README.md" and "videos/" in page.read_text():
        run("emovid render --all --size 320x180 --fps 5 --set duration=2 --quiet", folder)
    words = {"$SLURM_ARRAY_TASK_ID": "1"}
    return words | {"CODE": code_of_a_participant(folder)} if page.stem == "survey" else words


def code_of_a_participant(folder: Path) -> str:
    """Build a kit, let three take part, and return the code of one."""
    with serving(small_kit(folder)) as server:
        crowd = Crowd(server.address, 3, duration=1.0)
        crowd.start()
        crowd.wait()
    assert crowd.failures == []
    return crowd.people[0].code


def run(line: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Run a command in this process, or in its own where only a signal ends it."""
    command = shlex.split(line)
    assert command[0] == "emovid", line
    if command[1:3] == ["study", "serve"]:
        return started_and_stopped([*command, "--port", "0"], folder)
    return started_and_stopped(command, folder) if "--watch" in command else called(command, folder)


def called(command: list[str], folder: Path) -> "subprocess.CompletedProcess[str]":
    """Return the exit code and the output of a command that is called as a function."""
    out = TextIOWrapper(BytesIO(), encoding="utf-8", write_through=True)
    err = TextIOWrapper(BytesIO(), encoding="utf-8", write_through=True)
    with chdir(folder), redirect_stdout(out), redirect_stderr(err), pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "200")
        code = main(command[1:])
    said, complained = (stream.buffer.getvalue().decode() for stream in (out, err))  # type: ignore[attr-defined]
    return subprocess.CompletedProcess(command, code, said, complained)


def started_and_stopped(command: list[str], folder: Path) -> "subprocess.CompletedProcess[str]":
    """Wait for the first line of a command that only a signal ends, and end it: not by SIGINT, which may be ignored."""
    with subprocess.Popen(
        command, cwd=folder, env=ENV, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as it:
        assert it.stdout
        said = it.stdout.readline()
        it.terminate()
        said += it.stdout.read()
        code = it.wait()
    return subprocess.CompletedProcess(command, 0 if code in (0, 143) else code, said, "")


def write(keys: Keys, folder: Path) -> None:
    path = folder / keys.file
    have = yaml.safe_load(path.read_text()) if path.is_file() else {}
    path.write_text(yaml.safe_dump(merged(have, yaml.safe_load(keys.text))))


def merged(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """Return keys over keys. A group that says what kind it is replaces another kind, as an editor's hand would."""
    result = dict(old)
    for key, value in new.items():
        deeper = isinstance(value, dict) and isinstance(old.get(key), dict) and "kind" not in value
        result[key] = merged(old[key], value) if deeper else value
    return result


def follow(page: Path, folder: Path) -> None:
    """Do what a page says, in a folder with what its reader has."""
    words = given(page, folder)
    for step in steps(page):
        if isinstance(step, Keys):
            write(step, folder)
            continue
        done = run(re.sub("|".join(map(re.escape, words)) or "$^", lambda word: words[word[0]], step.line), folder)
        said = done.stdout + done.stderr
        if step.line.startswith("emovid study new "):  # of which the reader makes their own
            study = folder / step.line.split()[3] / "study.yaml"
            study.write_text(small(study).replace("duration: 15", "duration: 3"))
        if step.printed is None:
            assert done.returncode == 0, f"{step.line}\n{said}"
        else:
            assert agrees(said, step.printed), f"{step.line}\n{said}"
            assert "Traceback" not in said


# The README and the tutorial have tests of their own below.
FOLLOWED = [page for page in pages() if page.stem not in ("README", "tutorial") and any(steps(page))]


@pytest.mark.parametrize("page", FOLLOWED, ids=lambda page: str(page.relative_to(DOCS)))
def test_the_commands_of_a_page_do_what_it_says(page, tmp_path) -> None:
    follow(page, tmp_path)


def test_the_commands_of_the_readme_do_what_it_says(tmp_path) -> None:
    page = ROOT / "README.md"
    follow(page, tmp_path)
    made = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.*")}
    assert {"videos/anger.mp4", "videos/manifest.json", "fear.webm", "out/surprise.gif"} <= made
    assert {"curious.yaml", "previews/curious.gif", "kit/public/manifest.json", "kit/private/key.csv"} <= made
    assert {"figures/densities.pdf", "figures/curious-frames.png", "figures/anger-frames.pdf"} <= made
    assert {"results/report.html", "results/results.json", "results/confusion_matrix.tex"} <= made
    assert 1e6 < (tmp_path / "videos" / "anger.mp4").stat().st_size < 3e6  # as the questions say
    for line in in_tables(page):
        done = run(line, tmp_path)
        assert done.returncode == (1 if " diff " in line else 0), f"{line}\n{done.stdout}{done.stderr}"


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_a_command_that_is_named_in_passing_exists_with_its_options(page) -> None:
    for line in mentioned(page):
        words = shlex.split(line.replace("...", "x"))[1:]
        command = get_command(app)
        while hasattr(command, "commands"):
            if not words or words[0].isupper() or words[0].startswith("-"):  # COMMAND, or an option of all
                break
            assert words[0] in command.commands, line
            command = command.commands[words.pop(0)]
        known = {name for option in command.params for name in option.opts}
        given_options = {word.split("=")[0] for word in words if word.startswith("-")}
        assert given_options <= known | {"--help", "--install-completion", "--show-completion"}, line


def test_the_tutorial_s_emotion_moves_as_it_says(tmp_path) -> None:
    follow(DOCS / "tutorial.md", tmp_path)
    scenes = json.loads(run("emovid measure curious.yaml fear disgust --json", tmp_path).stdout)["scenes"]
    curious, fear, disgust = (scenes[name] for name in ("curious.yaml", "fear", "disgust"))
    assert curious["turning_per_metre"] < fear["turning_per_metre"] / 5
    assert curious["cusps_per_second"] < fear["cusps_per_second"] / 5
    assert curious["speed_mean"] < disgust["speed_mean"]


def test_the_readme_counts_the_tools() -> None:
    of_no_tool = {"emovid survey", "long table", "wide table"}
    assert len({dialect.name for dialect in DIALECTS} - of_no_tool) == len(EXAMPLES) - 2 == 13
    assert "any of thirteen tools" in " ".join((ROOT / "README.md").read_text().split())


def test_every_tool_has_a_page_and_every_page_an_export() -> None:
    assert {page.stem for page in (DOCS / "analyse").glob("*.md")} == set(EXAMPLES)
