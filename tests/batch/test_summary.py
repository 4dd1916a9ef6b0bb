"""What a sweep leaves besides its items, when several runs into one folder end at once."""

import csv

import pytest

from emovid.batch import results
from emovid.batch.job import make
from emovid.batch.manifest import Journal
from emovid.batch.results import write_summary
from emovid.batch.sweep import items
from emovid.batch.sweep_file import read_sweep

SWEEP = "only: measure\nscenes: [fear]\nset: {duration: 0.5, robots: 3}\nseeds: 3\n"


@pytest.fixture
def run_item(tmp_path):
    """Give a function that does one item of the sweep as a run of its own, and then what a run does at its end."""
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    sweep = read_sweep(tmp_path / "sweep.yaml")
    every = items(sweep)

    def run(number: int) -> int:
        with Journal(tmp_path) as journal:
            item = every[number]
            journal.add(item.name, make(item.job(tmp_path, sweep.only)))
        return write_summary(tmp_path, sweep, every, 1)

    return run


def test_whoever_ends_last_leaves_the_table_of_all(run_item, tmp_path, monkeypatch) -> None:
    run_item(0)
    write, written = results.write_table, []

    def write_late(*of: object) -> None:
        written.append(of)
        if len(written) == 1:
            run_item(2)  # another run, which ends while this one is about to write
        write(*of)

    monkeypatch.setattr(results, "write_table", write_late)
    assert run_item(1) == 3
    with (tmp_path / "results.csv").open(newline="") as file:
        assert [row["item"] for row in csv.DictReader(file)] == ["1", "2", "3"]


def test_runs_that_go_on_are_not_waited_for(run_item, tmp_path, monkeypatch) -> None:
    written = []

    def write(*of: object) -> None:
        written.append(of)
        (tmp_path / ".manifest.json.elsewhere-1.journal").write_text(f'["{len(written)}", {{"only": "measure"}}]\n')

    monkeypatch.setattr(results, "write_table", write)
    assert run_item(1) == 1
    assert len(written) == 1
