"""jsPsych: a row for each trial of any kind, as CSV or JSON; one file for all participants or for each."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from emovid.csv_reader import Table, table_of, utf8
from emovid.errors import SourceError
from emovid.responses.dialects.columns import says
from emovid.responses.dialects.parsed_export import Column, Known, Raw
from emovid.responses.dialects.people import PARTICIPANT, groups_of_pairs, joined, who
from emovid.responses.dialects.trials import emptied, read_trials, translated, with_column

_VIDEO_TRIALS = ("video button response", "video keyboard response")
_TOOL = (
    "trial_type",
    "trial_index",
    "time_elapsed",
    "internal_node_id",
    "plugin_version",
    "rt",
    "response",
    "stimulus",
    "question_order",
    "view_history",
    "success",
    "timeout",
    "failed_images",
    "failed_audio",
    "failed_video",
)


def recognises(table: Table, _: Known) -> bool:
    """Return whether a table has the columns of every trial."""
    return {"trial_type", "trial_index"} <= set(table.names)


def read(table: Table, known: Known) -> Raw:
    """Read the trials that show a video; what surveys asked of the participant are groups."""
    table = emptied(table, "null")
    people = who(table, known, *PARTICIPANT, alone=Path(table.file).stem)
    if people.place is None and table.cells[table.names.index("trial_index")].duplicated().any():
        raise SourceError(table.file, "no column tells its participants apart; expected map.yaml: participant", 1)
    pairs: list[tuple[str, str, str]] = []
    if "response" in table.names:
        place = table.names.index("response")
        pairs = list(asked(people.ids, table.cells[place], known))
        table = with_column(table, place, translated(table.cells[place], only_value))
    raw = read_trials(
        table,
        known,
        lambda rows, _, recognised: recognised | says(rows, _VIDEO_TRIALS, "trial_type"),
        ("video_code", "video", "stimulus"),
        ("response",),
        ("trial_index",),
        is_tool=_TOOL.__contains__,
    )
    return replace(raw, participants=joined(raw.participants, groups_of_pairs(pairs)))


def json_table(data: bytes, file: str) -> Table:
    """Return the table of a JSON file: a list of trials, or one list on each line.

    Raises:
        SourceError: for another file.
    """
    text = utf8(data, file).decode()
    try:
        trials = list(_trials(text))
    except (ValueError, RecursionError):
        raise SourceError(file, "no JSON; expected a list of trials") from None
    if not trials or not all(isinstance(trial, dict) for trial in trials):
        raise SourceError(file, "no list of trials; expected one as jsPsych writes it")
    names = list(dict.fromkeys(name for trial in trials for name in trial))
    rows = ((line, [_text(trial.get(name)) for name in names]) for line, trial in enumerate(trials, start=1))
    return table_of(file, [(0, names), *rows])


def asked(ids: Column, cells: Column, known: Known) -> Iterator[tuple[str, str, str]]:
    """Yield participant, name and value of what is answered in cells such as `{"gender":"Female"}`."""
    titles = {title: name for name, title in known.mapping.groups.items()}
    opened = cells.str.startswith("{")
    for participant, cell in zip(ids[opened], cells[opened], strict=True):
        for name, value in _object(cell).items():
            if not known.labels.is_label(_text(value)):
                yield participant, titles.get(name, name), _text(value)


def only_value(cell: str) -> str:
    """Return the value in a cell such as `{"Q0":"Anger"}`, and any other cell as it is."""
    values = list(_object(cell).values()) if cell.startswith("{") else []
    return _text(values[0]) if len(values) == 1 else cell


def _object(cell: str) -> dict[str, Any]:
    try:
        found = json.loads(cell)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _trials(text: str) -> Iterator[Any]:
    try:
        parts = [json.loads(text)]
    except ValueError:
        parts = [json.loads(line) for line in text.splitlines() if line.strip()]
    for part in parts:
        yield from part if isinstance(part, list) else [part]


def _text(value: Any) -> str:
    text = value if isinstance(value, str) else "" if value is None else json.dumps(value, ensure_ascii=False)
    return text.encode(errors="replace").decode()  # JSON can spell half a surrogate pair
