"""Measure the overhead of batches: two processes against one, Dask against processes, and nothing left to do.

    python benchmarks/batch.py

prints a Markdown table. Nothing else should run meanwhile: the ratio for Dask is one of wall times.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from distributed import LocalCluster

VIDEOS = (
    "scenes: [happiness, surprise, sadness, fear, disgust, anger]\nseeds: 10\nset: {duration: 5, video.size: 640x360}\n"
)
MEASURES = "only: measure\nscenes: [happiness]\nseeds: 10000\nset: {duration: 0.2, robots: 3}\n"
ROUNDS = 3  # of which the fastest counts: everything else is another program's doing


class Spent(NamedTuple):
    """Wall time of a command, and processor time including its child processes [s]."""

    wall: float
    cpu: float


def spent(*arguments: object) -> Spent:
    """Run a command and return its times."""
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-m", "emovid", *map(str, arguments), "--quiet"], check=True)
    wall, after = time.perf_counter() - started, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Spent(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def six_videos(folder: Path) -> tuple[str, str]:
    """Compare the six videos in two processes with one process."""
    one, two = (spent("render", "--all", "-o", folder / f"six-{jobs}", "--jobs", jobs) for jobs in (1, 2))
    cpu = f"{two.cpu / one.cpu:.2f} of the processor time ({two.cpu:.1f} s, {one.cpu:.1f} s)"
    return "six videos, `--jobs 2` against 1", f"{cpu}, {two.wall / one.wall:.2f} of the wall time"


def sixty_on_dask(folder: Path) -> tuple[str, str]:
    """Compare 60 videos on a Dask cluster of two workers with two processes."""
    file = folder / "videos.yaml"
    file.write_text(VIDEOS)
    local, dask = [], []
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        for i in range(ROUNDS):
            local.append(spent("sweep", file, "-o", folder / f"local-{i}", "--jobs", 2).wall)
            there = ("--scheduler", cluster.scheduler_address)
            dask.append(spent("sweep", file, "-o", folder / f"dask-{i}", *there).wall)
    ratio = f"{min(dask) / min(local):.2f} of the wall time ({min(dask):.1f} s, {min(local):.1f} s)"
    return "60 videos of 5 s, a Dask LocalCluster of two against two processes", ratio


def ten_thousand(folder: Path) -> list[tuple[str, str]]:
    """Measure 10 000 tiny measurements, and finding that all are up to date."""
    file = folder / "measures.yaml"
    file.write_text(MEASURES)
    made, found = (spent("sweep", file, "-o", folder / "measures", "--jobs", 2) for _ in range(2))
    each = f"{made.wall:.0f} s, {made.cpu / 10:.1f} ms of processor time each"
    return [("10 000 tiny measurements", each), ("the same again: nothing to make", f"{found.wall:.1f} s")]


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        rows = [six_videos(folder), sixty_on_dask(folder), *ten_thousand(folder)]
    print("| batch | measured |\n|---|---|")
    for what, measured in rows:
        print(f"| {what} | {measured} |")


if __name__ == "__main__":
    main()
