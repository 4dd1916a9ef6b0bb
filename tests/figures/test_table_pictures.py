import re

import pytest
from matplotlib.text import Text

from emovid.figures.attributes import ATTRIBUTES, BEHAVIOURS, PAPER, SOURCES, Cell, Table, cited, named
from emovid.figures.style import SINGLE_COLUMN, text_width
from emovid.figures.tables import table_figure, table_latex, table_markdown
from emovid.scene.emotions import EMOTIONS

TABLES = (ATTRIBUTES, BEHAVIOURS)


def rows(table: Table) -> dict[str, tuple[Cell, ...]]:
    return {name: cells for _, group in table.groups for name, cells in group}


def test_table_i_says_what_the_paper_says() -> None:
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


def test_table_ii_says_what_the_scenes_are_made_for() -> None:
    for name, (behaviour, control) in rows(BEHAVIOURS).items():
        assert (behaviour.text, control.text) == (EMOTIONS[name].behaviour, EMOTIONS[name].control)
    assert list(rows(BEHAVIOURS)) == list(EMOTIONS)


@pytest.mark.parametrize("table", TABLES)
def test_each_cell_that_says_something_has_a_source_and_no_other_has(table) -> None:
    for cells in rows(table).values():
        for cell in cells:
            assert bool(cell.text) == bool(cell.sources) == bool(named(cell))
            assert set(cell.sources) <= set(SOURCES)
            assert 0 <= cell.note <= len(table.notes)
            assert bool(cell.place) == (cell.sources == (PAPER,))


def test_every_source_is_cited_somewhere() -> None:
    assert set(SOURCES) == {key for table in TABLES for key in cited(table)}


@pytest.mark.parametrize("table", TABLES)
def test_latex_is_a_balanced_table_of_booktabs(table) -> None:
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


def test_latex_escapes_what_it_must() -> None:
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


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("width", [SINGLE_COLUMN, 7.16])
def test_the_picture_says_all_that_the_table_says(table, width) -> None:
    written = [text.get_text() for text in table_figure(table, width=width).findobj(Text) if text.get_text()]
    said = " ".join(written).replace("†", "").replace("‡", "").split()
    for name, cells in rows(table).items():
        assert name.capitalize() in written
        for cell in cells:
            assert set((cell.text + " " + named(cell)).replace(";", "").split()) <= {word.strip(";") for word in said}
    assert written.count("–") == sum(not cell.text for cells in rows(table).values() for cell in cells)


def test_in_one_column_a_source_breaks_before_et_al_and_no_word_leaves_its_column() -> None:
    figure = table_figure(ATTRIBUTES, width=SINGLE_COLUMN)
    lines = [text for text in figure.findobj(Text) if text.get_text()]
    assert not [line for line in lines if re.search(r"\bet$|\bal\.$|^\d{4}$", line.get_text())]
    assert len([line for line in lines if re.search(r"et\sal\.\s\d{4}$", line.get_text())]) == 9
    starts = sorted({line.get_position()[0] for line in lines})
    assert len(starts) == 4
    for line in lines:
        start, end = line.get_position()[0], line.get_position()[0] + text_width([line.get_text()])
        is_note = line.get_text()[0] in "†‡" or "decides" in line.get_text()
        assert is_note or end < min((s for s in starts if s > start), default=SINGLE_COLUMN * 72)


def test_what_the_paper_does_not_apply_is_marked() -> None:
    marked = {(name, cell.text): cell.note for name, cells in rows(ATTRIBUTES).items() for cell in cells if cell.note}
    assert marked == {
        ("fear", "downward pointing triangles"): 1,
        ("negative", "angularity"): 2,
        ("negative", "angular movement trace"): 2,
    }
    for text in (table_markdown(ATTRIBUTES), table_latex(ATTRIBUTES)):
        assert all(note in text for note in ATTRIBUTES.notes)
