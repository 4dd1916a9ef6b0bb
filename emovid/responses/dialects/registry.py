"""The dialects, in the order in which they are tried."""

from collections.abc import Callable
from typing import NamedTuple

from emovid.csv_reader import Table
from emovid.errors import SourceError, quoted
from emovid.responses.dialects import (
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
from emovid.responses.dialects.columns import check_named, holds_answers, holds_videos, video_column
from emovid.responses.dialects.parsed_export import Known, Raw
from emovid.responses.dialects.videos import no_videos


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
        SourceError: if none does, with what was looked for.
    """
    for dialect in DIALECTS:
        if dialect.recognises(table, known):
            return dialect
    raise SourceError(table.file, _unrecognised(table, known), 1)


def _unrecognised(table: Table, known: Known) -> str:
    check_named(table, known)
    return _no_answers(table, known) or no_videos(table, known) or _nothing_known(table, known)


def _no_answers(table: Table, known: Known) -> str:
    """Return what a table with a row for each answer lacks, or "" if no column of videos is there."""
    holding = [place for place in range(len(table.names)) if known.codes and holds_videos(table, place, known)]
    video = video_column(table, known)
    if video is None:
        several = " and ".join(quoted(table.names[place]) for place in holding)
        return f"columns {several} hold codes of the key; expected map.yaml: video: one of them" if several else ""
    name, labels = quoted(table.names[video]), ", ".join(known.labels.signalled[:3])
    answering = [place for place in range(len(table.names)) if place != video and holds_answers(table, place, known)]
    if answering:
        several = " and ".join(quoted(table.names[place]) for place in answering)
        return f"videos in {name}, answers in {several}; expected map.yaml: response: one of them"
    return (
        f"videos in {name}, but no column holds answers ({labels}, ...); expected map.yaml: response: their column, "
        "and answers: what its cells mean, or other --labels"
    )


def _nothing_known(table: Table, known: Known) -> str:
    names = ", ".join(quoted(name, 20) for name in table.names[:6])
    codes = f"the key's codes ({', '.join(list(known.codes)[:3])}, ...)" if known.codes else "emotions"
    return (
        f"no export known here: columns {names}; looked for the headers of {_tools()}, and for {codes} in a column of "
        f"videos or in the names of columns; expected {'' if known.codes else 'a key, or '}map.yaml: video and "
        "response (a row for each answer) or videos (a column for each video)"
    )


def _tools() -> str:
    return ", ".join(dialect.name for dialect in DIALECTS[:-2])
