import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "robotarium.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def maker() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_robotarium", DOCS / "make_robotarium.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_robotarium"] = module
    spec.loader.exec_module(module)
    return module


def row(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


@pytest.mark.parametrize("emotion", ["happiness", "surprise", "sadness", "fear", "disgust", "anger"])
def test_parameter_tables_match_the_scenes(maker: ModuleType, emotion: str) -> None:
    (section,) = [part for part in PAGE.split("\n### ") if part.startswith(emotion.capitalize())]
    table = section.split("\n\n")[1].splitlines()
    assert table[2:] == [row(cells) for cells in maker.parameters(emotion)]


def test_descriptor_table_matches_the_measurements(maker: ModuleType) -> None:
    # Only the emotion that is fastest to simulate; make robotarium-table computes all.
    (section,) = [part for part in PAGE.split("\n### ") if part.startswith("Sadness")]
    table = section.split("\n\n")[2].splitlines()
    assert table[2:] == [row(cells) for cells in maker.descriptors("sadness")]


def test_tables_are_replaced_between_their_markers(maker: ModuleType) -> None:
    page = "before\n<!-- tables -->\n\nold\n\n<!-- end -->\nafter\n"
    assert maker.with_tables(page, r"new \1") == "before\n<!-- tables -->\n\nnew \\1\n\n<!-- end -->\nafter\n"
    assert maker.with_tables(maker.with_tables(page, "new"), "new") == maker.with_tables(page, "new")
