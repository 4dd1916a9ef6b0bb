"""Previews: a small loop or a contact sheet of a scene, made once or whenever the scene's file is saved."""

import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NoReturn

import numpy as np

from emovid.errors import EmovidError
from emovid.figures.contact import contact_figure
from emovid.figures.style import save
from emovid.swarm.trajectory import Trajectory
from emovid.video.encoder import FORMATS
from emovid.video.painter import Painter
from emovid.video.render import reduced, render_video
from emovid.workflows.outputs import write_outputs

SHEET = ".png"
_WIDTH = 320  # of the loop, and of each picture of a contact sheet [pixels]
_FPS = 10
_ROWS, _COLUMNS = 2, 3  # of a contact sheet
_PAUSE = 0.1  # seconds between two checks of the file


def write_preview(run: Trajectory, target: Path, *, force: bool) -> None:
    """Write a preview of a run: a contact sheet if the target ends in .png, else a video. Raises as `write_outputs`."""
    suffix = target.suffix.lower()
    with TemporaryDirectory() as folder:
        made = Path(folder) / f"preview{suffix}"
        if suffix == SHEET:
            _write_sheet(reduced(run, _WIDTH, _FPS), made)
        else:
            format = next(name for name, format in FORMATS.items() if format.suffix == suffix)
            render_video(reduced(run, _WIDTH, _FPS, format), made)
        write_outputs({target: made.read_bytes()}, force=force)


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
    """Write pictures of a run at equal distances in time, from the start to the end of its video."""
    times, painter = np.linspace(*run.scene.window, _ROWS * _COLUMNS), Painter(run)
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
