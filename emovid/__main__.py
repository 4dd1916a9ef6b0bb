"""The program, `emovid` or `python -m emovid`. It imports the command line last, since worker processes import this."""

import sys
from typing import NoReturn


def run() -> NoReturn:
    """Run the command line; a Ctrl-C before that has been imported ends the program like one that comes later."""
    try:
        from emovid.cli.main import run as run_command_line  # noqa: PLC0415
    except KeyboardInterrupt:
        sys.exit(130)
    run_command_line()


if __name__ == "__main__":
    run()
