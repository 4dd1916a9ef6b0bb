"""Survey suites of universities: LimeSurvey, SoSci Survey, Unipark (EFS), REDCap, formr. One row for a participant."""

import re
from dataclasses import replace

from emovid.csv_reader import Table, cells_that
from emovid.responses.columns import column
from emovid.responses.dialects.tables import read_wide, video_columns
from emovid.responses.exclusions import FALSE, TRUE, Marks, says
from emovid.responses.labels import plain
from emovid.responses.parsed_export import Known, ParsedExport, numeric

_LIMESURVEY = (
    ("id", "response id", "antwort id", "id de la réponse", "id de respuesta"),
    ("submitdate", "date submitted", "datum abgeschickt", "date de soumission", "fecha de envío"),
    ("lastpage", "last page", "letzte seite", "dernière page", "última página"),
    ("startlanguage", "start language", "start sprache", "langue de départ", "lenguaje inicial"),
    ("seed", "zufallsstartwert", "zufallsgeneratorstartwert", "seme", "semilla"),
    ("startdate", "date started", "datum gestartet"),
    ("datestamp", "date last action", "datum letzte aktivität"),
    ("ipaddr", "ip address", "ip adresse"),
    ("refurl", "referrer url"),
    ("interviewtime", "total time", "gesamtzeit"),
)
# Questions of a survey that `study export --to limesurvey` made: they are not groups.
_KIT = ("consent", "instructions", "practice", "videoset")
_KIT_NAME = re.compile(r"[a-z][a-z0-9]*(U[a-z0-9]*)+")
_SOSCI = (
    "CASE", "SERIAL", "REF", "QUESTNNR", "MODE", "STARTED", "TIME_SUM", "MAILSENT", "LASTDATA", "FINISHED", "Q_VIEWER",
    "LASTPAGE", "MAXPAGE", "MISSING", "MISSREL", "TIME_RSI", "DEG_TIME", "LANGUAGE",
)  # fmt: skip
_SOSCI_TESTS = ("pretest", "debug", "admin", "test", "preview", "author")
_UNIPARK = (
    "lfdn", "external_lfdn", "tester", "dispcode", "lastpage", "quality", "duration", "browser", "referer", "referrer",
    "device_type", "participant_browser", "participant_browser_version", "participant_os", "participant_device",
    "participant_brand", "participant_model", "quota", "quota_assignment", "quota_rejected_id", "page_history", "hflip",
    "vflip", "output_mode", "javascript", "flash", "session_id", "language", "cleaned", "ats", "datetime",
    "date_of_last_access", "date_of_first_mail", "rts", "c_0001",
)  # fmt: skip
_UNIPARK_COMPLETE = (31, 32)  # dispcodes: completed, and completed after an interruption
_FORMR = ("session", "session_id", "study_id", "created", "modified", "ended", "expired", "iteration")


def recognizes_limesurvey(table: Table, _: Known) -> bool:
    """Return whether a table has an id, a date of submission, and one of the tool's other columns."""
    names = {plain(name) for name in _split_codes(table).names}
    first, submitted, *others = (bool(names & set(either)) for either in _LIMESURVEY)
    return first and submitted and any(others)


def read_limesurvey(table: Table, known: Known) -> ParsedExport:
    """Read one row for each response; those never submitted are left out."""
    table = _names_of_kit(_split_codes(table), known)
    place = column(table, *_LIMESURVEY[1])
    assert place is not None  # it was recognized by this column
    skip = [name for either in _LIMESURVEY for name in either] + list(_KIT)
    skip += [name for name in table.names if re.search(r"time\W*$|^(question|group) ?time", name.casefold())]
    marks = Marks({"partial": table.cells[place].isin(["", "N"])})
    return read_wide(table, known, *_LIMESURVEY[0], marks=marks, skip=skip)


def _split_codes(table: Table) -> Table:
    """Return a table whose header is `code. text` with the codes as names and the texts as texts."""
    parts = [re.fullmatch(r"(\w+(?:\[\w+\])*)\. (.*)", name) for name in table.names]
    if not any(part and part[1] == "id" for part in parts):
        return table
    names = tuple(part[1] if part else name for part, name in zip(parts, table.names, strict=True))
    texts = tuple(part[2] if part else name for part, name in zip(parts, table.names, strict=True))
    return replace(table, names=names, texts=texts)


