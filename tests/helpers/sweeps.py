"""Sweeps on a Dask cluster that loses workers, compared with undisturbed sweeps."""

import os
import random
import signal
import subprocess
import sys
import time
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from tests.helpers.dask_cluster import dask_cluster
from tests.helpers.trial import hidden, left_of

EMOVID = [sys.executable, "-m", "emovid"]
FEW = "scenes: [anger, fear]\nseeds: 4\nset: {duration: 2, video.size: 320x240, video.fps: 15}\n"
MANY = (
    "scenes: [happiness, surprise, sadness, fear, anger]\nseeds: 20\nset: {duration: 0.4, video.size: 96x64, "
    "video.fps: 10}\ngrid: {robot.l: {from: 0.004, to: 0.02, count: 5}}\n"
)


class Made(NamedTuple):
    """A finished sweep: its way of running, its number of videos, and digests of its table and files."""

    how: str
    videos: int
    table: str
    files: str


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files of a folder."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def sweep(file: Path, target: Path, *arguments: str) -> None:
    """Make a sweep without disturbance."""
    subprocess.run([*EMOVID, "sweep", str(file), "-o", str(target), "-q", *arguments], check=True)


class DaskTrials:
    """Repeated small sweeps, on workers of which one gets a signal at a random time."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "few.yaml"
        self.file.write_text(FEW)
        sweep(self.file, folder / "few", "--jobs", "2")
        self.reference = contents(folder / "few")
        with dask_cluster(folder, 2) as (address, _):
            started = time.monotonic()
            sweep(self.file, folder / "on-dask", "--scheduler", address)
            self.seconds = time.monotonic() - started

    def violations(self, number: signal.Signals, rng: random.Random) -> list[str]:
        """Try a signal at one time, and at another if that was too late; return violations."""
        while (found := self._violations(number, rng)) is None:
            pass
        return found

    def _violations(self, number: signal.Signals, rng: random.Random) -> list[str] | None:
        with TemporaryDirectory(prefix="emovid-chaos-") as place, dask_cluster(Path(place), 2) as (address, workers):
            target, victim = Path(place) / "few", rng.choice(workers).pid
            command = [*EMOVID, "sweep", str(self.file), "-o", str(target), "--scheduler", address]
            process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
            time.sleep(self.seconds * rng.random())
            too_late = process.poll() is not None
            os.kill(victim, number)
            said = process.communicate(timeout=180)[1]
            if too_late:
                return None
            if process.returncode or "Traceback" in said:
                return [f"exit code {process.returncode}: {said[-500:]}"]
            found = [] if contents(target) == self.reference else ["other results than without a fault"]
            if hidden(target):
                found.append(f"temporary files left: {hidden(target)}")
            if left := left_of([victim]):
                found.append(f"processes left: {left}")
            return found


def five_hundred(folder: Path) -> tuple[list[Made], list[str]]:
    """Make 500 videos here, in shards, and on two Dask workers of which one is killed midway; return violations."""
    file = folder / "many.yaml"
    file.write_text(MANY)
    sweep(file, folder / "here", "--jobs", "2")
    for shard in (2, 3, 1):
        sweep(file, folder / "shards", "--shard", f"{shard}/3", "--jobs", "2")
    with TemporaryDirectory() as place, dask_cluster(Path(place), 2) as (address, workers):
        command = [*EMOVID, "sweep", str(file), "-o", str(folder / "dask"), "--scheduler", address]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert process.stderr
        for line in process.stderr:
            if line.startswith("[200/500]"):
                workers[0].kill()
                break
        said = process.communicate(timeout=600)[1]
    made = [
        _made("two processes here", folder / "here"),
        _made("three shards, the second first", folder / "shards"),
        _made("two Dask workers, one killed after 200", folder / "dask"),
    ]
    found = [] if process.returncode == 0 else [f"exit code {process.returncode}: {said[-500:]}"]
    if made[0].videos != 500:
        found.append("not 500 videos")
    return made, found + [f"{other.how}: not the same" for other in made[1:] if other[1:] != made[0][1:]]


def _made(how: str, folder: Path) -> Made:
    files = contents(folder)
    listed = "".join(f"{sha256(data).hexdigest()}  {name}\n" for name, data in sorted(files.items()))
    table = sha256(files["results.csv"]).hexdigest()
    return Made(how, sum(name.endswith(".mp4") for name in files), table, sha256(listed.encode()).hexdigest())
