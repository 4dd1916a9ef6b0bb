from pathlib import Path

import pandas as pd
import pytest

from emovid.errors import SourceError
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses
from tests.helpers.exports import (
    ANSWERS,
    CODES,
    COUNTS,
    EMOTIONS,
    EXPORTS,
    GENDER,
    KEY,
    ORDER,
    Export,
    jspsych,
    otree_wide,
    pcibex,
    psychopy,
    qualtrics,
    revisit,
    surveymonkey,
)


def write(export: Export, folder: Path) -> Path:
    """Write the files and return the folder, or the file if there is only one."""
    target = folder / "exports"
    target.mkdir()
    for name, data in export.files.items():
        (target / name).write_bytes(data)
    (folder / "key.csv").write_text(KEY)
    (folder / "map.yaml").write_text(export.map or "labels:\n")
    return target if len(export.files) > 1 else target / next(iter(export.files))


def read(export: Export, folder: Path) -> Responses:
    source = write(export, folder)
    return read_responses(source, folder / "key.csv", folder / "map.yaml", groups=["gender"])


@pytest.mark.parametrize("make", EXPORTS, ids=lambda make: make.__name__)
def test_every_dialect_gives_the_same_matrix(make, tmp_path) -> None:
    export = make()
    found = read(export, tmp_path)
    assert {source.dialect for source in found.sources} == {export.dialect}
    assert found.labels == found.signalled == EMOTIONS
    assert found.counts().tolist() == COUNTS
    assert len(found.answers) == 48
    rejected = [row for row in found.rejected if not row.reason.startswith("left out: ")]
    assert [(row.row, row.cell) for row in rejected] == [(0, "")] * export.skipped
    assert (found.dropped, found.left_out) == (export.dropped, export.left_out)
    by_person = found.answers.pivot(index="participant", columns="video", values="perceived")[list(CODES)]
    assert sorted(map(tuple, by_person.to_numpy())) == sorted(tuple(given.values()) for given in ANSWERS.values())
    genders = dict(
        zip(map(tuple, by_person.to_numpy()), found.participants.loc[by_person.index, "gender"], strict=True)
    )
    assert genders == {tuple(ANSWERS[p].values()): GENDER[p] for p in ANSWERS}


@pytest.mark.parametrize("make", [make for make in EXPORTS if make().positions], ids=lambda make: make.__name__)
def test_video_order_is_read(make, tmp_path) -> None:
    found = read(make(), tmp_path).answers.sort_values("position")
    orders = sorted(tuple(rows["video"]) for _, rows in found.groupby("participant"))
    assert orders == sorted(tuple(order) for order in ORDER.values())
    assert sorted(found["position"].unique()) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("make", [make for make in EXPORTS if not make().positions], ids=lambda make: make.__name__)
def test_positions_are_missing_without_an_order_column(make, tmp_path) -> None:
    positions = read(make(), tmp_path).answers["position"]
    assert positions.isna().all()
    assert positions.dtype == pd.Int64Dtype()


def test_column_that_differs_between_rounds_is_not_a_group(tmp_path) -> None:
    assert list(read(otree_wide(), tmp_path).participants) == ["gender"]


def test_revisit_export_needs_no_key(tmp_path) -> None:
    (tmp_path / "tidy.csv").write_bytes(revisit().files["tidy.csv"])
    found = read_responses(tmp_path / "tidy.csv", groups=["gender"])
    assert found.counts().tolist() == COUNTS
    assert sorted(found.participants["gender"]) == sorted(GENDER.values())


def test_trial_numbers_within_a_block_are_compared_as_numbers(tmp_path) -> None:
    export = revisit()
    head, *lines = [line.split(",") for line in export.files["tidy.csv"].decode().splitlines()]
    rows = [[who, trial, f"{int(order) + 6}_0", *rest] for who, trial, order, *rest in lines]  # 9_0 is before 10_0
    export.files["tidy.csv"] = "\n".join(",".join(row) for row in [head, *rows]).encode()
    found = read(export, tmp_path).answers.sort_values("position")
    orders = sorted(tuple(rows["video"]) for _, rows in found.groupby("participant"))
    assert orders == sorted(tuple(order) for order in ORDER.values())


def test_questionnaire_items_about_emotions_are_not_groups(tmp_path) -> None:
    export = jspsych()
    asked, broken = b'{""gender"":""Female"",""mood"":""sad""}', b"{gender"
    data = export.files["all.csv"].replace(b'{""gender"":""Female""}', asked)
    data = data.replace(b'"<p>Welcome, friend</p>","0"', b'"<p>Welcome, friend</p>","' + broken + b'"')
    assert data.count(asked) == 3
    assert data.count(broken) == 8
    export.files["all.csv"] = data
    assert list(read(export, tmp_path).participants) == ["gender"]