def _names_of_kit(table: Table, known: Known) -> Table:
    """Return a table of a survey that `study export --to limesurvey` made with the names of the kit.

    Headers may be names (`CODE`, `CODEconfidence[SQ1]`, `ageU1` for age_1) or full texts (`CODE: Which emotion ...`).
    """
    parts = [re.fullmatch(r"(\w+): (.*)", name, re.DOTALL) for name in table.names]
    if any(part and part[1] in known.codes for part in parts):
        names = [part[1] if part else name for part, name in zip(parts, table.names, strict=True)]
        return replace(table, names=tuple(names))
    if not set(known.codes) & set(table.names):
        return table
    names = [re.sub(r"(confidence|valence|arousal)\[SQ1\]$", r"_\1", name) for name in table.names]
    return replace(table, names=tuple(name.replace("U", "_") if _KIT_NAME.fullmatch(name) else name for name in names))


def recognizes_sosci(table: Table, _: Known) -> bool:
    """Return whether a table has the columns of SoSci Survey's data set."""
    return {"CASE", "QUESTNNR", "STARTED"} <= set(table.names)


def read_sosci(table: Table, known: Known) -> ParsedExport:
    """Read one row for each interview; pretests, tests of the editor and unfinished ones are left out."""
    if (
        table.row(0)[:1] and not table.row(0)[table.names.index("CASE")].isdigit()
    ):  # a second header: labels of variables
        table = table.with_texts(1)
    times = tuple(name for name in table.names if re.fullmatch(r"TIME\d+", name))
    marks = Marks({"test run": says(table, _SOSCI_TESTS, "MODE"), "partial": says(table, FALSE, "FINISHED")})
    return read_wide(table, known, "CASE", marks=marks, skip=(*_SOSCI, *times))


def recognizes_unipark(table: Table, _: Known) -> bool:
    """Return whether a table has the running number and the disposition code of Unipark (EFS Survey)."""
    return {"lfdn", "dispcode"} <= set(table.names)


def read_unipark(table: Table, known: Known) -> ParsedExport:
    """Read one row for each participant; testers and those whose disposition code is not complete are left out."""
    place = table.names.index("dispcode")
    complete = numeric(table.cells[place]).isin(_UNIPARK_COMPLETE)
    marks = Marks({"test run": says(table, TRUE, "tester"), "partial": ~complete})
    parsed = read_wide(table, known, "lfdn", marks=marks, skip=_UNIPARK)
    if known.labels.is_declared("0"):
        return parsed
    answers = parsed.answers["answer"]
    return replace(parsed, answers=parsed.answers.assign(answer=answers.mask(answers == "0", "")))  # seen, no answer


_REDCAP = (
    "record_id", "redcap_survey_identifier", "redcap_event_name", "redcap_repeat_instrument", "redcap_repeat_instance",
    "redcap_data_access_group", "Record ID", "Survey Identifier", "Survey Timestamp", "Event Name", "Repeat Instrument",
    "Repeat Instance", "Data Access Group", "Complete?",
)  # fmt: skip


_REDCAP_INCOMPLETE = ("0", "1", "incomplete", "unverified")


def recognizes_redcap(table: Table, _: Known) -> bool:
    """Return whether a table has the columns of REDCap's raw export, or of its export of labels."""
    names = set(table.names)
    raw = "record_id" in names and any(name.endswith("_complete") for name in names)
    return raw or ("Complete?" in names and bool(names & set(_REDCAP)))


def read_redcap(table: Table, known: Known) -> ParsedExport:
    """Read one row for each record; records whose answers belong to an unfinished instrument are left out."""
    partial = says(table, (), "record_id")
    for place in _instruments(table, known):
        partial |= cells_that(table.cells[place], lambda state: plain(state) in _REDCAP_INCOMPLETE)
    stamps = [name for name in table.names if name.endswith("_timestamp") or name == "Survey Timestamp"]
    for name in stamps:
        partial |= table.cells[table.names.index(name)] == "[not completed]"
    skip = (*_REDCAP, *stamps, *(n for n in table.names if n.endswith("_complete")))
    return read_wide(table, known, "record_id", "Record ID", marks=Marks({"partial": partial}), skip=skip)


def _instruments(table: Table, known: Known) -> set[int]:
    """Return the columns that mark an instrument with answers as complete: each follows its questions."""
    complete = [i for i, name in enumerate(table.names) if name.endswith("_complete") or name.startswith("Complete?")]
    if len(complete) < 2:
        return set(complete)
    return {min((i for i in complete if i > place), default=complete[-1]) for place in video_columns(table, known)}


def recognizes_formr(table: Table, _: Known) -> bool:
    """Return whether a table has a session and its times."""
    return {"session", "created", "ended"} <= set(table.names)


def read_formr(table: Table, known: Known) -> ParsedExport:
    """Read one row for each session; unfinished sessions and the tool's test sessions (XXX) are left out."""
    ended, session = (table.names.index(name) for name in ("ended", "session"))
    marks = Marks({"test run": table.cells[session].str.contains("XXX"), "partial": table.cells[ended] == ""})
    return read_wide(table, known, "session", marks=marks, skip=_FORMR)
