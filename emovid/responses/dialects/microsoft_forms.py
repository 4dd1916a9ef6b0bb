"""Microsoft Forms: an Excel sheet saved as CSV. A question asked again has a number after it."""

from emovid.csv_reader import Table
from emovid.responses.dialects.generic import read_wide
from emovid.responses.dialects.parsed_export import Known, Raw
from emovid.responses.labels import plain

_END = ("completion time", "fertigstellungszeit", "heure de fin", "hora de finalización")
_TOOL = ("ID", "Start time", "Completion time", "Email", "Name", "Last modified time", "Startzeit", "E-Mail")


def recognises(table: Table, _: Known) -> bool:
    """Return whether the first columns are the form's id and times."""
    first = [plain(name) for name in table.names[:4]]
    return first[0] == "id" and any(name in _END for name in first)


def read(table: Table, known: Known) -> Raw:
    """Read one row for each person who sent the form."""
    return read_wide(table, known, "ID", skip=(*_TOOL, *table.names[:3]))
