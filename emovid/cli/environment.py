"""The environment that commands run in: standard streams, matplotlib's settings and folders, threads of OpenBLAS."""

import logging
import os
import sys
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path
from typing import TextIO


class _PatientStream(TextIOWrapper):
    """A stream that drops its text if its reader is gone, so that work continues without messages."""

    def write(self, text: str) -> int:
        with suppress(OSError):
            return super().write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError):
            super().flush()


def set_up_streams() -> None:
    """Make the standard streams safe to write to: closed ones, unread ones, characters outside their encoding."""
    # The next file that is opened would otherwise get the number of a closed stream, and its messages.
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
    sys.stdout = sys.stdout or _null()
    if isinstance(sys.stderr, TextIOWrapper):
        sys.stderr = _PatientStream(sys.stderr.detach(), encoding=sys.stderr.encoding, errors="backslashreplace")
    sys.stderr = sys.stderr or _null()
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def set_up_libraries() -> None:
    """Set up matplotlib and OpenBLAS by what they read when they are imported, here and in worker processes."""
    os.environ["MPLBACKEND"] = "agg"  # nothing is shown; a notebook sets a backend that exists only there
    if not _has_matplotlib_folders():
        # Without a folder for its caches matplotlib prints a warning, and reads all fonts again in every process.
        folder = Path(os.environ.get("TMPDIR") or "/tmp", f"emovid-{os.getuid()}")  # noqa: S108 - checked to be ours
        with suppress(OSError):
            folder.mkdir(mode=0o700, exist_ok=True)
            if folder.stat().st_uid == os.getuid():
                os.environ["MPLCONFIGDIR"] = str(folder)
    # On a slow machine, matplotlib logs that it reads the fonts, even with --quiet.
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
    # Commands are short: threads that help only with larger matrices than ours would cost 0.2 s each to start.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _has_matplotlib_folders() -> bool:
    """Return whether matplotlib can write to its folders for settings and caches."""
    own = os.environ.get("MPLCONFIGDIR")
    try:
        home = Path.home()
        folders = [Path(own)] if own else [home / ".config", home / ".cache"]
        for variable, folder in zip(("XDG_CONFIG_HOME", "XDG_CACHE_HOME"), list(folders), strict=False):
            inside = folder if own else Path(os.environ.get(variable) or folder) / "matplotlib"
            inside.mkdir(parents=True, exist_ok=True)
            if not os.access(inside, os.W_OK):
                return False
    except (OSError, RuntimeError):  # no such folder and no way to create it, or the home of an unknown user
        return False
    return True


def _null() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 - for the rest of the process
