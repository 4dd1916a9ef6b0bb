"""Previews: a small loop or a contact sheet of a scene, made once or whenever the scene's file is saved."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import numpy as np

from emovid.errors import EmovidError
from emovid.figures.contact import contact_figure
from emovid.figures.style import save
from emovid.swarm.trajectory import Trajectory
from emovid.video.encoder import FORMATS
from emovid.video.painter import Painter
from emovid.video.render import reduced, render_video

SHEET = ".png"
_WIDTH = 320  # of the loop, and of each picture of a contact sheet [pixels]
_FPS = 10
_ROWS, _COLUMNS = 2, 3  # of a contact sheet
_PAUSE = 0.1  # seconds between two looks at the file


def write_preview(run: Trajectory, target: Path) -> None:
    """Write a preview of a run: a contact sheet if the target ends in .png, else a video."""
    suffix = target.suffix.lower()
    if suffix == SHEET:
        _write_sheet(reduced(run, _WIDTH, _FPS), target)
    else:
        format = next(name for name, made in FORMATS.items() if made.suffix == suffix)
        render_video(reduced(run, _WIDTH, _FPS, format), target)


def make_when_saved(make: Callable[[], None], file: Path, report: Callable[[EmovidError], None]) -> NoReturn:
    """Call `make` now, and again whenever the file changes, forever; report the errors in it.

    Polling works alike on all systems, in network folders, and with editors that save by renaming; it takes
    microseconds.
    """
    made: tuple[int, ...] = ()
    while True:
        now = _state(file)
        if now and now != made:
            made = now
            try:
                make()
            except EmovidError as error:
                report(error)
        time.sleep(_PAUSE)


def _write_sheet(run: Trajectory, target: Path) -> None:
    """Write pictures of a run at equal distances in time, from its start to its end."""
    times, painter = np.linspace(0, run.t[-1], _ROWS * _COLUMNS), Painter(run)
    pictures = np.stack([painter.frame(t)[..., :3].copy() for t in times])
    grid = pictures.reshape(_ROWS, _COLUMNS, *pictures.shape[1:])
    save(contact_figure(grid, captions=[f"{t:.3g} s" for t in times]), target)


def _state(file: Path) -> tuple[int, ...]:
    """Return values that change when a file is saved; none while an editor replaces it."""
    try:
        found = file.stat()
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino
