"""Exports to other tools, and reading back the data files that these tools would write."""

import csv
import html
import io
import json
import re
from itertools import takewhile
from pathlib import Path

import pytest

from emovid.errors import InputError
from emovid.kit.audit import audit
from emovid.kit.export import TOOLS, export
from emovid.kit.exports.reporting import OPEN
from emovid.kit.folder import Kit, open_kit
from emovid.responses.read import read_responses
from emovid.statistics.analyze import analyze
from emovid.statistics.planning import plan
from emovid.statistics.results import StudyResults
from tests.helpers.limesurvey import seen
from tests.helpers.tiny import LABELS, STUDY, make_kit, make_kit_of_placeholders

# Labels without known synonyms, in another script, with characters that formats must quote.
GREEK = """\
labels: {happiness: Χαρά, surprise: Έκπληξη, anger: Θυμός, fear: Φόβος, disgust: "Αηδία, <b>&</b>", sadness: Λύπη}
none_of_these: Κανένα
ratings: {confidence: {question: Πόσο σίγουρος είστε;, low: καθόλου, high: απόλυτα}}
hypotheses: [People see it.]
exclusions: [Test runs.]
ethics: {board: A board, approval: "2026-17"}
authors: [A. Author]
language: el
"""


@pytest.fixture(scope="module")
def greek(tmp_path_factory) -> Kit:
    """Make a kit in another language, and export it for every tool."""
    folder = tmp_path_factory.mktemp("greek")
    labels = STUDY[STUDY.index("labels") : STUDY.index("stimuli")]
    text = STUDY.replace(labels, GREEK).replace(
        "You can stop at any time.", '"One </script> <!-- <script> line.\\n\\nTwo & more."'
    )
    make_kit(folder, text)
    kit = open_kit(folder / "kit")
    for tool in TOOLS:
        export(kit, tool, video_url="https://example.org/videos/")
    return kit


def written(kit: Kit, tool: str, name: str) -> str:
    return (kit.folder.exports / tool / name).read_text(encoding="utf-8-sig")


def answers_of(kit: Kit) -> dict[str, dict[str, str]]:
    """Return invented answers: correct except for the first video."""
    found = {}
    for participant, order in kit.orders.items():
        found[participant] = {code: kit.key[code] for code in order} | {order[0]: "fear"}
    return found


def counts(kit: Kit) -> list[list[int]]:
    answers = answers_of(kit).values()
    labels = [*LABELS, "none"]
    return [
        [sum(kit.key[code] == emotion and said == label for a in answers for code, said in a.items())
         for emotion in LABELS] for label in labels
    ]  # fmt: skip


def table(path: Path, header: list[str], rows: list[list[str]], delimiter: str = ",") -> Path:
    text = io.StringIO()
    csv.writer(text, delimiter=delimiter, lineterminator="\n").writerows([header, *rows])
    path.write_text(text.getvalue())
    return path


def test_exports_do_not_reveal_emotions(greek) -> None:
    assert [str(finding) for finding in audit(greek.folder.path).findings] == []


@pytest.mark.parametrize("tool", ["jspsych", "psychopy", "qualtrics", "limesurvey"])
def test_videos_are_copied_unchanged(greek, tool) -> None:
    for code in greek.manifest.codes:
        copy = greek.folder.exports / tool / "videos" / f"{code}.mp4"
        assert copy.read_bytes() == greek.folder.video(code).read_bytes()
        assert copy.stat().st_mtime == greek.folder.video(code).stat().st_mtime


# --- jsPsych ----------------------------------------------------------------------------------------------------------


