import pickle
from pathlib import Path

import pandas as pd
import pytest
import yaml

from emovid.errors import InputError, SourceError
from emovid.responses.describe_columns import describe_columns
from emovid.responses.dialects.registry import DIALECTS
from emovid.responses.read import read_responses
from emovid.statistics.analyze import analyze
from tests.helpers.exports import CODES, COUNTS, EMOTIONS, EXPORTS, KEY, own, psychopy

HEAD = "participant,video,response,gender\n"
SIX = "happiness, surprise, anger, fear, disgust, sadness"
OTHERS = "or others by --labels or the map's labels"


@pytest.fixture
def read(tmp_path):
    """Read text as an export, with the text of a key and of a map."""

    def read(text: str | bytes, key: str = "", mapping: str = "", name: str = "x.csv", **how):
        for file, content in ((name, text), ("key.txt", key), ("map.yaml", mapping)):
            (tmp_path / file).write_bytes(content if isinstance(content, bytes) else content.encode())
        given = {"key": tmp_path / "key.txt" if key else None, "mapping": tmp_path / "map.yaml" if mapping else None}
        return read_responses(tmp_path / name, **given, **how)

    return read


@pytest.fixture
def refusal(read, tmp_path):
    """Return the message of the refusal, without the folder."""

    def refusal(*given, **how) -> str:
        with pytest.raises(SourceError) as error:
            read(*given, **how)
        assert isinstance(error.value, InputError)
        return str(error.value).replace(f"{tmp_path}/", "")

    return refusal


def reasons(found) -> list[tuple[int, str, str, str]]:
    return [(row.row, row.cell, row.value, row.reason) for row in found.rejected]


def test_codes_with_emotion_names_need_no_key(read) -> None:
    found = read(HEAD + "a,videos/Anger.mp4,angry,f\na,video_fear,Sad,f\nb,happiness 1,happy,m\n")
    assert found.answers["signalled"].tolist() == ["anger", "fear", "happiness"]
    assert found.answers["perceived"].tolist() == ["anger", "sadness", "happiness"]
    assert found.answers["video"].tolist() == ["anger", "video_fear", "happiness 1"]
    assert found.participants["gender"].to_dict() == {"a": "f", "b": "m"}
    assert found.sources[0].dialect == "long table"
    assert found.sources[0].participants == 2
    assert len(found.sources[0].sha256) == 64


def test_columns_with_emotion_names_need_no_key(read) -> None:
    found = read("id,age,Anger,Fear,fear of robots\n1,20,angry,sad,4\n2,30,fear,fear,2\n")
    assert found.answers["signalled"].tolist() == ["anger", "anger", "fear", "fear"]
    assert found.participants["age"].tolist() == ["20", "30"]


def test_file_with_a_column_of_signaled_emotions_needs_no_key(read) -> None:
    found = read("participant,video,true_emotion,response\n1,z8,anger,fear\n2,z8,anger,angry\n")
    assert found.answers[["video", "signalled"]].to_numpy().tolist() == [["z8", "anger"]] * 2


def test_rejected_answers_have_row_and_reason(read) -> None:
    rows = ["a,z8r4,happy,f", "a,z8r4,sad,f", "a,nope,sad,f", "a,k2m9,meh,f", "b,z8r4,,m", ",k2m9,fear,", "b,,fear,m"]
    text = HEAD + "\n".join([*rows, "b,k2m9", "b,k2m9,fear,m"]) + "\n"
    found = read(text, KEY, "repeats: first\n", max_rejected=1)
    assert reasons(found) == [
        (3, "response", "sad", "answered twice: the first counts"),
        (4, "video", "nope", f"unknown video; expected {', '.join(CODES)}"),
        (5, "response", "meh", f"not a label; expected {SIX}"),
        (6, "response", "", "no answer"),
        (7, "response", "fear", "no participant"),
        (8, "video", "", "no video"),
        (9, "", "b | k2m9", "ragged row: 2 cells where the header has 4"),
    ]
    assert found.answers[["participant", "perceived"]].to_numpy().tolist() == [["a", "happiness"], ["b", "fear"]]


