"""A data set by Psych-DS (psych-ds.github.io): data as CSV, and a dictionary of the columns."""

import hashlib
import json
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from emovid.csv_reader import Table
from emovid.csv_writer import csv_text
from emovid.kit.exports.texts import Files, template
from emovid.kit.folder import Kit
from emovid.kit.study import Question
from emovid.responses.export_files import open_table
from emovid.responses.responses import RECORDED, Responses

_ORDER_ROW = "order_row"
_KNOWN = {
    "participant_id": "participant; pseudonyms stand for all names that the kit did not give",
    "video_code": "random code of the video; key.csv, published after the study, gives its emotion",
    "position": "position of the video in the participant's order, from 1",
    "choices": "order of the answers on the participant's pages",
    "signalled": "label that the video signals",
    "response": "label that the participant chose",
    "confidence": "rating: how sure the participant is of the choice",
    "valence": "rating: how unpleasant or pleasant the emotion is",
    "arousal": "rating: how calm or excited the emotion is",
    "rt": "time from the start of the page to the answer [ms]",
    "plays": "number of times that the video was played",
    "watched_seconds": "time for which the video was watched [s]",
    _ORDER_ROW: "row of the orders that the participant saw",
    "consent_version": "version of the consent text",
    "first_response": "label that the participant chose first",
    "changes": "number of changes of the answer",
    "device": "kind of device",
}
# Columns of the answers, here and in the data set.
_NAMES = {
    "participant": "participant_id",
    "video": "video_code",
    "position": "position",
    "signalled": "signalled",
    "perceived": "response",
}
_ALIASES = {"order_index": _ORDER_ROW}  # of columns in exports
_RATINGS = ("confidence", "valence", "arousal")
_TYPED = "(typed)"  # in the place of text where the study offers choices
_FEWEST = 3  # participants from which on a column without a repeated value identifies them
_ANSWER_CODE = "[A-Z]{0,2}[0-9]{1,3}|[YN]"  # as survey tools export choices
_OF_PEOPLE = (_ORDER_ROW, "consent_version", "device")  # recorded once for each participant
_OF_ANSWERS = (*dict.fromkeys((*_RATINGS, "rt", "plays", "watched_seconds", "choices", *RECORDED)),)


@dataclass(frozen=True)
class _Data:
    """Answers for publication, and a list of removed data."""

    table: pd.DataFrame
    removed: tuple[str, ...]


def psych_ds(kit: Kit, responses: Responses | None) -> Files:
    """Return the data set: the orders, and the answers if there are any."""
    manifest = kit.manifest
    name = "study-" + (re.sub(r"[^a-zA-Z0-9]", "", manifest.title.title()) or "emovid")
    orders = pd.DataFrame(
        [
            {"participant_id": who, "position": place, "video_code": code}
            | ({"choices": "|".join(kit.choices[who])} if kit.choices else {})
            for who, order in kit.orders.items()
            for place, code in enumerate(order, start=1)
        ]
    )
    data = _published(kit, responses) if responses else _Data(pd.DataFrame(), ())
    tables = {"orders": orders} | ({"responses": data.table} if responses else {})
    columns = {column: table[column] for table in tables.values() for column in table}
    description = {
        "@context": "http://schema.org/",
        "@type": "Dataset",
        "schemaVersion": "Psych-DS 1.4.0",
        "name": manifest.title,
        "description": f"{manifest.question} A study of {len(manifest.videos)} videos.",
        "author": list(manifest.authors),
        "keywords": ["human-robot interaction", "swarm robotics", "emotion", "forced choice"],
        "inLanguage": manifest.language,
        "variableMeasured": [_variable(column, cells, kit) for column, cells in columns.items()],
    }
    files = {f"data/{name}_description-{what}_data.csv": _csv(table) for what, table in tables.items()}
    answers = "and the answers" if responses else "and not the answers yet: add them with `--responses EXPORT`"
    removed = "\n".join(f"- {what}" for what in data.removed) or "- nothing"
    return files | {
        "dataset_description.json": json.dumps(description, indent=2, ensure_ascii=False) + "\n",
        "materials/manifest.json": manifest.text(),
        "README.md": template("psych_ds.md", title=manifest.title, answers=answers, removed=removed),
    }


def _csv(table: pd.DataFrame) -> str:
    cells = table.astype(object).where(table.notna(), "")
    return csv_text(list(map(str, table)), cells.itertuples(index=False, name=None))


def _published(kit: Kit, responses: Responses) -> _Data:
    """Return each answer with its recorded data, under pseudonyms and without free text."""
    answers = responses.answers.rename(columns=_NAMES)[list(_NAMES.values())].reset_index(drop=True)
    recorded = _recorded(responses).reset_index(drop=True)
    groups, typed = _without_free_text(responses.participants, _questions(kit))
    groups = groups.rename(columns=lambda name: f"{name} (group)" if name in (*_KNOWN, *recorded) else name)
    table = answers.join(recorded).merge(groups, left_on="participant_id", right_index=True, how="left")
    pseudonyms = _pseudonyms(kit, list(responses.participants.index))
    table["participant_id"] = table["participant_id"].map(pseudonyms)
    hidden = sum(name != pseudonym for name, pseudonym in pseudonyms.items())
    removed = (
        [f"names of {hidden} participants, replaced by pseudonyms; no table of the names is kept"] if hidden else []
    )
    return _Data(table, (*removed, *typed))


