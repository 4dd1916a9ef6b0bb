"""Qualtrics: three header rows, or two in surveys of before 2017; choices as text or as numbers."""

import re
from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table, coded
from emovid.errors import SourceError
from emovid.responses.dialects.tables import code_in, read_wide, video_columns
from emovid.responses.exclusions import FALSE, Marks, below, says
from emovid.responses.key import code_of
from emovid.responses.parsed_export import Column, Known, ParsedExport, whole_numbers

_TOOL = (
    "StartDate", "EndDate", "Status", "IPAddress", "Progress", "Finished", "Duration (in seconds)", "RecordedDate",
    "ResponseId", "ResponseID", "ResponseSet", "RecipientLastName", "RecipientFirstName", "RecipientEmail", "Name",
    "Email", "ExternalDataReference", "ExternalReference", "LocationLatitude", "LocationLongitude", "LocationAccuracy",
    "DistributionChannel", "UserLanguage", "Q_RecaptchaScore",
)  # fmt: skip
# Values of Status: choice text in the languages of exports, and numbers.
_PREVIEW = (
    "1", "17", "survey preview", "preview", "umfragevorschau", "vorschau der umfrage", "umfrage vorschau",
    "aperçu de l enquête", "aperçu du sondage", "vista previa de la encuesta", "anteprima sondaggio",
    "anteprima del sondaggio", "enquêtevoorbeeld", "voorbeeld van enquête", "visualização da pesquisa",
    "pré visualização da pesquisa", "アンケートのプレビュー", "调查预览", "问卷预览", "предпросмотр опроса",
)  # fmt: skip
_TEST = (
    "2",
    "18",
    "survey test",
    "umfragetest",
    "test de l enquête",
    "prueba de encuesta",
    "test del sondaggio",
    "enquêtetest",
)
_SPAM = ("8", "9", "12", "40", "spam")


def recognizes(table: Table, _: Known) -> bool:
    """Return whether the third row holds import ids, or the columns are those of the tool."""
    return _headers(table) > 0 or {"ResponseId", "Finished", "RecordedDate"} <= set(table.names)


def read(table: Table, known: Known) -> ParsedExport:
    """Read one row for each response; previews, tests, spam and unfinished ones are left out."""
    headers = _headers(table)
    if len(table.lines) <= headers:
        raise SourceError(table.file, "only headers; expected a row for each response", 1)
    table = table.with_texts(headers) if headers else table
    people = {
        "preview": says(table, _PREVIEW, "Status", "Response Type"),
        "test run": says(table, _TEST, "Status", "Response Type"),
        "spam": says(table, _SPAM, "Status", "Response Type"),
        "bot": below(table, 0.5, "Q_RecaptchaScore"),
        "partial": says(table, FALSE, "Finished") | below(table, 100, "Progress"),
    }
    tool = [name for name in (*table.names, *table.texts) if name in _TOOL]
    tool += [name for name in table.names if name.endswith("_DO") or "_DO_" in name]
    if headers == 1:  # the old tool's own columns are V1, V2, ...
        tool += [name for name, text in zip(table.names, table.texts, strict=True) if text in _TOOL]
    raw = read_wide(table, known, "ResponseId", "ResponseID", marks=Marks(people), skip=tool)
    return _with_positions(raw, table, known)


def _headers(table: Table) -> int:
    """Return the number of header rows below the first."""
    if any(re.match(r"\{\W{1,2}ImportId", cell) for cell in table.row(1)):
        return 2
    first, second = (dict(zip(table.names, cells, strict=True)) for cells in (table.names, table.row(0) or table.names))
    return 1 if "V1" in first and second["V1"] in ("ResponseID", "ResponseId") else 0


def _with_positions(raw: ParsedExport, table: Table, known: Known) -> ParsedExport:
    """Return the answers with the display order: `FL_7_DO` = A|B|..., or a rank in each of `FL_7_DO_A`, ...

    `Q2_DO_1` is the order of the first choice of question Q2, not of a video.
    """
    videos = video_columns(table, known)
    questions = {table.names[place] for place in videos}
    loops = {name.split("_")[0]: code for place, code in videos.items() if (name := table.names[place])[:1].isdigit()}
    found: dict[str, Column] = {}
    for place, name in enumerate(table.names):
        cells = table.cells[place]
        if name.endswith("_DO"):
            if name.removesuffix("_DO") in questions:
                continue
            orders = {cell: [_code(part, loops, known) for part in cell.split("|")] for cell in coded(cells)[1]}
            for code in videos.values():
                ranks = {cell: order.index(code) + 1 for cell, order in orders.items() if code in order}
                if ranks:
                    found.setdefault(code, cells.map(ranks).astype("Int64"))
        elif name.partition("_DO_")[0] in questions:
            continue
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
