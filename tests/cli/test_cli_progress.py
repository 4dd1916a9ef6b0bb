"""Bars on a terminal: one for each item under way, in whatever order other threads say what happens."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from emovid.batch.job import Record
from emovid.cli import terminal
from emovid.cli.terminal import reporter
from emovid.errors import EmovidError
from tests.helpers.terminal import on_a_terminal


@pytest.fixture(autouse=True)
def _terminal(monkeypatch) -> None:
    monkeypatch.setattr(terminal, "is_interactive", lambda: True)


def job(name: str) -> SimpleNamespace:
    return SimpleNamespace(target=Path(name))


def shown(report) -> dict[str, tuple[float, float | None]]:
    return {str(task.description): (task.completed, task.total) for task in report.progress.tasks if task.visible}


def test_there_is_a_bar_for_each_item_under_way_and_one_for_all(capsys) -> None:
    with reporter(2, quiet=False) as report:
        report.advanced(job("a.mp4"), 1, 4)
        report.advanced(job("b.mp4"), 2, 4)
        report.advanced(job("a.mp4"), 3, 4)
        assert shown(report) == {"all": (0, 2), "a.mp4": (3, 4), "b.mp4": (2, 4)}
        report.finished(job("a.mp4"), Record("video", frames=4), made=True)
        assert shown(report) == {"all": (1, 2), "b.mp4": (2, 4)}
    assert "[1/2] a.mp4: 4 frames" in capsys.readouterr().err


@pytest.mark.parametrize("end", ["finished", "failed"])
def test_a_report_that_comes_after_the_end_brings_no_bar_back(end) -> None:
    with reporter(2, quiet=False) as report:
        report.advanced(job("a.mp4"), 1, 4)
        report.finished(job("a.mp4"), Record("video", frames=4), made=True) if end == "finished" else report.failed(
            job("a.mp4"), EmovidError("a.mp4: no")
        )
        report.advanced(job("a.mp4"), 4, 4)
        assert "a.mp4" not in shown(report)


def test_an_item_whose_worker_died_starts_again(capsys) -> None:
    with reporter(2, quiet=False) as report:
        report.advanced(job("a.mp4"), 3, 4)
        report.died(job("a.mp4"), 1)
        assert "a.mp4" not in shown(report)
        report.advanced(job("a.mp4"), 1, 4)
        assert shown(report)["a.mp4"] == (1, 4)
    assert "a.mp4: its worker died, attempt 1; another worker tries again" in capsys.readouterr().err


def test_an_item_whose_worker_died_before_it_began_has_no_bar_to_end(capsys) -> None:
    with reporter(2, quiet=False) as report:
        report.died(job("a.mp4"), 1)
        assert shown(report) == {"all": (0, 2)}
        report.advanced(job("a.mp4"), 1, 4)
        assert shown(report)["a.mp4"] == (1, 4)


def test_quiet_reports_failures_only(capsys) -> None:
    with reporter(2, quiet=True) as report:
        report.advanced(job("a.mp4"), 3, 4)
        report.died(job("a.mp4"), 1)
        report.failed(job("a.mp4"), EmovidError("a.mp4: no"))
        report.noted("no workers yet")
        report.finished(job("b.mp4"), Record("video", frames=4), made=True)
    assert capsys.readouterr() == ("", "a.mp4: no\n")


def test_one_item_needs_no_bar_for_all() -> None:
    with reporter(1, quiet=False) as report:
        report.advanced(job("a.mp4"), 1, 4)
        assert list(shown(report)) == ["a.mp4"]


def test_what_is_listed_is_named_beside_a_bar(tmp_path) -> None:
    said = on_a_terminal("figures", "shapes", "densities", "-o", str(tmp_path), "--format", "pdf").decode()
    assert "shapes" in said
    assert "2/2" in said


@pytest.mark.parametrize("name", ["run.npz", f"{80 * 'r'}.npz", "[red]run.npz"])
def test_what_is_counted_has_a_bar(name, tmp_path) -> None:
    folder = tmp_path / ("a-folder-with-a-long-name" + 60 * "-")
    said = on_a_terminal("simulate", "sadness", "-o", str(folder / name)).decode()
    assert name[-20:] in said
    assert re.search(r"━━━ (\d{3})/\1 ", re.sub(r"\x1b\[[0-9;]*m", "", said))
