"""The data set by Psych-DS: all recorded data under pseudonyms, by the rules of the standard."""

import csv
import json
import re
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.kit.export import export
from emovid.kit.folder import Kit
from tests.helpers.tiny import STUDY, make_kit_of_placeholders

HERE = Path(__file__).parent
JSPSYCH = sorted((HERE / "exported" / "jspsych").glob("*.csv"))
# Official keywords of file names, and keys that dataset_description.json must or should have, by version 1.4 of the
# standard's schema.
KEYWORDS = ("study", "site", "subject", "session", "task", "condition", "trial", "stimulus", "description")
REQUIRED = ("@context", "@type", "name", "description", "variableMeasured")


@pytest.fixture(scope="module")
def kit(tmp_path_factory) -> Kit:
    text = (HERE / "studies" / "german.yaml").read_text()
    return make_kit_of_placeholders(tmp_path_factory.mktemp("german"), text, seed=7)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        return list(csv.DictReader(file, delimiter=";" if "limesurvey" in path.name else ","))


def trials() -> dict[tuple[str, str], dict[str, str]]:
    """Return the rows of jsPsych's files that show a video, by participant and video."""
    return {
        (row["participant"], row["video_code"]): row for path in JSPSYCH for row in rows_of(path) if row["video_code"]
    }


