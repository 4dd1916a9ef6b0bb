"""Tests named in docs/statistics.md exist, and the rates in docs/validation.md are near their nominal values."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STATISTICS = (ROOT / "docs" / "statistics.md").read_text(encoding="utf-8")
VALIDATION = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (.*?) \| (.*?) \| (0\.\d+) \| (0\.\d+) ± (0\.\d+) \|", VALIDATION, re.MULTILINE)


def test_every_test_file_named_in_the_tables_exists() -> None:
    named = set(re.findall(r"`(test_\w+\.py)`", STATISTICS))
    assert len(named) >= 9
    assert named <= {path.name for path in (ROOT / "tests").rglob("test_*.py")}


@pytest.mark.parametrize(("name", "situation", "nominal", "found", "error"), ROWS)
def test_sizes_and_coverages_are_near_nominal(name, situation, nominal, found, error) -> None:
    # Three standard errors, plus two percentage points for tests that are not exact.
    slack = 3 * float(error) + 0.02
    if float(nominal) < 0.5:
        assert float(found) <= float(nominal) + slack
    else:
        assert abs(float(found) - float(nominal)) <= slack


def test_every_test_and_interval_is_validated() -> None:
    assert len(ROWS) >= 25
