"""A survey for LimeSurvey as a tab-separated structure file: one row per setting, group, question and answer."""

import csv
import io

from emovid.kit.exports.texts import Files, paragraphs, template, thanks, video_tag
from emovid.kit.folder import Kit
from emovid.kit.study import Question
from emovid.responses.labels import NONE

# Columns of the structure file: https://www.limesurvey.org/manual/Tab_Separated_Value_survey_structure
_COLUMNS = (
    "id", "related_id", "class", "type/scale", "name", "relevance", "text", "help", "language", "validation",
    "mandatory", "encrypted", "other", "default", "same_default", "random_group", "slider_min", "slider_max",
    "slider_accuracy", "slider_layout", "slider_separator",
)  # fmt: skip
Row = dict[str, object]


def limesurvey(kit: Kit, video_url: str) -> Files:
    """Return the structure file, with the videos at an address, and a README."""
    manifest = kit.manifest
    rows: list[Row] = [
        {"class": "S", "name": "language", "text": manifest.language},
        {"class": "S", "name": "format", "text": "G"},
        {"class": "S", "name": "allowprev", "text": "Y"},
        {"class": "SL", "name": "surveyls_title", "text": manifest.title},
        {"class": "SL", "name": "surveyls_endtext", "text": thanks(manifest)},
        {"class": "G", "name": "Consent"},
        *_choice("consent", paragraphs(manifest.consent.text), dict(zip("YN", _agreement(kit), strict=True))),
    ]
    agreed = 'consent.NAOK == "Y"'
    if manifest.demographics:
        rows.append({"class": "G", "name": manifest.texts.about_you, "relevance": agreed})
        rows += [row for item in manifest.demographics for row in _item(item)]
    rows += [
        {"class": "G", "name": "Instructions", "relevance": agreed},
        {"class": "Q", "type/scale": "X", "name": "instructions", "text": paragraphs(manifest.instructions)},
    ]
    for code in manifest.codes:
        rows.append({"class": "G", "name": code, "relevance": agreed, "random_group": "videos"})
        rows += _video(kit, code, video_url)
    codes = {answer_code(answer.label, i): answer.label for i, answer in enumerate(manifest.choices.labels, start=1)}
    return {
        "survey.txt": _table(rows, manifest.language),
        "map.yaml": manifest.map_yaml(codes),
        "README.md": template("limesurvey.md", title=manifest.title),
    }


def _table(rows: list[Row], language: str) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, _COLUMNS, delimiter="\t", lineterminator="\n", restval="")
    writer.writeheader()
    for number, row in enumerate(rows, start=1):
        writer.writerow({"id": number, "relevance": "1", "language": "" if row["class"] == "S" else language} | row)
    return "\ufeff" + text.getvalue()


def _agreement(kit: Kit) -> list[str]:
    return [kit.manifest.consent.agree, kit.manifest.consent.decline]


def _choice(name: str, text: str, answers: dict[str, str], mandatory: bool = True) -> list[Row]:
    needed = "Y" if mandatory else "N"
    question: Row = {"class": "Q", "type/scale": "L", "name": name, "text": text, "mandatory": needed}
    listed: list[Row] = [{"class": "A", "type/scale": 0, "name": code, "text": said} for code, said in answers.items()]
    return [question, *listed]


def _item(item: Question) -> list[Row]:
    name = item.name.replace("_", "")  # names consist of letters and digits
    if item.choices is None:
        needed = "Y" if item.required else "N"
        return [{"class": "Q", "type/scale": "S", "name": name, "text": item.question, "mandatory": needed}]
    answers = {f"A{i}": choice for i, choice in enumerate(item.choices, start=1)}
    return _choice(name, item.question, answers, item.required)


def _video(kit: Kit, code: str, video_url: str) -> list[Row]:
    manifest = kit.manifest
    answers = {answer_code(label.label, i): label.text for i, label in enumerate(manifest.choices.labels, start=1)}
    rows = _choice(code, f"{video_tag(code, video_url)}{paragraphs(manifest.question)}", answers)
    for rating in manifest.ratings:
        slider = {"slider_min": 1, "slider_max": rating.steps, "slider_accuracy": 1}
        ends = {"slider_layout": 1, "slider_separator": "|"}
        question = {"class": "Q", "type/scale": "K", "name": f"{code}{rating.name}", "text": rating.question}
        rows += [question | {"mandatory": "Y"} | slider | ends]
        rows += [{"class": "SQ", "name": "SQ1", "text": f"|{rating.low}|{rating.high}"}]
    return rows


def answer_code(label: str, number: int) -> str:
    """Return the code of an answer, of at most five characters."""
    return "AN" if label == NONE else f"A{number}"
