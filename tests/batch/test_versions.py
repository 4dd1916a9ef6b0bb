"""Recorded versions are those of the imported code, not of the files on disk."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import emovid
from emovid.batch.versions import OtherVersionsError, check_versions, differences, versions

PACKAGE = Path(emovid.__file__).parent
SCRIPT = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import emovid
from emovid.batch.versions import versions
from emovid.errors import EmovidError
from emovid.swarm import unicycle

def say(kind):
    try:
        print(versions(kind)["code"])
    except EmovidError as error:
        print(str(error).replace(sys.argv[1], ""))

file = Path(unicycle.__file__)
{steps}
"""
EDIT = "file.write_text(file.read_text() + '\\nedited = True\\n')"


@pytest.fixture
def run(tmp_path):
    """Return a function that runs steps with a copy of the package, and returns what they print."""
    for room in ("scene", "swarm", "video", "measure", "figures", "batch"):
        (tmp_path / "emovid" / room).mkdir(parents=True)
        for file in (PACKAGE / room).glob("*.py"):
            (tmp_path / "emovid" / room / file.name).write_bytes(file.read_bytes())
    for file in PACKAGE.glob("*.py"):
        (tmp_path / "emovid" / file.name).write_bytes(file.read_bytes())
    (tmp_path / "configs").symlink_to(PACKAGE.parent / "configs")

    def run_steps(*steps: str) -> list[str]:
        script = SCRIPT.format(steps="\n".join(steps))
        command = [sys.executable, "-c", script, str(tmp_path)]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()

    return run_steps


def test_code_edited_after_import_keeps_its_digest(run) -> None:
    # A worker rendered a video; then its code is edited; then it is asked for a measurement.
    video, measure = run("say('video')", EDIT, "say('measure')")
    again, edited = run("say('video')", "say('measure')")
    assert again != video
    assert edited != measure


def test_code_edited_before_its_first_digest_is_refused(run) -> None:
    (said,) = run(EDIT, "say('trajectory')")
    assert said == "/emovid/swarm/unicycle.py: was edited while emovid was running: start this process again"


def test_digest_covers_all_modules_of_a_kind_of_result(run) -> None:
    video, trajectory = run("say('video')", "say('trajectory')")
    assert video != trajectory
    assert run("say('video')") == [video]


def test_version_differences_are_named() -> None:
    here = versions("trajectory")
    assert differences(here, here) == ""
    assert differences({**here, "numpy": "1.0"}, here) == f"numpy 1.0, here {here['numpy']}"
    check_versions("trajectory", here)
    with pytest.raises(OtherVersionsError, match=rf"other versions: numpy {here['numpy']}, here 1\.0"):
        check_versions("trajectory", here | {"numpy": "1.0"})
    assert json.loads(json.dumps(here)) == here
