"""A data set by Psych-DS (psych-ds.github.io): the data as CSV, and a dictionary of its columns."""

import json
import re

from emovid.csv_writer import csv_text
from emovid.kit.exports.texts import Files
from emovid.kit.folder import Kit
from emovid.responses.responses import Responses

_KNOWN = {
    "participant_id": "the participant, as the survey names them",
    "video_code": "the video's random code; key.csv, published after the study, says what it stands for",
    "position": "the video's place in the participant's order, from 1",
    "choices": "the order of the answers on the participant's pages",
    "signalled": "the label that the video stands for",
    "response": "the label that the participant chose",
}
# The columns of the answers, here and in the data set.
_NAMES = {"participant": "participant_id", "video": "video_code", "position": "position", "signalled": "signalled",
          "perceived": "response"}  # fmt: skip


def psych_ds(kit: Kit, responses: Responses | None) -> Files:
    """Return the data set: the orders, and the answers if there are some."""
    manifest = kit.manifest
    name = "study-" + (re.sub(r"[^a-zA-Z0-9]", "", manifest.title.title()) or "emovid")
    header = ["participant_id", "position", "video_code", *(["choices"] if kit.choices else [])]
    orders = [
        [who, place, code, *(["|".join(kit.choices[who])] if kit.choices else [])]
        for who, order in kit.orders.items()
        for place, code in enumerate(order, start=1)
    ]
    files = {f"data/{name}_content-orders_data.csv": csv_text(header, orders)}
    columns = list(header)
    if responses is not None:
        header, answers = _answers(responses)
        files[f"data/{name}_content-responses_data.csv"] = csv_text(header, answers)
        columns += [column for column in header if column not in columns]
    description = {
        "@context": "http://schema.org/",
        "@type": "Dataset",
        "schemaVersion": "Psych-DS 1.4.0",
        "name": manifest.title,
        "description": f"{manifest.question} A study of {len(manifest.videos)} videos.",
        "author": list(manifest.authors),
        "keywords": ["human-robot interaction", "swarm robotics", "emotion", "forced choice"],
        "inLanguage": manifest.language,
        "variableMeasured": [_variable(column, kit) for column in columns],
    }
    return files | {
        "dataset_description.json": json.dumps(description, indent=2, ensure_ascii=False) + "\n",
        "materials/manifest.json": manifest.text(),
        "README.md": _readme(kit, responses is not None),
    }


def _answers(responses: Responses) -> tuple[list[str], list[tuple[object, ...]]]:
    """Return the columns and the rows of the answers, each participant's groups repeated in every row."""
    answers = responses.answers.rename(columns=_NAMES)[list(_NAMES.values())]
    groups = responses.participants.rename(columns=lambda name: f"{name} (group)" if name in _KNOWN else name)
    table = answers.merge(groups, left_on="participant_id", right_index=True, how="left")
    rows = table.astype(object).where(table.notna(), "").itertuples(index=False, name=None)
    return list(map(str, table.columns)), list(rows)


def _variable(column: str, kit: Kit) -> dict[str, object]:
    questions = {item.name: item for item in kit.manifest.demographics}
    variable: dict[str, object] = {"@type": "PropertyValue", "name": column}
    variable["description"] = _KNOWN.get(column) or getattr(questions.get(column), "question", column)
    if column in ("response", "signalled"):
        variable["levels"] = {answer.label: answer.text for answer in kit.manifest.choices.labels}
    if column in questions and questions[column].choices:
        variable["levels"] = list(questions[column].choices or ())
    if column == "position":
        variable |= {"minValue": 1, "maxValue": kit.manifest.videos_shown}
    return variable


def _readme(kit: Kit, has_answers: bool) -> str:
    answers = "the answers and " if has_answers else ""
    lines = [
        f"# {kit.manifest.title}",
        "",
        f"A data set by Psych-DS: {answers}the planned orders in `data/`, each column described in",
        "`dataset_description.json`; the texts that participants read in `materials/manifest.json`.",
        "",
    ]
    if not has_answers:
        lines += [
            "The answers are not in it yet: `emovid study export KIT --to psych-ds --responses EXPORT` adds them, with",
            "the emotion of each video, once the study is over.",
            "",
        ]
    return "\n".join(lines)
