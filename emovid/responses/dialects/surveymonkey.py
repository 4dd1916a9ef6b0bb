"""SurveyMonkey: two header rows; condensed (one column for a question) or expanded (one for each option)."""

from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table
from emovid.errors import SourceError
from emovid.responses.dialects.generic import read_wide
from emovid.responses.dialects.parsed_export import Column, Known, Raw
from emovid.responses.labels import plain

_TOOL = (
    "Respondent ID",
    "RespondentID",
    "Collector ID",
    "Date Created",
    "Date Modified",
    "IP Address",
    "Email Address",
    "First Name",
    "Last Name",
    "Custom Data 1",
)


def recognises(table: Table, _: Known) -> bool:
    """Return whether the first column is the respondent's id."""
    return plain(table.names[0]) in ("respondent id", "respondentid")


def read(table: Table, known: Known) -> Raw:
    """Read one row for each respondent."""
    if not table.row(0)[0]:  # the second header row
        table = _condensed(table.with_texts(1))
    if not len(table.lines):
        raise SourceError(table.file, "headers alone; expected a row for each respondent", 1)
    return read_wide(table, known, *_TOOL[:2], skip=_TOOL)


def _condensed(table: Table) -> Table:
    """Return a table with one column for each question: options that were ticked repeat their heading."""
    names: list[str] = []
    columns: list[Column] = []
    for places in _questions(table.names):
        title = table.names[places[0]]
        if len(places) > 1 and all(_repeats(table, place) for place in places):
            names.append(title)
            columns.append(_ticked([table.cells[place] for place in places]))
        else:
            names += [title if len(places) == 1 else f"{title} {table.texts[place]}" for place in places]
            columns += [table.cells[place] for place in places]
    cells = pd.DataFrame(dict(enumerate(columns)), index=table.cells.index)
    return replace(table, names=tuple(names), texts=tuple(names), cells=cells)


def _questions(names: tuple[str, ...]) -> list[list[int]]:
    """Return the columns of each question: one with a heading, and those without that follow."""
    questions: list[list[int]] = []
    for place, name in enumerate(names):
        if name or not questions:
            questions.append([])
        questions[-1].append(place)
    return questions


def _repeats(table: Table, place: int) -> bool:
    return set(table.cells[place].unique()) <= {"", table.texts[place]}


def _ticked(columns: list[Column]) -> Column:
    """Return what is ticked; several in one cell, which is no label."""
    joined = columns[0]
    for cells in columns[1:]:
        both = (joined != "") & (cells != "")
        joined = (joined + cells).where(~both, joined + "; " + cells)
    return joined
