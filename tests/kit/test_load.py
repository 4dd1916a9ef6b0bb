import re
from pathlib import Path

import pytest
import yaml
from pydantic import BaseModel

from emovid.errors import EmovidError
from emovid.kit.load import load_study
from emovid.kit.study import Study
from emovid.kit.texts import Texts
from emovid.yaml_source import read_yaml
from tests.helpers.tiny import STUDY, write_study

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "studies" / "example"
BROKEN = sorted((ROOT / "studies" / "errors").glob("*.yaml"))


def changed(*pairs: tuple[str, str]) -> str:
    text = STUDY
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


def test_examples_of_invalid_studies_exist() -> None:
    assert len(BROKEN) >= 45


@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.stem)
def test_invalid_study_gives_one_line_with_file_and_line(path, monkeypatch) -> None:
    monkeypatch.chdir(ROOT)
    expected = path.read_text().splitlines()[0].removeprefix("# expected: ")
    assert expected.startswith(f"studies/errors/{path.name}:")
    with pytest.raises(EmovidError) as caught:
        load_study(path.relative_to(ROOT))
    assert str(caught.value) == expected
    assert caught.value.exit_code == 2


def test_example_study_follows_the_procedure_of_the_paper() -> None:
    loaded = load_study(EXAMPLE)
    study = loaded.study
    assert [item.emotion for item in loaded.exemplars] == list(study.labels)
    assert sorted(study.labels) == ["anger", "disgust", "fear", "happiness", "sadness", "surprise"]
    assert (study.video.size, study.video.fps, study.video.duration) == ("1280x720", 30, 15)
    assert "best described the movement of the robots in the video" in study.question
    items = {item.name: item for item in study.demographics}
    assert set(items) == {"age", "gender", "robotics_background"}
    assert set(items["age"].choices) >= {"18-24", "25-34", "35-44", "45-54"}
    assert len(items["gender"].choices) > 3
    assert "Prefer not to say" in items["gender"].choices
    assert not any(label in study.title.casefold() for label in study.labels)


def keys_of(model: type[BaseModel], at: str = "") -> set[str]:
    """Return the dotted keys of a model, without list items."""
    found = set()
    for name, field in model.model_fields.items():
        found.add(at + name)
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            found |= keys_of(field.annotation, f"{at}{name}.")
    return found


def test_example_study_comments_every_key() -> None:
    text = (EXAMPLE / "study.yaml").read_text()
    _, places = read_yaml(text, "study.yaml")
    given = {".".join(map(str, path)) for path in places}
    texts = {key for key in keys_of(Study) if key.startswith("texts.")}
    assert keys_of(Study) - texts <= given
    commented = "\n".join(line[4:] for line in text.splitlines() if line.startswith("#   "))
    words = {name: field.default for name, field in Texts.model_fields.items()}
    assert yaml.safe_load(commented[commented.index("next: Continue") :]) == words  # of the language en
    repeated = {"stimuli.0.scene", "demographics.0.name", "demographics.0.question", "demographics.0.choices"}
    assert repeated | {"demographics.0.required"} <= given
    for key in ("video:", "emotion:", "set:", "steps:", "choices: null"):  # of keys that exist in another form
        assert re.search(rf"^ *# .*{key}", text, re.MULTILINE)


def test_defaults_equal_the_values_of_the_example() -> None:
    study = load_study(EXAMPLE).study
    for group in ("texts", "vary", "video", "orders", "plan", "ratings", "ethics"):
        assert getattr(study, group) == type(getattr(study, group))()


def test_a_folder_and_its_file_are_the_same_study(tmp_path) -> None:
    folder = write_study(tmp_path)
    assert load_study(folder).digest() == load_study(folder / "study.yaml").digest()


def test_digest_depends_on_texts_scenes_and_settings_only(tmp_path) -> None:
    def digest(name: str, *pairs: tuple[str, str]) -> str:
        return load_study(write_study(tmp_path / name, changed(*pairs))).digest()

    first = digest("a")
    assert digest("b", ("title:", "# a comment\nparticipants: 9\ntitle:")) == first
    assert digest("c", ("Thank you.", "Thanks.")) != first
    assert digest("d", ("robots: 6", "robots: 7")) != first
    assert digest("e", ("scene: anger", "scene: fear\n    emotion: anger")) != first


