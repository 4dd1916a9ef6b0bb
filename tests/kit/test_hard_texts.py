"""Exports with texts in any script, one video and twenty, and the longest consent text."""

import html
import json
import re
from pathlib import Path

import pytest

from emovid.kit.checks.findings import Hints
from emovid.kit.checks.texts import check_pages
from emovid.kit.export import TOOLS, export
from emovid.kit.folder import Kit
from emovid.responses.mapping import read_mapping
from emovid.responses.read import read_responses
from tests.helpers.limesurvey import answers_text, rows_of, seen
from tests.helpers.tiny import STUDY, make_kit_of_placeholders

TEXTS = {
    "happiness": 'Freude 😀, "Glück"',
    "surprise": "مفاجأة, نعم; لا",
    "anger": "כעס 'כן' {לא}",
    "fear": "<b>恐怖</b> & $1 [2] | \\",
    "disgust": "Ekel\u200d 👩\u200d🔬 ${e://x}",
    "sadness": "`Traurig` #1 %s $x $$",
}
LONG = ("Sie können „aufhören“, 'wann' {Sie} wollen: <jederzeit> & überall \\o/. " * 400)[:20_000].strip()


def study(videos: int) -> str:
    names = list(TEXTS)
    scenes = [names[i % 6] for i in range(videos)]
    keys = {
        "title": 'Über "Roboter" <&> {x}',
        "question": 'Was? "Ja" {nein} | \\ $x',
        "labels": TEXTS,
        "stimuli": [{"scene": name} for name in scenes],
        "demographics": [{"name": "a_1", "question": "<Wie> {viele}?", "choices": ['"1"', "2 & {3}"]}],
        "consent": {"text": LONG, "version": "1"},
        "instructions": "$x ${y} {z}\n\nZweiter Absatz.",
        "thanks": {"text": "Danke {Ihnen} $!", "code": "$C0DE{1}"},
    }
    kept = [line for line in STUDY.splitlines() if line.partition(":")[0] in ("set", "video")]
    return "\n".join([*(f"{name}: {json.dumps(value, ensure_ascii=False)}" for name, value in keys.items()), *kept, ""])


@pytest.fixture(scope="module", params=[1, 20], ids=["one-video", "twenty-videos"])
def kit(request, tmp_path_factory) -> Kit:
    made = make_kit_of_placeholders(tmp_path_factory.mktemp("hard"), study(request.param))
    for tool in TOOLS:
        export(made, tool, video_url="https://example.org/v")
    return made


def exported(kit: Kit, tool: str, name: str) -> Path:
    return kit.folder.exports / tool / name


def test_pages_never_show_an_emotion_next_to_a_code(kit) -> None:
    assert [str(finding) for finding in check_pages(kit, Hints(kit))] == []


def test_limesurvey_shows_texts_as_written(kit) -> None:
    rows = rows_of(exported(kit, "limesurvey", "survey.txt").read_text(encoding="utf-8"))
    asked = {row["name"]: row for row in rows if row["class"] == "Q"}
    assert seen(asked["consent"]["text"]) == [" ".join(LONG.split())]
    assert seen(asked["aU1"]["text"]) == ["<Wie> {viele}?"]
    for code in kit.manifest.codes:
        assert seen(asked[code]["text"]) == [kit.manifest.question]
    answers = [seen(row["text"]) for row in rows if row["class"] == "A" and row["name"].startswith("A")]
    assert answers[:2] == [['"1"'], ["2 & {3}"]]
    assert answers[2:] == [[text] for text in TEXTS.values()] * len(kit.manifest.codes)


def test_qualtrics_shows_texts_as_written(kit) -> None:
    survey = exported(kit, "qualtrics", "survey.txt").read_text(encoding="utf-8")
    for code in kit.manifest.codes:
        (part,) = re.findall(rf"\[\[ID:{code}\]\]\n.*\n\[\[Choices\]\]\n((?:.+\n)*)", survey)
        assert [html.unescape(line) for line in part.splitlines()] == list(TEXTS.values())
    assert "${" not in survey
    tags = set(re.findall(r"\[\[(\w+)", survey))
    assert tags == {"AdvancedFormat", "Block", "Question", "ID", "Choices", "PageBreak"}


def test_jspsych_has_texts_as_written(kit) -> None:
    page = exported(kit, "jspsych", "index.html").read_text(encoding="utf-8")
    data = json.loads(re.search(r'id="kit">(.*?)</script>', page, re.DOTALL)[1])
    assert {one["label"]: one["text"] for one in data["choices"]["labels"]} == TEXTS
    assert data["consent"]["text"] == LONG
    assert data["thanks"]["code"] == "$C0DE{1}"


def test_psychopy_readme_has_texts_as_written(kit) -> None:
    readme = exported(kit, "psychopy", "README.md").read_text(encoding="utf-8")
    for words in (*TEXTS.values(), LONG, "<Wie> {viele}?", "$C0DE{1}"):
        assert words in readme


@pytest.mark.parametrize("tool", ["limesurvey", "qualtrics"])
def test_maps_contain_every_answer_text(kit, tool) -> None:
    said = read_mapping(exported(kit, tool, "map.yaml"))
    assert {text: said.answers[text] for text in TEXTS.values()} == {text: label for label, text in TEXTS.items()}


@pytest.mark.parametrize("headings", ["code", "full", "codetext"])
def test_full_answers_of_limesurvey_are_read(kit, tmp_path, headings) -> None:
    rows = rows_of(exported(kit, "limesurvey", "survey.txt").read_text(encoding="utf-8"))
    codes = kit.manifest.codes
    people = [
        {"consent": "Y", "aU1": "A1"} | {code: f"A{(i + k) % 6 + 1}" for k, code in enumerate(codes)} for i in range(6)
    ]
    source = tmp_path / "export.csv"
    source.write_text(answers_text(rows, people, headings, full=True), encoding="utf-8")
    found = read_responses(source, key=kit.folder.key, mapping=exported(kit, "limesurvey", "map.yaml"))
    labels = list(TEXTS)
    expected = {(code, labels[int(person[code][1:]) - 1]) for person in people for code in codes}
    assert set(zip(found.answers["video"], found.answers["perceived"], strict=True)) == expected
    assert len(found.answers) == 6 * len(codes)
    assert set(found.participants["a_1"]) == {'"1"'}