def test_rejected_answer_does_not_block_a_later_one(read) -> None:
    found = read(HEAD + "a,anger,,f\na,anger,meh,f\na,anger,fear,f\n", max_rejected=1)
    assert found.answers["perceived"].tolist() == ["fear"]
    assert [row.row for row in found.rejected] == [2, 3]


def test_none_of_these_is_a_separate_row(read) -> None:
    found = read(HEAD + "a,anger,none of these,f\nb,anger,angry,m\n")
    others = tuple(label for label in EMOTIONS if label != "anger")
    assert found.labels == ("anger", *others, "none")
    assert found.counts()[:, 0].tolist() == [1, 0, 0, 0, 0, 0, 1]
    assert read(HEAD + "b,anger,angry,m\n").labels == ("anger", *others)
    assert read(HEAD + "b,anger,angry,m\n", labels=["anger", "fear", "none"]).labels == ("anger", "fear", "none")


def test_label_without_a_video_is_a_row_without_a_column(read) -> None:
    rows = "a,awe,sadness,f\na,fear,awe,f\nb,awe,awe,m\nb,fear,fear,m\n"
    labels = ["sadness", "awe", "surprise", "fear", "none"]
    found = read(HEAD + rows, labels=labels)
    assert (found.signalled, found.labels) == (("awe", "fear"), ("awe", "fear", "sadness", "surprise", "none"))
    assert found.counts().tolist() == [[1, 1], [0, 1], [1, 0], [0, 0], [0, 0]]
    results = analyze(found)
    assert {*results.recognition} == {*results.goodness_of_fit} == {"awe", "fear"}
    assert {*results.groups["gender"]["f"].recognition} == {"awe", "fear"}
    holm = [results.recognition[name].p_holm for name in ("awe", "fear")]
    assert holm == pytest.approx([2 * (1 - 0.8**2)] * 2)  # 1 of 2 hits at chance 1 / 5, over two videos only
    assert results.recognition["awe"].chance == 1 / 5  # it may still be an answer
    assert not any("missing" in warning or "no answers" in warning for warning in results.warnings)
    assert "no video shows sadness, surprise: rows of the matrix without a column" in results.warnings
    keyed = read(HEAD + "a,m1,sadness,f\n", "video_code,true_emotion\nm1,awe\nm2,fear\n", labels=labels)
    assert keyed.signalled == ("awe", "fear")  # the key has a video of fear, although it has no answers
    assert "fear: no answers to a video of it" in analyze(keyed).warnings


def test_labels_without_a_circumplex_position_are_reported(read) -> None:
    found = analyze(read(HEAD + "a,awe,fear,f\na,fear,awe,f\n", labels=["awe", "fear"]))
    said = (*found.warnings, *found.notes)
    assert (
        "awe: no known position on the circumplex, so there is no figure of it, and tests of valence, arousal and near "
        "neighbors leave them out"
    ) in said
    assert not any("circumplex" in line for line in analyze(read(HEAD + "a,fear,fear,f\n")).warnings)


def test_labels_argument_overrides_the_map(read) -> None:
    text = HEAD + "a,calm,Calm,f\na,tense,calm,f\n"
    assert read(text, mapping="labels: [calm, tense]\n").counts().tolist() == [[1, 1], [0, 0]]
    assert read(text, mapping="labels: [joy, fear]\n", labels=["tense", "calm"]).signalled == ("tense", "calm")


def test_map_defines_columns_answers_groups_and_exclusions(read) -> None:
    mapping = """
participant: Wer
videos: {Frage 1: z8r4, Frage 2: k2m9}
answers: {Freude: happiness, 2: surprise, x: }
groups: {gender: Geschlecht}
drop: {Geschlecht: [roboter, 7]}
"""
    text = "Wer;Frage 1;Frage 2;Geschlecht\nu;Freude;2.0;w\nv;x;Freude;m\nw;2;2;7\n"
    found = read(text, KEY, mapping)
    assert found.answers[["participant", "video", "perceived"]].to_numpy().tolist() == [
        ["u", "z8r4", "happiness"],
        ["u", "k2m9", "surprise"],
        ["v", "k2m9", "happiness"],
    ]
    assert found.participants["gender"].tolist() == ["w", "m"]
    assert found.dropped == {"Geschlecht = roboter": 0, "Geschlecht = 7": 1}
    assert reasons(found) == [(3, "Frage 1", "x", "no answer")]


