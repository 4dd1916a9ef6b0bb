"""The survey for LimeSurvey, as read by its importer: texts and design."""

import json
import re
from pathlib import Path

import pytest

from emovid.errors import InputError
from emovid.kit.audit import sets_of
from emovid.kit.export import check_export, export
from emovid.kit.exports.design import Status
from emovid.kit.exports.limesurvey import language_code
from emovid.kit.folder import Kit
from tests.helpers.limesurvey import heading, links, rows_of, seen
from tests.helpers.tiny import STUDY, make_kit_of_placeholders

STUDIES = Path(__file__).parent / "studies"
ADDRESS = "https://example.org/videos"


def kit_of(name: str, folder: Path) -> Kit:
    return make_kit_of_placeholders(folder, (STUDIES / f"{name}.yaml").read_text())


@pytest.fixture(scope="module", params=["german", "special_characters", "one_of_each"])
def any_kit(request, tmp_path_factory) -> Kit:
    return kit_of(request.param, tmp_path_factory.mktemp(request.param))


@pytest.fixture(scope="module")
def german(tmp_path_factory) -> Kit:
    return kit_of("german", tmp_path_factory.mktemp("german"))


@pytest.fixture(scope="module")
def sets(tmp_path_factory) -> Kit:
    return kit_of("one_of_each", tmp_path_factory.mktemp("sets"))


def survey(kit: Kit) -> list[dict[str, str]]:
    export(kit, "limesurvey", video_url=ADDRESS)
    return rows_of((kit.folder.exports / "limesurvey" / "survey.txt").read_text(encoding="utf-8"))


def questions(rows: list[dict[str, str]]) -> dict[str, dict[str, str]]:
    return {row["name"]: row for row in rows if row["class"] == "Q"}


def answers(rows: list[dict[str, str]], question: str) -> dict[str, str]:
    """Return the answers of a question, by code and displayed text."""
    found: dict[str, str] = {}
    place = next(i for i, row in enumerate(rows) if row["class"] == "Q" and row["name"] == question)
    for row in rows[place + 1 :]:
        if row["class"] != "A":
            break
        (found[row["name"]],) = seen(row["text"])
    return found


def paragraphs(text: str) -> list[str]:
    return [" ".join(part.split()) for part in re.split(r"\n\s*\n", text.strip())]


def endings(rows: list[dict[str, str]]) -> tuple[str, str]:
    """Return the last pages with and without consent."""
    (end,) = (row["text"] for row in rows if row["name"] == "surveyls_endtext")
    found = re.fullmatch(r"\{if\(consent\.NAOK == 'Y', '([^'{}]*)', '([^'{}]*)'\)\}", end)
    assert found
    return found[1], found[2]


def test_texts_are_shown_as_written(any_kit) -> None:
    rows, manifest = survey(any_kit), any_kit.manifest
    asked = questions(rows)
    assert seen(asked["consent"]["text"]) == paragraphs(manifest.consent.text)
    assert list(answers(rows, "consent").values()) == [manifest.consent.agree, manifest.consent.decline]
    assert seen(asked["instructions"]["text"]) == paragraphs(manifest.instructions)
    for item in manifest.demographics:
        name = item.name.replace("_", "U")
        assert seen(asked[name]["text"]) == [item.question]
        if item.choices:
            assert tuple(answers(rows, name).values()) == item.choices
    for code in manifest.codes:
        assert seen(asked[code]["text"]) == [manifest.question]
        assert list(answers(rows, code).values()) == [choice.text for choice in manifest.choices.labels]
        assert links(asked[code]["text"]) == [f"{ADDRESS}/{code}.mp4"]
    (title,) = (row["text"] for row in rows if row["name"] == "surveyls_title")
    assert seen(title) == [manifest.title]


def test_texts_are_never_evaluated_as_expressions(any_kit) -> None:
    for row in survey(any_kit):
        allowed = row["name"] in ("surveyls_endtext", "videoset")
        assert allowed or not set("{}") & set(row["text"]), row


