"""Crowdsourcing: psiTurk, and batch results of Amazon Mechanical Turk."""

import json
import re
from collections import Counter
from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Rejected, Table
from emovid.errors import SourceError
from emovid.responses.columns import Format, video_column
from emovid.responses.dialects.jspsych import json_object, table_of_objects, text_of
from emovid.responses.dialects.tables import read_long, read_wide, video_columns
from emovid.responses.exclusions import Marks, says
from emovid.responses.parsed_export import Known, ParsedExport, no_answers
from emovid.responses.participants import groups_of_pairs

_PSITURK_ID = re.compile(r"[^\s:]+:[^\s:]+")
_ANSWER = "Answer."


def recognizes_psiturk(table: Table, _: Known) -> bool:
    """Return whether the first cell is `worker:assignment`, in a table as wide as psiTurk's trials or questions.

    Raises:
        SourceError: for psiTurk's third file, its events.
    """
    if not (3 <= len(table.names) <= 5 and _PSITURK_ID.fullmatch(table.names[0])):
        return False
    if len(table.names) == 5:
        raise SourceError(table.file, "events of psiTurk; expected its trials or questions")
    return True


def read_psiturk(table: Table, known: Known) -> ParsedExport:
    """Read the trials of trialdata.csv, or the groups of questiondata.csv; debug runs are left out."""
    rows = [(1, list(table.names)), *zip(table.lines.tolist(), table.cells.to_numpy().tolist(), strict=True)]
    if len(table.names) == 3:
        groups = groups_of_pairs((cells[0], cells[1], cells[2]) for _, cells in rows if not _is_debug(cells[0]))
        titles = {title: name for name, title in known.mapping.groups.items()}
        return ParsedExport(no_answers(), groups.rename(columns=titles))
    return _psiturk_trials(table, rows, known)


def _psiturk_trials(table: Table, rows: list[tuple[int, list[str]]], known: Known) -> ParsedExport:
    debug = {cells[0] for _, cells in rows if _is_debug(cells[0])}
    rejected = [Rejected(table.file, line, "4", cells[3][:80], "not a JSON object") for line, cells in rows
                if not cells[3].lstrip().startswith("{") or not _is_object(cells[3])]  # fmt: skip
    broken = {item.row for item in rejected}
    trials = [
        (line, {**json_object(cells[3]), "uniqueid": cells[0], "trial_number": cells[1]})
        for line, cells in rows
        if line not in broken and cells[0] not in debug
    ]
    dropped = Counter({"test run": len(debug)} if debug else {})
    if not trials:
        return ParsedExport(no_answers(), groups_of_pairs([]), (*table.rejected, *rejected), dropped)
    inner = table_of_objects(table.file, trials)
    form = Format(order=("trial_number",), participants=("uniqueid",), is_tool=lambda name: name == "phase")
    raw = read_long(inner, known, form, pick=lambda rows, video, _: rows.cells[video] != "")
    dropped.update(raw.dropped)
    return replace(raw, rejected=(*table.rejected, *rejected), dropped=dropped)


def _is_object(data: str) -> bool:
    return bool(json_object(data)) or data.strip() == "{}"


def _is_debug(person: str) -> bool:
    return person.startswith("debug")


def recognizes_mturk(table: Table, _: Known) -> bool:
    """Return whether a table has the columns of MTurk's batch results."""
    return {"HITId", "AssignmentId", "WorkerId"} <= set(table.names)


def read_mturk(table: Table, known: Known) -> ParsedExport:
    """Read one row for each assignment; rejected assignments are left out."""
    table = _with_task_answers(table)
    answers = tuple(name for name in table.names if name.startswith(_ANSWER[:-1]))
    inputs = tuple(name for name in table.names if name.startswith("Input."))
    form = Format(inputs, answers, (), ("WorkerId",), lambda name: name not in answers)
    if not known.mapping.video and video_column(table, known, form) is None and video_columns(table, known):
        return read_wide(table, known, "WorkerId", marks=_rejected(table), skip=[*set(table.names) - set(answers)])
    return read_long(table, known, form, _rejected)


def _rejected(table: Table) -> Marks:
    return Marks(rows={"rejected": says(table, ("rejected",), "AssignmentStatus")})


def _with_task_answers(table: Table) -> Table:
    """Return the table with a column for each answer in the JSON of `Answer.taskAnswers`."""
    if "Answer.taskAnswers" not in table.names:
        return table
    cells = table.cells[table.names.index("Answer.taskAnswers")]
    found = [dict(_flat(_first_object(cell))) for cell in cells]
    for name in dict.fromkeys(name for answers in found for name in answers):
        texts = pd.Series([answers.get(name, "") for answers in found], index=table.cells.index, dtype="str")
        table = table.with_column(_ANSWER + name, texts)
    return table


def _first_object(cell: str) -> dict[str, object]:
    try:
        found = json.loads(cell)
    except (ValueError, RecursionError):
        return {}
    if isinstance(found, list):
        found = found[0] if found else {}
    return found if isinstance(found, dict) else {}


def _flat(answers: dict[str, object], prefix: str = "") -> list[tuple[str, str]]:
    """Return names and texts of nested answers: {"emotion": {"label": "Fear"}} is emotion.label = Fear."""
    pairs: list[tuple[str, str]] = []
    for name, value in answers.items():
        if isinstance(value, dict):
            pairs += _flat(value, f"{prefix}{name}.")
        else:
            pairs.append((prefix + name, text_of(value)))
    return pairs
