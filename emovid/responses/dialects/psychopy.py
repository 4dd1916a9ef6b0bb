"""PsychoPy and its online twin Pavlovia: a row for each trial, one file for each participant."""

from emovid.csv_reader import Table
from emovid.responses.dialects.parsed_export import Known, Raw
from emovid.responses.dialects.trials import emptied, read_trials

_VIDEOS = ("video_code", "video", "videoFile", "video_file", "movieFile", "movie", "stimFile", "stimulus")
_TOOL = ("date", "expName", "expStart", "psychopyVersion", "frameRate", "session", "OS", "notes", "expVersion")


def recognises(table: Table, _: Known) -> bool:
    """Return whether a table has the counter of a loop and what the tool says of itself."""
    loops = any(name.endswith((".thisN", ".thisTrialN")) for name in table.names)
    return loops and bool({"psychopyVersion", "expName", "frameRate"} & set(table.names))


def read(table: Table, known: Known) -> Raw:
    """Read the trials that show a video; a cell that says None is empty."""
    table = emptied(table, "None")
    loops = tuple(name for name in table.names if name.endswith(".thisN") and _counts(table, name))
    answers = tuple(name for name in table.names if name.endswith((".keys", ".response", ".text", ".clicked_name")))
    return read_trials(table, known, None, _VIDEOS, answers, loops, is_tool=_is_tool)


def _counts(table: Table, name: str) -> bool:
    return bool((table.cells[table.names.index(name)] != "").any())


def _is_tool(name: str) -> bool:
    return "." in name or name in _TOOL