@pytest.mark.parametrize("value", ["007", "1.50", "TRUE", "no", "0x10", "2026-01-01"])
def test_map_values_are_used_verbatim(read, value) -> None:
    text = f"who,video,response\n{value},fear,fear\nb,fear,{value}\n"
    found = read(text, mapping=f"participant: who\ndrop: {{who: [{value}]}}\nanswers: {{{value}: fear}}\n")
    assert found.answers[["participant", "perceived"]].to_numpy().tolist() == [["b", "fear"]]
    assert found.dropped == {f"who = {value}": 1}


def test_exclusion_rule_without_a_match_counts_zero(read, refusal) -> None:
    found = read(HEAD + "a,anger,angry,f\n", mapping="drop: {participant: [P07]}\n")
    assert found.dropped == {"participant = P07": 0}
    assert "participants left out: 0 participant = P07" in analyze(found).warnings
    message = refusal(HEAD + "a,anger,angry,f\n", mapping="drop: {participant: [b, A]}\n")
    assert message == "x.csv: no participant is left (1 participant = A); expected answers"


def test_a_participant_without_a_usable_answer_is_counted(read) -> None:
    found = read(HEAD + "a,anger,angry,f\nb,anger,meh,m\n", max_rejected=1)
    assert found.participants.index.tolist() == ["a"]
    assert found.dropped == {"no usable answer": 1}


def test_formulas_in_cells_are_read_as_data(read) -> None:
    found = read(HEAD + '=1+1,anger,angry,"=HYPERLINK(""x"")"\nb,anger,=fear,m\n')
    assert found.participants["gender"].to_dict() == {"=1+1": '=HYPERLINK("x")', "b": "m"}
    assert found.answers["perceived"].tolist() == ["anger", "fear"]


ORDERED = "participant,video,response,position\n"


@pytest.mark.parametrize(
    ("first", "second", "places"),
    [
        (["1", "2"], ["2", "1"], [1, 2, 2, 1]),
        (["0", "1"], ["1", "0"], [1, 2, 2, 1]),  # counted from 0
        (["7", "12"], ["12", "7"], [1, 2, 2, 1]),  # trial numbers, some of trials without a video
        (["999999999", "5"], ["5", "6"], [2, 1, 1, 2]),
        (["1.0", "2.0"], ["'2,0'", "'1,0'"], [1, 2, 2, 1]),
        (["3", "3"], ["1", "2"], [None, None, 1, 2]),  # of the first, the number of a list
        (["A", "A"], ["B", "B"], [None, None, None, None]),
        (["2", ""], ["1", "2"], [2, None, 1, 2]),
    ],
)
def test_positions_from_any_counter_become_ranks_from_1(read, first, second, places) -> None:
    rows = [
        f"{who},{video},fear,{place}\n".replace("'", '"')
        for who, order in (("a", first), ("b", second))
        for video, place in zip(("fear", "anger"), order, strict=True)
    ]
    found = read(ORDERED + "".join(rows)).answers["position"]
    assert [None if place is pd.NA else place for place in found] == places


def test_repeated_answer_keeps_known_positions(read) -> None:
    found = read(ORDERED + "a,fear,fear,1\na,fear,sad,1\na,anger,anger,2\n", mapping="repeats: first\n")
    assert found.answers["position"].tolist() == [1, 2]


@pytest.mark.parametrize("cells", ["0,1\n1,0", "1,2\n2,1", "1.0,2.0\n2,1"])
def test_positions_in_columns_may_count_from_0_and_have_decimals(read, cells) -> None:
    first, second = cells.split("\n")
    found = read(f"id,Anger,Fear,anger_position,fear_position\n1,anger,fear,{first}\n2,anger,fear,{second}\n")
    assert found.answers["position"].tolist() == [1, 2, 2, 1]  # first the answers to anger, then to fear


