"""psiTurk: three files without headers; trials hold their data as JSON, questions a key and a value."""

import json
import re
from collections import Counter
from dataclasses import replace
from typing import Any

from emovid.csv_reader import Rejected, Table, table_of
from emovid.errors import SourceError
from emovid.responses.dialects.parsed_export import Known, Raw, no_answers
from emovid.responses.dialects.people import groups_of_pairs
from emovid.responses.dialects.trials import read_trials

_ID = re.compile(r"[^\s:]+:[^\s:]+")


def recognises(table: Table, _: Known) -> bool:
    """Return whether the first cell is `worker:assignment` and the table is as wide as one of the three."""
    return 3 <= len(table.names) <= 5 and _ID.fullmatch(table.names[0]) is not None


def read(table: Table, known: Known) -> Raw:
    """Read the trials of trialdata.csv, or the groups of questiondata.csv; debug runs are left out."""
    rows = [(1, list(table.names)), *zip(table.lines.tolist(), table.cells.to_numpy().tolist(), strict=True)]
    if len(table.names) == 3:
        groups = groups_of_pairs((cells[0], cells[1], cells[2]) for _, cells in rows if not _is_debug(cells[0]))
        return Raw(no_answers(), groups.rename(columns={title: name for name, title in known.mapping.groups.items()}))
    if len(table.names) == 5:
        raise SourceError(table.file, "psiTurk's events; expected its trials or questions")
    return _trials(table, rows, known)


def _trials(table: Table, rows: list[tuple[int, list[str]]], known: Known) -> Raw:
    debug = {cells[0] for _, cells in rows if _is_debug(cells[0])}
    rejected: list[Rejected] = []
    trials: list[tuple[int, dict[str, str]]] = []
    for line, (person, trial, _, data) in rows:
        found = _object(data)
        if found is None:
            rejected.append(Rejected(table.file, line, "4", data[:80], "no JSON object"))
        elif person not in debug:
            trials.append((line, {**found, "uniqueid": person, "trial_number": trial}))
    names = list(dict.fromkeys(name for _, trial in trials for name in trial))
    cells = [(line, [trial.get(name, "") for name in names]) for line, trial in trials]
    dropped = Counter({"test run": len(debug)} if debug else {})
    if not cells:
        return Raw(no_answers(), groups_of_pairs([]), (*table.rejected, *rejected), dropped)
    inner = table_of(table.file, [(0, names), *cells])
    raw = read_trials(inner, known, order=("trial_number",), ids=("uniqueid",), is_tool=lambda name: name == "phase")
    dropped.update(raw.dropped)
    return replace(raw, rejected=(*table.rejected, *rejected), dropped=dropped)


def _object(data: str) -> dict[str, str] | None:
    try:
        found: Any = json.loads(data)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict):
        return None
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in found.items()}


def _is_debug(person: str) -> bool:
    return person.startswith("debug")
