"""The program, `emovid` or `python -m emovid`; worker processes import this module, but not the command line."""

import sys
from typing import NoReturn


def run() -> NoReturn:
    """Run the command line; Ctrl-C during its import ends the program like a later one."""
    try:
        from emovid.cli.main import run as run_command_line  # noqa: PLC0415
    except KeyboardInterrupt:
        sys.exit(130)
    run_command_line()


if __name__ == "__main__":
    run()