def test_decimal_commas_are_read_in_answers_groups_and_scores(read) -> None:
    text = "ResponseId;Finished;RecordedDate;Progress;Q_RecaptchaScore;age;Anger;Fear\n"
    rows = "1;True;2026;100,0;0,9;24,0;1,00;2,0\n2;True;2026;99,5;0,9;30;1;2\n3;True;2026;100;0,4;31;1;2\n"
    found = read(text + rows, mapping="answers: {1: anger, 2: fear}\n")
    assert found.participants["age"].to_dict() == {"1": "24"}
    assert found.answers["perceived"].tolist() == ["anger", "fear"]
    assert found.dropped == {"partial": 1, "bot": 1}


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_json_with_a_byte_order_mark_is_recognized(read, encoding) -> None:
    trials = '[{"trial_type": "x", "trial_index": 0, "subject": "a", "video": "fear", "response": "fear"}]'
    assert read(trials.encode(encoding)).sources[0].dialect == "jsPsych"


def test_without_a_participant_column_each_row_is_a_participant(read, tmp_path) -> None:
    text = "Anger,Fear\nangry,fear\nsad,fear\n"
    assert read(text).participants.index.tolist() == ["1", "2"]
    read(text, name="y.csv")
    found = read_responses([tmp_path / "x.csv", tmp_path / "y.csv"])
    assert found.participants.index.tolist() == ["x:1", "x:2", "y:1", "y:2"]


def test_requested_group_is_found_by_name_or_question_text(read) -> None:
    text = "id,Do you have a robotics background?,Anger,Fear\n1,yes,angry,fear\n2,no,sad,fear\n"
    assert read(text, groups=["robotics_background"]).participants["robotics_background"].tolist() == ["yes", "no"]


def test_other_files_in_a_folder_are_named_and_skipped(tmp_path) -> None:
    folder = tmp_path / "exports"
    folder.mkdir()
    for name, data in (own().files | {"notes.txt": b"call Ada\n", "empty.csv": b"", "x.xlsx": b"PK\x03\x04"}).items():
        (folder / name).write_bytes(data)
    (folder / "key.csv").write_text(KEY)
    found = read_responses(folder, folder / "key.csv")
    assert found.counts().tolist() == COUNTS
    assert [(Path(row.file).name, row.row) for row in found.rejected] == [
        ("empty.csv", 0), ("notes.txt", 0), ("own.csv", 50), ("own.csv", 51), ("x.xlsx", 0),
    ]  # fmt: skip
    assert [row.reason for row in found.rejected[2:4]] == ["left out: test run", "left out: partial"]
    assert found.rejected[4].reason == "not a workbook: Cannot detect file format"


def test_files_with_one_participant_each_are_combined(tmp_path) -> None:
    export = psychopy()
    for name, data in export.files.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "key.csv").write_text(KEY)
    (tmp_path / "map.yaml").write_text(export.map)
    found = read_responses(sorted(tmp_path.glob("P*")), tmp_path / "key.csv", tmp_path / "map.yaml")
    assert [source.participants for source in found.sources] == [1] * 8


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "x.csv: empty; expected a header and rows"),
        (HEAD, "x.csv:1: a header alone; expected a row for each participant or answer"),
        (HEAD + "a,b\n",
         "x.csv:1: ragged row: 2 cells where the header has 4; expected a row for each participant or answer"),
        (HEAD + "a,anger,1,f\nb,anger,2,f\n",
         f"x.csv:2: response: '1' not a label; expected {SIX}; the map's answers can give its label (2 cells or "
            "rows rejected); see emovid study columns"),
        (HEAD + "a,z8,fear,f\n",
         "x.csv:2: video: 'z8' unknown video; expected an emotion, or a key; see emovid study columns"),
        ("participant,video,response,status\na,anger,angry,test\n",
         "x.csv: no participant is left (1 test run); expected answers"),
        ("Timestamp,Which?,Which?\n1/2/2026 9:00,angry,sad\n",
         "x.csv:1: 2 columns ask one question ('Which?' ...), and none is named by an emotion; expected a key, or "
         "map.yaml: videos (or video and response, if each row is one answer)"),
        ("id,Anger,my anger\n1,sad,angry\n",
         "x.csv:1: columns 'Anger' and 'my anger' both name the video anger; expected one of them in map.yaml: "
         "videos"),
        ('[{"a":', "x.csv: not JSON; expected a list of trials"),
        ("[1, 2]", "x.csv: not a list of trials; expected one as jsPsych writes it"),
        ('"V1","V2"\n"ResponseID","x"\n', "x.csv:1: only headers; expected a row for each response"),
        ("trial_type,trial_index,stimulus,response\nvideo-button-response,0,anger.mp4,0\nvideo-button-response,0,fear.mp4,1\n",
         "x.csv:1: no column identifies its participants; expected map.yaml: participant"),
    ],
)  # fmt: skip
def test_unreadable_file_gives_a_one_line_message(refusal, text, message) -> None:
    assert refusal(text) == message


