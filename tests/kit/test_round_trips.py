"""From a kit to a tool, and from the data files of the tool back to the given answers."""

import csv
import io
import json
import re
from collections import Counter
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.kit.export import export
from emovid.kit.folder import Kit
from tests.helpers.limesurvey import answers_text, rows_of
from tests.helpers.tiny import make_kit_of_placeholders

HERE = Path(__file__).parent
EXPORTED = HERE / "exported"
CODES = ("A1", "A2", "A3", "A4", "A5", "A6", "AN")  # of answers in LimeSurvey
BEGIN = ("2026-11-30 10:00:00", "IP Address", "100", "True")  # of a row of Qualtrics
PAGES = ("instructions", "end")
AGE = ("18-24", "25-34", "65 oder älter", "Keine Angabe, danke")


@pytest.fixture(scope="module")
def kit(tmp_path_factory) -> Kit:
    """Build the German kit with three sliders, a none-of-these answer and random choices."""
    text = (HERE / "studies" / "german.yaml").read_text()
    made = make_kit_of_placeholders(tmp_path_factory.mktemp("german"), text, seed=7)
    for tool in ("limesurvey", "qualtrics", "psychopy", "jspsych"):
        export(made, tool, video_url="https://example.org/videos")
    return made


@pytest.fixture(scope="module")
def given(kit) -> dict[str, dict[str, str]]:
    """Return an invented label for each participant and video."""
    labels = [choice.label for choice in kit.manifest.choices.labels]
    codes = kit.manifest.codes
    return {
        who: {code: labels[(3 * i + 2 * k + i * k) % len(labels)] for k, code in enumerate(codes)}
        for i, who in enumerate(kit.orders)
    }


def matrix(kit: Kit, answers: list[tuple[str, str]]) -> list[list[int]]:
    """Return the counts of (code, label), rows perceived, columns signaled."""
    counted = Counter((label, kit.key[code]) for code, label in answers)
    signaled = [choice.label for choice in kit.manifest.choices.labels if choice.label != "none"]
    return [[counted[label, emotion] for emotion in signaled] for label in (*signaled, "none")]


def all_of(given: dict[str, dict[str, str]]) -> list[tuple[str, str]]:
    return [pair for answers in given.values() for pair in answers.items()]


def analyzed(kit: Kit, source: Path, mapping: Path | None = None) -> dict:
    out = source.parent / "results"
    options = ["--key", str(kit.folder.key), "--map", str(mapping or kit.folder.map), "-o", str(out), "--quiet"]
    assert main(["study", "analyze", str(source), *options]) == 0
    return json.loads((out / "results.json").read_text())


def written(path: Path, text: str) -> Path:
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("full", [True, False], ids=["full answers", "answer codes"])
@pytest.mark.parametrize("headings", ["code", "full", "codetext"])
def test_limesurvey_answers_are_read_back(kit, given, tmp_path, headings, full) -> None:
    rows = rows_of((kit.folder.exports / "limesurvey" / "survey.txt").read_text())
    code_of = dict(zip(list_of_labels(kit), CODES, strict=True))
    people = []
    for i, answers in enumerate(given.values()):
        person = {"consent": "Y", "age": f"A{i % 4 + 1}", "roboticsUbackground": f"A{i % 2 + 1}", "country": "A"}
        person |= {code: code_of[label] for code, label in answers.items()}
        person |= {f"{code}{name}": str(i + 1) for code in answers for name in ("confidence", "valence", "arousal")}
        people.append(person)
    people.append({"consent": "N"})
    source = written(tmp_path / "export.csv", answers_text(rows, people, headings, full=full))
    found = analyzed(kit, source, kit.folder.exports / "limesurvey" / "map.yaml")
    assert found["counts"] == matrix(kit, all_of(given))
    assert found["n_participants"] == 12
    assert set(found["groups"]) == {"age", "robotics_background", "country"}
    if full:
        assert set(found["groups"]["age"]) == set(AGE)


def list_of_labels(kit: Kit) -> list[str]:
    return [choice.label for choice in kit.manifest.choices.labels]


@pytest.mark.parametrize("numbers", [True, False], ids=["numeric values", "choice text"])
def test_qualtrics_answers_are_read_back(kit, given, tmp_path, numbers) -> None:
    survey = (kit.folder.exports / "qualtrics" / "survey.txt").read_text()
    names = [name for name in re.findall(r"^\[\[ID:(\w+)\]\]$", survey, re.MULTILINE) if name not in PAGES]
    texts = {choice.label: choice.text for choice in kit.manifest.choices.labels}
    header = ["StartDate", "Status", "Progress", "Finished", "ResponseId", "UserLanguage", *names, "FL_7_DO"]
    lines = [header, header, [json.dumps({"ImportId": f"QID{i}"}) for i in range(len(header))]]
    for i, (who, answers) in enumerate(given.items()):
        said = {"consent": "1" if numbers else "Ich stimme zu", "age": str(i % 4 + 1) if numbers else AGE[i % 4]}
        said |= {code: str(list(texts).index(x) + 1) if numbers else texts[x] for code, x in answers.items()}
        said |= {name: str(i + 1) for name in names if name.endswith(("_confidence", "_valence", "_arousal"))}
        cells = [said.get(name, "") for name in names]
        order = "|".join(kit.orders[who])
        lines.append([*BEGIN, f"R_{i:015}", "DE", *cells, order])
    text = io.StringIO()
    csv.writer(text).writerows(lines)
    found = analyzed(kit, written(tmp_path / "q.csv", text.getvalue()), kit.folder.exports / "qualtrics" / "map.yaml")
    assert found["counts"] == matrix(kit, all_of(given))
    assert set(found["groups"]) == {"age"}


