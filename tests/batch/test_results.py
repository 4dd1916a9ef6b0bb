"""The table of a sweep: as CSV and as Parquet the same, whatever kinds of values are set."""

import csv
import json

import pytest

from emovid.batch import results
from emovid.batch.job import Record
from emovid.batch.results import write_table
from emovid.batch.sweep import items
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


@pytest.fixture
def swept(tmp_path):
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    found = items(read_sweep(tmp_path / "sweep.yaml"))
    write_table(
        tmp_path, found, {item.name: Record("measure", descriptors={"speed": item.number / 2}) for item in found[:-1]}
    )
    return tmp_path


def test_cells_are_as_in_the_sweep(swept) -> None:
    with (swept / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["item"] for row in rows] == ["1", "2", "3"]  # the last is not finished
    assert [row["speed"] for row in rows] == ["0.5", "1.0", "1.5"]
    for row, cells in zip(rows, CELLS, strict=True):
        assert {key: row[key] for key in list(row)[3:-1] if row[key]} == cells


def test_parquet_says_the_same_and_keeps_numbers(swept) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    with (swept / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    read = parquet.read_table(swept / "results.parquet").to_pylist()
    for row, told in zip(read, rows, strict=True):
        text = {key: json.dumps(value) if isinstance(value, bool) else value for key, value in row.items()}
        assert {key: "" if value is None else str(value) for key, value in text.items()} == told
    assert [row["robot.K"] for row in read] == [2.0, 2.5, None]
    assert read[2]["video.trails.fade"] is False


def test_without_pyarrow_there_is_no_parquet(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(results, "find_spec", lambda name: None)
    write_table(tmp_path, [], {})
    assert [path.name for path in tmp_path.iterdir()] == ["results.csv"]


def test_a_sweep_with_nothing_finished_is_a_table_without_rows(tmp_path) -> None:
    write_table(tmp_path, [], {})
    assert (tmp_path / "results.csv").read_text() == "item,name\n"


def test_values_of_several_kinds_are_words_in_parquet(tmp_path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    (tmp_path / "sweep.yaml").write_text("only: measure\nscenes: [fear, anger, sadness]\n")
    found = items(read_sweep(tmp_path / "sweep.yaml"))
    kinds = {
        item.name: Record("measure", descriptors={"gait": gait})
        for item, gait in zip(found, (1.5, "slow", None), strict=True)
    }
    write_table(tmp_path, found, kinds)
    assert parquet.read_table(tmp_path / "results.parquet")["gait"].to_pylist() == ["1.5", "slow", None]
