"""The dialects, in the order in which they are tried."""

from collections.abc import Callable
from typing import NamedTuple

from emovid.csv_reader import Table
from emovid.errors import SourceError, quoted
from emovid.responses.columns import check_named
from emovid.responses.dialects import (
    crowdsourcing,
    experiments,
    forms,
    jspsych,
    otree,
    pcibex,
    qualtrics,
    surveys,
    tables,
)
from emovid.responses.parsed_export import Known, ParsedExport


class Dialect(NamedTuple):
    """The format in which one tool exports answers.

    Attributes:
        name: in words.
        recognizes: whether a table has this format, by its header if the tool has columns of its own.
        read: the table's answers.
        is_pooled: whether all files of the format are read as one table, since their columns have the same roles.
    """

    name: str
    recognizes: Callable[[Table, Known], bool]
    read: Callable[[Table, Known], ParsedExport]
    is_pooled: bool = False


DIALECTS = (
    Dialect("Qualtrics", qualtrics.recognizes, qualtrics.read),
    Dialect("SurveyMonkey", forms.recognizes_surveymonkey, forms.read_surveymonkey),
    Dialect("LimeSurvey", surveys.recognizes_limesurvey, surveys.read_limesurvey),
    Dialect("SoSci Survey", surveys.recognizes_sosci, surveys.read_sosci),
    Dialect("Unipark", surveys.recognizes_unipark, surveys.read_unipark),
    Dialect("REDCap", surveys.recognizes_redcap, surveys.read_redcap),
    Dialect("jsPsych", jspsych.recognizes, jspsych.read, is_pooled=True),
    Dialect("PsychoPy or Pavlovia", experiments.recognizes_psychopy, experiments.read_psychopy, is_pooled=True),
    Dialect("OpenSesame", experiments.recognizes_opensesame, experiments.read_opensesame, is_pooled=True),
    Dialect("E-Prime", experiments.recognizes_eprime, experiments.read_eprime, is_pooled=True),
    Dialect("Gorilla", experiments.recognizes_gorilla, experiments.read_gorilla, is_pooled=True),
    Dialect("Labvanced", experiments.recognizes_labvanced, experiments.read_labvanced, is_pooled=True),
    Dialect("PCIbex", pcibex.recognizes, pcibex.read, is_pooled=True),
    Dialect("oTree", otree.recognizes, otree.read),
    Dialect("lab.js", experiments.recognizes_labjs, experiments.read_labjs, is_pooled=True),
    Dialect("psiTurk", crowdsourcing.recognizes_psiturk, crowdsourcing.read_psiturk),
    Dialect("MTurk", crowdsourcing.recognizes_mturk, crowdsourcing.read_mturk, is_pooled=True),
    Dialect("pymushra", experiments.recognizes_pymushra, experiments.read_pymushra, is_pooled=True),
    Dialect("formr", surveys.recognizes_formr, surveys.read_formr),
    Dialect("reVISit", experiments.recognizes_revisit, experiments.read_revisit, is_pooled=True),
    Dialect("Typeform", forms.recognizes_typeform, forms.read_typeform),
    Dialect("Google Forms", forms.recognizes_google, forms.read_google),
    Dialect("Microsoft Forms", forms.recognizes_microsoft, forms.read_microsoft),
    Dialect("emovid survey", tables.recognizes_survey, tables.read_survey, is_pooled=True),
    Dialect("long table", tables.recognizes_long, tables.read_generic_long, is_pooled=True),
    Dialect("wide table", tables.recognizes_wide, tables.read_wide),
)


def dialect_of(table: Table, known: Known) -> Dialect:
    """Return the first dialect that recognizes a table.

    Raises:
        SourceError: if none does, with the columns that were looked for.
    """
    for dialect in DIALECTS:
        if dialect.recognizes(table, known):
            return dialect
    check_named(table, known)
    raise SourceError(table.file, tables.no_videos(table, known) or _nothing_known(table, known), 1)


def _nothing_known(table: Table, known: Known) -> str:
    names = ", ".join(quoted(name, 20) for name in table.names[:6])
    codes = f"the key's codes ({', '.join(list(known.codes)[:3])}, ...)" if known.codes else "emotions"
    tools = ", ".join(dialect.name for dialect in DIALECTS[:-2])
    return (
        f"unknown format: columns {names}; looked for the headers of {tools}, and for {codes} in a column of videos "
        f"or in the names of columns; expected {'' if known.codes else 'a key, or '}map.yaml: video and response "
        "(a row for each answer) or videos (a column for each video)"
    )
