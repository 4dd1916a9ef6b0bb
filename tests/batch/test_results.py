"""The table of a sweep: equal as CSV and Parquet for all types of values."""

import csv
import json

import pytest

from emovid.batch import results
from emovid.batch.job import Record
from emovid.batch.results import Table, table_of, write_table
from emovid.batch.sweep import Items
from emovid.batch.sweep_file import read_sweep

SWEEP = """
scenes: [anger]
list:
  - {robot.K: 2.0, video.overlays: {}, safety: none}
  - {robot.K: 2.5, robot.limits: model, safety: {kind: none}}
  - {robot.limits: {v_max: 1}, video.trails.fade: false, snapshots: [0, 1]}
  - {robot.K: 3}
"""
CELLS = [
    {"robot.K": "2.0", "video.overlays": "{}", "safety": "none"},
    {"robot.K": "2.5", "robot.limits": "model", "safety": '{"kind": "none"}'},
    {"robot.limits": '{"v_max": 1}', "video.trails.fade": "false", "snapshots": "[0, 1]"},
]

EMPTY = Table(["item", "name"], [])


@pytest.fixture
def swept(tmp_path):
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    items = Items(read_sweep(tmp_path / "sweep.yaml"))
    records = {f"r{i}": Record("measure", descriptors={"speed": i / 2}) for i in (1, 2, 3)}  # the last is not finished
    write_table(tmp_path, table_of(items, {i: f"r{i}" for i in (1, 2, 3)}, records))
    return tmp_path


def test_table_cells_are_the_settings_of_the_sweep(swept) -> None:
    with (swept / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["item"] for row in rows] == ["1", "2", "3"]
    assert [row["speed"] for row in rows] == ["0.5", "1.0", "1.5"]
    for row, cells in zip(rows, CELLS, strict=True):
        assert {key: row[key] for key in list(row)[3:-1] if row[key]} == cells


def test_parquet_has_the_same_cells_and_keeps_numbers(swept) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    with (swept / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    read = parquet.read_table(swept / "results.parquet").to_pylist()
    for row, told in zip(read, rows, strict=True):
        text = {key: json.dumps(value) if isinstance(value, bool) else value for key, value in row.items()}
        assert {key: "" if value is None else str(value) for key, value in text.items()} == told
    assert [row["robot.K"] for row in read] == [2.0, 2.5, None]
    assert read[2]["video.trails.fade"] is False


def test_parquet_is_skipped_without_pyarrow(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(results, "find_spec", lambda name: None)
    write_table(tmp_path, EMPTY)
    assert [path.name for path in tmp_path.iterdir()] == ["results.csv"]


def test_sweep_without_finished_items_has_an_empty_table(tmp_path) -> None:
    write_table(tmp_path, EMPTY)
    assert (tmp_path / "results.csv").read_text() == "item,name\n"


def test_columns_of_mixed_types_are_text_in_parquet(tmp_path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    (tmp_path / "sweep.yaml").write_text("only: measure\nscenes: [fear, anger, sadness]\n")
    items = Items(read_sweep(tmp_path / "sweep.yaml"))
    kinds = {f"r{i}": Record("measure", descriptors={"gait": gait}) for i, gait in enumerate((1.5, "slow", None), 1)}
    write_table(tmp_path, table_of(items, {i: f"r{i}" for i in (1, 2, 3)}, kinds))
    assert parquet.read_table(tmp_path / "results.parquet")["gait"].to_pylist() == ["1.5", "slow", None]
