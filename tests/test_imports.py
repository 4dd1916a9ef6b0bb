import subprocess
import sys

import pytest

RUN = """
import sys

from emovid.cli.main import main

assert main(sys.argv[1:]) == 0
print(*{name.split(".")[0] for name in sys.modules})
"""
SMALL = ["--size", "96x64", "--fps", "5", "--set", "duration=1", "-q"]


@pytest.mark.parametrize(
    "command",
    [
        *(["render", emotion, *SMALL] for emotion in ("happiness", "fear", "disgust", "anger")),
        ["preview", "fear", "--set", "duration=1", "-q"],
        ["simulate", "fear", "--set", "duration=1", "-q", "-o", "fear.csv"],
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_a_command_on_a_small_swarm_imports_no_slow_package(command: list[str], tmp_path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", RUN, *command], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    imported = set(done.stdout.split())
    assert {"emovid", "numpy"} <= imported
    assert not imported & {"scipy", "pandas", "statsmodels", "distributed"}
