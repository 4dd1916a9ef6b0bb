"""Changes of an export without a change of meaning keep its matrix, or the export is refused."""

import csv
import io
import json
import tempfile
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from emovid.errors import SourceError
from emovid.responses import columns
from emovid.responses.export_files import open_table
from emovid.responses.read import read_responses
from tests.helpers.exports import CODES, COUNTS, EMOTIONS, EXPORTS, KEY, Export

TRUTHS = ("emotion", "label", "answer", "correct_answer", "condition", "category")
OTHERS = {
    "constant": lambda i: "A",
    "constant label": lambda i: "fear",
    "rt": lambda i: str(400 + 37 * i % 900),
    "RT.seconds": lambda i: f"{1 + (7 * i) % 13}.{i % 10}",
    "comment": lambda i: ("no idea", "it looked angry to me, or sad", "", "fear?? not sure", "nice robots")[i % 5],
}
HEADERS = {"qualtrics": 2, "surveymonkey": 1}  # further header rows below the first
FIXTURES = {make.__name__: make for make in EXPORTS}


def headers_of(name: str) -> int:
    if name == "qualtrics_legacy":
        return 1
    return next((rows for start, rows in HEADERS.items() if name.startswith(start)), 0)


def truth_of(row: list[str], i: int) -> str:
    """The true emotion of the video in a row; in a row of many videos, any emotion."""
    found = {emotion for code, emotion in CODES.items() if any(code in cell for cell in row)}
    return found.pop() if len(found) == 1 else EMOTIONS[i % 6] if not found else ""


class Change:
    """Changes of the tables of an export, drawn from one seed."""

    def __init__(self, seed: int, rows: bool, columns: bool, added: str, renamed: bool, front: bool = False) -> None:
        self.seed, self.rows, self.columns, self.added, self.renamed = seed, rows, columns, added, renamed
        self.front = front

    def table(self, file: str, data: bytes, headers: int, names: dict[str, str]) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / file
            path.write_bytes(data)
            table, _ = open_table(path)
        rows = [list(table.names), *table.cells.to_numpy().tolist()]
        rows[0] = [names.get(cell, cell) for cell in rows[0]]
        if self.added:
            for i, row in enumerate(rows):
                cell = self.added if i <= headers else OTHERS.get(self.added, lambda i, row=row: truth_of(row, i))(i)
                row.insert(0 if self.front else len(row), cell)
        if self.columns:
            places = np.random.default_rng(self.seed).permutation(len(rows[0]))
            rows = [[row[place] for place in places] for row in rows]
        if self.rows:
            rows[1 + headers :] = self.shuffled(rows[1 + headers :])
        out = io.StringIO(newline="")
        csv.writer(out, lineterminator="\n").writerows(rows)
        return out.getvalue().encode()

    def trials(self, data: bytes) -> bytes:
        lists = [json.loads(line) for line in data.decode().splitlines()]
        for trials in lists:
            for i, trial in enumerate(trials):
                if self.added:
                    text = truth_of([json.dumps(trial)], i)
                    trial[self.added] = OTHERS.get(self.added, lambda _, text=text: text)(i)
        lists = [self.shuffled(trials) if self.rows else trials for trials in lists]
        return "\n".join(map(json.dumps, lists)).encode()

    def shuffled(self, items: list) -> list:
        return [items[i] for i in np.random.default_rng(self.seed).permutation(len(items))]


def changed(name: str, change: Change) -> Export:
    export = FIXTURES[name]()
    mapping = yaml.safe_load(export.map or "{}") or {}
    videos = mapping.get("videos") if isinstance(mapping.get("videos"), dict) else {}
    named = [mapping.get("participant"), *(mapping.get("groups") or {}).values(), *videos]
    names = {title: f"{title} (x)" for title in named if title} if change.renamed else {}
    if isinstance(mapping.get("participant"), str):
        mapping["participant"] = names.get(mapping["participant"], mapping["participant"])
    if videos:
        mapping["videos"] = {names.get(title, title): code for title, code in videos.items()}
    if mapping.get("groups"):
        mapping["groups"] = {group: names.get(title, title) for group, title in mapping["groups"].items()}
    export.map = yaml.safe_dump(mapping, allow_unicode=True) if mapping else ""
    for file, data in list(export.files.items()):
        if data:
            del export.files[file]
            is_json = data.lstrip()[:1] in (b"[", b"{")
            table = change.trials(data) if is_json else change.table(file, data, headers_of(name), names)
            export.files[file.replace(".xlsx", ".csv")] = table
    return export


def matrix_of(export: Export) -> list[list[int]] | None:
    """The counts of an export; None if it is refused."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "exports").mkdir()
        for file, data in export.files.items():
            (root / "exports" / file).write_bytes(data)
        (root / "key.csv").write_text(KEY)
        (root / "map.yaml").write_text(export.map or "labels:\n")
        source = root / "exports" if len(export.files) > 1 else root / "exports" / next(iter(export.files))
        try:
            found = read_responses(source, root / "key.csv", root / "map.yaml")
        except SourceError:
            return None
        return found.counts().tolist() if found.labels == EMOTIONS else [[len(found.labels)]]


# Equal questions of Google Forms differ only in column order, which therefore must stay.
IN_COLUMN_ORDER = ("google_sheets",)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(sorted(FIXTURES)),
    st.integers(0, 1000),
    st.booleans(),
    st.booleans(),
    st.sampled_from(["", *TRUTHS, *OTHERS]),
    st.booleans(),
)
def test_equivalent_changes_keep_the_matrix_or_are_refused(name, seed, rows, columns, added, renamed) -> None:
    change = Change(seed, rows, columns and name not in IN_COLUMN_ORDER, added, renamed)
    assert matrix_of(changed(name, change)) in (None, COUNTS)


@pytest.mark.parametrize("added", ["correct_answer", "rt", "comment"])
@pytest.mark.parametrize("name", ["own", "generic_wide", "jspsych", "psychopy", "qualtrics"])
def test_additional_column_does_not_lead_to_a_refusal(name, added) -> None:
    assert matrix_of(changed(name, Change(0, rows=True, columns=False, added=added, renamed=False))) == COUNTS


# Long tables in which no name of a column belongs to a tool, so that the content of the columns decides.
BY_CONTENT = ("generic_long", "choices_long", "labvanced", "otree_app")


@pytest.mark.parametrize("added", TRUTHS)
@pytest.mark.parametrize("name", BY_CONTENT)
def test_true_emotions_in_the_first_column_are_no_answers(name, added) -> None:
    change = Change(1, rows=True, columns=False, added=added, renamed=False, front=True)
    assert matrix_of(changed(name, change)) in (None, COUNTS)


def test_a_reader_that_takes_the_first_column_of_labels_fails(monkeypatch) -> None:
    monkeypatch.setattr(columns._Evidence, "truth", lambda _: {})
    monkeypatch.setattr(columns, "_different", lambda _, places, __: list(places)[:1])
    change = Change(1, rows=True, columns=False, added="emotion", renamed=False, front=True)
    assert all(matrix_of(changed(name, change)) not in (None, COUNTS) for name in BY_CONTENT[:3])
