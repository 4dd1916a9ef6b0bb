"""jsPsych 6, 7 and 8: one row for each trial of any kind, as CSV or JSON; one file for all participants or for each.

Version 6 has `button_pressed` or `key_press` instead of `response`, and answers of surveys as JSON in `responses`.
"""

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from emovid.csv_reader import Table, cells_that, table_of, translated, utf8
from emovid.errors import SourceError
from emovid.responses.columns import Format
from emovid.responses.dialects.tables import read_long
from emovid.responses.exclusions import Marks, says
from emovid.responses.parsed_export import Column, Known, ParsedExport
from emovid.responses.participants import PARTICIPANT, groups_of_pairs, joined, who

_VIDEO_TRIALS = ("video button response", "video keyboard response", "video slider response")
_PRESSED = ("response", "button_pressed", "key_press")
_SURVEYS = ("response", "responses")
_TOOL = (
    "trial_type", "trial_index", "time_elapsed", "internal_node_id", "plugin_version", "rt", "response", "responses",
    "button_pressed", "key_press", "stimulus", "question_order", "view_history", "success", "timeout", "failed_images",
    "failed_audio", "failed_video",
)  # fmt: skip


_PLUGIN = re.compile(r"(html|image|audio|video|canvas|survey)-(\w+-)*(response|choice|select|text|likert|form)")


def recognizes(table: Table, _: Known) -> bool:
    """Return whether a table has the columns of every trial, or the names of jsPsych's plugins."""
    if "trial_type" not in table.names:
        return False
    plugins = cells_that(table.cells[table.names.index("trial_type")], lambda text: bool(_PLUGIN.fullmatch(text)))
    return "trial_index" in table.names or bool(plugins.any())


def read(table: Table, known: Known) -> ParsedExport:
    """Read the trials that show a video; answers of surveys are groups of participants."""
    table = without_word(table, "null")
    people = who(table, known, *PARTICIPANT, by_file=True)
    if people.place is None and not known.mapping.participant and _is_shared(table):
        raise SourceError(table.file, "no column identifies its participants; expected map.yaml: participant", 1)
    pairs: list[tuple[str, str, str]] = []
    for name in _SURVEYS:
        if name in table.names:
            place = table.names.index(name)
            pairs += asked(people.ids, table.cells[place], known)
            table = table.replaced(place, translated(table.cells[place], only_value))
    form = Format(("video_code", "video", "stimulus"), _PRESSED, ("trial_index",), is_tool=_TOOL.__contains__)
    raw = read_long(table, known, form, lambda _: Marks(), _shows_video, by_file=True)
    return replace(raw, participants=joined(raw.participants, groups_of_pairs(pairs)))


def _is_shared(table: Table) -> bool:
    """Return whether a file has several runs, or can have them."""
    if "trial_index" not in table.names:
        return True
    rows = table.cells[[table.names.index("trial_index")]].assign(file=0 if table.origins is None else table.origins)
    return bool(rows.duplicated().any())


def _shows_video(rows: Table, _: int, recognized: Column) -> Column:
    return recognized | says(rows, _VIDEO_TRIALS, "trial_type")


def without_word(table: Table, word: str) -> Table:
    """Return the table without cells that hold only the word of a tool for an empty value."""
    return replace(table, cells=table.cells.mask(table.cells == word, ""))


def json_table(data: bytes, file: str) -> Table:
    """Return the table of a JSON file: a list of trials, or one list on each line.

    Raises:
        SourceError: for any other file.
    """
    text = utf8(data, file).decode()
    try:
        trials = list(_trials(text))
    except (ValueError, RecursionError):
        raise SourceError(file, "not JSON; expected a list of trials") from None
    if not trials or not all(isinstance(trial, dict) for trial in trials):
        raise SourceError(file, "not a list of trials; expected one as jsPsych writes it")
    return table_of_objects(file, enumerate(trials, start=1))


def table_of_objects(file: str, trials: Iterable[tuple[int, dict[str, Any]]]) -> Table:
    """Return a table with one row for each object (line, keys and values)."""
    rows = list(trials)
    names = list(dict.fromkeys(name for _, trial in rows for name in trial))
    return table_of(file, [(0, names), *((line, [text_of(trial.get(name)) for name in names]) for line, trial in rows)])


def asked(ids: Column, cells: Column, known: Known) -> Iterator[tuple[str, str, str]]:
    """Yield participant, name and value of each answer in cells such as `{"gender":"Female"}`."""
    titles = {title: name for name, title in known.mapping.groups.items()}
    opened = cells.str.startswith("{")
    for participant, cell in zip(ids[opened], cells[opened], strict=True):
        for name, value in json_object(cell).items():
            if not known.labels.is_label(text_of(value)):
                yield participant, titles.get(name, name), text_of(value)


def only_value(cell: str) -> str:
    """Return the value in a cell such as `{"Q0":"Anger"}`, and any other cell as it is."""
    values = list(json_object(cell).values()) if cell.startswith("{") else []
    return text_of(values[0]) if len(values) == 1 else cell


def json_object(cell: str) -> dict[str, Any]:
    """Return the JSON object in a cell; empty if there is none."""
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


def text_of(value: Any) -> str:
    """Return a JSON value as the text of a cell."""
    text = value if isinstance(value, str) else "" if value is None else json.dumps(value, ensure_ascii=False)
    return text.encode(errors="replace").decode()  # JSON can contain half a surrogate pair
