"""Measure the cost of a process, including its child processes."""

import os
import subprocess
import time
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

# emovid sets this for itself; all programs in a comparison get the same.
ENVIRONMENT = os.environ | {"OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}


class Cost(NamedTuple):
    """Wall time and processor time [s], and the memory of the largest process [MB]."""

    wall: float
    cpu: float
    memory: float


def cost(command: list[str], folder: Path | None = None, given: Iterable[bytes] = ()) -> Cost:
    """Run a command in a folder, with bytes on its standard input, and return its cost.

    Raises:
        CalledProcessError: if it fails.
    """
    started = time.perf_counter()
    with subprocess.Popen(
        command, cwd=folder, env=ENVIRONMENT, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
    ) as process:
        assert process.stdin
        for part in given:
            process.stdin.write(part)
        process.stdin.close()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.perf_counter() - started
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return Cost(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)