def test_jspsych_page_has_its_data_but_not_the_library(greek) -> None:
    page = written(greek, "jspsych", "index.html")
    text = re.search(r'id="kit">(.*?)</script>', page, re.DOTALL)[1]
    assert "<" not in text  # </script> ends the data early, <!-- <script> late
    data = json.loads(text)
    assert data["consent"]["text"] == "One </script> <!-- <script> line.\n\nTwo & more."
    assert data["preload"] == [f"videos/{code}.mp4" for code in greek.manifest.codes]
    assert {name: tuple(order) for name, order in data["orders"].items()} == greek.orders
    assert '<html lang="el">' in page
    names = {path.name for path in (greek.folder.exports / "jspsych").iterdir()}
    assert names == {"index.html", "experiment.js", "experiment.css", "README.md", "videos"}
    assert "jspsych@8.3.0" in written(greek, "jspsych", "README.md")


# --- PsychoPy ---------------------------------------------------------------------------------------------------------


def test_psychopy_data_are_read_back(greek, tmp_path) -> None:
    answers = answers_of(greek)
    for participant, order in greek.orders.items():
        rows = list(csv.DictReader(io.StringIO(written(greek, "psychopy", f"conditions/{participant}.csv"))))
        assert [row["video_code"] for row in rows] == list(order)
        assert all((greek.folder.exports / "psychopy" / row["video_file"]).is_file() for row in rows)
        header = ["trials.thisN", *rows[0], "answer.clicked_name", "participant", "psychopyVersion"]
        made = [
            [str(i), *row.values(), answers[participant][row["video_code"]], participant, "2026.2.5"]
            for i, row in enumerate(rows)
        ]
        table(tmp_path / f"{participant}.csv", header, made)
    responses = read_responses(tmp_path, key=greek.folder.key, mapping=greek.folder.map)
    assert responses.sources[0].dialect == "PsychoPy or Pavlovia"
    assert responses.counts().tolist() == counts(greek)
    first = responses.answers[responses.answers["position"] == 1]
    assert set(zip(first["participant"], first["video"], strict=True)) == {(p, o[0]) for p, o in greek.orders.items()}


# --- Qualtrics --------------------------------------------------------------------------------------------------------


def questions(survey: str) -> dict[str, list[str]]:
    """Return the choices of each question of Qualtrics' advanced format."""
    found = {}
    for part in re.split(r"^\[\[Question:", survey, flags=re.MULTILINE)[1:]:
        name = re.search(r"^\[\[ID:(\w+)\]\]$", part, re.MULTILINE)[1]
        choices = part.partition("[[Choices]]\n")[2].split("\n\n")[0]
        found[name] = [line for line in choices.splitlines() if line and not line.startswith("[[")]
    return found


def test_qualtrics_data_are_read_back(greek, tmp_path) -> None:
    survey = written(greek, "qualtrics", "survey.txt")
    assert survey.startswith("[[AdvancedFormat]]\n")
    asked = questions(survey)
    assert [name for name in asked if name in greek.manifest.codes] == greek.manifest.codes
    assert asked["gender"] == ["Woman", "Man", "Another gender"]
    assert len(asked["consent"]) == 2
    for code in greek.manifest.codes:
        assert f"src='https://example.org/videos/{code}.mp4'" in survey
        assert len(asked[code]) == 7
        assert asked[f"{code}_confidence"] == [str(step) for step in range(1, 102)]
    texts = {answer.label: answer.text for answer in greek.manifest.choices.labels}
    header = ["ResponseId", "Finished", *asked]
    imports = [json.dumps({"ImportId": f"QID{i}"}) for i in range(len(header))]
    rows = []
    for participant, answers in answers_of(greek).items():
        said = {code: texts[label] for code, label in answers.items()} | {"gender": "Woman"}
        said |= {f"{code}_confidence": "4" for code in answers}
        rows.append([participant, "True", *(said.get(name, "") for name in asked)])
    path = table(tmp_path / "q.csv", header, [header, imports, *rows])
    responses = read_responses(path, key=greek.folder.key, mapping=greek.folder.map)
    assert responses.sources[0].dialect == "Qualtrics"
    assert responses.counts().tolist() == counts(greek)
    assert list(responses.participants["gender"].unique()) == ["Woman"]


