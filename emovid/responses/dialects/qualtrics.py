"""Qualtrics: three header rows, or two in surveys of before 2017; choices as text or as numbers."""

import re
from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table, coded, translated
from emovid.errors import SourceError, quoted
from emovid.responses.columns import column
from emovid.responses.dialects.tables import code_in, read_wide, video_columns
from emovid.responses.exclusions import FALSE, TRUE, Marks, below, says
from emovid.responses.key import code_of
from emovid.responses.labels import number
from emovid.responses.parsed_export import Column, Known, ParsedExport, whole_numbers

_TOOL = (
    "StartDate", "EndDate", "Status", "IPAddress", "Progress", "Finished", "Duration (in seconds)", "RecordedDate",
    "ResponseId", "ResponseID", "ResponseSet", "RecipientLastName", "RecipientFirstName", "RecipientEmail", "Name",
    "Email", "ExternalDataReference", "ExternalReference", "LocationLatitude", "LocationLongitude", "LocationAccuracy",
    "DistributionChannel", "UserLanguage", "Q_RecaptchaScore",
)  # fmt: skip
# Words in the values of Status, which Qualtrics translates into the language of its user: "Survey Preview",
# "Umfragevorschau", "Aperçu de l'enquête". Numbers are codes; a spam code or word counts before the others.
_STATES = {
    "spam": (
        r"spam|スパム|스팸|垃圾|спам|ספאם|مزعج",
        ("8", "9", "10", "11", "12", "40", "41", "48"),
    ),
    "preview": (
        r"preview|vorschau|aper[cç]u|previa|pr[eé]via|anteprima|voorbeeld|voorvertoning|visualiza[cç]|プレビュー|预览|預覽|미리|"
        r"предпросмотр|предварительн|podgląd|f[oö]rhandsgransk|forh[aå]ndsvis|esikatsel|[oö]nizleme|معاينة|תצוגה|"
        r"előnézet|n[aá]hled|προεπισκόπηση|previzualiz|ตัวอย่าง|xem trước|pratinjau",
        ("1", "17"),
    ),
    "test run": (r"test|prueba|prova|teste|тест|テスト|测试|測試|테스트|اختبار", ("2", "18")),
    "": (
        r"\bip|ip\b|import|offline|synch?ron|sync|anonym|panel|email|インポート|オフライン|导入|離線|가져|импорт",
        ("0", "4", "16", "32"),
    ),
}


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
        **_previews_tests_and_spam(table, known),
        "bot": below(table, 0.5, "Q_RecaptchaScore"),
        "partial": _unfinished(table),
    }
    tool = [name for name in (*table.names, *table.texts) if name in _TOOL]
    tool += [name for name in table.names if name.endswith("_DO") or "_DO_" in name]
    if headers == 1:  # the old tool's own columns are V1, V2, ...
        tool += [name for name, text in zip(table.names, table.texts, strict=True) if text in _TOOL]
    raw = read_wide(table, known, "ResponseId", "ResponseID", marks=Marks(people), skip=tool)
    return _with_positions(raw, table, known)


def _previews_tests_and_spam(table: Table, known: Known) -> dict[str, Column]:
    """Return the responses (True) that are previews, tests or spam.

    Raises:
        SourceError: for a state that is not known, unless the map leaves out participants or rows by this column.
    """
    place = column(table, "Status", "Response Type")
    if place is None:
        return {}
    states = translated(table.cells[place], _state)
    unknown = table.cells[place][states == "unknown"]
    name = table.names[place]
    if len(unknown) and name not in {*known.mapping.drop, *known.mapping.rows.keep, *known.mapping.rows.leave_out}:
        value = quoted(str(unknown.iloc[0]))
        message = (
            f"{value} is not known to be an answer, a preview or a test; expected map.yaml: drop: "
            f"{{{name}: [the values to leave out]}}"
        )
        raise SourceError(table.file, message, int(table.lines[(states == "unknown").to_numpy()][0]), name)
    return {state: states == state for state in ("preview", "test run", "spam")}


def _unfinished(table: Table) -> Column:
    """Return the responses (True) that are not finished. Raises SourceError if that is unknown."""
    place = column(table, "Finished")
    if place is not None and "Progress" not in table.names:
        other = ~says(table, (*TRUE, *FALSE), "Finished") & (table.cells[place] != "")
        if other.any():
            message = f"{quoted(str(table.cells[place][other].iloc[0]))}; expected true or false, or a column Progress"
            raise SourceError(table.file, message, int(table.lines[other.to_numpy()][0]), "Finished")
    return says(table, FALSE, "Finished") | below(table, 100, "Progress")


def _state(text: str) -> str:
    word = number(text).casefold()
    for state, (words, codes) in _STATES.items():
        if not word or word in codes or (not word.isdigit() and re.search(words, word)):
            return state if word else ""
    return "unknown"


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
