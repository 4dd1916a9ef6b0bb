"""How long `emovid --help` takes, against a Typer program that does nothing: whole processes, in turn."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

RUNS = 15
EMPTY = '''
import typer

app = typer.Typer()


@app.command()
def nothing(name: str = "nobody") -> None:
    """Do nothing."""


app()
'''


def seconds(command: list[str]) -> float:
    """Return the wall time of a command [s]."""
    started = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - started


def main() -> None:
    """Print the medians and the ratio."""
    with tempfile.TemporaryDirectory() as folder:
        empty = Path(folder) / "empty.py"
        empty.write_text(EMPTY)
        commands = ([sys.executable, "-m", "emovid", "--help"], [sys.executable, str(empty), "--help"])
        for command in commands:
            seconds(command)
        pairs = [[seconds(command) for command in commands] for _ in range(RUNS)]
    ours, theirs = (median(times) for times in zip(*pairs, strict=True))
    ratio = median(a / b for a, b in pairs)
    print(
        f"emovid --help {1000 * ours:.0f} ms, empty Typer program {1000 * theirs:.0f} ms: ratio {ratio:.2f} (at most 2)"
    )


if __name__ == "__main__":
    main()