def _without_free_text(people: pd.DataFrame, questions: tuple[Question, ...]) -> tuple[pd.DataFrame, list[str]]:
    """Return the groups of participants without typed or identifying text, and a list of removed data."""
    known = {item.name: item for item in questions}
    kept, removed = people.copy(), []
    for name in map(str, people):
        cells = people[name].fillna("")
        item, filled = known.get(name), cells[cells != ""]
        if item is not None and _is_free_text(item):
            kept = kept.drop(columns=name)
            removed.append(f"answers to {name}, which are free text")
        elif item is None and len(filled) >= _FEWEST and filled.is_unique:
            kept = kept.drop(columns=name)
            removed.append(f"column {name}, which differs for each participant")
        elif item is not None:
            typed = ~cells.map(lambda cell, asked=item: not cell or _is_given_by(str(cell), asked))
            kept[name] = cells.mask(typed, _TYPED)
            if typed.any():
                removed.append(f"{typed.sum()} answers to {name} that are none of its choices, shown as {_TYPED}")
    return kept, removed


def _is_given_by(cell: str, question: Question) -> bool:
    """Return whether a cell is an answer that a question offers, or the code of one."""
    if question.number:
        return re.fullmatch(r"[+-]?[0-9]+([.]0*)?", cell) is not None
    choices = question.choices or ()
    parts = cell.split("|") if question.several else [cell]
    return all(part in choices or re.fullmatch(_ANSWER_CODE, part) for part in parts)


def _questions(kit: Kit) -> tuple[Question, ...]:
    return (*kit.manifest.demographics, *kit.manifest.questions_after)


def _is_free_text(question: Question) -> bool:
    return question.choices is None and question.number is None


def _pseudonyms(kit: Kit, names: list[str]) -> Mapping[str, str]:
    """Return a pseudonym for each name that is not from the kit, in an order independent of the names."""
    salt = kit.folder.salt.read_bytes() if kit.folder.salt.is_file() else secrets.token_bytes(32)
    others = [name for name in names if name not in kit.orders]
    others.sort(key=lambda name: hashlib.sha256(salt + name.encode()).digest())
    return {name: name for name in names} | {name: f"S{number:03}" for number, name in enumerate(others, start=1)}


def _recorded(responses: Responses) -> pd.DataFrame:
    """Return the data recorded with each answer: ratings, times, plays, choices, row of the orders."""
    found = pd.DataFrame(index=responses.answers.index)
    if responses.places.empty:
        return found
    for file, places in responses.places.groupby("file"):
        table, _ = open_table(Path(str(file)))
        rows = {int(line): row for row, line in enumerate(table.lines)}
        for answer, line in places["line"].items():
            video, who = responses.answers.loc[answer, ["video", "participant"]]
            if int(line) in rows:
                for name, cell in _cells_beside(table, rows[int(line)], str(video)).items():
                    found.loc[answer, name] = cell
        for who, mine in responses.answers.loc[places.index].groupby("participant"):
            lines = [rows[int(line)] for line in places.loc[mine.index, "line"] if int(line) in rows]
            for name, cell in _cells_of_person(table, lines, str(who)).items():
                found.loc[mine.index, name] = cell
    known = [name for name in dict.fromkeys((*_OF_ANSWERS, *_OF_PEOPLE)) if name in found]
    return found[known]


def _cells_beside(table: Table, row: int, video: str) -> dict[str, str]:
    """Return the recorded cells of an answer: in its row (long table), or of its video (one column for each video)."""
    found = {}
    for place, title in enumerate(table.names):
        name, cell = title.partition(":")[0], str(table.cells[place].iloc[row])
        of_video = re.fullmatch(rf"{re.escape(video)}_?(\w+?)(\[SQ1\])?", name, re.IGNORECASE)
        slider = re.fullmatch(r"(\w+)\.response", name)
        name = of_video[1] if of_video else slider[1] if slider else name
        if cell and name in (_RATINGS if of_video or slider else _OF_ANSWERS):
            found[name] = cell
    return found


def _cells_of_person(table: Table, rows: list[int], who: str) -> dict[str, str]:
    """Return the cells recorded once per participant, in a separate row or file."""
    theirs = [place for place in range(len(table.names)) if rows and all(table.cells[place].iloc[rows] == who)]
    mask = np.ones(len(table.lines), dtype=bool)
    if theirs:
        mask = (table.cells[theirs[0]] == who).to_numpy(dtype=bool)
    found = {}
    for place, title in enumerate(table.names):
        name = _ALIASES.get(title, title)
        cells = table.cells[place][mask]
        filled = cells[cells != ""].unique()
        if name in _OF_PEOPLE and len(filled) == 1:
            found[name] = str(filled[0])
    return found


def _variable(column: str, cells: "pd.Series[str]", kit: Kit) -> dict[str, object]:
    questions = {item.name: item for item in _questions(kit)}
    ratings = {rating.name: rating for rating in kit.manifest.ratings}
    variable: dict[str, object] = {"@type": "PropertyValue", "name": column}
    variable["description"] = _KNOWN.get(column) or getattr(questions.get(column), "question", column)
    if column in ("response", "signalled", "first_response"):
        variable["levels"] = {choice.label: choice.text for choice in kit.manifest.choices.labels}
    if column in questions and questions[column].choices:
        variable["levels"] = list(questions[column].choices or ())
    if column in ratings:
        rating = ratings[column]
        variable["description"] = f"{rating.question} (1: {rating.low}, {rating.steps}: {rating.high})"
        return variable | {"minValue": 1, "maxValue": rating.steps}
    if column == "position":
        return variable | {"minValue": 1, "maxValue": kit.manifest.videos_shown}
    numbers = pd.to_numeric(cells[cells.notna() & (cells != "")], errors="coerce")
    if column in _OF_ANSWERS and len(numbers) and numbers.notna().all():
        variable |= {"minValue": float(numbers.min()), "maxValue": float(numbers.max())}
    return variable
