"""What the tools that write a row for each trial or screen have in common."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd

from emovid.csv_reader import Table
from emovid.errors import SourceError
from emovid.responses.dialects.columns import answer_column, check_named, column, video_column
from emovid.responses.dialects.generic import left_out
from emovid.responses.dialects.parsed_export import Column, Known, Raw, answers_long, ranks
from emovid.responses.dialects.people import PARTICIPANT, groups_of, who, without

Pick = Callable[[Table, int, Column], Column]


def read_trials(
    table: Table,
    known: Known,
    pick: Pick | None = None,
    videos: tuple[str, ...] = (),
    answers: tuple[str, ...] = (),
    order: tuple[str, ...] = (),
    ids: tuple[str, ...] = PARTICIPANT,
    reasons: dict[str, Column] | None = None,
    is_tool: Callable[[str], bool] = lambda _: False,
) -> Raw:
    """Read a table of trials, of which some show a video.

    Args:
        table: the file.
        known: what is known besides.
        pick: the trials (True) that show a video, given the table, the place of the videos, and the rows whose video is
            known; else the rows in which a video is named.
        videos: names that the column of videos may have, likely ones first.
        answers: as for the answers.
        order: as for what counts the trials.
        ids: as for the participant.
        reasons: rows whose participants are left out.
        is_tool: whether a column is the tool's own, and no group.
    """
    people = who(table, known, *ids, alone=Path(table.file).stem)
    table, people = without(table, known, people, left_out(table, reasons))
    check_named(table, known)
    video = video_column(table, known, *videos)
    if video is None:
        raise SourceError(table.file, "no column of videos; expected one with the key's codes", 1)
    cells = table.cells[video]
    recognised = cells.isin([word for word in cells.unique() if known.emotion(str(word))])
    rows = (pick(table, video, recognised) if pick else cells != "").to_numpy(dtype=bool)
    shown = table.rows(rows)
    answer = answer_column(shown, known, video, *answers)
    if answer is None:
        raise SourceError(table.file, "no column of answers beside the videos; expected one with labels", 1)
    place = column(table, *order)
    frame = answers_long(shown, people.ids[rows].reset_index(drop=True), video, answer)
    if place is not None:
        frame["position"] = ranks(frame["participant"], shown.cells[place])
    tools = {i for i, name in enumerate(table.names) if is_tool(name)}
    roles = {video: "video", answer: "answer", people.place: "participant", place: "order"}
    return Raw(
        frame,
        groups_of(table, known, people.ids, {*roles, *tools}),
        table.rejected,
        people.dropped,
        {table.names[i]: role for i, role in roles.items() if i is not None},
        people.numbered,
    )


def emptied(table: Table, word: str) -> Table:
    """Return the table with cells that hold nothing but a tool's word for nothing emptied."""
    return replace(table, cells=table.cells.mask(table.cells == word, ""))


def with_column(table: Table, place: int, cells: Column) -> Table:
    """Return the table with other cells in one column."""
    return replace(table, cells=pd.DataFrame({i: cells if i == place else table.cells[i] for i in table.cells}))


def translated(cells: Column, translate: Callable[[str], str]) -> Column:
    """Return a column with each text translated once."""
    return cells.map({word: translate(str(word)) for word in cells.unique()}).astype("str")
