"""The dialects, in the order in which they are tried."""

from collections.abc import Callable
from typing import NamedTuple

from emovid.study.dialects import (
    formr,
    generic,
    google_forms,
    jspsych,
    labjs,
    limesurvey,
    microsoft_forms,
    otree,
    own,
    psiturk,
    psychopy,
    pymushra,
    qualtrics,
    revisit,
    surveymonkey,
)
from emovid.study.dialects.raw import Known, Raw
from emovid.study.dialects.videos import no_videos
from emovid.study.errors import StudyError, quoted
from emovid.study.tables import Table


class Dialect(NamedTuple):
    """How one tool writes its answers.

    Attributes:
        name: in words.
        recognises: whether a table is of it, from its headers alone where the tool has some of its own.
        read: the table's answers.
    """

    name: str
    recognises: Callable[[Table, Known], bool]
    read: Callable[[Table, Known], Raw]


DIALECTS = (
    Dialect("Qualtrics", qualtrics.recognises, qualtrics.read),
    Dialect("SurveyMonkey", surveymonkey.recognises, surveymonkey.read),
    Dialect("LimeSurvey", limesurvey.recognises, limesurvey.read),
    Dialect("jsPsych", jspsych.recognises, jspsych.read),
    Dialect("PsychoPy or Pavlovia", psychopy.recognises, psychopy.read),
    Dialect("oTree", otree.recognises, otree.read),
    Dialect("lab.js", labjs.recognises, labjs.read),
    Dialect("psiTurk", psiturk.recognises, psiturk.read),
    Dialect("pymushra", pymushra.recognises, pymushra.read),
    Dialect("formr", formr.recognises, formr.read),
    Dialect("reVISit", revisit.recognises, revisit.read),
    Dialect("Google Forms", google_forms.recognises, google_forms.read),
    Dialect("Microsoft Forms", microsoft_forms.recognises, microsoft_forms.read),
    Dialect("emovid survey", own.recognises, own.read),
    Dialect("long table", generic.recognises_long, generic.read_long),
    Dialect("wide table", generic.recognises_wide, generic.read_wide),
)


def dialect_of(table: Table, known: Known) -> Dialect:
    """Return the first dialect that recognises a table.

    Raises:
        StudyError: if none does, with what was looked for.
    """
    for dialect in DIALECTS:
        if dialect.recognises(table, known):
            return dialect
    raise StudyError(table.file, _unrecognised(table, known), 1)


def _unrecognised(table: Table, known: Known) -> str:
    names = ", ".join(quoted(name, 20) for name in table.names[:6])
    return no_videos(table, known) or (
        f"no export known here: columns {names}; looked for the headers of {_tools()}, a column of videos beside one "
        "of answers, and columns named by video; expected one of them, a key, or map.yaml: videos and answers"
    )


def _tools() -> str:
    return ", ".join(dialect.name for dialect in DIALECTS[:-2])
