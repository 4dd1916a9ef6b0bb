"""The checks of `emovid doctor`: each one tries the thing itself, and suggests a remedy if it fails.

Packages are imported where they are tried, so that a missing one is found and named, not raised.
"""

import re
import shlex
import shutil
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import NamedTuple

from emovid.errors import EmovidError, reason

_ROOM = 500_000_000  # bytes: the six videos take 13 MB, and so do every six videos of a sweep
_SMALL = {"video.size": "96x64", "video.fps": 5, "duration": 1.0}
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "firefox", "microsoft-edge")
_OF_DEVELOPERS = ("dev", "docs")  # extras
_REINSTALL = "pip install --force-reinstall"


class Check(NamedTuple):
    """The result of one check.

    Attributes:
        name: of the thing checked.
        passed: whether it works.
        needed: whether emovid fails without it.
        found: the version or size found, or the error.
        remedy: steps to fix it; empty if it works.
    """

    name: str
    passed: bool
    needed: bool
    found: str
    remedy: str = ""


def checks(folder: Path) -> Iterator[Check]:
    """Yield the result of each check of this installation, and of a folder to write to."""
    yield _versions()
    yield _packages("packages", _needs()[""], needed=True)
    yield _scenes()
    yield from _videos()
    yield _fonts()
    yield _writing(folder)
    yield _temporary()
    yield _browser()
    for extra, needs in _needs().items():
        if extra not in ("", *_OF_DEVELOPERS):
            yield _packages(f"extra {extra}", needs, needed=False)
    yield _packages("results as Parquet", ["pyarrow"], needed=False)


def _versions() -> Check:
    numbers = ".".join(map(str, sys.version_info[:3]))
    return Check("emovid", True, True, f"{version('emovid')} with Python {numbers} on {sys.platform}")


def _needs() -> dict[str, list[str]]:
    """Return the packages that each extra requires, as in ``numpy>=2.1``; under "" those of emovid itself."""
    needs: dict[str, list[str]] = {"": []}
    for need in requires("emovid") or ():
        package, _, condition = need.partition(";")
        extra = re.search(r"""extra == ['"](.+)['"]""", condition)
        needs.setdefault(extra[1] if extra else "", []).append(package.strip())
    return needs


def _packages(name: str, needs: list[str], *, needed: bool) -> Check:
    """Return whether all packages are installed and new enough."""
    faults = {need: fault for need in needs if (fault := _fault(need))}
    found = "; ".join(faults.values()) or f"{len(needs)} installed"
    return Check(name, not faults, needed, found, f"pip install {shlex.join(faults)}" if faults else "")


def _fault(need: str) -> str:
    """Return the problem of a required package, given as ``name`` or ``name>=1.2``; "" if there is none."""
    name, _, least = need.partition(">=")
    try:
        there = version(name)
    except PackageNotFoundError:
        return f"{name} is missing"
    return f"{name} {there} is older than {least}" if _numbers(there) < _numbers(least) else ""


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r"\d+", text)[:3]))


def _scenes() -> Check:
    def load() -> str:
        from emovid.scene.emotions import EMOTIONS
        from emovid.scene.load import load_scene

        return f"{len([load_scene(emotion) for emotion in EMOTIONS])} load"

    return _tried("scenes", True, load, "reinstall emovid: files are missing")


def _videos() -> Iterator[Check]:
    """Yield a check for each format, which simulates, draws and encodes a second of a scene."""
    remedy = f"{_REINSTALL} imageio-ffmpeg, and unset IMAGEIO_FFMPEG_EXE if it is set"
    for format in ("mp4", "webm", "gif"):
        check = _tried(format, format == "mp4", partial(_render, format), remedy)
        is_other = not check.passed and "ffmpeg" not in check.found  # for example a missing package or folder
        yield check._replace(remedy="see the other checks: ffmpeg is not at fault") if is_other else check


def _render(format: str) -> str:
    from emovid.scene.load import load_scene
    from emovid.swarm.simulate import simulate
    from emovid.video import ffmpeg
    from emovid.video.render import render_video

    run = simulate(load_scene("sadness", _SMALL | {"video.format": format}))
    with tempfile.TemporaryDirectory() as folder:
        render_video(run, Path(folder) / f"run.{format}")
    return f"encoded by ffmpeg {ffmpeg.version()}"


def _fonts() -> Check:
    """Return whether the font of all figures exists; matplotlib brings it along."""

    def find() -> str:
        from matplotlib.font_manager import findfont

        return Path(findfont("DejaVu Sans", fallback_to_default=False)).name

    return _tried("font", True, find, f"{_REINSTALL} matplotlib")


def _writing(folder: Path) -> Check:
    """Return whether a folder is writable and has enough free space."""
    name = f"folder {folder}"
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(b"emovid")
        free = shutil.disk_usage(folder).free
    except OSError as error:
        return Check(name, False, True, reason(error), "choose a folder that you may write to")
    found = f"writable, {free / 1e9:.1f} GB free"
    return Check(
        name, free >= _ROOM, True, found, "" if free >= _ROOM else "free some space, or use -o on another disk"
    )


def _temporary() -> Check:
    """Return whether the folder for temporary files is writable, as `_writing`."""
    try:
        return _writing(Path(tempfile.gettempdir()))
    except OSError as error:  # no folder that Python tries is writable
        return Check("folder for temporary files", False, True, reason(error), "free some space, or set TMPDIR")


def _browser() -> Check:
    """Return whether there is a browser to view reports and rehearse surveys."""
    found = next(filter(shutil.which, _BROWSERS), None)  # webbrowser finds none of them without a screen
    with suppress(webbrowser.Error):
        found = found or getattr(webbrowser.get(), "name", "found")
    remedy = "copy report.html or kit/ to a machine with one"
    return Check("browser", bool(found), False, found or "none found", "" if found else remedy)


def _tried(name: str, needed: bool, check: Callable[[], str], remedy: str) -> Check:
    """Return the result of a check that returns what it found, or raises an error."""
    try:
        return Check(name, True, needed, check())
    except (EmovidError, ImportError, OSError, ValueError) as error:
        return Check(name, False, needed, " ".join(str(error).split()), remedy)
