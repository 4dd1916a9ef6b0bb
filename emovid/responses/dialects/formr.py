"""formr: a row for each session, choices as numbers."""

from emovid.csv_reader import Table
from emovid.responses.dialects.columns import column
from emovid.responses.dialects.generic import read_wide
from emovid.responses.dialects.parsed_export import Known, Raw

_TOOL = ("session", "session_id", "study_id", "created", "modified", "ended", "expired", "iteration")


def recognises(table: Table, _: Known) -> bool:
    """Return whether a table has a session and its times."""
    return {"session", "created", "ended"} <= set(table.names)


def read(table: Table, known: Known) -> Raw:
    """Read one row for each session; those that did not end are left out, and the tool's test sessions (XXX)."""
    ended, session = (column(table, name) for name in ("ended", "session"))
    assert ended is not None  # it was recognised by both
    assert session is not None
    reasons = {"test run": table.cells[session].str.contains("XXX"), "partial": table.cells[ended] == ""}
    return read_wide(table, known, "session", reasons=reasons, skip=_TOOL)
