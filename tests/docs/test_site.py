"""The documentation as a site: built without network and without a warning."""

import os
import re
import subprocess
import sys

import pytest

from tests.helpers.pages import ROOT


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    env = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}  # of planned changes by its authors
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "WARNING" not in said
    return folder


def test_pages_load_nothing_from_other_hosts(site) -> None:
    for page in site.rglob("*.html"):
        loaded = re.findall(
            r'<(?:script|img|link|iframe|video|source)[^>]*(?:src|href)="(https?:[^"]*)"', page.read_text()
        )
        assert loaded == [], page.name


def test_reference_pages_are_generated_from_the_code(site) -> None:
    commands, scene = ((site / "reference" / f"{name}.html").read_text() for name in ("commands", "scene"))
    assert all(f"emovid {name}" in commands for name in ("render", "study analyze", "scene new", "sweep"))
    assert all(f"<code>{key}</code>" in scene for key in ("angular_rate", "control_period", "R_max", "sigma"))


def test_formulas_are_rendered_and_external_files_are_named(site) -> None:
    theory = (site / "theory.html").read_text()
    assert theory.count("<math") > 30
    assert "$" not in re.sub(r"<script.*?</script>", "", theory, flags=re.DOTALL)
    assert "<code>studies/example/study.yaml</code>" in (site / "run-a-study.html").read_text()