def test_question_names_are_valid_in_limesurvey(any_kit) -> None:
    rows = survey(any_kit)
    names = [row["name"] for row in rows if row["class"] == "Q"]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9]{0,19}", name) for name in names)
    assert all(len(row["name"]) <= 5 for row in rows if row["class"] == "A")


def test_names_that_differ_only_in_an_underscore_stay_distinct(tmp_path) -> None:
    about = "\n".join(f'  - {{name: {name}, question: "Which {name}?"}}' for name in ("age_1", "age1", "a_ge1"))
    text = re.sub(r"demographics:\n.*\n", f"demographics:\n{about}\n", STUDY)
    asked = questions(survey(make_kit_of_placeholders(tmp_path, text)))
    assert [seen(asked[name]["text"]) for name in ("ageU1", "age1", "aUge1")] == [
        ["Which age_1?"], ["Which age1?"], ["Which a_ge1?"]
    ]  # fmt: skip


def test_completion_code_and_return_link_are_shown_only_after_consent(german) -> None:
    agreed, declined = endings(survey(german))
    assert seen(agreed) == ["Danke!", "Ihr Abschlusscode: ABC123", "Zurück zum Rekrutierungsdienst"]
    assert links(agreed) == ["https://example.org/back?cc=1&x=2"]
    assert seen(declined) == ["Sie nehmen nicht teil."]
    assert links(declined) == []


def test_long_consent_text_and_special_characters_are_preserved(tmp_path) -> None:
    long = "Ein Satz mit \"Anführung\", 'Apostroph', {Klammer} und \\ Strich. " * 300
    text = STUDY.replace("You can stop at any time.", json.dumps(long[:20_000].strip()))
    last = {"text": "It's {done}, he said\\", "code": "'{x}'|\\"}
    text = text.replace("{text: Thank you.}", json.dumps(last))
    kit = make_kit_of_placeholders(tmp_path, text)
    rows = survey(kit)
    assert seen(questions(rows)["consent"]["text"]) == paragraphs(kit.manifest.consent.text)
    agreed, _ = endings(rows)
    assert seen(agreed) == ["It's {done}, he said\\", "Your completion code: '{x}'|\\"]


def test_survey_in_another_language_has_no_english_headings(german) -> None:
    settings = {row["name"]: row["text"] for row in survey(german) if row["class"] == "S"}
    assert settings["showgroupinfo"] == "X"
    assert settings["language"] == "de"


@pytest.mark.parametrize(
    ("language", "code"),
    [
        ("en", "en"), ("de-AT", "de"), ("pt-br", "pt-BR"), ("es-MX", "es-MX"), ("no", "nb"), ("sw", "swh"),
        ("zh", "zh-Hans"), ("zh-CN", "zh-Hans"), ("zh-TW", "zh-Hant-TW"), ("zh-Hant", "zh-Hant-TW"), ("eo", None),
    ],
)  # fmt: skip
def test_languages_have_their_codes_in_limesurvey(language, code) -> None:
    assert language_code(language) == code


@pytest.mark.parametrize(
    ("language", "code", "status"), [("zh", "zh-Hans", Status.CHANGED), ("eo", "en", Status.BY_HAND)]
)
def test_language_without_the_same_code_is_imported_and_listed(tmp_path, language, code, status) -> None:
    kit = make_kit_of_placeholders(tmp_path, f"language: {language}\n{STUDY}")
    rows = survey(kit)
    assert [row["text"] for row in rows if (row["class"], row["name"]) == ("S", "language")] == [code]
    assert {row["language"] for row in rows if row["class"] != "S"} == {code}
    (part,) = (part for part in check_export(kit, "limesurvey") if part.name == "language")
    assert part.support.status is status