def test_scene_path_is_relative_to_the_study(tmp_path, monkeypatch) -> None:
    scene = (ROOT / "configs" / "fear.yaml").read_text()
    folder = write_study(tmp_path / "study", changed(("scene: fear", "scene: scenes/mine.yaml")))
    (folder / "scenes").mkdir()
    (folder / "scenes" / "mine.yaml").write_text(scene)
    monkeypatch.chdir(tmp_path)
    (item,) = (item for item in load_study(Path("study")).exemplars if item.source == "mine")
    assert item.emotion == "fear"
    assert item.scene.robots == 6


def test_a_custom_scene_may_have_snapshots_after_the_end_of_the_stimuli(tmp_path) -> None:
    folder = write_study(tmp_path, changed(("scene: fear", "scene: mine.yaml")))
    text = (ROOT / "configs" / "fear.yaml").read_text()
    assert "\nsnapshots: null" in text
    (folder / "mine.yaml").write_text(text.replace("\nsnapshots: null", "\nsnapshots: [0, 7]"))
    (item,) = (item for item in load_study(folder).exemplars if item.source == "mine")
    assert (item.scene.duration, item.scene.snapshots) == (1, (0, 1))


def test_view_can_be_a_factor(tmp_path) -> None:
    factors = (
        "factors:\n  view:\n    above: {video.view: overhead}\n    side: {video.view: perspective}\nset: {robots: 6}"
    )
    items = load_study(write_study(tmp_path, changed(("set: {robots: 6}", factors)))).exemplars
    assert {(item.factors["view"], item.scene.video.view) for item in items} == {
        ("above", "overhead"),
        ("side", "perspective"),
    }
    assert len(items) == 12


def test_exemplars_and_factors_multiply_the_scenes(tmp_path) -> None:
    factors = "factors:\n  swarm:\n    few: {robots: 4}\n    many: {robots: 8}\nexemplars: 3\nset: {}"
    loaded = load_study(write_study(tmp_path, changed(("set: {robots: 6}", factors))))
    assert len(loaded.exemplars) == 6 * 2 * 3
    fear = [item for item in loaded.exemplars if item.emotion == "fear"]
    assert [(item.factors["swarm"], item.scene.robots, item.number) for item in fear] == [
        *(("few", 4, i) for i in range(3)),
        *(("many", 8, i) for i in range(3)),
    ]


def test_stimulus_settings_override_level_and_study_settings(tmp_path) -> None:
    factors = "factors:\n  swarm:\n    few: {robots: 4, seed: 5}\n    many: {robots: 8}\nset: {robots: 6, seed: 6}"
    text = changed(("set: {robots: 6}", factors), ("scene: fear", "scene: fear\n    set: {robots: 3}"))
    items = {(i.emotion, i.factors["swarm"]): i.scene for i in load_study(write_study(tmp_path, text)).exemplars}
    assert (items["fear", "few"].robots, items["anger", "few"].robots) == (3, 4)
    assert (items["anger", "few"].seed, items["anger", "many"].seed) == (5, 6)


@pytest.mark.parametrize(("said", "found"), [("null", "has no emotion"), ("anger", "'anger' is not a label")])
def test_scene_without_a_label_gives_a_message_with_a_remedy(tmp_path, said, found) -> None:
    text = (ROOT / "configs" / "anger.yaml").read_text()
    assert text.count("\nemotion: anger") == 1
    labels = ("anger: Anger", "curiosity: Curiosity")
    folder = write_study(tmp_path, changed(labels, ("scene: anger", "scene: mine.yaml")))
    (folder / "mine.yaml").write_text(text.replace("\nemotion: anger", f"\nemotion: {said}"))
    with pytest.raises(EmovidError) as caught:
        load_study(folder)
    expected = "expected an additional emotion, one of happiness, surprise, curiosity, fear, disgust, sadness"
    assert str(caught.value) == f"{folder / 'study.yaml'}:7: stimuli.2.scene: {found}; {expected}"
    write_study(tmp_path, changed(labels, ("scene: anger", "scene: mine.yaml\n    emotion: curiosity")))
    assert [item.emotion for item in load_study(folder).exemplars][2] == "curiosity"


