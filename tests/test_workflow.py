"""The workflow file that users copy: it is what GitHub reads, and each of its commands is one of ours that works."""

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from typer.main import get_command

from emovid.cli.main import app

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "docs" / "ci" / "github-workflow.yml").read_text()
# "on" is true in YAML 1.1, which GitHub does not read its files by.
WORKFLOW = yaml.load(TEXT, Loader=yaml.BaseLoader)  # noqa: S506 - it makes plain text of everything
STEPS = WORKFLOW["jobs"]["make"]["steps"]
LINES = [line for step in STEPS for line in step.get("run", "").splitlines()]


def test_it_has_the_parts_of_a_workflow() -> None:
    assert {"name", "on", "permissions", "jobs"} == set(WORKFLOW)
    assert set(WORKFLOW["on"]) == {"push", "pull_request", "workflow_dispatch"}
    assert WORKFLOW["permissions"] == {"contents": "read"}
    for step in STEPS:
        assert ("run" in step) != ("uses" in step)
        assert set(step) <= {"name", "run", "uses", "with"}
    assert all(re.fullmatch(r"actions/[a-z-]+@v\d+", step["uses"]) for step in STEPS if "uses" in step)


@pytest.mark.parametrize("line", LINES)
def test_each_command_is_a_target_of_make_or_one_of_ours(line) -> None:
    program, *words = shlex.split(line)
    if program == "make":
        make = shutil.which("make")
        assert make
        subprocess.run([make, *words, "--dry-run"], cwd=ROOT, capture_output=True, check=True)
        return
    assert program == ".venv/bin/emovid"
    command = get_command(app)
    while hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    command.make_context(line, words)


def test_it_makes_videos_figures_and_results_and_keeps_them() -> None:
    assert {"make all-videos", "make figures", "make study"} <= set(LINES)
    kept = STEPS[-1]["with"]["path"].split()
    assert kept == ["videos", "figures", "results"]
    makefile = (ROOT / "Makefile").read_text()
    for folder in kept:
        assert re.search(rf"-o {folder}\b", makefile)


def test_it_uses_the_oldest_python_that_we_support() -> None:
    (setup,) = (step["with"] for step in STEPS if step.get("uses", "").startswith("actions/setup-python"))
    assert f'requires-python = ">={setup["python-version"]}"' in (ROOT / "pyproject.toml").read_text()
