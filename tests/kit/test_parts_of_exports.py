"""Practice, attention checks, questions after the videos, recruitment: exported, listed or refused."""

import re

import pytest

from emovid.cli.main import main
from emovid.errors import InputError
from emovid.kit.export import check_export, export
from emovid.kit.exports.design import Status
from emovid.kit.folder import Kit
from tests.helpers.limesurvey import rows_of, seen
from tests.helpers.tiny import STUDY, make_kit_of_placeholders

FURTHER = """\
practice: {scene: fear}
checks:
  - {name: shape, scene: sadness, question: "Which <shape>?", choices: [Circle, Star], answer: Star, after: 2}
  - {name: last_one, scene: anger, question: Which one?, choices: [A, B, C], answer: C, after: 6}
questions_after:
  - {name: comments, question: Any comments?, long: true, required: false}
  - {name: hobbies, question: Which hobbies?, choices: [Chess, Go, "Bridge {4}"], several: true}
  - {name: years, question: How many years?, number: {low: 0, high: 99}}
debriefing: "The {purpose} of the study."
requirements: {text: Please use a computer., devices: [desktop]}
recruitment: {service: prolific}
"""
FURTHER = FURTHER.replace("Which one?", '"Which one?"').replace("Any comments?", '"Any comments?"')
FURTHER = FURTHER.replace("Which hobbies?", '"Which hobbies?"').replace("How many years?", '"How many years?"')
FURTHER_RETURNS = FURTHER.replace(
    "{service: prolific}", "{service: prolific, declined: {code: N0C0NSENT}, failed: {code: FA1LED}}"
)
PARTS = {"practice video", "attention checks", "questions after the videos", "debriefing", "devices and browsers",
         "recruitment parameters", "codes for declining or failing"}  # fmt: skip


@pytest.fixture(scope="module")
def kit(tmp_path_factory) -> Kit:
    return make_kit_of_placeholders(tmp_path_factory.mktemp("parts"), STUDY + FURTHER)


@pytest.fixture(scope="module")
def returns(tmp_path_factory) -> Kit:
    text = STUDY.replace("{text: Thank you.}", "{text: Thank you., code: D0NE}") + FURTHER_RETURNS
    return make_kit_of_placeholders(tmp_path_factory.mktemp("returns"), text)