@pytest.mark.parametrize(
    ("name", "why"),
    [("participant_id", "is a column of the data"), ("consent", "is a page of the survey"),
     ("end", "is a page of the survey")],
)  # fmt: skip
def test_reserved_question_names_are_refused(tmp_path, name, why) -> None:
    with pytest.raises(EmovidError, match=f"study.yaml:14: demographics.0.name: '{name}' {why}: expected another name"):
        load_study(write_study(tmp_path, changed(("name: gender", f"name: {name}"))))


def test_answers_may_be_emoji(tmp_path) -> None:
    texts = {"Happiness": "😀", "Anger": "😠"}
    study = load_study(write_study(tmp_path, changed(*((f": {old}", f": {new}") for old, new in texts.items())))).study
    assert (study.answers["happiness"], study.answers["anger"]) == ("😀", "😠")
    with pytest.raises(EmovidError, match="'😀' occurs twice"):
        load_study(write_study(tmp_path, changed((": Happiness", ": 😀"), (": Anger", ": 😀"))))


@pytest.mark.parametrize(("key", "value"), [("speed", "2"), ("begin", "0.5"), ("end", "0.5")])
def test_stimulus_shows_its_complete_run(tmp_path, key, value) -> None:
    text = changed(("set: {robots: 6}", f"set: {{robots: 6, video.{key}: {value}}}"))
    with pytest.raises(EmovidError, match=rf"video\.{key}: {value}: a stimulus shows its whole run, at"):
        load_study(write_study(tmp_path, text))


def test_external_video_refuses_scene_keys(tmp_path) -> None:
    text = changed(("scene: anger", "video: mine.mp4\n    emotion: anger\n    set: {robots: 3}"))
    with pytest.raises(EmovidError, match=r"stimuli\.2\.set: a finished video has no keys to set"):
        load_study(write_study(tmp_path, text))


def test_too_large_study_file_is_refused(tmp_path) -> None:
    (tmp_path / "study.yaml").write_text("# " + 2_000_000 * "x" + "\n")
    with pytest.raises(EmovidError, match=r"study\.yaml: too large for a study"):
        load_study(tmp_path)


def test_a_label_of_two_lines_is_refused(tmp_path) -> None:
    text = changed(("{happiness: Happiness", '{"happi\\nness": Happiness'), ("scene: happiness", "scene: fear"))
    with pytest.raises(EmovidError, match=r"study.yaml:3: labels: 'happi\\nness': expected one line without"):
        load_study(write_study(tmp_path, text))


def test_binary_file_is_refused(tmp_path) -> None:
    (tmp_path / "study.yaml").write_bytes(b"title: \xff\xfe")
    with pytest.raises(EmovidError, match=r"study.yaml:1: not UTF-8 text"):
        load_study(tmp_path)
    with pytest.raises(EmovidError, match="cannot be read: no such file"):
        load_study(tmp_path / "nowhere")


def test_commented_translation_of_the_example_is_yaml_once_uncommented() -> None:
    text = (EXAMPLE / "study.yaml").read_text(encoding="utf-8")
    before, rest = text.split("translations: {}", 1)
    example, after = rest.split("\nauthors:", 1)
    lines = [line.removeprefix("# ").removeprefix("#") for line in example.splitlines()[1:]]
    values, _ = read_yaml("\n".join([f"{before}translations:", *lines, f"authors:{after}"]), "study.yaml")
    assert values["translations"]["de"]["questions"]["gender"]["question"] == "Was ist Ihr Geschlecht?"


def test_all_missing_texts_of_a_language_are_named_at_once_with_their_form(tmp_path) -> None:
    text = (
        STUDY
        + """ratings: {confidence: {question: Sure, low: a, high: b}}
translations:
  de: {title: x, question: y, labels: {happiness: Freude}, consent: a, instructions: b, thanks: c}
"""
    )
    with pytest.raises(EmovidError) as refused:
        load_study(write_study(tmp_path, text))
    message = str(refused.value)
    assert "translations.de: missing texts in this language: labels.surprise (surprise: ...), " in message
    assert "ratings.confidence (confidence: {question: ..., low: ..., high: ...})" in message
    assert message.endswith("questions.gender (gender: {question: ..., choices: [...]})")
