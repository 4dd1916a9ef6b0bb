"""Warnings as a line each."""

import io
import warnings

import pytest
from matplotlib.figure import Figure

from emovid import errors


@pytest.fixture(autouse=True)
def _ours(monkeypatch):
    """Have warnings shown as the command shows them, afresh."""
    monkeypatch.setattr(errors, "_fonts_told", set())
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        errors.say_warnings_in_one_line()
        yield


def test_warnings_are_one_line(capsys) -> None:
    warnings.warn("mind the gap", UserWarning, stacklevel=1)
    warnings.warn("mind the gap", UserWarning, stacklevel=1)
    assert capsys.readouterr().err == 2 * "warning: mind the gap\n"


def test_missing_glyphs_are_reported_once(capsys) -> None:
    figure = Figure()
    figure.text(0, 0, "幸福", family="DejaVu Sans")
    figure.text(0, 1, "悲伤", family="DejaVu Sans")
    for _ in range(2):
        figure.savefig(io.BytesIO(), format="svg")
    expected = "DejaVu Sans, the font of figures, lacks 幸 and maybe other characters: they are drawn as boxes"
    assert capsys.readouterr().err == f"warning: {expected}\n"