# --- LimeSurvey -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("full", [True, False], ids=["full answers", "answer codes"])
def test_limesurvey_data_are_read_back(greek, tmp_path, full) -> None:
    rows = list(csv.DictReader(io.StringIO(written(greek, "limesurvey", "survey.txt")), delimiter="\t"))
    names = [row["name"] for row in rows if row["class"] == "Q"]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9]{0,19}", name) for name in names)
    assert all(len(row["name"]) <= 5 for row in rows if row["class"] == "A")
    groups = [row for row in rows if row["class"] == "G" and row["random_group"] == "videos"]
    assert [row["name"] for row in groups] == greek.manifest.codes
    first = next(i for i, row in enumerate(rows) if row["class"] == "Q" and row["name"] in greek.manifest.codes)
    codes = {
        html.unescape(row["text"]): row["name"] for row in takewhile(lambda row: row["class"] == "A", rows[first + 1 :])
    }
    texts = {answer.label: answer.text for answer in greek.manifest.choices.labels}
    assert list(codes) == list(texts.values())
    header = ["id", "submitdate", "lastpage", "startlanguage", "seed", *names]
    made = []
    for number, answers in enumerate(answers_of(greek).values(), start=1):
        said = {code: texts[label] if full else codes[texts[label]] for code, label in answers.items()}
        said |= {"consent": "Y", "gender": "Woman"}
        made.append([str(number), "2026-11-01 10:00:00", "9", "el", "1", *(said.get(name, "") for name in names)])
    path = table(tmp_path / "l.csv", header, made)
    mapping = greek.folder.exports / "limesurvey" / "map.yaml"
    responses = read_responses(path, key=greek.folder.key, mapping=mapping)
    assert responses.sources[0].dialect == "LimeSurvey"
    assert responses.counts().tolist() == counts(greek)


# --- data set, preregistration, checklist -----------------------------------------------------------------------------


