"""The export of our own survey: `emovid study responses` writes it, and its columns are known by name."""

from emovid.csv_reader import Table
from emovid.responses.dialects.generic import is_mapped_wide, read_long
from emovid.responses.dialects.parsed_export import Known, Raw

FIRST = ("participant", "video", "position", "response")
# What is recorded of answers and sessions, and tells participants in no groups.
RECORDED = (
    "first_response", "changes", "confidence", "valence", "arousal", "choices", "plays", "watched_share",
    "shown_seconds", "played_seconds", "first_answer_seconds", "answer_seconds", "width", "height", "frames",
    "dropped_frames", "ended_seconds", "stalls", "stalled_ms", "play_ms", "response_ms", "device",
    "order_row", "consent_version", "status", "mode",
)  # fmt: skip


def recognises(table: Table, known: Known) -> bool:
    """Return whether a table is our own survey's export."""
    return table.names[: len(FIRST)] == FIRST and not is_mapped_wide(known)


def read(table: Table, known: Known) -> Raw:
    """Read a table of our own survey; who has not submitted, and pilots, are left out and counted."""
    return read_long(table, known, FIRST[0], skip=RECORDED)
