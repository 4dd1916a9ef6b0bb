"""The folder of a sweep: checks of its table and plan, a changed sweep file, and parallel sweeps."""

import json
import os
import re
from pathlib import Path

import pytest

from emovid.cli.main import main
from tests.helpers.owners import DEAD, PARENT

SWEEP = "only: measure\nscenes: [anger]\nset: {duration: 0.4, robots: 4}\nseeds: [1, 2]\n"
TABLES = ["results.csv", "results.parquet"]


@pytest.fixture(scope="module")
def swept(tmp_path_factory) -> Path:
    """Return a folder with a finished sweep in `out`."""
    folder = tmp_path_factory.mktemp("swept")
    (folder / "s.yaml").write_text(SWEEP)
    assert main(["sweep", str(folder / "s.yaml"), "-o", str(folder / "out"), "-q", "-j", "1"]) == 0
    return folder


@pytest.fixture(autouse=True)
def _copy(swept, tmp_path, monkeypatch) -> None:
    """Work beside a copy of the finished sweep."""
    (tmp_path / "s.yaml").write_text(SWEEP)
    (tmp_path / "out").mkdir()
    for file in (swept / "out").iterdir():
        (tmp_path / "out" / file.name).write_bytes(file.read_bytes())
    monkeypatch.chdir(tmp_path)


def names() -> list[str]:
    return sorted(json.loads(Path("out/manifest.json").read_text())["measurements"])


def change_descriptor() -> None:
    file = Path("out/manifest.json")
    file.write_text(re.sub(r'"speed_mean": [^,]*', '"speed_mean": 99', file.read_text(), count=1))


def test_rebuilt_measurements_without_changes_are_current(capsys) -> None:
    for command in (["status"], ["verify"], ["verify", "--rebuild", "-j", "1"]):
        assert main([*command, "out"]) == 0
        assert capsys.readouterr().out == "4 results: 4 current\n"


def test_changed_measurement_is_detected(capsys) -> None:
    change_descriptor()
    for command in ("verify", "status"):
        assert main([command, "out"]) == 1
        assert f"corrupt: {names()[0]}: its descriptors were changed" in capsys.readouterr().out
    assert main(["verify", "out", "--rebuild", "-j", "1"]) == 1
    assert f"changed: {names()[0]}: in the descriptors\n" in capsys.readouterr().out


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("state", ["missing", "corrupt"])
def test_missing_or_changed_table_is_detected_and_rebuilt(capsys, table, state) -> None:
    before = Path("out", table).read_bytes()
    Path("out", table).unlink() if state == "missing" else Path("out", table).write_bytes(b"junk\n")
    for command in ("status", "verify"):
        assert main([command, "out"]) == 1
        said = capsys.readouterr().out.splitlines()
        assert said[0].startswith(f"{state}: {table}: ")
        assert said[-1] == f"4 results: {', '.join(sorted(['3 current', f'1 {state}'], key=lambda part: part[2:]))}"
    if table == "results.csv" and state == "corrupt":
        Path("out", table).write_text("item,name\n")  # a file that emovid did not write is never replaced
    assert main(["sweep", "s.yaml", "-o", "out", "-q"]) == 0
    assert Path("out", table).read_bytes() == before


def test_missing_table_row_is_detected(capsys) -> None:
    lines = Path("out/results.csv").read_text().splitlines(keepends=True)
    Path("out/results.csv").write_text("".join(lines[:-1]))
    assert main(["verify", "out"]) == 1
    assert "corrupt: results.csv: not the table of these results" in capsys.readouterr().out


