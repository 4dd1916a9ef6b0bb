"""The table of a sweep's results, as CSV and as Parquet."""

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from emovid.atomic_io import replace_if_changed
from emovid.batch.contact_sheet import write_contact_sheet
from emovid.batch.job import Record
from emovid.batch.manifest import has_journals, read_manifest
from emovid.batch.sweep import Items, axes
from emovid.batch.versions import versions
from emovid.csv_writer import csv_text

TABLE = "results.csv"
PARQUET = "results.parquet"
_FACTS = ("frames", "samples", "trajectory_sha256", "frames_crc32", "sha256")


@dataclass(frozen=True)
class Table:
    """The table of a sweep: a row for each finished item.

    Attributes:
        columns: their names.
        rows: values by column.
    """

    columns: Sequence[str]
    rows: Sequence[Mapping[str, Any]]

    @property
    def csv(self) -> bytes:
        """The text of `results.csv`."""
        return csv_text(self.columns, ((_cell(row.get(name)) for name in self.columns) for row in self.rows)).encode()

    @property
    def parquet(self) -> bytes:
        """The bytes of `results.parquet`; needs pyarrow."""
        pa, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
        columns = {}
        for name in self.columns:
            values = [row.get(name) for row in self.rows]
            values = [json.dumps(value) if isinstance(value, list | dict) else value for value in values]
            try:
                columns[name] = pa.array(values)
            except (pa.ArrowInvalid, pa.ArrowTypeError):  # values of several types
                columns[name] = pa.array([None if value is None else str(_cell(value)) for value in values])
        file = io.BytesIO()
        parquet.write_table(pa.table(columns), file)
        return file.getvalue()


def finished_items(folder: Path, items: Items, records: Mapping[str, Record]) -> dict[int, str]:
    """Return the names of the results that exist and have today's versions, by the number of their item."""
    wanted = cache(lambda barrier: versions(items.sweep.only, barrier=barrier))
    return {
        number: name
        for number, name in items.numbers_of(records).items()
        if records[name].versions == wanted(records[name].has_barrier)
        and (not records[name].has_file or (folder / name).exists())
    }


def table_of(items: Items, finished: Mapping[int, str], records: Mapping[str, Record]) -> Table:
    """Return the table of some items.

    Args:
        items: of the sweep.
        finished: names of results, by the number of their item.
        records: by name.
    """
    rows = [_row(items, number, name, records[name]) for number, name in finished.items()]
    return Table(list(dict.fromkeys(key for row in rows for key in row)) or ["item", "name"], rows)


def write_table(folder: Path, table: Table) -> None:
    """Write `results.csv`, and `results.parquet` if pyarrow is installed."""
    replace_if_changed(folder / TABLE, table.csv)
    if find_spec("pyarrow"):
        replace_if_changed(folder / PARQUET, table.parquet)


def is_parquet_of_sweep(data: bytes) -> bool:
    """Return whether a file is a `results.parquet` that `write_table` wrote; a damaged file counts as one."""
    if not find_spec("pyarrow"):
        return True  # the file is not replaced then
    pa, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    try:
        return bool(parquet.read_schema(io.BytesIO(data)).names[:2] == ["item", "name"])
    except (pa.ArrowException, OSError):
        return True


def same_parquet(one: bytes, other: bytes) -> bool:
    """Return whether two Parquet files hold equal tables, for all versions of pyarrow that wrote them."""
    pa, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    try:
        return bool(parquet.read_table(io.BytesIO(one)).equals(parquet.read_table(io.BytesIO(other))))
    except (pa.ArrowException, OSError):
        return False


def write_summary(folder: Path, items: Items, threads: int = 0) -> int:
    """Write the table of all finished items, of this run or another one, and the contact sheet once all are finished.

    Args:
        folder: of the results.
        items: of the sweep.
        threads: number of videos to read at once for the contact sheet; 0 for no contact sheet.

    Returns:
        The number of finished items.
    """
    records, before = read_manifest(folder), None
    while records != before:
        finished = finished_items(folder, items, records)
        write_table(folder, table_of(items, finished, records))
        # A run that has ended meanwhile may have written its table before this one; a run in progress will write later.
        records, before = records if has_journals(folder) else read_manifest(folder), records
    if threads and len(finished) == len(items) and items.sweep.only != "measure":
        write_contact_sheet(folder, list(finished.values()), axes(items.sweep), records, threads)
    return len(finished)


def _row(items: Items, number: int, name: str, record: Record) -> dict[str, Any]:
    facts = {key: value for key in _FACTS if (value := getattr(record, key)) is not None}
    if not record.has_file:
        facts.pop("sha256", None)
    return {"item": number, "name": name, **items.cells(number), **(record.descriptors or {}), **facts}


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    return json.dumps(value) if isinstance(value, bool | list | dict) else value
