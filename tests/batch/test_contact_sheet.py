"""The contact sheet of a sweep: its layout, and the conditions for making it again."""

import os
from pathlib import Path

import pytest
from PIL import Image

from emovid.batch import contact_sheet
from emovid.batch.contact_sheet import write_contact_sheet
from emovid.batch.job import make
from emovid.batch.manifest import Journal
from emovid.batch.sweep import axes
from emovid.batch.sweep_file import read_sweep
from tests.helpers.batches import jobs

WIDE, HIGH = 480, 270  # the largest width of a picture [pixels]


@pytest.fixture
def draw(tmp_path):
    """Return a function that makes the items of a sweep and its sheet, and returns the path of the sheet."""

    def draw_sheet(varied: str) -> Path:
        text = f"only: trajectory\nscenes: [fear]\nset: {{duration: 0.25, robots: 2}}\n{varied}\n"
        (tmp_path / "sweep.yaml").write_text(text)
        sweep = read_sweep(tmp_path / "sweep.yaml")
        records = {job.target.name: make(job) for job in jobs(sweep, tmp_path)}
        with Journal(tmp_path) as journal:
            for name, record in records.items():
                journal.add(name, record)
        write_contact_sheet(tmp_path, list(records), axes(sweep), records, 1)
        return tmp_path / contact_sheet.NAME

    return draw_sheet


def size(file: Path) -> tuple[int, int]:
    with Image.open(file) as picture:
        return picture.size


@pytest.mark.parametrize(
    ("varied", "columns", "rows"),
    [
        ("seeds: 1", 1, 1),
        ("seeds: 3", 3, 1),
        ("seeds: 9", 3, 3),  # more than fit in one row
        ("seeds: 2\ngrid: {robot.K: [4, 8, 12]}", 2, 3),
    ],
)
def test_varied_values_are_rows_and_columns(draw, varied, columns, rows) -> None:
    width, height = size(draw(varied))
    assert columns * WIDE < width < (columns + 1) * WIDE
    assert rows * HIGH < height < (rows + 1) * HIGH


def test_sheet_is_rebuilt_only_when_its_pictures_change(draw) -> None:
    file = draw("seeds: 2")
    os.utime(file, (0, 0))
    assert draw("seeds: 2").stat().st_mtime == 0
    assert draw("seeds: [2, 3]").stat().st_mtime > 0
    shown = file.read_bytes()
    file.write_bytes(b"damaged")
    assert draw("seeds: [2, 3]").read_bytes() == shown


def test_no_sheet_is_made_for_too_many_rows(draw, monkeypatch) -> None:
    monkeypatch.setattr(contact_sheet, "MAX_SIDE", 2)
    assert draw("seeds: 2").exists()
    draw("seeds: 2").unlink()
    assert not draw("seeds: 3").exists()
