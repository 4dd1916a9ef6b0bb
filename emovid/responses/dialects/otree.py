"""oTree: all apps in one row (`app.round.player.field`), or one app with a row for each player and round."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd

from emovid.csv_reader import Table
from emovid.responses.columns import Format, column, video_column
from emovid.responses.dialects.tables import is_mapped_wide, read_long, read_wide, video_columns
from emovid.responses.exclusions import Marks, below, says
from emovid.responses.parsed_export import Known, ParsedExport, numeric
from emovid.responses.participants import groups_of, joined, who

_CODE = "participant.code"
_ROUND = "subsession.round_number"
_OWN = ("id_in_group", "role", "payoff")  # fields that every player has
_FIELD = re.compile(r"(\w+)\.(\d+)\.player\.(\w+)")


def recognizes(table: Table, _: Known) -> bool:
    """Return whether a table has the participants' codes."""
    return _CODE in table.names


def read(table: Table, known: Known) -> ParsedExport:
    """Read either export; bots, demonstrations and participants who did not reach the last page are left out."""
    table = _bare(table)
    for stacked in _stacked(table):
        if is_mapped_wide(known) or video_columns(table, known):
            break
        if video_column(stacked, known) is not None:
            raw = _read_rounds(stacked, known)
            people = who(table, known, _CODE)
            used = {*_tool(table), *_in_rounds(table)}
            return replace(raw, participants=joined(raw.participants, groups_of(table, known, people.ids, used)))
    if _ROUND in table.names and video_column(table, known) is not None:
        return _read_rounds(table, known)
    names = tuple(table.names[place] for place in _tool(table))
    return read_wide(table, known, _CODE, marks=_marks(table), skip=names)


def _read_rounds(table: Table, known: Known) -> ParsedExport:
    form = Format(order=(_ROUND,), participants=(_CODE,), is_tool=lambda name: "." in name or name in _OWN)
    return read_long(table, known, form, _marks, lambda rows, video, _: rows.cells[video] != "")


def _marks(table: Table) -> Marks:
    reached, last = (column(table, f"participant.{name}") for name in ("_index_in_pages", "_max_page_index"))
    partial = below(table, 1, "participant.visited")
    if reached is not None and last is not None:
        partial |= numeric(table.cells[reached]) < numeric(table.cells[last])
    bot, demo = says(table, ("1", "true"), "participant._is_bot"), says(table, ("1", "true"), "session.is_demo")
    return Marks({"bot": bot, "test run": demo, "partial": partial})


def _bare(table: Table) -> Table:
    """Return an app's own export with its fields (`player.video`) named as they were in the code."""
    names = tuple(re.sub(rf"^player\.(?!{'|'.join(_OWN)})", "", name) for name in table.names)
    return replace(table, names=names, texts=names)


def _tool(table: Table) -> list[int]:
    pattern = rf"(participant|session|subsession|group)\.|.*\.(subsession|group)\.|.*player\.({'|'.join(_OWN)})$"
    return [place for place, name in enumerate(table.names) if re.match(pattern, name)]


def _in_rounds(table: Table) -> list[int]:
    """Return the fields of apps of several rounds, which differ between rounds and are therefore not groups."""
    return [place for rounds in _apps(table) for fields in rounds.values() for place in fields.values()]


def _stacked(table: Table) -> list[Table]:
    """Return, for each app of several rounds, a table with a row for each player and round."""
    return [_stack(table, rounds) for rounds in _apps(table)]


def _apps(table: Table) -> list[dict[int, dict[str, int]]]:
    """Return the places of the fields in each round of each app that has several."""
    apps: dict[str, dict[int, dict[str, int]]] = {}
    for place, name in enumerate(table.names):
        found = _FIELD.fullmatch(name)
        if found:
            apps.setdefault(found[1], {}).setdefault(int(found[2]), {})[found[3]] = place
    return [rounds for rounds in apps.values() if len(rounds) > 1]


def _stack(table: Table, rounds: dict[int, dict[str, int]]) -> Table:
    common = [place for place, name in enumerate(table.names) if name.startswith(("participant.", "session."))]
    fields = list(dict.fromkeys(field for places in rounds.values() for field in places))
    blank = pd.Series("", index=table.cells.index, dtype="str")
    parts = []
    for number, places in sorted(rounds.items()):
        columns = [table.cells[place] for place in common] + [blank + str(number)]
        columns += [table.cells[places[field]] if field in places else blank for field in fields]
        parts.append(pd.DataFrame(dict(enumerate(columns))))
    names = (*(table.names[place] for place in common), _ROUND, *fields)
    cells = pd.concat(parts, ignore_index=True)
    return replace(table, names=names, texts=names, cells=cells, lines=np.tile(table.lines, len(parts)))