def test_unknown_format_message_lists_the_known_formats(refusal) -> None:
    message = refusal("name,town\nAda,London\n")
    assert message.startswith("x.csv:1: unknown format: columns 'name', 'town'; looked for the headers of Qualtr")
    assert message.endswith(
        "looked for the headers of " + ", ".join(dialect.name for dialect in DIALECTS[:-2]) + ", and for emotions in a "
        "column of videos or in the names of columns; expected a key, or map.yaml: video and response (a row for each "
        "answer) or videos (a column for each video)"
    )
    assert "\n" not in message


KEYS = [
    ("code;emotion\n", "key.txt: a header alone; expected a row for each video"),
    ("video,x\nz,anger\n", "key.txt:1: no column true_emotion; expected video_code,true_emotion"),
    ("video_cod,true_emotion\nz,anger\n",
     "key.txt:1: no column video_code (did you mean video_cod?); expected video_code,true_emotion"),
    ("video_code,true_emotion\nz,anger\nZ.mp4,fear\n",
     "key.txt:3: video_code: 'Z.mp4' is given twice; expected a code for each video"),
    ("video_code,true_emotion\n,anger\n", "key.txt:2: video_code: empty; expected a code for each video"),
    ("video_code,true_emotion\nz,angr\n",
     f"key.txt:2: true_emotion: 'angr' is not an emotion (did you mean anger?); expected {SIX}, {OTHERS}"),
    ("video_code,true_emotion\nz\n", "key.txt:2: ragged row: 1 cells where the header has 2; expected 2"),
    ("video_code,true_emotion\nz,none\n",
     f"key.txt:2: true_emotion: 'none' is not an emotion; expected {SIX}, {OTHERS}"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "message"), KEYS)
def test_invalid_key_is_refused(refusal, key, message) -> None:
    assert refusal(HEAD + "a,anger,angry,f\n", key) == message


KEYS_OF_MAP = "participant, video, response, truth, videos, answers, groups, drop, rows, repeats, labels"
MAPS = [
    (" \n", f"map.yaml: empty; expected some of {KEYS_OF_MAP}"),
    ("- a\n", f"map.yaml: not a map; expected some of {KEYS_OF_MAP}"),
    ("\nparticipnt: a\n", "map.yaml:2: participnt: unknown key (did you mean participant?)"),
    ("videos: 3\n", "map.yaml:1: videos: '3': expected column: code, or a list of codes"),
    ("videos: [[a]]\n", "map.yaml:1: videos.0: no code; expected the code of a video"),
    ("videos:\n  video:\n", "map.yaml:2: videos.video: no code; expected the code of a video"),
    ("videos: [z8r4, '']\n", "map.yaml:1: videos.1: no code; expected the code of a video"),
    ("video: video\nvideos: {Q: a}\n",
     "map.yaml:1: video: given together with videos; expected video for a row for each answer, "
     "or videos for a column for each"),
    ("video: video\nresponse: video\n", "map.yaml:2: response: also the column of videos; expected another column"),
    ("video: video\ntruth: video\n", "map.yaml:2: truth: also the column of videos; expected another column"),
    ("video: Clip\n", "x.csv:1: Clip: no such column; expected the one of the map's video"),
    ("response: respons\n",
     "x.csv:1: respons: no such column (did you mean response?); expected the one of the map's response"),
    ("drop:\n  gender:\n", "map.yaml:2: drop.gender: empty: expected a list"),
    ("answers:\n  1: {a: b}\n", "map.yaml:2: answers.1: a group of keys: expected text"),
    ("labels: joy\n", "map.yaml:1: labels: 'joy': expected a list"),
    ("labels: [joy]\n", "map.yaml:1: labels: 1 given; expected 2 to 12"),
    ("answers: {1: x}\n", f"map.yaml:1: answers.1: 'x' is not a label; expected {SIX} or none"),
    ("participant: [\n", "map.yaml:2: not YAML: expected the node content, but found '<stream end>'"),
    ("participant: persn\n",
     "x.csv:1: persn: no such column (did you mean person?); expected the one of the map's participant"),
    ("videos: {Videos: z8r4}\n",
     "x.csv:1: Videos: no such column (did you mean video?); expected the one of the map's videos"),
    ("videos: [z8r4, k2m9]\n", "x.csv:1: videos: 1 columns hold answers; the map lists 2 codes"),
    ("groups: {g: gendr}\n",
     "map.yaml:1: groups.g: no file has the column 'gendr' (did you mean gender?); expected a column of the export"),
    ("drop: {stat: x}\n",
     "map.yaml:1: drop.stat: no file has the column 'stat'; expected a column of the export"),
    ("rows: {keep: {phas: main}}\n",
     "map.yaml:1: rows.keep.phas: no file has the column 'phas'; expected a column of the export"),
    ("rows: {kep: {gender: f}}\n", "map.yaml:1: rows.kep: unknown key (did you mean rows.keep?)"),
    ("repeats: frst\n",
     "map.yaml:1: repeats: 'frst': expected one of first, last, all, null (did you mean first?)"),
]  # fmt: skip


