"""A short run of the chaos suite; `make chaos` is the long one, its table is docs/chaos.md."""

import random
from pathlib import Path

import pytest

from tests.helpers.data_loss import LOSSES
from tests.helpers.faults import SIGNALS, VICTIMS, at_random, damaged, lasting, with_ffmpeg
from tests.helpers.trial import Fault, reference_run, try_fault

SEED = 20210321
RNG = random.Random(SEED)  # noqa: S311 - a failure can be repeated
MOMENTS = [at_random(RNG, SIGNALS[i % 3], victim) for i, victim in enumerate(VICTIMS)]
LASTING = {fault.name: fault for fault in lasting()}
CHOSEN = (  # tests/video/test_encoder.py has more of them, for one video
    "a limit on the size of files",
    "a full device",
    "an ffmpeg that hangs at the start",
    "a folder that vanishes",
    "two runs into one folder",
    "stale temporary files",
    "a closed stderr",
    "two runs in containers with equal process numbers",
)
FAULTS = [*(LASTING[name] for name in CHOSEN if name in LASTING), damaged(RNG, "manifest.json"), *MOMENTS]


@pytest.fixture(scope="module")
def reference(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("reference") / "videos"


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_faults_leave_no_partial_results(reference: Path, fault: Fault) -> None:
    assert try_fault(fault, reference, reference_run(reference)) == []


@pytest.mark.parametrize("name", LOSSES)
def test_faults_lose_and_leak_no_data(name: str) -> None:
    assert LOSSES[name](RNG) == []


@pytest.mark.parametrize(
    ("broken", "violation"),
    [
        (
            "cache._staging = contextlib.contextmanager(lambda folder: (yield folder));"
            "encoder.whole_file = cache.whole_file = contextlib.contextmanager(lambda target: (yield target))",
            "is neither absent, nor the old one",
        ),
        (
            "cache.shutil = atomic_io.shutil = SimpleNamespace(rmtree=lambda *_, **__: None);"
            "atomic_io._remove = lambda path: None",
            "temporary files left",
        ),
        ("encoder._check_count = lambda *_: None", "exit code 0 with 0 of 6 complete"),
    ],
    ids=["writes in place", "leaves its temporary files", "does not count frames"],
)
def test_chaos_suite_detects_violations(reference: Path, broken: str, violation: str) -> None:
    imports = "import contextlib; from types import SimpleNamespace; from emovid import atomic_io"
    first = f"{imports}; from emovid.batch import cache; from emovid.video import encoder; {broken}"
    script = 'head -c 1000000 | "$real" "$@"; cat > /dev/null'
    fault = with_ffmpeg("an ffmpeg that loses frames", script, "of 30 frames", first)
    assert violation in "; ".join(try_fault(fault, reference, reference_run(reference)))
