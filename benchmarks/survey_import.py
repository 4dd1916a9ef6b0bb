"""Measure the analysis of a large survey: reading its export and writing every table, test and figure.

The participants are model ones, six answers each.

Usage: python benchmarks/survey_import.py [PYTHON]

PYTHON is an interpreter with an earlier version of emovid, which then analyzes the same files beside this version. Its
path can also be in the environment variable BESIDE, as in `make bench ONLY=survey_import BESIDE=../v0.1.0/bin/python`.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from processes import cost

PARTICIPANTS = (45, 1000, 10_000, 100_000)


def version_of(python: str) -> str:
    """Return the version of emovid that an interpreter runs."""
    command = [python, "-c", "from importlib.metadata import version; print(version('emovid'))"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def main(beside: str) -> None:
    """Print the table."""
    earlier = {version_of(beside): beside} if beside else {}
    pythons = {"this version": sys.executable} | earlier
    print(f"{'participants':>12}{'':>14}{'wall time':>12}{'processor':>12}{'memory':>11}{'export':>11}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for participants in PARTICIPANTS:
            export = folder / f"{participants}.csv"
            simulate = ["study", "simulate", "-o", export.name, "--participants", str(participants), "--quiet"]
            cost([sys.executable, "-m", "emovid", *simulate], folder)
            size = export.stat().st_size / 1e6
            for i, (version, python) in enumerate(pythons.items()):
                analyze = ["study", "analyze", export.name, "-o", f"results-{participants}-{i}", "--quiet"]
                used = cost([python, "-m", "emovid", *analyze], folder)
                times = f"{used.wall:>10.1f} s{used.cpu:>10.1f} s{used.memory:>8.0f} MB{size:>8.1f} MB"
                print(f"{participants:>12}{version:>14}{times}", flush=True)


if __name__ == "__main__":
    main(next(iter(sys.argv[1:]), os.environ.get("BESIDE", "")))
