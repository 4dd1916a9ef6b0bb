"""Progress bars: one for each running item, for any order of reports from other threads."""

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


def test_each_running_item_and_the_total_have_a_bar(capsys) -> None:
    with reporter(2, quiet=False) as report:
        report.advanced(job("a.mp4"), 1, 4)
        report.advanced(job("b.mp4"), 2, 4)
        report.advanced(job("a.mp4"), 3, 4)
        assert shown(report) == {"all": (0, 2), "a.mp4": (3, 4), "b.mp4": (2, 4)}
        report.finished(job("a.mp4"), Record("video", frames=4), made=True)
        assert shown(report) == {"all": (1, 2), "b.mp4": (2, 4)}
    assert "[1/2] a.mp4: 4 frames" in capsys.readouterr().err


@pytest.mark.parametrize("end", ["finished", "failed"])
def test_late_progress_report_does_not_restore_a_bar(end) -> None:
    with reporter(2, quiet=False) as report:
        report.advanced(job("a.mp4"), 1, 4)
        report.finished(job("a.mp4"), Record("video", frames=4), made=True) if end == "finished" else report.failed(
            job("a.mp4"), EmovidError("a.mp4: no")
        )
        report.advanced(job("a.mp4"), 4, 4)
        assert "a.mp4" not in shown(report)


def test_bar_restarts_when_the_worker_of_an_item_dies(capsys) -> None:
    with reporter(2, quiet=False) as report:
        report.advanced(job("a.mp4"), 3, 4)
        report.died(job("a.mp4"), 1)
        assert "a.mp4" not in shown(report)
        report.advanced(job("a.mp4"), 1, 4)
        assert shown(report)["a.mp4"] == (1, 4)
    assert "a.mp4: its worker died, attempt 1; another worker tries again" in capsys.readouterr().err


def test_worker_death_before_the_start_of_an_item_is_handled(capsys) -> None:
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


def test_single_item_has_no_total_bar() -> None:
    with reporter(1, quiet=False) as report:
        report.advanced(job("a.mp4"), 1, 4)
        assert list(shown(report)) == ["a.mp4"]


def test_listed_items_are_named_beside_the_bar(tmp_path) -> None:
    said = on_a_terminal("figures", "shapes", "densities", "-o", str(tmp_path), "--format", "pdf").decode()
    assert "shapes" in said
    assert "2/2" in said


@pytest.mark.parametrize("name", ["run.npz", f"{80 * 'r'}.npz", "[red]run.npz"])
def test_counted_steps_have_a_bar(name, tmp_path) -> None:
    folder = tmp_path / ("a-folder-with-a-long-name" + 60 * "-")
    said = on_a_terminal("simulate", "sadness", "-o", str(folder / name)).decode()
    assert name[-20:] in said
    assert re.search(r"━━━ (\d{3})/\1 ", re.sub(r"\x1b\[[0-9;]*m", "", said))