@pytest.mark.parametrize(("mapping", "message"), MAPS)
def test_invalid_map_is_refused(refusal, mapping, message) -> None:
    assert refusal("person,video,response,gender\na,m1,angry,f\n", "", mapping) == message


def test_previews_and_test_runs_are_dropped_and_counted(read) -> None:
    head = ["ResponseId,Status,Finished,Progress,RecordedDate,Q_RecaptchaScore,Anger,Fear"]
    kinds = ["IP Address,True,100", "Spam,True,100", "Survey Test,True,100", "Survey Preview,False,3", "0,1,100"]
    rows = [f"R{i},{kind},2026,0.9,angry,fear" for i, kind in enumerate(kinds)]
    found = read("\n".join([*head, *rows, "R9,IP Address,True,100,2026,0.2,angry,fear"]))
    assert found.participants.index.tolist() == ["R0", "R4"]
    assert found.dropped == {"preview": 1, "test run": 1, "spam": 1, "bot": 1}


def test_group_that_changes_within_a_participant_is_refused(refusal) -> None:
    message = refusal(HEAD + "a,anger,angry,f\na,fear,fear,m\n", groups=["gender"])
    assert message == "x.csv:1: gender: changes within a participant; expected one value for each"


def test_unknown_group_is_refused(refusal) -> None:
    message = refusal(HEAD + "a,anger,angry,f\n", groups=["gendre"])
    assert message == "--by: gendre: no file has this group (did you mean gender?); expected gender"


def test_table_of_test_runs_only_is_refused(refusal) -> None:
    text = ORDERED.strip() + ",status\na,anger,angry,1,test\n"
    assert refusal(text) == "x.csv: no participant is left (1 test run); expected answers"


def test_psiturk_questions_without_trials_are_refused(refusal) -> None:
    assert refusal("w:A,gender,Female\nv:B,gender,Male\n") == "x.csv: no answers found; expected some"


def test_jspsych_answers_may_be_in_a_separate_column(read) -> None:
    text = "trial_type,trial_index,subject,video,answer\nx,0,a,fear,sad\nx,1,a,anger,angry\n"
    found = read(text)
    assert found.sources[0].dialect == "jsPsych"
    assert found.answers[["perceived", "position"]].to_numpy().tolist() == [["sadness", 1], ["anger", 2]]


def test_otree_table_without_page_columns_is_read(read) -> None:
    text = "participant.code,subsession.round_number,player.video,player.response\nab,2,fear,sad\nab,1,anger,angry\n"
    found = read(text)
    assert found.sources[0].dialect == "oTree"
    assert found.answers[["perceived", "position"]].to_numpy().tolist() == [["sadness", 2], ["anger", 1]]


