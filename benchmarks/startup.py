"""Compare the start of `emovid --help` with that of an empty Typer program: whole processes, alternating."""

import sys
import tempfile
from pathlib import Path
from statistics import median

from processes import cost

RUNS = 15
EMPTY = '''
import typer

app = typer.Typer()


@app.command()
def nothing(name: str = "nobody") -> None:
    """Do nothing."""


app()
'''


def main() -> None:
    """Print the medians and the ratio."""
    with tempfile.TemporaryDirectory() as folder:
        empty = Path(folder) / "empty.py"
        empty.write_text(EMPTY)
        commands = ([sys.executable, "-m", "emovid", "--help"], [sys.executable, str(empty), "--help"])
        for command in commands:
            cost(command)
        pairs = [[cost(command).wall for command in commands] for _ in range(RUNS)]
    ours, theirs = (median(times) for times in zip(*pairs, strict=True))
    ratio = median(a / b for a, b in pairs)
    times = f"emovid --help {1000 * ours:.0f} ms, empty Typer program {1000 * theirs:.0f} ms"
    print(f"{times}: ratio {ratio:.2f} (at most 1.3)")


if __name__ == "__main__":
    main()
