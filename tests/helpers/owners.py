"""Names of processes, as in the names of their temporary files."""

import os

from emovid.atomic_io import owner

PARENT = owner(os.getppid())
DEAD = f"{owner().partition('-')[0]}-999999999-1"  # of this machine; no process has this number
ELSEWHERE = "0123456789ab-1-1"  # of another machine, or another container


def former() -> str:
    """Return the name of an earlier process that had the number of this one, as happens in containers."""
    space, number, start = owner().split("-")
    return f"{space}-{number}-{int(start) - 1}"
