"""lab.js: a row for each screen and each loop around it."""

from emovid.csv_reader import Table
from emovid.responses.dialects.columns import column
from emovid.responses.dialects.parsed_export import Column, Known, Raw
from emovid.responses.dialects.people import PARTICIPANT
from emovid.responses.dialects.trials import read_trials

_TOOL = ("sender", "sender_type", "sender_id", "meta", "ended_on", "duration", "correct", "correctResponse", "url")


def recognises(table: Table, _: Known) -> bool:
    """Return whether a table says of each row which screen sent it."""
    return {"sender", "sender_type"} <= set(table.names)


def read(table: Table, known: Known) -> Raw:
    """Read the screens that show a video; the rows of loops and sequences, which repeat it, are no screens."""
    return read_trials(
        table,
        known,
        _shows,
        answers=("response",),
        order=("timestamp", "time_run", "sender_id"),
        ids=(*PARTICIPANT, "observation"),
        is_tool=lambda name: name in _TOOL or name.startswith("time_"),
    )


def _shows(table: Table, video: int, _: Column) -> Column:
    place = column(table, "sender_type")
    assert place is not None  # it was recognised by it
    return (table.cells[video] != "") & ~table.cells[place].str.startswith("flow.")
