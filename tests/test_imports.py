import subprocess
import sys

import pytest

RUN = """
import sys
from pathlib import Path

from emovid.batch.job import Job, make
from emovid.scene.load import Setting, load_scene

keys = [Setting("duration", 1.0, ""), Setting("video.size", "96x64", "")]
make(Job(load_scene(sys.argv[1], keys), Path("x.mp4")))
print(*{name.split(".")[0] for name in sys.modules})
"""


@pytest.mark.parametrize("emotion", ["happiness", "fear", "disgust", "anger"])
def test_a_video_of_a_small_swarm_is_made_without_what_takes_long_to_import(emotion: str, tmp_path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", RUN, emotion], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    imported = set(done.stdout.split())
    assert {"emovid", "numpy"} <= imported
    assert not imported & {"scipy", "pandas", "statsmodels", "distributed"}
