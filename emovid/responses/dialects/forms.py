"""Online forms: Google Forms, Microsoft Forms, Typeform and SurveyMonkey. One row for each person who sent the form."""

from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table, coded
from emovid.errors import SourceError
from emovid.responses.columns import video_column
from emovid.responses.dialects.tables import read_wide
from emovid.responses.exclusions import Marks, says
from emovid.responses.labels import plain
from emovid.responses.parsed_export import Column, Known, ParsedExport

# "Timestamp" in the languages of most forms.
_TIMESTAMP = (
    "timestamp", "zeitstempel", "horodateur", "marca temporal", "carimbo de data hora", "tijdstempel",
    "informazioni cronologiche", "sygnatura czasowa", "отметка времени", "タイムスタンプ", "时间戳记", "zaman damgası",
)  # fmt: skip
_GOOGLE = ("Timestamp", "Email Address", "Email", "Username", "Score")
_START = ("start time", "startzeit", "heure de début", "hora de inicio", "ora di inizio", "begintijd", "hora de início")
_END = (
    "completion time", "fertigstellungszeit", "heure de fin", "hora de finalización", "ora di completamento",
    "tijd van voltooien", "hora de conclusão",
)  # fmt: skip
_MICROSOFT = (
    "ID", "Email", "Name", "Last modified time", "E-Mail", "Adresse de messagerie", "Nom", "Correo electrónico",
    "Nombre", "Uhrzeit der letzten Änderung",
)  # fmt: skip
_TYPEFORM = (
    "#", "Response Type", "Start Date (UTC)", "Stage Date (UTC)", "Submit Date (UTC)", "Network ID", "Tags", "Ending",
    "Token", "Submitted At",
)  # fmt: skip
_MONKEY = (
    "Respondent ID", "RespondentID", "Collector ID", "Date Created", "Date Modified", "IP Address", "Email Address",
    "First Name", "Last Name", "Custom Data 1",
)  # fmt: skip


def recognizes_google(table: Table, known: Known) -> bool:
    """Return whether a column is the form's time stamp."""
    places = [place for place, name in enumerate(table.names) if plain(name) in _TIMESTAMP]
    if 0 not in places and not known.mapping.video and video_column(table, known) is not None:
        return False  # a row for each answer, with its time
    return any(all(cell[:1].isdigit() for cell in table.cells[place].head(20) if cell) for place in places)


def read_google(table: Table, known: Known) -> ParsedExport:
    """Read one row for each person; questions with one text need the map's list of codes."""
    times = tuple(name for name in table.names if plain(name) in _TIMESTAMP)
    return read_wide(table, known, "participant", "participant id", skip=(*_GOOGLE, *times))


def recognizes_microsoft(table: Table, _: Known) -> bool:
    """Return whether a table has the form's id and times."""
    names = {plain(name) for name in table.names}
    return "id" in names and bool(names & set(_END)) and bool(names & set(_START))


def read_microsoft(table: Table, known: Known) -> ParsedExport:
    """Read one row for each person; a question asked again has a number after it."""
    times = tuple(name for name in table.names if plain(name) in (*_START, *_END))
    return read_wide(table, known, "ID", skip=(*_MICROSOFT, *times))


def recognizes_typeform(table: Table, _: Known) -> bool:
    """Return whether a table has the columns of Typeform's responses."""
    names = set(table.names)
    return {"Network ID", "Start Date (UTC)"} <= names or {"Token", "Submitted At"} <= names


def read_typeform(table: Table, known: Known) -> ParsedExport:
    """Read one row for each response; those that only started are left out."""
    marks = Marks({"partial": says(table, ("started", "partial"), "Response Type")})
    return read_wide(table, known, "#", "Token", marks=marks, skip=_TYPEFORM)


def recognizes_surveymonkey(table: Table, _: Known) -> bool:
    """Return whether a column is the respondent's id, beside another column of the tool."""
    names = {plain(name) for name in table.names}
    return bool(names & {"respondent id", "respondentid"}) and len(names & set(map(plain, _MONKEY))) > 1


def read_surveymonkey(table: Table, known: Known) -> ParsedExport:
    """Read one row for each respondent; a column is for a question (condensed) or an option (expanded)."""
    ids = [place for place, name in enumerate(table.names) if plain(name) in ("respondent id", "respondentid")]
    if not table.row(0)[ids[0]]:  # the second header row
        table = _condensed(table.with_texts(1))
    if not len(table.lines):
        raise SourceError(table.file, "only headers; expected a row for each respondent", 1)
    return read_wide(table, known, *_MONKEY[:2], skip=_MONKEY)


def _condensed(table: Table) -> Table:
    """Return a table with one column for each question: ticked options repeat their heading."""
    names: list[str] = []
    columns: list[Column] = []
    options = [tuple(sorted(table.texts[place] for place in places)) for places in _questions(table.names)]
    if any(len(set(texts)) < len(texts) for texts in options if len(texts) > 1):
        raise SourceError(
            table.file, "a question has one option twice; expected the columns as SurveyMonkey wrote them", 2
        )
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
    """Return the columns of each question: one with a heading, and the following columns without one."""
    questions: list[list[int]] = []
    for place, name in enumerate(names):
        if name or not questions:
            questions.append([])
        questions[-1].append(place)
    return questions


def _repeats(table: Table, place: int) -> bool:
    return set(coded(table.cells[place])[1]) <= {"", table.texts[place]}


def _ticked(columns: list[Column]) -> Column:
    """Return the ticked option; several in one cell, which is not a label."""
    joined = columns[0]
    for cells in columns[1:]:
        both = (joined != "") & (cells != "")
        joined = (joined + cells).where(~both, joined + "; " + cells)
    return joined
