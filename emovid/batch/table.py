"""The results of a sweep as a table: a row for each finished item, as CSV and, where pyarrow is there, as Parquet."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from emovid.atomic_io import replace_if_changed
from emovid.batch.job import Record
from emovid.batch.sweep import Item

NAME = "results.csv"
_FACTS = ("frames", "samples", "trajectory_sha256", "frames_crc32", "sha256")


def write_results(folder: Path, items: Sequence[Item], records: Mapping[str, Record]) -> None:
    """Write `results.csv`, and `results.parquet` if pyarrow is there, unless they say this already.

    Args:
        folder: to write to.
        items: of the sweep.
        records: of the finished ones, by name.
    """
    rows = [_row(item, records[item.name]) for item in items if item.name in records]
    replace_if_changed(folder / NAME, _csv(rows))
    if find_spec("pyarrow"):
        replace_if_changed((folder / NAME).with_suffix(".parquet"), _parquet(rows))


def _row(item: Item, record: Record) -> dict[str, Any]:
    facts = {key: record[key] for key in _FACTS if key in record}
    return {"item": item.number, "name": item.name, **item.cells, **record.get("descriptors", {}), **facts}


def _csv(rows: list[dict[str, Any]]) -> bytes:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    columns = _columns(rows)
    table.writerow(columns)
    table.writerows([_cell(row.get(column)) for column in columns] for row in rows)
    return text.getvalue().encode()


def _parquet(rows: list[dict[str, Any]]) -> bytes:
    import pyarrow as pa  # noqa: PLC0415 - not everyone has it
    from pyarrow import parquet  # noqa: PLC0415

    columns = {}
    for name in _columns(rows):
        values = [row.get(name) for row in rows]
        values = [json.dumps(value) if isinstance(value, list | dict) else value for value in values]  # some it refuses
        try:
            columns[name] = pa.array(values)
        except (pa.ArrowInvalid, pa.ArrowTypeError):  # values of several kinds
            columns[name] = pa.array([None if value is None else str(_cell(value)) for value in values])
    file = io.BytesIO()
    parquet.write_table(pa.table(columns), file)
    return file.getvalue()


def _columns(rows: list[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(key for row in rows for key in row)) or ["item", "name"]


def _cell(value: Any) -> Any:
    return json.dumps(value) if isinstance(value, bool | list | dict) else value
