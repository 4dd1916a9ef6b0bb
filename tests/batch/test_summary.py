"""The table of a sweep when several runs into one folder end at the same time."""

import csv

import pytest

from emovid.batch import results
from emovid.batch.job import make
from emovid.batch.manifest import Journal
from emovid.batch.results import write_summary
from emovid.batch.sweep import Items
from emovid.batch.sweep_file import read_sweep
from tests.helpers.batches import jobs

SWEEP = "only: measure\nscenes: [fear]\nset: {duration: 0.5, robots: 3}\nseeds: 3\n"


@pytest.fixture
def run_item(tmp_path):
    """Return a function that makes one item and writes the summary, as a separate run."""
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    sweep = read_sweep(tmp_path / "sweep.yaml")
    every = jobs(sweep, tmp_path)

    def run(number: int) -> int:
        with Journal(tmp_path) as journal:
            job = every[number]
            journal.add(job.target.name, make(job))
        return write_summary(tmp_path, Items(sweep), 1)

    return run


def test_last_run_to_end_writes_the_complete_table(run_item, tmp_path, monkeypatch) -> None:
    run_item(0)
    write, written = results.write_table, []

    def write_late(*of: object) -> None:
        written.append(of)
        if len(written) == 1:
            run_item(2)  # another run, which ends just before this one writes
        write(*of)

    monkeypatch.setattr(results, "write_table", write_late)
    assert run_item(1) == 3
    with (tmp_path / "results.csv").open(newline="") as file:
        assert [row["item"] for row in csv.DictReader(file)] == ["1", "2", "3"]


def test_parallel_runs_do_not_wait_for_each_other(run_item, tmp_path, monkeypatch) -> None:
    written = []

    def write(*of: object) -> None:
        written.append(of)
        (tmp_path / ".manifest.json.0123456789ab-1-1.journal").write_text(
            f'["{len(written)}", {{"only": "measure"}}]\n'
        )

    monkeypatch.setattr(results, "write_table", write)
    assert run_item(1) == 1
    assert len(written) == 1