def is_psych_ds(folder: Path) -> None:
    """Check the requirements of Psych-DS: required keys, names of data files, and descriptions of all columns."""
    said = json.loads((folder / "dataset_description.json").read_text())
    assert {"@context", "@type", "name", "description", "variableMeasured"} <= set(said)
    assert said["@type"] == "Dataset"
    described = {variable["name"] for variable in said["variableMeasured"]}
    data = list((folder / "data").iterdir())
    assert data
    columns = set()
    for path in data:
        assert re.fullmatch(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv", path.name)
        with path.open() as file:
            header, *rows = csv.reader(file)
        columns |= set(header)
        assert all(len(row) == len(header) for row in rows)
    assert columns == described
    assert all(variable["description"] for variable in said["variableMeasured"])


def test_data_set_is_valid_psych_ds_before_and_after_the_study(greek, tmp_path) -> None:
    is_psych_ds(greek.folder.exports / "psych-ds")
    rows = [["participant", "video", "position", "response", "gender"]]
    for participant, answers in answers_of(greek).items():
        order = greek.orders[participant]
        rows += [[participant, c, str(order.index(c) + 1), said, "Man"] for c, said in answers.items()]
    path = table(tmp_path / "answers.csv", rows[0], rows[1:])
    export(greek, "psych-ds", tmp_path / "set", responses=[path])
    is_psych_ds(tmp_path / "set")
    (data,) = (tmp_path / "set" / "data").glob("*responses*")
    with data.open() as file:
        answers = list(csv.DictReader(file))
    assert len(answers) == 72
    assert {row["participant_id"] for row in answers} == set(greek.orders)
    assert all(row["signalled"] == greek.key[row["video_code"]] and row["gender"] == "Man" for row in answers)
    assert all(greek.orders[row["participant_id"]][int(row["position"]) - 1] == row["video_code"] for row in answers)


def test_answers_without_positions_and_with_any_group_name_are_exported(kit, tmp_path) -> None:
    codes = open_kit(kit).manifest.codes
    rows = [["P001", code, "fear", "=1+1", ""] for code in codes] + [["P002", codes[0], "anger", "", "yes"]]
    path = table(tmp_path / "answers.csv", ["participant", "video", "response", "country", "choices"], rows)
    export(open_kit(kit), "psych-ds", tmp_path / "set", responses=[path])
    is_psych_ds(tmp_path / "set")
    (data,) = (tmp_path / "set" / "data").glob("*responses*")
    with data.open() as file:
        found = list(csv.DictReader(file))
    assert {row["position"] for row in found} == {""}
    assert {(row["participant_id"], row["country"]) for row in found} == {("P001", "'=1+1"), ("P002", "")}
    assert "nan" not in data.read_text()


def test_last_page_has_completion_code_and_return_link(tmp_path) -> None:
    said = 'thanks: {text: Thank you., code: "C0DE <1>", link: "https://example.org/?a=1&b=2"}'
    kit = make_kit_of_placeholders(tmp_path, STUDY.replace("thanks: {text: Thank you.}", said))
    page = (
        "<p>Thank you.</p><p>Your completion code: C0DE &lt;1&gt;</p>"
        '<p><a href="https://example.org/?a=1&amp;b=2">Return to the recruitment service</a></p>'
    )
    for tool in ("qualtrics", "limesurvey"):
        export(kit, tool)
        assert page in written(kit, tool, "survey.txt").replace('""', '"')


def test_a_line_of_text_and_no_questions_at_all_are_exported_too(tmp_path) -> None:
    about = STUDY[STUDY.index("demographics:") : STUDY.index("consent:")]
    line = 'demographics:\n  - {name: home_country, question: "Where do you live?", required: false}\n'
    short = STUDY.replace("duration: 1}", "duration: 0.2}")
    for name, text in (("line", short.replace(about, line)), ("none", short.replace(about, ""))):
        kit = make_kit_of_placeholders(tmp_path / name, text)
        export(kit, "limesurvey")
        export(kit, "qualtrics")
        rows = list(csv.DictReader(io.StringIO(written(kit, "limesurvey", "survey.txt")), delimiter="\t"))
        asked = {row["name"]: row for row in rows if row["class"] == "Q"}
        blocks = re.findall(r"^\[\[Block:(.*)\]\]$", written(kit, "qualtrics", "survey.txt"), re.MULTILINE)
        if name == "line":
            question = asked["homeUcountry"]
            assert (question["type/scale"], question["mandatory"], seen(question["text"])) == (
                "S", "N", ["Where do you live?"]
            )  # fmt: skip
            assert "[[Question:TE:SingleLine]]\n[[ID:home_country]]" in written(kit, "qualtrics", "survey.txt")
        else:
            assert set(asked) == {"consent", "instructions", *kit.manifest.codes}
            assert blocks == ["Consent", "Instructions", *kit.manifest.codes, "End"]


def test_checklist_names_forced_choice_as_a_limitation(fresh, tmp_path, greek) -> None:
    assert '"None of these" is offered' in written(greek, "checklist", "checklist.md")
    export(open_kit(fresh), "checklist", tmp_path)
    assert '"None of these" is not offered: a forced choice' in (tmp_path / "checklist.md").read_text()


def test_own_videos_are_kept_and_a_missing_video_gives_a_one_line_message(kit) -> None:
    own = kit / "exports" / "jspsych" / "videos" / "practice.mp4"
    own.parent.mkdir(parents=True)
    own.write_bytes(b"mine")
    export(open_kit(kit), "jspsych")
    assert own.read_bytes() == b"mine"
    gone = sorted((kit / "public" / "videos").iterdir())[0]
    gone.unlink()
    with pytest.raises(InputError, match=rf"public/videos/{gone.name}: no such file or directory; expected a video"):
        export(open_kit(kit), "jspsych")


def test_preregistration_states_the_facts_of_the_kit(greek) -> None:
    text = written(greek, "prereg", "preregistration.md")
    found = plan(0.5, 7, 6)
    assert f"needs {found.n} participants who each answer one video of the emotion: {found.n_binomial} for" in " ".join(
        text.split()
    )
    for said in ("1. People see it.", "- Test runs.", "A board, number 2026-17", "A. Author", "12 participants"):
        assert said in text
    assert greek.manifest.key_commitment in text
    assert not [code for code in greek.manifest.codes if code in text]
    assert text.count(OPEN) == 9  # explanation, purpose, blinding, existing data (2), N, procedures, stopping, ratings


def test_exemplars_of_an_emotion_share_one_test_in_plan_and_preregistration(tmp_path) -> None:
    kit = make_kit_of_placeholders(tmp_path, STUDY + "exemplars: 2\n")
    path = export(kit, "prereg").files[0]
    text = " ".join(path.read_text().split())
    assert "12 videos: simulations of 6 scenes" in text
    assert "2 exemplars of each." in text
    assert "after Holm's correction for 6 tests" in text
    assert f"Holm's correction for 6 tests: {0.05 / 6:.4g}), the study needs {plan(0.5, 6, 6).n} participants" in text
    assert len(analyzed(kit, tmp_path).recognition) == 6  # as stated in the text


def analyzed(kit: Kit, folder: Path) -> StudyResults:
    """Return the results of a study in which all answers are correct."""
    rows = [[who, code, str(i), kit.key[code]] for who, order in kit.orders.items() for i, code in enumerate(order, 1)]
    path = table(folder / "answers.csv", ["participant", "video", "position", "response"], rows)
    return analyze(read_responses(path, key=kit.folder.key))


def test_unknown_facts_are_marked_as_to_do(fresh, tmp_path) -> None:
    export(open_kit(fresh), "prereg", tmp_path)
    text = (tmp_path / "preregistration.md").read_text()
    assert f"### Hypotheses\n\n{OPEN}" in text
    assert f"Approved by {OPEN}" in text


def test_filled_in_draft_is_not_replaced(fresh, tmp_path) -> None:
    draft = export(open_kit(fresh), "prereg", tmp_path).files[0]
    written = draft.read_text()
    assert export(open_kit(fresh), "prereg", tmp_path).files[0] == draft
    draft.write_text("filled in")
    with pytest.raises(InputError, match=r"preregistration\.md exists with other content; use --force"):
        export(open_kit(fresh), "prereg", tmp_path)
    assert draft.read_text() == "filled in"
    export(open_kit(fresh), "prereg", tmp_path, force=True)
    assert draft.read_text() == written


def test_exports_need_the_orders_and_the_study(kit) -> None:
    for name in ("key.csv", "study.json"):
        (kit / "private" / name).unlink()
        with pytest.raises(InputError, match=f"{name}: no such file; expected the kit's private folder"):
            export(open_kit(kit), "prereg")
    (kit / "orders.csv").write_text("participant,position,video_code\n")
    with pytest.raises(InputError, match=r"orders\.csv: only a header; expected the orders of the kit"):
        export(open_kit(kit), "jspsych")
    (kit / "orders.csv").unlink()
    with pytest.raises(InputError, match=r"orders\.csv: no such file; expected the orders of the kit"):
        export(open_kit(kit), "jspsych")


def test_export_of_an_earlier_kit_is_replaced_only_with_force(kit, tmp_path) -> None:
    export(open_kit(kit), "jspsych")
    old = {path.name for path in (kit / "exports" / "jspsych" / "videos").iterdir()}
    built = make_kit(tmp_path, seed=5, force=True)
    with pytest.raises(InputError, match=r"exists with other content; use --force to overwrite it, or -o"):
        export(open_kit(kit), "jspsych")
    assert {path.name for path in (kit / "exports" / "jspsych" / "videos").iterdir()} == old
    export(open_kit(kit), "jspsych", force=True)
    new = {path.name for path in (kit / "exports" / "jspsych" / "videos").iterdir()}
    assert new == {f"{code}.mp4" for code in built.codes}
    assert not old & new