@pytest.mark.parametrize("name", ["this", "self", "that", "practice", "videoset"])
def test_names_that_limesurvey_or_the_reader_reserve_are_refused(tmp_path, name) -> None:
    about = f'demographics:\n  - {{name: {name}, question: "How much?"}}\n'
    kit = make_kit_of_placeholders(tmp_path, re.sub(r"demographics:\n.*\n", about, STUDY))
    with pytest.raises(InputError, match=f"{name} is a reserved name"):
        survey(kit)


def test_answers_in_random_order_are_random(german, sets) -> None:
    orders = {name: row["answer_order"] for name, row in questions(survey(german)).items()}
    assert {name for name, order in orders.items() if order} == set(german.manifest.codes)
    assert set(orders.values()) == {"", "random"}
    assert {row["answer_order"] for row in survey(sets)} == {""}


def test_ratings_are_sliders_with_their_own_steps_and_ends(german) -> None:
    rows = survey(german)
    code = german.manifest.codes[0]
    for rating in german.manifest.ratings:
        place = next(i for i, row in enumerate(rows) if row["name"] == f"{code}{rating.name}")
        question, ends = rows[place : place + 2]
        assert (question["type/scale"], question["slider_min"], question["slider_max"]) == ("K", "1", str(rating.steps))
        assert [seen(part) for part in ends["text"].split("|")] == [[], [rating.low], [rating.high]]


def test_each_participant_sees_one_set_of_the_orders(sets) -> None:
    rows = survey(sets)
    groups = [row for row in rows if row["class"] == "G" and row["random_group"] == "videos"]
    assert [row["name"] for row in groups] == sets.manifest.codes
    draw = questions(rows)["videoset"]
    assert (draw["type/scale"], draw["hidden"]) == ("*", "1")
    assert draw["text"] == "{if(is_empty(videoset.NAOK), rand(1, 4), videoset.NAOK)}"
    shown = {
        tuple(row["name"] for row in groups if f"videoset.NAOK == {drawn}" in row["relevance"]) for drawn in range(1, 5)
    }
    assert shown == set(sets_of(sets.orders.values()))
    for codes in shown:
        assert sorted(sets.key[code] for code in codes) == ["anger", "happiness", "sadness"]
    assert all(row["relevance"].startswith("consent.NAOK == 'Y' and (") for row in groups)


def test_question_texts_start_with_the_question_name(german) -> None:
    for name, row in questions(survey(german)).items():
        wanted = name if "confidence" not in name else f"{name[:6]}_confidence"
        if "valence" in name or "arousal" in name:
            wanted = f"{name[:6]}_{name[6:]}"
        assert heading(row["text"]).startswith(f"{wanted.replace('U', '_')}: ")


def test_parts_that_limesurvey_changes_are_listed(german, sets) -> None:
    found = {part.name: part.support.status for part in check_export(german, "limesurvey")}
    assert {name for name, status in found.items() if status is Status.CHANGED} == {
        "orders", "choices", "changing earlier answers"
    }  # fmt: skip
    assert found["watching to the end"] is Status.BY_HAND
    assert found["ratings"] is found["declining"] is found["completion code"] is Status.CARRIED
    assert "sets of videos" not in found
    (part,) = (part for part in check_export(sets, "limesurvey") if part.name == "sets of videos")
    assert (part.value, part.support.status) == ("4, one for each participant, 3 videos each", Status.CHANGED)
    readme = (sets.folder.exports / "limesurvey" / "README.md").read_text()
    assert "- **sets of videos** (4, one for each participant, 3 videos each): carried differently." in readme


def test_duplicate_question_names_are_refused(tmp_path) -> None:
    kit = make_kit_of_placeholders(tmp_path)
    text = STUDY.replace("name: gender", f"name: {kit.manifest.codes[0]}")
    kit = make_kit_of_placeholders(tmp_path / "again", text)
    with pytest.raises(InputError, match=f"two questions would be called {kit.manifest.codes[0]}"):
        export(kit, "limesurvey")