def test_map_can_name_otree_videos(tmp_path) -> None:
    export = otree_wide()
    export.map = "videos: {study.1.player.response: z8r4}\n"
    source = write(export, tmp_path)
    found = read_responses(source, tmp_path / "key.csv", tmp_path / "map.yaml")
    assert set(found.answers["video"]) == {"z8r4"}
    assert len(found.participants) == 8


def test_otree_app_without_videos_is_skipped(tmp_path) -> None:
    export = otree_wide()
    lines = export.files["all_apps_wide.csv"].decode().splitlines()
    lines[0] += ",quiz.1.player.score,quiz.2.player.score"
    data = "\n".join([lines[0], *(f"{line},1,0" for line in lines[1:])])
    moved = [row.split(",")[-2:] + row.split(",")[:-2] for row in data.splitlines()]  # the quiz comes first
    export.files["all_apps_wide.csv"] = "\n".join(",".join(row) for row in moved).encode()
    assert read(export, tmp_path).counts().tolist() == COUNTS


def test_psiturk_file_with_only_debug_runs_or_broken_trials_is_refused(tmp_path) -> None:
    (tmp_path / "trialdata.csv").write_text('debugA:A,0,17,"{}"\nw:A,1,18,[1]\nw:A,2,19,{\n')
    with pytest.raises(
        SourceError, match=r"trialdata.csv:2: 4: '\[1\]' not a JSON object \(2 cells or rows rejected\)"
    ):
        read_responses(tmp_path / "trialdata.csv")


def test_a_video_that_a_display_order_lacks_has_no_position(tmp_path) -> None:
    export = qualtrics()
    data = export.files["q.csv"].replace(b"z8r4|", b"").replace(b"|z8r4", b"")
    export.files["q.csv"] = data
    places = read(export, tmp_path).answers.groupby("video")["position"].agg(["count", "max"])
    assert places["count"].to_dict() == {code: 8 * (code != "z8r4") for code in CODES}
    assert places["max"].max() == 5


def test_surveymonkey_file_without_second_header_is_read_and_without_rows_refused(tmp_path) -> None:
    head, second, *rows = surveymonkey().files["monkey.csv"].decode().splitlines()
    for name, lines in (("one", [head, *rows]), ("none", [head, second])):
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "key.csv").write_text(KEY)
    found = read_responses(tmp_path / "one.csv", tmp_path / "key.csv")
    assert (found.counts().tolist(), found.sources[0].dialect) == (COUNTS, "SurveyMonkey")
    with pytest.raises(SourceError, match=r"none.csv:1: only headers; expected a row for each respondent"):
        read_responses(tmp_path / "none.csv", tmp_path / "key.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sender,sender_type,response\nQ,html.Form,fear\n", "no column of videos; expected one with the key's codes"),
        (
            "sender,sender_type,video\nQ,html.Form,z8r4\n",
            "videos in 'video', but no column holds answers (happiness, surprise, anger, ...); expected map.yaml: "
            "response: their column, and answers: the label of each cell, or other --labels",
        ),
    ],
)
def test_trials_without_video_or_answer_are_refused(tmp_path, text, message) -> None:
    (tmp_path / "x.csv").write_text(text)
    (tmp_path / "key.csv").write_text(KEY)
    with pytest.raises(SourceError) as error:
        read_responses(tmp_path / "x.csv", tmp_path / "key.csv")
    assert error.value.message == message


def test_unpressed_key_is_not_an_answer(tmp_path) -> None:
    export = psychopy()
    export.files = {name: data.replace(b",1,1.5", b",None,None") for name, data in export.files.items()}
    found = read(export, tmp_path)
    assert found.labels == EMOTIONS
    assert [row.reason for row in found.rejected] == ["no answer"] * sum(COUNTS[0])


def test_timed_out_trial_is_not_an_answer(tmp_path) -> None:
    export = jspsych()
    export.files = {name: data.replace(b'.mp4""]","0"', b'.mp4""]","null"') for name, data in export.files.items()}
    found = read(export, tmp_path)
    assert [row.reason for row in found.rejected] == ["no answer"] * sum(COUNTS[0])