@pytest.fixture(scope="module")
def data_set(kit, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("set")
    export(kit, "psych-ds", folder, responses=JSPSYCH)
    return folder


def answers_in(folder: Path) -> list[dict[str, str]]:
    (path,) = (folder / "data").glob("*responses*")
    return rows_of(path)


def check_rules(folder: Path) -> None:
    """Check the rules of Psych-DS whose violation is an error of its validator, and its recommendations."""
    assert (folder / "README.md").read_text().strip()
    text = (folder / "dataset_description.json").read_text(encoding="utf-8")
    said = json.loads(text)
    assert set(REQUIRED) <= set(said)
    assert said["@type"] == "Dataset"
    assert said["@context"].startswith("http://schema.org")
    described = [variable["name"] for variable in said["variableMeasured"]]
    assert len(set(described)) == len(described)
    assert all(
        variable["@type"] == "PropertyValue" and variable["description"] for variable in said["variableMeasured"]
    )
    columns: set[str] = set()
    data = list((folder / "data").iterdir())
    assert data
    for path in data:
        assert re.fullmatch(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv", path.name)
        keywords = [part.partition("-")[0] for part in path.stem.removesuffix("_data").split("_")]
        assert set(keywords) <= set(KEYWORDS)
        with path.open(encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
        assert rows
        assert all(header)
        assert len(set(header)) == len(header)
        assert {len(row) for row in rows} == {len(header)}
        columns |= set(header)
    assert columns == set(described)


def test_data_set_is_valid_with_and_without_answers(kit, data_set, tmp_path) -> None:
    check_rules(data_set)
    export(kit, "psych-ds", tmp_path)
    check_rules(tmp_path)


def test_every_recorded_column_is_exported_with_its_values(kit, data_set) -> None:
    found = answers_in(data_set)
    expected = trials()
    assert len(found) == len(expected) == 24
    columns = ("position", "response", "confidence", "valence", "arousal", "rt", "plays", "watched_seconds", "choices")
    names = {row["participant_id"]: row for row in found}
    assert len(names) == 4

    def facts(rows, video: str) -> list[tuple[str, ...]]:
        return sorted((row[video], *(row[name] for name in columns)) for row in rows)

    assert facts(found, "video_code") == facts(expected.values(), "video_code")
    assert all(row["signalled"] == kit.key[row["video_code"]] for row in found)


def test_order_row_matches_the_consent_page(kit, data_set) -> None:
    consent = {row["participant"]: row for path in JSPSYCH for row in rows_of(path) if row["order_index"]}
    expected = sorted(row["order_index"] for row in consent.values())
    people = {row["participant_id"]: row["order_row"] for row in answers_in(data_set)}
    assert sorted(people.values()) == expected
    for row in answers_in(data_set):
        assert kit.orders[row["order_row"]][int(row["position"]) - 1] == row["video_code"]


def test_value_ranges_are_described(data_set) -> None:
    said = json.loads((data_set / "dataset_description.json").read_text(encoding="utf-8"))
    variables = {variable["name"]: variable for variable in said["variableMeasured"]}
    for name, most in (("confidence", 101), ("valence", 7), ("arousal", 9), ("position", 6)):
        assert (variables[name]["minValue"], variables[name]["maxValue"]) == (1, most)
    plays = [int(row["plays"]) for row in trials().values()]
    assert (variables["plays"]["minValue"], variables["plays"]["maxValue"]) == (min(plays), max(plays))


def test_names_and_free_text_are_not_published(kit, data_set) -> None:
    names = {participant for participant, _ in trials()} - set(kit.orders)
    assert len(names) == 2
    texts = [
        json.loads(row["response"])["country"] for path in JSPSYCH for row in rows_of(path) if row["trial_index"] == "2"
    ]
    published = "".join(path.read_text(encoding="utf-8") for path in data_set.rglob("*") if path.is_file())
    for private in (*names, *filter(None, texts)):
        assert private not in published
    people = {row["participant_id"] for row in answers_in(data_set)}
    assert {name for name in people if name not in kit.orders} == {"S001", "S002"}
    readme = (data_set / "README.md").read_text()
    assert "- names of 2 participants, replaced by pseudonyms" in readme
    assert "- answers to country, which are free text" in readme


def test_limesurvey_answers_need_their_map(kit, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    export(kit, "limesurvey")
    source = HERE / "exported" / "limesurvey_codes.csv"
    command = ["study", "export", str(kit.folder.path), "--to", "psych-ds", "--responses", str(source), "-o", "set"]
    mapping = kit.folder.exports / "limesurvey" / "map.yaml"
    assert main(command) == 2
    assert "not a label" in capsys.readouterr().err
    assert main([*command, "--map", str(mapping)]) == 0
    check_rules(tmp_path / "set")
    given = [row for row in rows_of(source) if row["consent"] == "Y"]
    found = answers_in(tmp_path / "set")
    assert len(found) == 6 * len(given)
    for row in found:
        assert row["confidence"] == row["valence"] == row["arousal"] == "3"
    assert main([*command[:-4], "-o", "set", "--map", str(mapping)]) == 2
    assert "--map: expected --responses" in capsys.readouterr().err


def test_text_typed_where_the_study_offers_choices_is_not_published(tmp_path) -> None:
    asked = (
        '  - {name: tools, question: "Tools?", choices: ["a, b", c], several: true}\n'
        '  - {name: age, question: "Age?", number: {low: 18, high: 99}}\nconsent:'
    )
    kit = make_kit_of_placeholders(tmp_path, STUDY.replace("consent:", asked, 1))
    people = {
        "P001": ("Woman", "a, b|c", "30", "anna@example.org"),
        "P002": ("my name is Ben", "c", "forty, Ben", "ben@example.org"),
        "P003": ("A2", "c|and Carl's", "31", "carl@example.org"),
    }
    table = tmp_path / "answers.csv"
    with table.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["participant", "video", "response", "gender", "tools", "age", "contact"])
        for name, facts in people.items():
            answers = zip(kit.manifest.codes, kit.manifest.choices.labels[int(name[-1]) :] * 2, strict=False)
            writer.writerows([name, code, choice.label, *facts] for code, choice in answers)
    export(kit, "psych-ds", tmp_path / "set", responses=[table])
    found = {row["participant_id"]: (row["gender"], row["tools"], row["age"]) for row in answers_in(tmp_path / "set")}
    assert found == {
        "P001": ("Woman", "a, b|c", "30"),
        "P002": ("(typed)", "c", "(typed)"),
        "P003": ("A2", "(typed)", "31"),
    }
    published = "".join(path.read_text(encoding="utf-8") for path in (tmp_path / "set").rglob("*") if path.is_file())
    assert not any(private in published for private in ("Ben", "Carl", "example.org"))
    readme = (tmp_path / "set" / "README.md").read_text()
    assert "- 1 answers to gender that are none of its choices, shown as (typed)" in readme
    assert "- column contact, which differs for each participant" in readme
