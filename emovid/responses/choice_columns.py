"""Choices that a tool spreads over columns of 0 and 1, one for each option: they become one column of labels."""

import re
from collections.abc import Mapping
from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table, cells_that, coded
from emovid.responses.columns import is_counted
from emovid.responses.exclusions import FALSE, TRUE
from emovid.responses.labels import number, plain
from emovid.responses.parsed_export import Column, Known

_TICKED = frozenset((*TRUE, "checked", "x"))
_EMPTY = frozenset(("", *FALSE, "unchecked"))
_FEWEST = 0.5  # of the rows with a tick: smallest share with exactly one


def with_choices(table: Table, known: Known) -> Table:
    """Return the table with one column of labels instead of each set of columns of 0 and 1.

    The names of a set differ in a label only, as in `z8r4[happiness]` and `z8r4[fear]`. A map that names columns of
    the file for answers, or gives labels to numbers, turns this off.
    """
    named = (*known.mapping.response, *known.mapping.codes_of_columns)
    is_mapped = bool(named) and all(title in table.names for title in named)
    if is_mapped or known.mapping.codes_in_order or known.labels.is_declared("1"):
        return table
    sets: dict[str, dict[int, str]] = {}
    for place, name in enumerate(table.names):
        if (split := _option(name, known)) and _is_ticks(table.cells[place]):
            sets.setdefault(split[0], {})[place] = split[1]
    chosen = {base: options for base, options in sets.items() if _is_choice(table, options)}
    if not chosen:
        return table
    for base, options in chosen.items():
        table = table.with_column(base, _ticked(table, options))
    gone = {place for options in chosen.values() for place in options}
    kept = [place for place in range(len(table.names)) if place not in gone]
    cells = table.cells[kept].set_axis(range(len(kept)), axis=1)
    names, texts = (tuple(titles[place] for place in kept) for titles in (table.names, table.texts))
    return replace(table, names=names, texts=texts, cells=cells)


def _is_choice(table: Table, options: Mapping[int, str]) -> bool:
    """Return whether columns are the options of one choice: most rows with a tick have exactly one."""
    if len(options) < 2 or len(set(options.values())) < len(options):
        return False
    ticks = sum(_is_ticked(table.cells[place]).astype(int) for place in options)
    return bool((ticks > 0).any() and (ticks == 1).sum() >= _FEWEST * (ticks > 0).sum())


def _is_ticks(cells: Column) -> bool:
    return all(plain(number(cell)) in _TICKED | _EMPTY for cell in coded(cells)[1])


def _is_ticked(cells: Column) -> Column:
    return cells_that(cells, lambda cell: plain(number(cell)) in _TICKED)


def _option(name: str, known: Known) -> tuple[str, str] | None:
    """Return the name without its label, and the label, of a name such as `z8r4_happiness`."""
    parts = re.split(r"([^\W_]+)", name)
    found = [i for i in range(1, len(parts), 2) if known.labels.is_label(parts[i])]
    if len(found) != 1 or is_counted(name):
        return None
    rest = "".join(parts[: found[0]] + parts[found[0] + 1 :]).strip(" ._-[]()/:=")
    return rest or "choice", known.labels.find(parts[found[0]]) or ""


def _ticked(table: Table, options: Mapping[int, str]) -> Column:
    """Return the label that is ticked in each row; several are joined, which is not a label."""
    chosen = pd.Series("", index=table.cells.index, dtype="str")
    for place, label in options.items():
        ticked = _is_ticked(table.cells[place])
        chosen = chosen.mask(ticked & (chosen != ""), chosen + "; " + label).mask(ticked & (chosen == ""), label)
    return chosen
