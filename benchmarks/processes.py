"""What a whole process costs, with all that it starts."""

import os
import subprocess
import time
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

# As `emovid` sets it for itself, and thus for all alike.
ENVIRONMENT = os.environ | {"OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}


class Cost(NamedTuple):
    """Wall time and processor time [s], and the memory of the largest process [MB]."""

    wall: float
    cpu: float
    memory: float


def cost(command: list[str], folder: Path | None = None, given: Iterable[bytes] = ()) -> Cost:
    """Return what a command costs that is run in a folder and is given bytes on its standard input.

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
