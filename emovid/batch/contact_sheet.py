"""The contact sheet of a sweep: the last frame of each item, with a row or column for each varied value."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import product
from math import ceil, prod, sqrt
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from emovid.atomic_io import file_digest, writing
from emovid.batch.job import Record
from emovid.batch.manifest import Journal
from emovid.batch.versions import versions
from emovid.figures.contact import contact_figure
from emovid.figures.style import encoded
from emovid.swarm.files import load_trajectory
from emovid.video.frame_reader import read_last_frame
from emovid.video.painter import Painter

NAME = "contact-sheet.png"
_SUBJECT = "emovid sweep"  # in the metadata of the picture
MAX_SIDE = 200  # pictures in a row or a column
_WIDE, _NARROW, _PAGE = 480, 150, 2150  # pixels: largest and smallest picture, preferred width of all columns
_ONE_ROW = 8  # pictures

Axes = Sequence[tuple[str, Sequence[str]]]


def write_contact_sheet(
    folder: Path, names: Sequence[str], axes: Axes, records: Mapping[str, Record], threads: int
) -> None:
    """Write `contact-sheet.png`, unless it is up to date, or would have more than `MAX_SIDE` rows or columns.

    Args:
        folder: of the items' files.
        names: of the results of all items.
        axes: names and values of the varied keys, slowest first.
        records: by name.
        threads: number of videos to read at once.
    """
    rows, columns = _arranged(axes)
    high, wide = _count(rows), _count(columns)
    wrapped = high == 1 and wide > _ONE_ROW
    if wrapped:
        wide = ceil(sqrt(len(names)))
        high = ceil(len(names) / wide)
    if max(high, wide) > MAX_SIDE:
        return
    files = [(name, records[name].sha256) for name in names]
    record = Record("sheet", shows=_digest([files, axes]), versions=versions("sheet"))
    target = folder / NAME
    with Journal(folder) as journal:
        known = journal.records.get(NAME)
        if known and target.is_file() and known == replace(record, sha256=file_digest(target)):
            return
        grid = _pictures(folder, names, records, threads, wide, high)
        with writing(target) as file:
            file.write(encoded(_figure(grid, rows, columns, wrapped=wrapped), "png", _SUBJECT))
        journal.add(NAME, replace(record, sha256=file_digest(target)))


def is_contact_sheet(data: bytes) -> bool:
    """Return whether a file is a contact sheet that `write_contact_sheet` made."""
    return _SUBJECT.encode() in data


def _pictures(
    folder: Path, names: Sequence[str], records: Mapping[str, Record], threads: int, wide: int, high: int
) -> NDArray[np.uint8]:
    """Return the last frames of items, (high, wide, height, width, 3), white in unused places."""
    width = 2 * (int(np.clip(_PAGE / wide, _NARROW, _WIDE)) // 2)
    wide_video, high_video = _size(records[names[0]])
    height = 2 * max(round(width * high_video / wide_video / 2), 32)
    with ThreadPoolExecutor(threads) as pool:
        made = list(pool.map(partial(_picture, folder, records, width, height), names))
    blank = [np.full_like(made[0], 255)] * (high * wide - len(names))
    return np.stack(made + blank).reshape(high, wide, height, width, 3)


def _arranged(axes: Axes) -> tuple[Axes, Axes]:
    """Return the axes of the rows and those of the columns, as near to a square as their order allows."""
    varied = [axis for axis in axes if len(axis[1]) > 1]
    square = sqrt(_count(varied))
    split = min(range(1, len(varied)), key=lambda rows: abs(_count(varied[:rows]) - square), default=0)
    return varied[:split], varied[split:]


def _count(axes: Axes) -> int:
    return prod(len(values) for _, values in axes)


def _figure(grid: NDArray[np.uint8], rows: Axes, columns: Axes, *, wrapped: bool) -> Figure:
    (row_title, row_labels), (column_title, column_labels) = _labels(rows), _labels(columns)
    if wrapped:
        return contact_figure(grid, captions=[f"{column_title} {label}".strip() for label in column_labels])
    return contact_figure(grid, row_labels, column_labels, row_title, column_title)


def _labels(axes: Axes) -> tuple[str, list[str]]:
    """Return the title of some axes together, and the labels of their crossed values."""
    titles = [title for title, _ in axes if title]
    return ", ".join(titles), [", ".join(values) for values in product(*(values for _, values in axes))]


def _picture(folder: Path, records: Mapping[str, Record], width: int, height: int, name: str) -> NDArray[np.uint8]:
    """Return the last frame of an item, (height, width, 3) RGB."""
    record = records[name]
    if record.frames and record.fps:
        return read_last_frame(folder / name, record.frames, record.fps, width, height)
    run = load_trajectory(folder / name)
    video = run.scene.video.model_copy(update={"size": f"{width}x{height}"})
    return Painter(run, video).frame(run.t[-1])[..., :3].copy()


def _size(record: Record) -> tuple[int, int]:
    """Return the width and height of the video of a result's scene [pixels]."""
    assert record.scene
    wide, _, high = record.scene["video"]["size"].partition("x")
    return int(wide), int(high)


def _digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value).encode()).hexdigest()