@pytest.mark.parametrize("component", ["button", "mouse", "slider", "keyboard"])
def test_psychopy_answers_are_read_back(kit, given, tmp_path, component) -> None:
    """PsychoPy writes a BOM, a comma at the end of each line, a file for each participant, and rows of other pages."""
    folder = tmp_path / "data"
    folder.mkdir()
    labels = list_of_labels(kit)
    for who in given:
        conditions = (kit.folder.exports / "psychopy" / "conditions" / f"{who}.csv").read_text()
        lines = []
        for i, row in enumerate(csv.DictReader(io.StringIO(conditions))):
            said = given[who][row["video_code"]]
            cells = {"trials.thisRepN": "0", "trials.thisTrialN": str(i), "trials.thisN": str(i), **row}
            cells |= answer_of(component, labels, said) | {"confidence.response": "4", "confidence.rt": "1.5"}
            cells |= {
                "thisRow.t": "",
                "notes": "",
                "participant": who,
                "date": "2026-11-30_10h00",
                "expName": "robots",
                "psychopyVersion": "2026.2.5",
            }
            lines.append(cells)
        page = dict.fromkeys(lines[0], "") | {"participant": who, "psychopyVersion": "2026.2.5"}
        table = [list(page), *(list(line.values()) for line in (page, *lines, page))]
        text = "".join(",".join(map(quoted, line)) + ",\n" for line in table)
        written(folder / f"{who}_robots_2026-11-30.csv", "\ufeff" + text)
    found = analyzed(kit, folder)
    assert found["counts"] == matrix(kit, all_of(given))
    assert found["groups"] == {}


def answer_of(component: str, labels: list[str], said: str) -> dict[str, str]:
    if component == "button":
        clicked = {f"{label}.numClicks": "1" if label == said else "0" for label in labels}
        return clicked | {f"{label}.timesOn": "[2.5]" if label == said else "" for label in labels}
    if component == "mouse":  # a list for each click
        return {"mouse.x": "[0.1]", "mouse.leftButton": "[1]", "mouse.clicked_name": f"['{said}']"}
    return {f"answer.{'keys' if component == 'keyboard' else 'response'}": said, "answer.rt": "2.5"}


def test_psychopy_readme_has_the_settings_that_its_defaults_would_break(kit) -> None:
    readme = (kit.folder.exports / "psychopy" / "README.md").read_text(encoding="utf-8")
    assert f"enter the participant (`{next(iter(kit.orders))}`)" in readme
    assert "Empty the field *Stop* of each component" in readme  # movies stop after one second by default
    assert "isFinished" not in readme  # PsychoJS has no such attribute: the answers would never appear online
    assert readme.count(", granularity 1;") == len(kit.manifest.ratings) == 3


def quoted(cell: str) -> str:
    return f'"{cell}"' if "," in cell else cell


def test_data_written_by_jspsych_are_read(kit, tmp_path) -> None:
    folder = tmp_path / "data"
    folder.mkdir()
    given = []
    for path in sorted((EXPORTED / "jspsych").glob("*.csv")):
        written(folder / path.name, path.read_text(encoding="utf-8"))
        with path.open(encoding="utf-8-sig") as file:
            given += [(row["video_code"], row["response"]) for row in csv.DictReader(file) if row["video_code"]]
    assert len(given) == 24
    found = analyzed(kit, folder)
    assert found["counts"] == matrix(kit, given)
    assert set(found["groups"]) == {"age", "robotics_background", "country"}


def test_data_written_by_limesurvey_are_read(kit, tmp_path) -> None:
    source = written(tmp_path / "export.csv", (EXPORTED / "limesurvey_codes.csv").read_text(encoding="utf-8"))
    mapping = kit.folder.exports / "limesurvey" / "map.yaml"
    with (EXPORTED / "limesurvey_codes.csv").open(encoding="utf-8-sig") as file:
        rows = [row for row in csv.DictReader(file, delimiter=";") if row["consent"] == "Y"]
    labels = dict(zip(CODES, list_of_labels(kit), strict=True))
    found = analyzed(kit, source, mapping)
    assert found["counts"] == matrix(kit, [(code, labels[row[code]]) for row in rows for code in kit.key])
    assert set(found["groups"]) == {"age", "roboticsbackground", "country"}  # names of an earlier version


def test_numeric_exports_of_qualtrics_are_read(kit, tmp_path) -> None:
    source = written(tmp_path / "export.csv", (EXPORTED / "qualtrics_numbers.csv").read_text(encoding="utf-8"))
    with (EXPORTED / "qualtrics_numbers.csv").open(encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))[2:]
    labels = list_of_labels(kit)
    found = analyzed(kit, source, kit.folder.exports / "qualtrics" / "map.yaml")
    answers = [(code, labels[int(row[code]) - 1]) for row in rows for code in kit.key if row[code]]
    assert found["counts"] == matrix(kit, answers)
    assert set(found["groups"]) == {"age", "robotics_background", "country"}