def test_question_about_an_emotion_is_not_read_as_a_video(read) -> None:
    found = read("id,Anger,fear of robots\n1,angry,4\n")
    assert found.answers["signalled"].tolist() == ["anger"]
    assert found.participants["fear of robots"].tolist() == ["4"]


def test_errors_survive_pickling() -> None:
    error = SourceError("x.csv", "empty; expected rows", 3, "video")
    again = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own bytes
    assert (str(again), again.where, again.line, again.key) == (str(error), "x.csv", 3, "video")


def test_unreadable_folder_gives_a_one_line_message(tmp_path, monkeypatch) -> None:
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "rglob", refuse)
    with pytest.raises(SourceError) as error:
        read_responses(tmp_path)
    assert str(error.value) == f"{tmp_path}: cannot be read: permission denied"


def test_ambiguous_column_name_in_a_map_is_refused(refusal, read) -> None:
    text = "who,Which?,Which?,Say!\na,angry,sad,fear\n"
    message = refusal(text, KEY, "videos: {'Which?': z8r4, 'Say!': k2m9}\n")
    assert message == "x.csv:1: Which?: 2 columns have this name; expected one: list the codes in their order"
    found = read(text, KEY, "videos: {SAY: k2m9}\n")  # in every spelling
    assert found.answers[["video", "perceived"]].to_numpy().tolist() == [["k2m9", "fear"]]


def test_video_with_two_true_emotions_is_unknown(refusal) -> None:
    text = "participant,video,true_emotion,response\n1,z8,anger,fear\n2,z8,fear,angry\n"
    assert "'z8' unknown video; expected an emotion, or a key" in refusal(text)


def test_missing_files_are_reported(tmp_path) -> None:
    with pytest.raises(SourceError, match=r"no\.csv: cannot be read: no such file"):
        read_responses(tmp_path / "no.csv")
    with pytest.raises(SourceError, match="no file here"):
        read_responses(tmp_path)


def test_missing_key_is_reported_although_test_runs_were_excluded(tmp_path) -> None:
    rows = "participant,video,response,status\n1,z8r4,fear,complete\n2,z8r4,fear,test\n"
    (tmp_path / "own.csv").write_text(rows)
    with pytest.raises(SourceError, match=r"own.csv:2: video: 'z8r4' unknown video; expected an emotion, or a key"):
        read_responses(tmp_path / "own.csv")


def test_a_folder_is_described_by_its_first_export(tmp_path) -> None:
    (tmp_path / "a.txt").write_text("no table\n")
    with pytest.raises(SourceError, match="no file here is an export"):
        describe_columns(tmp_path)
    (tmp_path / "b.csv").write_text("participant,video,response\n1,fear,fear\n")
    found = describe_columns(tmp_path)
    assert (found.file, found.dialect) == (str(tmp_path / "b.csv"), "long table")


def test_columns_are_described_with_a_proposed_map(tmp_path) -> None:
    file = tmp_path / "x.csv"
    file.write_text(
        "Timestamp,Who are you?,Which?,Which?2\n1/2/2026 9:00,Ada,angry,traurig\n1/3/2026 9:00,Bob,sad,fear\n"
    )
    found = describe_columns(file)
    assert found.dialect == "Google Forms"
    assert "2 columns ask one question" in found.problem
    assert [(c.name, c.role) for c in found.columns] == [
        ("Timestamp", ""), ("Who are you?", ""), ("Which?", "answer?"), ("Which?2", "answer?"),
    ]  # fmt: skip
    assert found.columns[3].examples == ("traurig", "fear")
    edited = found.map_yaml.replace("Which?: ''", "Which?: anger").replace("Which?2: ''", "Which?2: fear")
    (tmp_path / "map.yaml").write_text(edited.replace("traurig:", "traurig: sadness"))
    read = read_responses(file, mapping=tmp_path / "map.yaml")
    assert read.answers["perceived"].tolist() == ["anger", "sadness", "sadness", "fear"]