def test_status_compares_with_the_current_sweep_file(capsys) -> None:
    Path("s.yaml").write_text(SWEEP.replace("[1, 2]", "[2, 3]"))
    assert main(["status", "out"]) == 1
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("stale: plan.json: ")
    assert said[0].endswith("s.yaml has changed since")
    assert [line.split(": ")[0] for line in said[1:-1]] == ["missing", "unplanned"]
    assert main(["sweep", "s.yaml", "-o", "out", "-q", "-j", "1"]) == 2  # otherwise the table would lose a result
    assert main(["sweep", "s.yaml", "-o", "out", "-q", "-j", "1", "--force"]) == 0
    assert main(["status", "out"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "5 results: 4 current, 1 unplanned"


def test_dry_run_prints_its_plan_and_writes_nothing(capsys) -> None:
    before = {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in Path("out").iterdir()}
    changed, _ = names()
    change_descriptor()
    before["manifest.json"] = (Path("out/manifest.json").read_bytes(), Path("out/manifest.json").stat().st_mtime_ns)
    Path("s.yaml").write_text(SWEEP.replace("[1, 2]", "[1, 2, 3]"))
    assert main(["sweep", "s.yaml", "-o", "out", "--dry-run"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert sorted(line.split(": ")[0] for line in said[:-1]) == ["make", "replace"]
    assert f"replace: {changed}: corrupt: its descriptors were changed" in said
    assert said[-1] == "3 results: 1 to keep, 1 to make, 1 to replace"
    Path("s.yaml").write_text(SWEEP.replace("[1, 2]", "[3]"))
    assert main(["sweep", "s.yaml", "-o", "out", "-n", "--json", "--force"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"] == {"make": 1, "leave": 2}
    assert {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in Path("out").iterdir()} == before
    assert main(["sweep", "s.yaml", "-o", "new", "-n"]) == 0
    assert not Path("new").exists()


def test_second_sweep_in_a_folder_in_use_is_refused(capsys) -> None:
    Path("out", f".manifest.json.{PARENT}.journal").write_text('\n{"plan": "of another sweep"}\n')
    before = {path.name: path.read_bytes() for path in Path("out").iterdir()}
    Path("s.yaml").write_text(SWEEP.replace("[1, 2]", "[1, 2, 5]"))
    assert main(["sweep", "s.yaml", "-o", "out", "-j", "1"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == (
        "out: another sweep is being made there; expected another folder (-o), or wait"
    )
    assert {path.name: path.read_bytes() for path in Path("out").iterdir()} == before
    Path("out", f".manifest.json.{PARENT}.journal").rename(f"out/.manifest.json.{DEAD}.journal")
    assert main(["sweep", "s.yaml", "-o", "out", "-j", "1"]) == 0


def test_modification_times_of_current_results_are_updated(tmp_path) -> None:
    Path("t.yaml").write_text(SWEEP.replace("measure", "trajectory"))
    assert main(["sweep", "t.yaml", "-o", "t", "-q", "-j", "1"]) == 0
    files = [*Path("t").glob("*.npz"), Path("t/results.csv")]
    for file in files:
        os.utime(file, (0, 0))
    assert main(["sweep", "t.yaml", "-o", "t", "-q", "-j", "1"]) == 0
    assert all(file.stat().st_mtime > 0 for file in files)


def test_interrupted_sweep_writes_the_table_of_finished_items(capsys, monkeypatch) -> None:
    from emovid.batch import cache

    def interrupt(*_: object) -> None:
        raise SystemExit(143)

    Path("s.yaml").write_text(SWEEP.replace("[1, 2]", "[1, 2, 3, 4]"))
    placed = cache._placed
    monkeypatch.setattr(cache, "_placed", lambda job, *of: placed(job, *of) if job.scene.seed == 3 else interrupt())
    assert main(["sweep", "s.yaml", "-o", "out", "-j", "1"]) == 143
    said = capsys.readouterr().err.splitlines()
    assert said[-2:] == ["out/results.csv: 3 of 4 items", "terminated: run again to make what is missing"]
    assert len(Path("out/results.csv").read_text().splitlines()) == 4
    assert [path.name for path in Path("out").iterdir() if path.name.startswith(".")] == []
