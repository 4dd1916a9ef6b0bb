"""A real Dask scheduler with real workers, each in a separate process."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

Process = subprocess.Popen[bytes]


@contextmanager
def dask_scheduler(folder: Path) -> Iterator[tuple[str, Callable[..., Process]]]:
    """Give the address of a scheduler, and a function that starts a worker in `folder` with extra variables."""
    file = folder / "scheduler.json"
    processes: list[Process] = []

    def start(*arguments: str, **environment: str) -> Process:
        command = [sys.executable, "-m", "dask", *arguments, "--no-dashboard"]
        with (folder / f"dask-{len(processes)}.log").open("wb") as log:
            process = subprocess.Popen(
                command, stdout=log, stderr=log, start_new_session=True, cwd=folder, env=os.environ | environment
            )
        processes.append(process)
        return process

    try:
        start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
        deadline = time.monotonic() + 60
        while not (file.exists() and file.read_text()):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        yield address, partial(start, "worker", address, "--no-nanny", "--nthreads", "1")
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


@contextmanager
def dask_cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[Process]]]:
    """Give the address of the scheduler, and workers that are not restarted; each leads its own session."""
    with dask_scheduler(folder) as (address, start):
        yield address, [start() for _ in range(workers)]
