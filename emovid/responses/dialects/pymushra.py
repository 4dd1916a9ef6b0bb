"""pymushra, the server of webMUSHRA: a row for each answer, its columns in any order."""

import re
from dataclasses import replace

from emovid.csv_reader import Table
from emovid.responses.dialects.parsed_export import Known, Raw
from emovid.responses.dialects.people import PARTICIPANT
from emovid.responses.dialects.trials import read_trials

_VIDEO = "responses_stimulus"
_GROUP = "questionnaire_"


def recognises(table: Table, _: Known) -> bool:
    """Return whether a table has the column of what was answered to."""
    return _VIDEO in table.names


def read(table: Table, known: Known) -> Raw:
    """Read one row for each answer; what the questionnaire asked are groups."""
    names = tuple(name.removeprefix(_GROUP) for name in table.names)
    ids = tuple(name for name in names if re.search(r"uuid$|session_id$|participant", name))
    return read_trials(
        replace(table, names=names, texts=names),
        known,
        videos=(_VIDEO,),
        answers=tuple(name for name in names if name.startswith("responses_")),
        order=("trial_position", "position"),
        ids=(*ids, *PARTICIPANT),
        is_tool=lambda name: name.startswith(("responses_", "trial_", "wm_", "config", "errors")),
    )
