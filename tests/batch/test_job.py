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
}  # no result depends on them


def rooms_behind(names: set[str]) -> set[str]:
    """Return these rooms and those that they import, directly or not."""
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


def test_a_change_of_any_module_behind_a_result_makes_it_stale() -> None:
    for only in ("video", "trajectory", "measure"):
        rooms = set(_MODULES[only])
        assert rooms_behind(rooms) == rooms, only