@pytest.mark.parametrize("make", EXPORTS, ids=lambda make: make.__name__)
def test_proposed_map_reads_the_export_to_the_same_result(make, tmp_path) -> None:
    export = make()
    (tmp_path / "exports").mkdir()
    for name, data in export.files.items():
        (tmp_path / "exports" / name).write_bytes(data)
    (tmp_path / "key.csv").write_text(KEY)
    (tmp_path / "map.yaml").write_text(export.map or "labels:\n")
    paths = (tmp_path / "exports", tmp_path / "key.csv", tmp_path / "map.yaml")
    before, offered = read_responses(*paths), describe_columns(*paths).map_yaml
    said = yaml.safe_load(offered) | {"answers": (yaml.safe_load(export.map or "{}") or {}).get("answers")}
    paths[2].write_text(yaml.safe_dump(said, sort_keys=False))
    after = read_responses(*paths)
    assert after.answers.equals(before.answers)
    assert after.participants.equals(before.participants)


def test_column_that_differs_between_videos_is_not_a_group(read) -> None:
    text = "id,gender,Anger,Fear,fear of robots,anger_position,fear_position,fear time\n1,f,angry,fear,4,1,2,3\n"
    assert list(read(text).participants) == ["gender", "fear of robots"]
    coded = "id,gender,z8r4,k2m9,z8r4_loops,Loops k2m9\n1,f,angry,fear,4,5\n"
    assert list(read(coded, KEY).participants) == ["gender"]


def test_paths_may_be_strings(tmp_path) -> None:
    (tmp_path / "own.csv").write_bytes(own().files["own.csv"])
    (tmp_path / "key.csv").write_text(KEY)
    (tmp_path / "map.yaml").write_text("labels:\n")
    found = read_responses([f"{tmp_path}/own.csv"], f"{tmp_path}/key.csv", f"{tmp_path}/map.yaml")
    assert found.counts().tolist() == COUNTS


@pytest.mark.parametrize("first", ["the same", "happiness"])
def test_survey_without_a_key_is_refused_whatever_its_first_answers(read, first) -> None:
    """Answers on which all participants agree, and first answers that are all one label, looked like a key."""
    answers = [(person, code, EMOTIONS[i]) for person in ("P1", "P2") for i, code in enumerate(CODES)]
    rows = [f"{who},{code},1,{said},{said if first == 'the same' else first}\n" for who, code, said in answers]
    text = "participant,video,position,response,first_response\n" + "".join(rows)
    with pytest.raises(SourceError, match="do not contain the true emotions; expected --key"):
        read(text)
    assert read(text, KEY).counts().sum() == 12


def test_first_answers_are_analyzed_where_a_map_names_them(read) -> None:
    rows = [f"P{i},{next(iter(CODES))},1,fear,anger\n" for i in range(3)]
    text = "participant,video,position,response,first_response\n" + "".join(rows)
    found = read(text, KEY, "response: first_response\n")
    assert set(found.answers["perceived"]) == {"anger"}


def test_described_columns_of_a_readable_export(tmp_path) -> None:
    (tmp_path / "own.csv").write_bytes(own().files["own.csv"])
    (tmp_path / "key.csv").write_text(KEY)
    found = describe_columns(tmp_path / "own.csv", tmp_path / "key.csv")
    assert (found.dialect, found.problem) == ("emovid survey", "")
    assert [column.role for column in found.columns] == ["participant", "video", "order", "answer", "group", ""]
    (tmp_path / "map.yaml").write_text(found.map_yaml)
    again = read_responses(tmp_path / "own.csv", tmp_path / "key.csv", tmp_path / "map.yaml")
    assert again.counts().tolist() == COUNTS


def test_a_proposed_map_names_the_labels_that_are_left_to_decide(tmp_path) -> None:
    (tmp_path / "x.csv").write_text("participant,video,response\n1,fear,2\n2,fear,1\n")
    offered = describe_columns(tmp_path / "x.csv").map_yaml
    assert offered.startswith("# To decide: the label of each text under answers; a text without one is a missing answ")
    (tmp_path / "map.yaml").write_text(offered.replace("'1':", "'1': fear").replace("'2':", "'2': anger"))
    found = read_responses(tmp_path / "x.csv", mapping=tmp_path / "map.yaml")
    assert found.answers["perceived"].tolist() == ["anger", "fear"]
