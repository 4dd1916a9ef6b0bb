import re
from html import escape
from html.parser import HTMLParser

import pytest

from emovid.figures.paper_tables import (
    ATTRIBUTES,
    BEHAVIOURS,
    PAPER,
    SOURCES,
    Cell,
    Table,
    cited,
    named,
    table_html,
    table_latex,
    table_markdown,
)
from emovid.scene.emotions import EMOTIONS

TABLES = (ATTRIBUTES, BEHAVIOURS)


def rows(table: Table) -> dict[str, tuple[Cell, ...]]:
    return {name: cells for _, group in table.groups for name, cells in group}


def test_table_i_matches_the_paper() -> None:
    said = {name: tuple(cell.text for cell in cells) for name, cells in rows(ATTRIBUTES).items()}
    assert said == {
        "happiness": ("roundness, curvilinearity", "big", "smoothness"),
        "surprise": ("roundness", "very big", ""),
        "sadness": ("roundness", "small", "small, slow"),
        "anger": ("", "", "large, fast, angular"),
        "fear": ("downward pointing triangles", "", "small, slow"),
        "positive": ("roundness", "", "rounded movement trace"),
        "negative": ("angularity", "", "angular movement trace"),
    }


def test_table_ii_matches_the_emotions_of_the_scenes() -> None:
    for name, (behaviour, control) in rows(BEHAVIOURS).items():
        assert (behaviour.text, control.text) == (EMOTIONS[name].behaviour, EMOTIONS[name].control)
    assert list(rows(BEHAVIOURS)) == list(EMOTIONS)


@pytest.mark.parametrize("table", TABLES)
def test_exactly_the_cells_with_text_have_a_source(table) -> None:
    for cells in rows(table).values():
        for cell in cells:
            assert bool(cell.text) == bool(cell.sources) == bool(named(cell))
            assert set(cell.sources) <= set(SOURCES)
            assert 0 <= cell.note <= len(table.notes)
            assert bool(cell.place) == (cell.sources == (PAPER,))


def test_every_source_is_cited_somewhere() -> None:
    assert set(SOURCES) == {key for table in TABLES for key in cited(table)}


@pytest.mark.parametrize("table", TABLES)
def test_latex_is_a_balanced_booktabs_table(table) -> None:
    text = table_latex(table)
    body = "\n".join(line for line in text.splitlines() if not line.startswith("%"))
    assert body.count("{") == body.count("}")
    assert body.startswith(f"\\begin{{tabular}}{{{'l' * len(table.columns)}}}\n")
    assert body.endswith("\\end{tabular}")
    assert [body.count(rule) for rule in (r"\toprule", r"\bottomrule")] == [1, 1]
    assert body.count(r"\midrule") == len(table.groups)
    lines = [line for line in body.splitlines() if line.endswith(r"\\")]
    assert len(lines) == 1 + len(rows(table)) + sum(bool(title) for title, _ in table.groups) + len(table.notes)
    for line in lines:
        assert line.count("&") == len(table.columns) - 1 or r"\multicolumn" in line
    cites = set(re.findall(r"\\cite(?:\[[^\]]*\])?\{([^}]*)\}", body))
    assert {key for keys in cites for key in keys.split(",")} == set(cited(table))
    assert set(re.findall(r"^% (\w+): ", text, re.MULTILINE)) == set(cited(table))


def test_latex_special_characters_are_escaped() -> None:
    table = Table(("", "50 %"), (("", (("a_b", (Cell("x & y {z} #1 $2", ("Lee2007",)),)),)),))
    text = table_latex(table)
    assert r"50 \%" in text
    assert r"A\_b & x \& y \{z\} \#1 \$2 \cite{Lee2007} \\" in text


@pytest.mark.parametrize("table", TABLES)
def test_markdown_has_as_many_cells_in_every_row(table) -> None:
    text = table_markdown(table)
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert {line.count("|") for line in lines} == {len(table.columns) + 1}
    for cells in rows(table).values():
        for cell in cells:
            assert not cell.text or f" ({named(cell)}) |" in text
    for source in cited(table).values():
        assert f"- {source.name}: {source.full}." in text


class Cells(HTMLParser):
    """The text of the cells of a table, row by row."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs) -> None:
        if tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.rows[-1].append("")
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data) -> None:
        if "tr" in self.open:
            self.rows[-1][-1] += data


@pytest.mark.parametrize("table", TABLES)
def test_html_contains_all_cells_with_sources(table) -> None:
    found = {cells[0]: cells[1:] for cells in Cells(table_html(table)).rows}
    assert found[table.columns[0]] == list(table.columns[1:])
    for name, cells in rows(table).items():
        shown = [text.replace("†", "").replace("‡", "") for text in found[name.capitalize()]]
        assert shown == [cell.text + named(cell) for cell in cells]
    assert all(f"{escape(note)}</p>" in table_html(table) for note in table.notes)


def test_html_escapes_its_text() -> None:
    table = Table(("", "<b>"), (("", (("a&b", (Cell("x < y", ("Lee2007",)),)),)),))
    assert Cells(table_html(table)).rows == [["", "<b>"], ["A&b", "x < yLee et al. 2007"]]


def test_attributes_not_applied_in_the_paper_are_marked() -> None:
    marked = {(name, cell.text): cell.note for name, cells in rows(ATTRIBUTES).items() for cell in cells if cell.note}
    assert marked == {
        ("fear", "downward pointing triangles"): 1,
        ("negative", "angularity"): 2,
        ("negative", "angular movement trace"): 2,
    }
    for text in (table_markdown(ATTRIBUTES), table_latex(ATTRIBUTES), table_html(ATTRIBUTES)):
        assert all(note in text for note in ATTRIBUTES.notes)
