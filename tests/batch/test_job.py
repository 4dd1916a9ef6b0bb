"""Modules that decide whether a result is up to date."""

import re
from pathlib import Path

import emovid
from emovid.batch.versions import _MODULES

PACKAGE = Path(emovid.__file__).parent
OUTSIDE = {
    "errors",
    "signals",
    "atomic_io",
    "csv_writer",
    "yaml_source",
}  # not an input of any result


def rooms_behind(names: set[str]) -> set[str]:
    """Return these packages and all packages that they import, directly or indirectly."""
    found, left = set(), list(names)
    while left:
        room = left.pop()
        if room in found:
            continue
        found.add(room)
        files = (PACKAGE / room).glob("*.py") if (PACKAGE / room).is_dir() else [PACKAGE / f"{room}.py"]
        for file in files:
            left += re.findall(r"^ *from emovid\.(\w+)", file.read_text(), re.MULTILINE)
    return found - OUTSIDE


def test_change_in_any_module_of_a_result_makes_it_stale() -> None:
    for only in ("video", "trajectory", "measure"):
        rooms = set(_MODULES[only])
        assert rooms_behind(rooms) == rooms, only
