"""The examples for make, Snakemake and DVC on the page about sweeps work."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.pages import DOCS, ROOT

PAGE = (DOCS / "sweeps.md").read_text()
SWEEP = "only: measure\nscenes: [fear]\nset: {duration: 0.3, robots: 3}\nseeds: 2\n"


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a program in a folder with a scene, a sweep and our emovid; it returns the output."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "emovid").write_text(f'#!/bin/sh\necho called\nexec "{sys.executable}" -m emovid "$@"\n')
    (tmp_path / "bin" / "emovid").chmod(0o755)
    (tmp_path / "scenes").mkdir()
    scene = (ROOT / "configs" / "anger.yaml").read_text()
    for key, value in (("duration", "0.4"), ("  size", "96x64"), ("  fps", "5")):
        scene = re.sub(rf"(?m)^{key}: \S+", f"{key}: {value}", scene)
    (tmp_path / "scenes" / "anger.yaml").write_text(scene)
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    environment = os.environ | {"PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}"}

    def run_program(*command: str) -> str:
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        assert (tmp_path / "sweeps" / "lk" / "results.csv").read_text().count("\n") == 3
        return done.stdout

    return run_program


def example(fence: str) -> str:
    """Return the text of a code block by the words after its fence."""
    found = re.search(rf"^```{re.escape(fence)}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    assert found
    return found[1]


def program(name: str) -> str:
    path = shutil.which(name)
    if not path:
        pytest.skip(f"no {name}: its example was NOT TRIED")
    return path


def test_make_accepts_current_files(run, tmp_path) -> None:
    (tmp_path / "Makefile").write_text(example("make"))
    make = program("make")
    assert run(make, "videos").count("called") == 2
    assert run(make, "videos").count("called") == 0
    video = (tmp_path / "videos" / "anger.mp4").read_bytes()
    for file in ("scenes/anger.yaml", "sweep.yaml"):
        Path(tmp_path, file).touch()
    assert run(make, "videos").count("called") == 2  # nothing to make, and modification times are updated
    assert run(make, "videos").count("called") == 0
    assert (tmp_path / "videos" / "anger.mp4").read_bytes() == video


def test_snakemake_makes_the_sweep(run, tmp_path) -> None:
    (tmp_path / "Snakefile").write_text(example('python title="Snakefile"'))
    run(program("snakemake"), "--cores", "1", "--quiet")


def test_dvc_makes_the_sweep(run, tmp_path) -> None:
    dvc = program("dvc")
    (tmp_path / "dvc.yaml").write_text(example('yaml title="dvc.yaml"'))
    subprocess.run([dvc, "init", "--no-scm", "--quiet"], cwd=tmp_path, check=True)
    assert "called" in run(dvc, "repro")
    assert "called" not in run(dvc, "repro")
