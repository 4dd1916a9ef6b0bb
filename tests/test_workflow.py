"""The workflow file that users copy: GitHub can read it, and its commands work in a repository of one's own scenes."""

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from emovid.cli.main import all_commands

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "docs" / "ci" / "github-workflow.yml").read_text()
# "on" is true in YAML 1.1, which GitHub does not read its files by.
WORKFLOW = yaml.load(TEXT, Loader=yaml.BaseLoader)  # noqa: S506 - it makes plain text of everything
STEPS = WORKFLOW["jobs"]["videos"]["steps"]
LINES = [line for step in STEPS for line in step.get("run", "").splitlines()]


def test_example_workflow_has_the_required_parts() -> None:
    assert set(WORKFLOW) == {"name", "on", "concurrency", "permissions", "jobs"}
    assert set(WORKFLOW["on"]) == {"push", "pull_request", "workflow_dispatch"}
    assert WORKFLOW["on"]["push"] == {"branches": ["main"]}  # so that a pull request runs it once, not twice
    assert WORKFLOW["permissions"] == {"contents": "read"}
    for step in STEPS:
        assert ("run" in step) != ("uses" in step)
        assert set(step) <= {"name", "run", "uses", "with", "if"}
    assert all(re.fullmatch(r"actions/[a-z-]+@v\d+", step["uses"]) for step in STEPS if "uses" in step)


def test_example_workflow_caches_and_uploads_the_videos() -> None:
    uses = {step["uses"].split("@")[0]: step for step in STEPS if "uses" in step}
    assert uses["actions/cache"]["with"]["path"] == uses["actions/upload-artifact"]["with"]["path"] == "videos"
    assert uses["actions/upload-artifact"]["if"] == "always()"  # also the changed ones


def test_example_workflow_uses_the_oldest_supported_python() -> None:
    (setup,) = (step["with"] for step in STEPS if step.get("uses", "").startswith("actions/setup-python"))
    assert f'requires-python = ">={setup["python-version"]}"' in (ROOT / "pyproject.toml").read_text()


@pytest.mark.parametrize("line", LINES)
def test_commands_of_the_example_workflow_exist(line) -> None:
    program, *words = shlex.split(line.replace("*.yaml", "a.yaml"))
    if program in ("pip", "git"):
        return
    assert program == "emovid"
    command = all_commands()
    while hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    command.make_context(line, words)


@pytest.fixture
def repository(tmp_path) -> Path:
    """Return a git repository of two scenes, with the manifest of their videos."""
    (tmp_path / "scenes").mkdir()
    for name in ("calm", "upset"):
        text = (ROOT / "configs" / f"{'fear' if name == 'calm' else 'anger'}.yaml").read_text()
        text = re.sub(r"(?m)^duration: \S+", "duration: 0.4", text)
        text = re.sub(r"(?m)^(  size:) \S+", r"\1 96x64", re.sub(r"(?m)^(  fps:) \S+", r"\1 5", text))
        (tmp_path / "scenes" / f"{name}.yaml").write_text(text)
    shell(tmp_path, "git init -q && emovid render scenes/*.yaml -o videos -q && git add -f scenes videos/manifest.json")
    shell(tmp_path, "git -c user.name=a -c user.email=a@example.org commit -qm scenes")
    return tmp_path


def shell(folder: Path, line: str) -> "subprocess.CompletedProcess[str]":
    """Run a line as GitHub does, with our emovid."""
    script = f'emovid() {{ "{sys.executable}" -m emovid "$@"; }}; {line}'
    return subprocess.run(
        [shutil.which("bash") or "bash", "-ec", script], cwd=folder, capture_output=True, text=True, check=False
    )


def run(folder: Path) -> int:
    """Run the workflow's lines after the set-up, and return the exit code."""
    lines = [line for line in LINES if not line.startswith(("pip", "emovid doctor"))]
    return shell(folder, "\n".join(lines)).returncode


def test_example_workflow_passes_for_unchanged_scenes_and_fails_for_changed_ones(repository) -> None:
    assert run(repository) == 0
    scene = repository / "scenes" / "calm.yaml"
    scene.write_text(re.sub(r"(?m)^seed: \d+", "seed: 99", scene.read_text()))
    assert "seed: 99" in scene.read_text()
    assert run(repository) != 0
