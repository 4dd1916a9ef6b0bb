"""Run the benchmarks and write their output into RESULTS.md, one section each.

Usage: python benchmarks [NAME ...]

NAME is a file in this folder, such as render_cost; without a name, all benchmarks run. A section has a title, comments
written by hand, which are kept, and the measurement: command, date, machine, versions and output. Close other programs
before measuring.
"""

import os
import platform
import re
import subprocess
import sys
import time
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from emovid.video import ffmpeg

HERE = Path(__file__).parent
RESULTS = HERE / "RESULTS.md"
BENCHES = {
    "startup": "Start-up",
    "render_cost": "Rendering",
    "peers": "Comparison with other tools",
    "simulator": "Simulation",
    "coverage_scale": "Coverage in large swarms",
    "batch": "Batches",
    "survey_import": "Importing a survey",
    "survey": "The survey under load",
    "gate": "The paper's claims on 50 seeds",
    "robotarium_safety": "The Robotarium scenes on 50 seeds",
}
TITLE = """# Measurements

`make bench` runs all benchmarks and updates this page; `make bench ONLY=render_cost` runs one.
"""


def machine() -> str:
    """Return the processor, its cores, the system, and the package versions that affect the timings."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists() and (found := re.search(r"^model name\s*: (.*)$", info.read_text(), re.MULTILINE)):
        model = found[1]
    packages = " ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "matplotlib", "pandas"))
    python = f"Python {platform.python_version()}"
    return f"{model}, {os.cpu_count()} cores, {platform.system()}; {python}, {packages}, ffmpeg {ffmpeg.version()}"


def measured(name: str) -> tuple[str, bool]:
    """Run a benchmark; return its output with the machine and versions, and whether its limits hold."""
    command = [sys.executable, str(HERE / f"{name}.py")]
    started = time.monotonic()
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    minutes = (time.monotonic() - started) / 60
    print(done.stdout, flush=True)
    stamp = f"`python benchmarks/{name}.py`, {datetime.now(UTC):%Y-%m-%d}, {minutes:.1f} min. {machine()}."
    return f"{stamp}\n\n```text\n{done.stdout.strip()}\n```\n", done.returncode == 0


def sections(text: str) -> dict[str, str]:
    """Return the sections of a results file by title."""
    parts = re.split(r"^## (.*)\n", text, flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


def by_hand(section: str) -> str:
    """Return the comments of a section, without the measurement, which begins with the command."""
    return re.split(r"^`python benchmarks/", section, maxsplit=1, flags=re.MULTILINE)[0].strip()


def main(names: list[str]) -> None:
    """Run the benchmarks and update their sections, one after the other."""
    if unknown := [name for name in names if name not in BENCHES]:
        raise SystemExit(f"no benchmark {unknown[0]}: there are {', '.join(BENCHES)}")
    failed = []
    for name in names or BENCHES:
        print(f"{name}:", flush=True)
        found, held = measured(name)
        failed += [] if held else [name]
        known = sections(RESULTS.read_text() if RESULTS.exists() else "")
        title = BENCHES[name]
        known[title] = "\n\n".join(part for part in ("", by_hand(known.get(title, "")), found) if part)
        ordered = (f"## {title}\n\n{known[title].strip()}\n" for title in BENCHES.values() if title in known)
        RESULTS.write_text("\n".join([TITLE, *ordered]))
    if failed:
        raise SystemExit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main(sys.argv[1:])
