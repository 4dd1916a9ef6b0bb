"""Qualtrics: three header rows, or two in surveys of before 2017; choices as text or as numbers."""

from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table
from emovid.errors import SourceError
from emovid.responses.dialects.columns import below, says
from emovid.responses.dialects.generic import read_wide
from emovid.responses.dialects.parsed_export import Column, Known, Raw, whole_numbers
from emovid.responses.dialects.videos import code_in, video_columns
from emovid.responses.key import code_of

_TOOL = (
    "StartDate",
    "EndDate",
    "Status",
    "IPAddress",
    "Progress",
    "Finished",
    "Duration (in seconds)",
    "RecordedDate",
    "ResponseId",
    "ResponseID",
    "ResponseSet",
    "RecipientLastName",
    "RecipientFirstName",
    "RecipientEmail",
    "Name",
    "Email",
    "ExternalDataReference",
    "ExternalReference",
    "LocationLatitude",
    "LocationLongitude",
    "LocationAccuracy",
    "DistributionChannel",
    "UserLanguage",
    "Q_RecaptchaScore",
)


def recognises(table: Table, _: Known) -> bool:
    """Return whether the third row holds import ids, or the columns are those of either kind."""
    return _headers(table) > 0 or {"ResponseId", "Finished", "RecordedDate"} <= set(table.names)


def read(table: Table, known: Known) -> Raw:
    """Read one row for each response; previews, tests, spam and unfinished ones are left out."""
    headers = _headers(table)
    if len(table.lines) <= headers:
        raise SourceError(table.file, "headers alone; expected a row for each response", 1)
    table = table.with_texts(headers) if headers else table
    reasons = {
        "preview": says(table, ("survey preview", "1", "17"), "Status"),
        "test run": says(table, ("survey test", "2", "18"), "Status"),
        "spam": says(table, ("spam", "8", "9", "12", "40"), "Status"),
        "bot": below(table, 0.5, "Q_RecaptchaScore"),
        "partial": says(table, ("false", "0", "falsch", "faux", "falso"), "Finished") | below(table, 100, "Progress"),
    }
    tool = [name for name in (*table.names, *table.texts) if name in _TOOL]
    tool += [name for name in table.names if _is_order(name)]
    if headers == 1:  # the old tool's own columns are V1, V2, ...
        tool += [name for name, text in zip(table.names, table.texts, strict=True) if text in _TOOL]
    raw = read_wide(table, known, "ResponseId", "ResponseID", reasons=reasons, skip=tool)
    return _with_positions(raw, table, known)


def _headers(table: Table) -> int:
    """Return how many header rows there are below the first."""
    if any(cell.startswith('{"ImportId"') for cell in table.row(1)[:1]):
        return 2
    return 1 if table.names[0] == "V1" and table.row(0)[:1] in (["ResponseID"], ["ResponseId"]) else 0


def _is_order(name: str) -> bool:
    return name.endswith("_DO") or "_DO_" in name


def _with_positions(raw: Raw, table: Table, known: Known) -> Raw:
    """Return the answers with the display order: `FL_7_DO` = A|B|..., or a rank in each of `FL_7_DO_A`, ..."""
    videos = video_columns(table, known)
    loops = {name.split("_")[0]: code for place, code in videos.items() if (name := table.names[place])[:1].isdigit()}
    found: dict[str, Column] = {}
    for place, name in enumerate(table.names):
        cells = table.cells[place]
        if name.endswith("_DO"):
            orders = {cell: [_code(part, loops, known) for part in cell.split("|")] for cell in cells.unique()}
            for code in videos.values():
                ranks = {cell: order.index(code) + 1 for cell, order in orders.items() if code in order}
                if ranks:
                    found.setdefault(code, cells.map(ranks).astype("Int64"))
        elif "_DO_" in name and (code := _code(name.split("_DO_", 1)[1], loops, known)):
            found.setdefault(code, whole_numbers(cells))
    if not found:
        return raw
    at = pd.concat([pd.DataFrame({"line": table.lines, "video": code, "rank": rank}) for code, rank in found.items()])
    ranked = raw.answers.merge(at, on=["line", "video"], how="left")
    position = pd.Series(ranked["rank"].array, index=raw.answers.index).astype("Int64")
    return replace(raw, answers=raw.answers.assign(position=position))


def _code(text: str, loops: dict[str, str], known: Known) -> str:
    return loops.get(text.strip()) or code_in(code_of(text), known)
