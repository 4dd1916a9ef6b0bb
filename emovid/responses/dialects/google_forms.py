"""Google Forms: through Sheets (cells in quotes where needed) or as a downloaded CSV (all in quotes)."""

from emovid.csv_reader import Table
from emovid.responses.dialects.generic import read_wide
from emovid.responses.dialects.parsed_export import Known, Raw
from emovid.responses.labels import plain

# "Timestamp" in the languages of most forms.
_FIRST = ("timestamp", "zeitstempel", "horodateur", "marca temporal", "carimbo de data hora", "tijdstempel")
_TOOL = ("Timestamp", "Email Address", "Email", "Username", "Score")


def recognises(table: Table, _: Known) -> bool:
    """Return whether the first column is the form's time stamp."""
    return plain(table.names[0]) in _FIRST and all(cell[:1].isdigit() for cell in table.cells[0].head(20) if cell)


def read(table: Table, known: Known) -> Raw:
    """Read one row for each person who sent the form; questions asked alike need the map's list of codes."""
    return read_wide(table, known, "participant", "participant id", skip=(*_TOOL, table.names[0]))
