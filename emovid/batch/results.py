"""Files of a sweep besides its items: the plan, the table of results and the contact sheet."""

import io
import json
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from emovid.atomic_io import make_folder, replace_if_changed
from emovid.batch.contact_sheet import write_contact_sheet
from emovid.batch.job import Record
from emovid.batch.manifest import has_journals, read_manifest
from emovid.batch.sweep import Item, axes
from emovid.batch.sweep_file import Sweep
from emovid.csv_writer import csv_text

PLAN, TABLE = "plan.json", "results.csv"
_FACTS = ("frames", "samples", "trajectory_sha256", "frames_crc32", "sha256")


def write_plan(folder: Path, sweep: Sweep) -> None:
    """Write `plan.json`: the sweep in one file, for `emovid status` and for those who repeat it."""
    make_folder(folder)
    replace_if_changed(folder / PLAN, sweep.plan().encode())


def write_summary(folder: Path, sweep: Sweep, items: Sequence[Item], threads: int) -> int:
    """Write the table of all finished items, of this run or another one, and the contact sheet once all are finished.

    Args:
        folder: of the results.
        sweep: of the items.
        items: all of them.
        threads: number of videos to read at once.

    Returns:
        The number of finished items.
    """
    known, before = read_manifest(folder), None
    while known != before:
        records = _finished(folder, sweep, items, known)
        write_table(folder, items, records)
        # A run that has ended meanwhile may have written its table before this one; a run in progress will write later.
        known, before = known if has_journals(folder) else read_manifest(folder), known
    if len(records) == len(items) and sweep.only != "measure":
        write_contact_sheet(folder, items, axes(sweep), records, threads)
    return len(records)


def write_table(folder: Path, items: Iterable[Item], records: Mapping[str, Record]) -> None:
    """Write `results.csv`, and `results.parquet` if pyarrow is installed; unchanged files keep their dates.

    Args:
        folder: of the results.
        items: of the sweep.
        records: of the finished items, by name.
    """
    rows = [_row(item, records[item.name]) for item in items if item.name in records]
    columns = list(dict.fromkeys(key for row in rows for key in row)) or ["item", "name"]
    text = csv_text(columns, ((_cell(row.get(column)) for column in columns) for row in rows))
    replace_if_changed(folder / TABLE, text.encode())
    if find_spec("pyarrow"):
        replace_if_changed((folder / TABLE).with_suffix(".parquet"), _parquet(columns, rows))


def _finished(folder: Path, sweep: Sweep, items: Sequence[Item], known: Mapping[str, Record]) -> dict[str, Record]:
    """Return the records of the items that are finished, by name."""
    finished = {}
    for item in items:
        record, job = known.get(item.name), item.job(folder, sweep.only)
        if record and record.recipe == job.recipe and (sweep.only == "measure" or job.target.exists()):
            finished[item.name] = record
    return finished


def _row(item: Item, record: Record) -> dict[str, Any]:
    facts = {key: value for key in _FACTS if (value := getattr(record, key)) is not None}
    return {"item": item.number, "name": item.name, **item.cells, **(record.descriptors or {}), **facts}


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    return json.dumps(value) if isinstance(value, bool | list | dict) else value


def _parquet(names: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> bytes:
    pa, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")  # not everyone has it
    columns = {}
    for name in names:
        values = [row.get(name) for row in rows]
        values = [json.dumps(value) if isinstance(value, list | dict) else value for value in values]
        try:
            columns[name] = pa.array(values)
        except (pa.ArrowInvalid, pa.ArrowTypeError):  # values of several types
            columns[name] = pa.array([None if value is None else str(_cell(value)) for value in values])
    file = io.BytesIO()
    parquet.write_table(pa.table(columns), file)
    return file.getvalue()
