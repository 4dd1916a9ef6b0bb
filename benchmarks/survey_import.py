"""Measure the analysis of a large survey: reading its export and writing every table, test and figure.

The participants are model ones, six answers each.

Usage: python benchmarks/survey_import.py
"""

import sys
import tempfile
from pathlib import Path

from processes import cost

PARTICIPANTS = (45, 1000, 10_000, 100_000)


def main() -> None:
    """Print the table."""
    print(f"{'participants':>12}{'wall time':>12}{'processor':>12}{'memory':>11}{'export':>11}")
    emovid = [sys.executable, "-m", "emovid", "study"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for participants in PARTICIPANTS:
            export = folder / f"{participants}.csv"
            cost([*emovid, "simulate", "-o", export.name, "--participants", str(participants), "--quiet"], folder)
            used = cost([*emovid, "analyze", export.name, "-o", f"results-{participants}", "--quiet"], folder)
            size = export.stat().st_size / 1e6
            print(f"{participants:>12}{used.wall:>10.1f} s{used.cpu:>10.1f} s{used.memory:>8.0f} MB{size:>8.1f} MB")


if __name__ == "__main__":
    main()
