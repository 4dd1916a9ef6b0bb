"""What the README and the project's files promise."""

import json
import os
import re
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from emovid.measure.claims import CLAIMS

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text()
PATH = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}


def run(*command: str, cwd: Path = ROOT, **keys: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=True, env=PATH, **keys)


def commands(first_word: str) -> list[str]:
    """Return the README's lines of code that start with a word, without their comments."""
    lines = re.findall(rf"^    ({first_word} .*)$", README, re.MULTILINE)
    return [line.split("#")[0].strip() for line in lines]


def test_package_imports_follow_the_layers() -> None:
    assert "0 broken" in run("lint-imports").stdout


def test_make_commands_of_the_readme_exist() -> None:
    named = {*commands("make"), *re.findall(r"`(make [a-z-]+)`", README)}
    assert {"make all-videos", "make test", "make study", "make bench"} <= named
    for command in named:
        run(*command.split(), "--dry-run")


def test_python_examples_of_the_readme_run(tmp_path) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    (tmp_path / "responses.csv").write_bytes((ROOT / "studies/santos-egerstedt/responses.csv").read_bytes())
    run(sys.executable, "-c", block, cwd=tmp_path)
    assert (tmp_path / "anger.mp4").stat().st_size > 100_000


def test_contributing_lists_the_folders_that_exist() -> None:
    named = set(re.findall(r"^\| `([a-z/]+)/` ", CONTRIBUTING, re.MULTILINE))
    folders = {f"emovid/{path.name}" for path in (ROOT / "emovid").iterdir() if (path / "__init__.py").is_file()}
    assert named == folders | {"configs", "studies", "tests", "benchmarks"}


def test_contributing_names_files_and_make_commands_that_exist() -> None:
    paths = re.findall(r"`((?:emovid|tests|docs|benchmarks|configs)/[\w/.-]+)`", CONTRIBUTING)
    assert len(paths) > 15
    assert [path for path in paths if not (ROOT / path).exists()] == []
    for command in re.findall(r"(?:`|^    )(make [a-z-]+(?: [a-z]+)*)", CONTRIBUTING, re.MULTILINE):
        run(*command.split(), "--dry-run")


def test_architecture_picture_shows_the_actual_imports(tmp_path) -> None:
    run(sys.executable, str(ROOT / "docs" / "make_architecture.py"), str(tmp_path / "now.svg"))
    shown = ROOT / "docs" / "pictures" / "architecture.svg"
    assert (tmp_path / "now.svg").read_text() == shown.read_text(), "run make readme"


def test_readme_states_the_number_of_claims() -> None:
    assert f"{len(CLAIMS)} claims" in README


def test_readme_picture_matches_the_current_scenes(tmp_path) -> None:
    run(sys.executable, str(ROOT / "docs" / "make_picture.py"), str(tmp_path / "now.webp"))
    pictures = [Image.open(path) for path in (ROOT / "docs" / "six-emotions.webp", tmp_path / "now.webp")]
    assert [picture.n_frames for picture in pictures] == [80, 80]
    for frame in (0, 40, 79):
        for picture in pictures:
            picture.seek(frame)
        shown, now = (np.asarray(picture.convert("RGB"), dtype=float) for picture in pictures)
        # Coverage is chaotic: what rounds otherwise shows its robots elsewhere, in three of six panels.
        assert np.abs(shown - now).mean() < 3, "run make readme"


def test_version_numbers_agree() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == project["version"]
    assert run(sys.executable, "-m", "emovid", "--version").stdout == f"emovid {project['version']}\n"


def test_constraints_pin_every_package_without_urls() -> None:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    assert all(re.fullmatch(r"[A-Za-z0-9_.-]+==[0-9][0-9a-z.]*", line) for line in lines)
    pinned = {line.split("==")[0].lower().replace("_", "-") for line in lines}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [
        *project["dependencies"],
        *(need for extra in project["optional-dependencies"].values() for need in extra),
    ]
    assert {re.split("[>=<]", need)[0].lower().replace("_", "-") for need in wanted} <= pinned


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Build the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder))
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def venv(wheel) -> Path:
    """Install the wheel into a virtual environment of its own, which borrows our dependencies but not our checkout."""
    folder = wheel.parent / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", str(folder))
    install = ["install", "--quiet", "--no-deps", "--no-index", "--disable-pip-version-check", str(wheel)]
    run(sys.executable, "-m", "pip", "--python", str(folder / "bin" / "python"), *install)
    (packages,) = folder.glob("lib/python*/site-packages")
    (packages / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")  # .pth files in there have no effect
    return folder


def test_an_installed_wheel_works_in_an_empty_folder(venv, tmp_path) -> None:
    def emovid(*arguments: str) -> str:
        own = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        command = [str(venv / "bin" / "emovid"), *arguments]
        done = subprocess.run(command, cwd=tmp_path, env=own, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    where = "import emovid.scene.load as load; print(load.__file__, load.shipped_scene('anger'))"
    said = run(str(venv / "bin" / "python"), "-I", "-c", where, cwd=tmp_path).stdout
    assert [path.startswith(str(venv)) for path in said.split()] == [True, True]
    assert json.loads(emovid("doctor", "--json"))["passed"]
    emovid("render", "--all", "--jobs", "2", "--size", "96x64", "--fps", "5", "--set", "duration=1")
    emovid("scene", "new", "my.yaml")
    emovid("preview", "my.yaml", "--set", "duration=1")
    emovid("figures", "accuracy-gender", "--format", "svg")
    emovid("study", "new", "my-study")
    study = tmp_path / "my-study" / "study.yaml"
    text = study.read_text().replace("1280x720", "96x64").replace("fps: 30", "fps: 5")
    study.write_text(text.replace("duration: 15", "duration: 1"))
    emovid("study", "build", "my-study", "-o", "kit")
    emovid("study", "audit", "kit")
    made = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.*")}
    assert len([name for name in made if name.endswith(".mp4")]) == 6 + 6
    assert {"my.yaml", "previews/my.gif", "figures/accuracy-gender.svg"} <= made


def test_wheel_contains_scenes_and_types_but_no_tests(wheel) -> None:
    with zipfile.ZipFile(wheel) as archive:
        files = set(archive.namelist())
    assert {"emovid/configs/anger.yaml", "emovid/py.typed", "emovid/cli/main.py"} <= files
    assert {f"emovid/studies/{name}" for name in ("example/study.yaml", "santos-egerstedt/responses.csv")} <= files
    assert {"emovid/configs/robots/gritsbot.yaml", "emovid/platforms/robotarium_script.py.in"} <= files
    assert {f"emovid/survey/{name}" for name in ("schema.sql", "static/survey.js", "templates/video.html")} <= files
    assert not [name for name in files if name.startswith(("tests", "configs"))]
    ours = {str(path.relative_to(ROOT)) for path in (ROOT / "emovid").rglob("*") if path.is_file()}
    assert {name for name in ours if "__pycache__" not in name} <= files


def test_module_names_of_tests_are_unique() -> None:
    """Pytest imports them by their names alone; two of one name are an error that only a run of all shows."""
    names = Counter(path.name for path in Path(__file__).parent.rglob("test_*.py"))
    assert [name for name, count in names.items() if count > 1] == []
