import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def runner(tmp_path, monkeypatch) -> SimpleNamespace:
    """Load the runner, with two benchmarks of its own in a folder of its own."""
    module = runpy.run_path(str(BENCHMARKS / "__main__.py"))
    scripts = {"one": "print('1.0 s')", "two": "print('2.0 s')\nraise SystemExit(1)"}
    for name, code in scripts.items():
        (tmp_path / f"{name}.py").write_text(code)
    names = module["main"].__globals__
    shipped = names["BENCHES"]
    monkeypatch.setitem(names, "HERE", tmp_path)
    monkeypatch.setitem(names, "RESULTS", tmp_path / "RESULTS.md")
    monkeypatch.setitem(names, "BENCHES", {"one": "First", "two": "Second"})
    return SimpleNamespace(main=module["main"], results=tmp_path / "RESULTS.md", shipped=shipped)


def test_every_benchmark_has_its_section(runner) -> None:
    scripts = {path.stem for path in BENCHMARKS.glob("*.py")}
    assert scripts - {"__main__", "processes"} == set(runner.shipped)


def test_results_record_how_they_were_made(runner) -> None:
    runner.main(["one"])
    text = runner.results.read_text()
    assert "## First\n\n`python benchmarks/one.py`, 20" in text
    assert "cores" in text
    assert "numpy" in text
    assert "```text\n1.0 s\n```" in text
    assert "Second" not in text


def test_handwritten_text_and_other_sections_are_kept(runner) -> None:
    runner.main(["one"])
    with pytest.raises(SystemExit, match="failed: two"):
        runner.main(["two"])
    before = runner.results.read_text()
    runner.results.write_text(before.replace("## First\n", "## First\n\nOut of reach: see `two`.\n"))
    runner.main(["one"])
    after = runner.results.read_text()
    assert after.count("Out of reach") == after.count("1.0 s") == after.count("2.0 s") == 1
    assert after.index("Out of reach") < after.index("1.0 s") < after.index("## Second") < after.index("2.0 s")


def test_an_unknown_benchmark_is_named(runner) -> None:
    with pytest.raises(SystemExit, match="no benchmark three: there are one, two"):
        runner.main(["three"])
    assert not runner.results.exists()


def test_cost_of_a_process_is_measured_and_failures_are_raised() -> None:
    cost = runpy.run_path(str(BENCHMARKS / "processes.py"))["cost"]
    code = "import sys; size = len(bytearray(200 * 2**20)); assert sys.stdin.read() == 'given'"
    used = cost([sys.executable, "-c", code], given=[b"gi", b"ven"])
    assert used.memory > 200
    assert used.cpu > 0
    with pytest.raises(subprocess.CalledProcessError):
        cost([sys.executable, "-c", "raise SystemExit(3)"])
