"""Trajectories and measurements do not depend on the BLAS kernel; different arithmetic is recorded."""

import json
import os
import platform
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

DIGESTS = """
import json, sys
from emovid.batch.job import Job, make
from emovid.batch.versions import versions
from emovid.scene.load import load_scene
from pathlib import Path

picture = {"behaviour.density": {"kind": "image", "file": sys.argv[1], "smoothing": 0.1}, "robots": 5}
barrier = {"safety": {"kind": "barrier"}, "behaviour.separation": None, "robots": 5}
barrier["robot.limits"] = {"v_max": 0.1, "omega_max": 8}
scenes = [("anger", {}), ("happiness", {}), ("fear", picture), ("fear", barrier)]
made = [make(Job(load_scene(name, {"duration": 1, **keys}), Path("m"), only="measure")) for name, keys in scenes]
known = versions("measure", barrier=True)
print(json.dumps([known["projection"], known["arithmetic"], *((r.trajectory_sha256, r.sha256) for r in made)]))
"""


@pytest.fixture(scope="module")
def digests(tmp_path_factory):
    """Return a function that computes digests in a process with the given environment."""
    folder = tmp_path_factory.mktemp("pictures")
    grey = np.random.default_rng(1).integers(0, 256, (12, 18), dtype=np.uint8)
    Image.fromarray(grey).save(folder / "a.png")

    def compute(**environment: str) -> list:
        command = [sys.executable, "-c", DIGESTS, str(folder / "a.png")]
        done = subprocess.run(command, env=os.environ | environment, capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    return compute


def test_results_without_barriers_are_identical_under_all_blas_kernels_and_thread_counts(digests) -> None:
    settings = [
        {"OPENBLAS_CORETYPE": "Prescott", "OPENBLAS_NUM_THREADS": "1"},
        {"OPENBLAS_CORETYPE": "Haswell", "OPENBLAS_NUM_THREADS": "8"},
    ]
    here, prescott, haswell = [digests(**environment) for environment in [{}, *settings]]
    *without_barrier, _ = here[1:]
    assert prescott[1:-1] == haswell[1:-1] == without_barrier
    if platform.machine() == "x86_64":
        assert prescott[0] != haswell[0]  # so that scenes with barriers, which may differ, count as outdated


def test_different_results_imply_a_different_arithmetic_record(digests) -> None:
    found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    assert found, "this processor has none beyond the baseline"
    here, without = digests(), digests(NPY_DISABLE_CPU_FEATURES=" ".join(found))
    if here[2:] != without[2:]:
        assert here[1] != without[1]