def text_of(kit: Kit, tool: str, name: str) -> str:
    export(kit, tool, video_url="https://example.org/v", force=True)
    return (kit.folder.exports / tool / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("tool", ["jspsych", "psychopy", "qualtrics", "limesurvey"])
def test_every_part_is_listed_for_every_tool(returns, tool) -> None:
    parts = {part.name: part for part in check_export(returns, tool)}
    assert set(parts) >= PARTS
    assert all(part.support.note for part in parts.values() if part.support.status is not Status.CARRIED)


@pytest.mark.parametrize("tool", ["jspsych", "psychopy", "qualtrics", "limesurvey"])
def test_all_videos_are_copied(kit, tool) -> None:
    export(kit, tool, force=True)
    names = {path.stem for path in (kit.folder.exports / tool / "videos").iterdir()}
    assert names == set(kit.manifest.all_videos)
    assert len(names) == 9


def test_further_languages_are_reported_if_not_exported(tmp_path) -> None:
    labels = "{happiness: Freude, surprise: Staunen, anger: Wut, fear: Angst, disgust: Ekel, sadness: Trauer}"
    german = f"""translations:
  de:
    title: Kleine Roboter
    question: Welche Emotion?
    labels: {labels}
    questions: {{gender: {{question: Geschlecht, choices: [Frau, Mann, Anderes]}}}}
    consent: Sie können aufhören.
    instructions: Sehen Sie alles an.
    thanks: Danke.
"""
    kit = make_kit_of_placeholders(tmp_path, STUDY + german)
    for tool in ("psychopy", "qualtrics", "limesurvey"):
        (part,) = (part for part in check_export(kit, tool) if part.name == "further languages")
        assert (part.value, part.support.status) == ("de", Status.BY_HAND)
    with pytest.raises(InputError, match=r"further languages \(de\): The page has one language"):
        export(kit, "jspsych")


def test_limesurvey_has_all_parts_in_order(kit) -> None:
    rows = rows_of(text_of(kit, "limesurvey", "survey.txt"))
    groups = [row["name"] if row["name"] not in kit.manifest.codes else "video" for row in rows if row["class"] == "G"]
    assert groups == ["Consent", "About you", "Instructions", "Practice", "video", "video", "Check", *4 * ["video"],
                      "Check", "Last questions"]  # fmt: skip
    random = {row["name"] for row in rows if row["class"] == "G" and row["random_group"]}
    assert random == set(kit.manifest.codes)
    asked = {row["name"]: row for row in rows if row["class"] == "Q"}
    assert seen(asked["shape"]["text"]) == ["Which <shape>?"]
    assert {name: asked[name]["type/scale"] for name in ("comments", "hobbies", "years", "shape", "lastUone")} == {
        "comments": "T", "hobbies": "M", "years": "N", "shape": "L", "lastUone": "L"
    }  # fmt: skip
    assert (asked["years"]["min_num_value_n"], asked["years"]["max_num_value_n"]) == ("0", "99")
    assert [asked[name]["mandatory"] for name in ("comments", "hobbies", "years")] == ["N", "Y", "Y"]
    place = rows.index(asked["hobbies"])
    assert [seen(row["text"]) for row in rows[place + 1 : place + 4]] == [["Chess"], ["Go"], ["Bridge {4}"]]
    assert seen(asked["consent"]["text"])[0] == "Please use a computer."
    (end,) = (row["text"] for row in rows if row["name"] == "surveyls_endtext")
    assert "&#123;purpose&#125;" in end


def test_limesurvey_has_a_completion_code_for_each_outcome(returns) -> None:
    rows = rows_of(text_of(returns, "limesurvey", "survey.txt"))
    (end,) = (row["text"] for row in rows if row["name"] == "surveyls_endtext")
    found = re.fullmatch(
        r"\{if\(consent\.NAOK == 'Y', if\(shape\.NAOK == 'A2' and lastUone\.NAOK == 'A3', '([^']*)', '([^']*)'\), "
        r"'([^']*)'\)\}",
        end,
    )
    assert found
    codes = [re.findall("D0NE|FA1LED|N0C0NSENT", text) for text in found.groups()]
    assert codes == [["D0NE"], ["FA1LED"], ["N0C0NSENT"]]


def test_qualtrics_has_blocks_for_all_parts(kit) -> None:
    survey = text_of(kit, "qualtrics", "survey.txt")
    blocks = re.findall(r"^\[\[Block:(.*)\]\]$", survey, re.MULTILINE)
    assert blocks == ["Consent", "About you", "Instructions", "Practice", *kit.manifest.codes, "Check shape",
                      "Check last_one", "Last questions", "End"]  # fmt: skip
    assert "[[Question:MC:MultipleAnswer:Vertical]]\n[[ID:hobbies]]" in survey
    assert "[[Question:TE:Essay]]\n[[ID:comments]]" in survey
    assert "How many years? (0 to 99)" in survey
    readme = (kit.folder.exports / "qualtrics" / "README.md").read_text()
    assert "shape after 2 videos, last_one after 6 videos" in readme
    assert "PROLIFIC_PID, STUDY_ID, SESSION_ID" in readme


def test_psychopy_readme_has_all_texts(kit) -> None:
    readme = text_of(kit, "psychopy", "README.md")
    for words in ("Which <shape>?", "Any comments?", "The {purpose} of the study.", "Please use a computer."):
        assert words in readme
    for check in kit.manifest.checks:
        assert f"videos/{check.video.code}.mp4, after {check.after} videos" in readme


def test_export_without_a_server_refuses_secret_completion_codes(returns, capsys) -> None:
    with pytest.raises(InputError, match="--to jspsych: cannot carry the design: codes for declining or failing"):
        export(returns, "jspsych")
    assert not (returns.folder.exports / "jspsych").exists()
    assert main(["study", "export", str(returns.folder.path), "--to", "jspsych", "--check"]) == 1
    assert "cannot keep them secret" in capsys.readouterr().out
    assert main(["study", "export", str(returns.folder.path), "--to", "limesurvey", "--check"]) == 0
    assert main(["study", "export", str(returns.folder.path), "--to", "prereg", "--check"]) == 2
    assert "--check: prereg runs no survey" in capsys.readouterr().err