def test_pcibex_export_without_videos_is_refused(tmp_path) -> None:
    export = pcibex()
    export.files = {name: data.replace(b".mp4", b"") for name, data in export.files.items()}
    for code in CODES:
        export.files = {name: data.replace(code.encode(), b"clip") for name, data in export.files.items()}
    with pytest.raises(SourceError, match="video"):
        read(export, tmp_path)


@pytest.mark.parametrize(
    ("answered", "preview", "test", "spam", "finished", "partial"),
    [
        ("IP-Adresse", "Umfragevorschau", "Umfragetest", "Spam", "Wahr", "Falsch"),
        ("Adresse IP", "Aperçu de l'enquête", "Test de l'enquête", "Spam", "Vrai", "Faux"),
        ("Dirección IP", "Vista previa de la encuesta", "Prueba de encuesta", "Spam", "Verdadero", "Falso"),
        ("IPアドレス", "アンケートのプレビュー", "アンケートのテスト", "スパム", "True", "False"),
        ("IP 주소", "설문조사 미리 보기", "설문조사 테스트", "스팸", "참", "거짓"),
        ("0", "17", "18", "40", "1", "0"),
    ],
)
def test_states_of_qualtrics_are_known_in_many_languages(
    tmp_path, answered, preview, test, spam, finished, partial
) -> None:
    states = [answered, preview, test, spam]
    rows = [f"R{i},{state},{finished},2026,angry" for i, state in enumerate(states)]
    text = "\n".join(["ResponseId,Status,Finished,RecordedDate,Anger", *rows, f"R9,{answered},{partial},2026,angry"])
    (tmp_path / "q.csv").write_text(text)
    found = read_responses(tmp_path / "q.csv", max_rejected=1)
    assert found.participants.index.tolist() == ["R0"]
    assert found.dropped == {"preview": 1, "test run": 1, "spam": 1, "partial": 1}


def test_a_state_of_qualtrics_that_is_not_known_is_refused_unless_the_map_decides(tmp_path) -> None:
    (tmp_path / "q.csv").write_text(
        "ResponseId,Status,Finished,RecordedDate,Anger\nR0,0,1,2026,angry\nR1,Wib,1,2026,sad\n"
    )
    with pytest.raises(SourceError, match=r"q.csv:3: Status: 'Wib' is not known to be an answer.*drop: \{Status: \["):
        read_responses(tmp_path / "q.csv")
    (tmp_path / "map.yaml").write_text("drop: {Status: [Wib]}\n")
    assert len(read_responses(tmp_path / "q.csv", mapping=tmp_path / "map.yaml").participants) == 1
    (tmp_path / "q.csv").write_text("ResponseId,Status,Finished,RecordedDate,Anger\nR0,0,wib,2026,angry\n")
    with pytest.raises(SourceError, match="Finished: 'wib'; expected true or false, or a column Progress"):
        read_responses(tmp_path / "q.csv")


def test_sheets_with_the_same_columns_are_refused(tmp_path) -> None:
    with pd.ExcelWriter(tmp_path / "a.xlsx") as writer:
        for name in ("P01", "P02"):
            pd.DataFrame({"video": ["fear"], "answer": ["fear"]}).to_excel(writer, sheet_name=name, index=False)
    with pytest.raises(SourceError, match=r"sheets P01 and P02 have the same columns; expected a.xlsx#P02"):
        read_responses(tmp_path / "a.xlsx")
    assert len(read_responses(f"{tmp_path}/a.xlsx#P02").answers) == 1


def test_the_log_of_one_run_of_e_prime_is_refused(tmp_path) -> None:
    (tmp_path / "emo-1-1.txt").write_bytes("*** Header Start ***\r\nLevelName: Session\r\n".encode("utf-16"))
    with pytest.raises(SourceError, match="the log of one run of E-Prime; expected the text that E-DataAid or E-Merge"):
        read_responses(tmp_path / "emo-1-1.txt")


def test_export_of_the_own_survey_needs_its_key(tmp_path) -> None:
    rows = ["participant,video,position,response,first_response,changes,status,mode"]
    rows += [f"p-{i},{code},{j},{label},{label},0,finished,study" for i in (1, 2) for j, (code, label) in enumerate(
        zip(CODES, EMOTIONS, strict=True), start=1)]  # fmt: skip
    (tmp_path / "r.csv").write_text("\n".join(rows) + "\n")
    with pytest.raises(SourceError, match=r"the survey's answers do not contain the true emotions; expected --key"):
        read_responses(tmp_path / "r.csv")
    (tmp_path / "key.csv").write_text(KEY)
    assert read_responses(tmp_path / "r.csv", tmp_path / "key.csv").counts().sum() == 12
