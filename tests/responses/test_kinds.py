"""Exports that could silently be counted wrong: each is analyzed correctly or refused."""

import json
from pathlib import Path

import pytest

from emovid.errors import InputError, SourceError
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses, Synonym
from emovid.responses.results_files import WRITTEN, list_of_files
from emovid.workflows.analysis import _remove_former
from tests.responses.test_cases import matrix

KEY = "video_code,true_emotion\nz8r4,happiness\nk2m9,fear\np5t1,anger\n"
GIVEN = {
    "s1": {"z8r4": "happiness", "k2m9": "surprise", "p5t1": "disgust"},
    "s2": {"z8r4": "surprise", "k2m9": "fear", "p5t1": "anger"},
    "s3": {"z8r4": "happiness", "k2m9": "sadness", "p5t1": "disgust"},
}
TRUE = {"z8r4": "happiness", "k2m9": "fear", "p5t1": "anger"}
RIGHT = {
    "anger": {"anger": 1, "disgust": 2},
    "fear": {"fear": 1, "sadness": 1, "surprise": 1},
    "happiness": {"happiness": 2, "surprise": 1},
}
NUMBERS = {"happiness": "1", "surprise": "2", "anger": "3", "fear": "4", "disgust": "5", "sadness": "6"}
ANSWERS = "answers: {1: happiness, 2: surprise, 3: anger, 4: fear, 5: disgust, 6: sadness}\n"


def long(head: str, row, people=GIVEN) -> str:
    """Return a table with one row for each participant and video, with its cells from `row`."""
    return head + "\n" + "".join(row(p, c, label) + "\n" for p, given in people.items() for c, label in given.items())


@pytest.fixture
def read(tmp_path):
    """Read files by their names, with the key and the text of a map."""

    def read(files: str | dict[str, str], mapping: str = "", key: str = KEY, **how) -> Responses:
        folder = tmp_path / "data"
        files = {"x.csv": files} if isinstance(files, str) else files
        for name, text in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
        (tmp_path / "key.csv").write_text(key)
        (tmp_path / "map.yaml").write_text(mapping)
        source = folder if len(files) > 1 else folder / next(iter(files))
        paths = [tmp_path / name if text else None for name, text in (("key.csv", key), ("map.yaml", mapping))]
        return read_responses(source, *paths, **how)

    return read


@pytest.fixture
def refusal(read, tmp_path):
    def refusal(*given, **how) -> str:
        with pytest.raises(SourceError) as error:
            read(*given, **how)
        return str(error.value).replace(f"{tmp_path}/", "")

    return refusal


# 1. The column of the true emotion


@pytest.mark.parametrize("name", ["emotion", "label", "answer", "response", "condition", "category", "Angezeigt"])
@pytest.mark.parametrize("spell", [str, str.upper, {"happiness": "joy", "fear": "afraid", "anger": "angry"}.get])
def test_column_of_true_emotions_is_never_read_as_answers(read, name, spell) -> None:
    text = long(f"participant,stimulus,{name},felt", lambda p, c, label: f"{p},{c}.mp4,{spell(TRUE[c])},{label}")
    assert matrix(read(text)) == RIGHT


def test_column_with_one_label_per_video_is_not_read_as_answers(read) -> None:
    other = {"z8r4": "fear", "k2m9": "fear", "p5t1": "disgust"}
    text = long("participant,stimulus,response,felt", lambda p, c, label: f"{p},{c}.mp4,{other[c]},{label}")
    assert matrix(read(text)) == RIGHT


def test_column_that_equals_the_key_is_refused_unless_the_map_names_it(read, refusal) -> None:
    text = long("participant,stimulus,answer,rt", lambda p, c, _: f"{p},{c}.mp4,{TRUE[c]},1.{len(c)}")
    message = refusal(text)
    assert "column 'answer' agrees with the key on all 9 rows, so it seems to hold the true emotions" in message
    assert "expected map.yaml: response: the column of answers (answer, if all answers are right)" in message
    found = read(text, "response: answer\n")
    assert matrix(found) == {emotion: {emotion: 3} for emotion in sorted(TRUE.values())}
    (warning,) = found.warnings
    assert "'answer', which the map names for the answers, agrees with the key on all 9 rows" in warning


def test_two_possible_answer_columns_are_refused_by_name(read, refusal) -> None:
    guess = {"happiness": "fear", "surprise": "anger"}
    text = long("participant,video,response,second", lambda p, c, x: f"{p},{c},{x},{guess.get(x, 'sadness')}")
    assert "answers in 'response' and 'second'; expected map.yaml: response: one of them" in refusal(text)
    assert matrix(read(text, "response: response\n")) == RIGHT


def test_participant_column_is_not_read_as_answers(read) -> None:
    mood = {"s1": "happy", "s2": "sad", "s3": "happy"}
    text = long("participant,video,mood,felt", lambda p, c, label: f"{p},{c},{mood[p]},{label}")
    assert matrix(read(text)) == RIGHT


def test_true_emotions_in_video_columns_are_not_read_as_answers(read, refusal) -> None:
    head = "id," + ",".join(f"{c}_shown,{c}_felt" for c in TRUE) + "\n"
    rows = [[p, *(cell for c in TRUE for cell in (TRUE[c], given[c]))] for p, given in GIVEN.items()]
    assert matrix(read(head + "\n".join(map(",".join, rows)))) == RIGHT
    coded = [[p, *(cell for c in TRUE for cell in (TRUE[c], NUMBERS[given[c]]))] for p, given in GIVEN.items()]
    assert "agree with the key in all 9 answers" in refusal(head + "\n".join(map(",".join, coded)))


def test_truth_column_of_the_map_replaces_the_key(read) -> None:
    text = long("participant,video,intention,felt", lambda p, c, label: f"{p},{c}.mp4,{TRUE[c]},{label}")
    assert matrix(read(text, "truth: intention\n", key="")) == RIGHT
    assert matrix(read(text, key="")) == RIGHT  # one label for each video can only be the true emotion


# 2. Rows that are not answers of the study


@pytest.mark.parametrize(
    ("name", "practice", "main"),
    [
        ("phase", "practice", "test"),
        ("block_name", "Training 1", "Main"),
        ("is_practice", "TRUE", "FALSE"),
        ("Block", "Übungsblock", "Hauptblock"),
        ("trial type", "attention check", "video"),
        ("section", "instructions", "task"),
    ],
)
def test_practice_instruction_and_check_rows_are_excluded_and_counted(read, name, practice, main) -> None:
    text = long(f"participant,video,felt,{name}", lambda p, c, label: f"{p},{c},{label},{main}")
    text += "".join(f"{p},k2m9,disgust,{practice}\n" for p in GIVEN)
    found = read(text)
    assert matrix(found) == RIGHT
    assert list(found.left_out.values()) == [3]


def test_training_that_varies_between_participants_is_a_group(read) -> None:
    groups = {"s1": "training", "s2": "control", "s3": "training"}
    text = long("participant,video,felt,condition", lambda p, c, label: f"{p},{c},{label},{groups[p]}")
    found = read(text)
    assert (matrix(found), found.left_out) == (RIGHT, {})
    assert found.participants["condition"].to_dict() == groups


def test_map_includes_or_excludes_rows(read, refusal) -> None:
    text = long("participant,video,felt,part", lambda p, c, label: f"{p},{c},{label},B")
    text += "".join(f"{p},k2m9,disgust,A\n" for p in GIVEN)
    for rows in ("keep: {part: B}", "leave_out: {part: [A]}"):
        found = read(text, f"rows: {{{rows}}}\n")
        assert matrix(found) == RIGHT
        assert list(found.left_out.values()) == [3]
    assert "3 of 12 answers repeat" in refusal(text)
    message = refusal(text, "drop: {part: [A]}\n")
    assert "drop leaves out participants; expected rows: {leave_out: {part: [A]}}" in message


# 3. PsychoPy: one column of answers for each routine

PSYCHOPY = ",participant,date,expName,psychopyVersion"


def test_answers_of_two_psychopy_routines_are_combined(read) -> None:
    head = f"videoFile,block_a.thisN,block_b.thisN,key_resp.keys,key_resp_2.keys{PSYCHOPY}"

    def row(p: str, c: str, label: str) -> str:
        n, k = list(TRUE).index(c), NUMBERS[label]
        return f"stim/{c}.mp4," + (f"{n},,{k},," if n < 2 else f",0,,{k},") + f"{p},2026,emo,2026.1"

    found = read(long(head, row), ANSWERS)
    assert matrix(found) == RIGHT
    assert found.answers.groupby("participant")["position"].apply(list).tolist() == [[1, 2, 3]] * 3


def test_key_press_that_starts_a_trial_is_not_an_answer(read, refusal) -> None:
    head = f"videoFile,trials.thisN,start.keys,choice.keys,sure.keys{PSYCHOPY}"

    def row(p: str, c: str, label: str, sure: str = "x") -> str:
        return f"{c}.mp4,{list(TRUE).index(c)},space,{NUMBERS[label]},{sure},{p},2026,emo,2026.1"

    assert matrix(read(long(head, row), ANSWERS)) == RIGHT
    both = long(head, lambda p, c, label: row(p, c, label, sure=str(len(p + c) % 3 + list(TRUE).index(c) + 1)))
    assert "answers in 'choice.keys' and 'sure.keys'; expected map.yaml: response: one of them" in refusal(
        both, ANSWERS
    )
    assert matrix(read(both, f"{ANSWERS}response: choice.keys\n")) == RIGHT


# 4. One participant for each file


def files_of(head: str, name) -> dict[str, str]:
    return {name(p): long(head, lambda _, c, label: f"{c}.mp4,{label}", {p: given}) for p, given in GIVEN.items()}


def test_files_with_one_name_in_several_folders_are_several_participants(read) -> None:
    found = read(files_of("stimulus,felt", lambda p: f"{p}/session/data.csv"))
    assert matrix(found) == RIGHT
    assert found.participants.index.tolist() == ["s1/session/data", "s2/session/data", "s3/session/data"]


def test_map_can_define_each_file_as_a_participant(read, refusal) -> None:
    texts = files_of("stimulus,felt", lambda p: f"{p}.csv")
    texts = {name: f"{text}z8r4.mp4,happiness\n" for name, text in texts.items()}
    assert "participant: each file if a file is one person's" in refusal(texts)
    found = read(texts, "participant: each file\nrepeats: last\n")
    assert (len(found.participants), len(found.answers)) == (3, 9)


# 5. Repeated presentations


def test_many_repeats_are_refused_unless_the_map_chooses(read, refusal) -> None:
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},sadness\n{p},{c},{x}")
    assert "9 of 18 answers repeat" in refusal(text)
    assert "repeats: first, last or all" in refusal(text)
    assert matrix(read(text, "repeats: last\n")) == RIGHT
    first = read(text, "repeats: first\n")
    assert (first.repeats, first.answers["perceived"].unique().tolist()) == ("first", ["sadness"])
    assert len(read(text, "repeats: all\n").answers) == 18


def test_first_answer_is_chosen_by_position_not_by_row(read) -> None:
    text = long("participant,video,felt,trial", lambda p, c, x: f"{p},{c},sadness,{10 + len(x)}\n{p},{c},{x},{len(x)}")
    found = read(text, "repeats: first\n")
    assert len(found.answers) == 9


# 6. Many unusable rows


def test_many_unusable_rows_are_refused_with_grouped_reasons(refusal, read) -> None:
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{x}") + "s1,curious,fear\n" * 4 + "s2,z8r4,meh\n"
    message = refusal(text)
    assert "5 of 14 answers cannot be used (4 rows: 'curious' unknown video" in message
    assert "1 row: 'meh' not a label" in message
    assert "--max-rejected" in message
    assert matrix(read(text, max_rejected=0.5)) == RIGHT


def test_many_participants_without_usable_answers_are_refused(refusal, read) -> None:
    people = {f"p{i}": list(GIVEN.values())[i % 3] for i in range(20)}
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{x}", people)
    text += "".join(f"q{i},k2m9,?{i}\n" for i in range(3))
    message = refusal(text)
    assert "no answer of 3 of 23 participants can be used" in message
    assert read(text, max_rejected=0.2).dropped == {"no usable answer": 3}


def test_missing_answers_do_not_count_as_unusable_rows(read) -> None:
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{x}")
    text += "".join(f"s{i},{c},{missing}\n" for i in (4, 5) for c, missing in zip(TRUE, ("", "NA", "-99"), strict=True))
    found = read(text)
    assert matrix(found) == RIGHT
    assert {row.reason for row in found.rejected} == {"no answer"}


# 7. Synonyms


def test_synonyms_are_listed_with_their_counts(read) -> None:
    words = {"happiness": "Joy", "surprise": "SURPRISE", "disgust": "disgusted", "sadness": "sadness "}
    found = read(long("participant,video,felt", lambda p, c, x: f"{p},{c},{words.get(x, x)}"))
    assert matrix(found) == RIGHT
    assert found.synonyms == (Synonym("Joy", "happiness", 2), Synonym("disgusted", "disgust", 2))
    glad = read(long("participant,video,felt", lambda p, c, x: f"{p},{c},{'glad' if x == 'happiness' else x}"))
    assert glad.synonyms == (Synonym("glad", "happiness", 2),)


def test_answer_texts_of_the_map_are_marked(read) -> None:
    found = read(long("participant,video,felt", lambda p, c, x: f"{p},{c},{NUMBERS[x]}"), ANSWERS)
    assert found.synonyms[0] == Synonym("1", "happiness", 2, by_map=True)


def test_python_none_is_a_missing_answer_but_a_chosen_none_is_an_answer(read) -> None:
    def text(spell) -> str:
        return long("participant,video,felt", lambda p, c, x: f"{p},{c},{'None' if x == 'sadness' else spell(x)}")

    missing, answer = read(text(str)), read(text(str.title))
    assert "none" not in missing.labels
    assert [row.value for row in missing.rejected] == ["None"]
    assert matrix(answer)["fear"] == {"fear": 1, "none": 1, "surprise": 1}
    assert matrix(read(text(str), labels=["happiness", "fear", "anger", "surprise", "disgust", "none"])) == matrix(
        answer
    )


# 8. Spelling and bytes


@pytest.mark.parametrize(
    "name",
    ["video-{}", "V{}", "stimuli/{}_final.mp4?x=1", "https://x.org/a/{}.webm#t=2", "vid_{}", "C:\\\\v\\\\{}.MP4"],
)
def test_video_code_is_found_within_a_longer_name(read, name) -> None:
    text = long("participant,video,felt", lambda p, c, x: f"{p},{name.format(c)},{x}")
    assert matrix(read(text)) == RIGHT
    head = "id," + ",".join(name.format(c) for c in TRUE) + "\n"
    wide = head + "\n".join(",".join([p, *(given[c] for c in TRUE)]) for p, given in GIVEN.items())
    assert matrix(read(wide)) == RIGHT


def test_name_with_two_video_codes_is_not_a_video(refusal) -> None:
    assert "unknown video" in refusal(long("participant,video,felt", lambda p, c, x: f"{p},{c} z8r4 k2m9,{x}"))


def test_exact_column_name_takes_precedence_over_other_case(read) -> None:
    text = long("participant,Felt,video,felt", lambda p, c, x: f"{p},fear,{c},{x}")
    assert matrix(read(text, "response: felt\n")) == RIGHT


@pytest.mark.parametrize("ids", ["1.14E+11", "1,14e+11", "1.2345E+05"])
def test_ids_shortened_by_a_spreadsheet_are_refused(refusal, ids) -> None:
    text = long("participant;video;felt", lambda p, c, x: f"{ids};{c};{x}")
    assert "a spreadsheet has shortened the ids" in refusal(text)


# 9. Pilot and simulated answers


def test_pilot_data_are_excluded_unless_requested(read, refusal) -> None:
    text = long("participant,video,position,response,mode", lambda p, c, x: f"{p},{c},1,{x},pilot")
    assert "no participant is left (3 pilot)" in refusal(text)
    assert matrix(read(text, include_pilots=True)) == RIGHT


def test_answers_of_simulated_participants_are_recognized(read) -> None:
    text = long("participant,video,response,mode", lambda p, c, x: f"{p},{c},{x},simulated")
    assert read(text).simulated
    assert not read(long("participant,video,response", lambda p, c, x: f"{p},{c},{x}")).simulated


# More forms of each kind


def test_choices_in_a_different_order_in_each_row_give_numbers_no_label(refusal) -> None:
    def shown(p: str, c: str) -> list[str]:
        start = (list(TRUE).index(c) + len(p) + int(p[1])) % 6
        labels = list(NUMBERS)
        return labels[start:] + labels[:start]

    def row(p: str, c: str, label: str, mark: str) -> str:
        return f'{p},{c},{shown(p, c).index(label) + 1},"{mark.join(shown(p, c))}"'

    for mark in (",", "|", ", "):
        text = long("participant,video,pressed,choices", lambda p, c, x, mark=mark: row(p, c, x, mark))
        assert "column 'choices' shows the choices in different orders" in refusal(text, ANSWERS)
    head = "participant,video,pressed," + ",".join(f"option{i}" for i in range(1, 7))
    text = long(head, lambda p, c, x: f"{p},{c},{shown(p, c).index(x) + 1},{','.join(shown(p, c))}")
    assert "column 'option1' shows the choices in different orders" in refusal(text, f"{ANSWERS}response: pressed\n")


def test_choices_in_one_order_leave_numbers_their_labels(read) -> None:
    text = long("participant,video,pressed,choices", lambda p, c, x: f"{p},{c},{NUMBERS[x]},{'|'.join(NUMBERS)}")
    assert matrix(read(text, ANSWERS)) == RIGHT


def test_a_list_of_codes_does_not_fit_columns_whose_videos_differ_between_participants(read, refusal) -> None:
    orders = {p: list(TRUE)[i:] + list(TRUE)[:i] for i, p in enumerate(GIVEN)}

    def text(shown: dict[str, list[str]]) -> str:
        rows = (f"{p},{'|'.join(shown[p])},{','.join(given[c] for c in shown[p])}\n" for p, given in GIVEN.items())
        return "id,order,answer_1,answer_2,answer_3\n" + "".join(rows)

    message = refusal(text(orders), "videos: [z8r4, k2m9, p5t1]\n")
    assert "column 'order' shows that the videos of a column differ between participants" in message
    assert matrix(read(text({p: list(TRUE) for p in GIVEN}), "videos: [z8r4, k2m9, p5t1]\n")) == RIGHT


@pytest.mark.parametrize(
    ("head", "practice", "main"),
    [
        ("participant,video,réponse,bloc", "entraînement", "principal"),
        ("participante,video,respuesta,fase", "práctica", "experimento"),
        ("参加者,video,answer,ブロック", "練習", "本番"),
        ("被试,video,answer,阶段", "练习阶段", "正式"),
        ("участник,video,answer,блок", "тренировка", "основной"),
        ("deelnemer;video;antwoord;fase", "oefening", "test"),
        ("uczestnik;video;answer;blok", "ćwiczenie", "główny"),
        ("VP;video;Antwort;Teil", "Übung", "Haupt"),
        ("participant,video,answer,isPractice", "True", "False"),
        ("participant,video,answer,trial_kind", "prac", "exp"),
    ],
)
def test_practice_is_known_in_many_languages(read, head, practice, main) -> None:
    mark = ";" if ";" in head else ","
    text = long(head, lambda p, c, label: mark.join((p, c, label, main)))
    found = read(text + "".join(mark.join((p, "z8r4", "fear", practice)) + "\n" for p in GIVEN))
    assert (matrix(found), found.left_out) == (RIGHT, {"practice": 3})


@pytest.mark.parametrize(
    ("name", "bad", "good", "reason"),
    [
        ("excluded", "yes", "no", "excluded"),
        ("deleted", "1", "0", "excluded"),
        ("valid", "0", "1", "not valid"),
        ("consent", "no", "yes", "no consent"),
        ("attention_check", "failed", "passed", "failed check"),
    ],
)
def test_a_column_can_say_that_rows_do_not_count(read, name, bad, good, reason) -> None:
    text = long(f"participant,video,felt,{name}", lambda p, c, label: f"{p},{c},{label},{good}")
    found = read(text + "".join(f"x,{c},fear,{bad}\n" for c in TRUE))
    assert (matrix(found), found.left_out) == (RIGHT, {reason: 3})
    head = f"id,{name},{','.join(TRUE)}\n"
    wide = "".join(f"{p},{good},{','.join(given.values())}\n" for p, given in GIVEN.items())
    found = read(f"{head}{wide}x,{bad},fear,fear,fear\n")
    assert (matrix(found), found.left_out) == (RIGHT, {reason: 1})


@pytest.mark.parametrize("status", ["Testlauf", "abgebrochen", "excluded", "Vorschau"])
def test_a_status_in_words_leaves_participants_out(read, status) -> None:
    text = long("participant,video,felt,Status", lambda p, c, label: f"{p},{c},{label},fertig")
    found = read(text + "".join(f"x,{c},fear,{status}\n" for c in TRUE))
    assert (matrix(found), sum(found.dropped.values())) == (RIGHT, 1)


def test_answers_in_the_lists_of_clicked_names_are_read_and_practice_loops_are_not(read) -> None:
    head = f"videoFile,trials.thisN,practice_trials.thisN,choice.clicked_name,slider.response{PSYCHOPY}"
    text = long(head, lambda p, c, label: f"v/{c}.mp4,{list(TRUE).index(c)},,['{label}'],3,{p},2026,emo,2026.1")
    text += "".join(f"v/z8r4.mp4,,0,['fear'],3,{p},2026,emo,2026.1\n" for p in GIVEN)
    found = read(text)
    assert (matrix(found), found.left_out) == (RIGHT, {"practice": 3})


def test_a_copy_of_a_file_counts_once(read) -> None:
    texts = files_of("stimulus,felt", lambda p: f"{p}.csv")
    found = read(texts | {"s1 (1).csv": texts["s1.csv"], "s2 - Copy.csv": texts["s2.csv"]})
    assert matrix(found) == RIGHT
    assert [row.reason for row in found.rejected] == ["the same data as s1 (1).csv", "the same data as s2 - Copy.csv"]


def test_files_with_different_columns_are_a_participant_each(read) -> None:
    texts = files_of("stimulus,felt", lambda p: f"{p}.csv")
    texts["s2.csv"] = "stimulus,rt,felt\n" + "".join(f"{c},{k}00,{x}\n" for k, (c, x) in enumerate(GIVEN["s2"].items()))
    assert matrix(read(texts)) == RIGHT


def test_repeats_of_unknown_participants_are_not_hidden(refusal) -> None:
    text = long("nick,video,felt", lambda p, c, x: f"{p},{c},{x}") + "".join(f"{p},z8r4,fear\n" for p in GIVEN)
    assert "'nick' may; expected map.yaml: participant: nick" in refusal(text)


def test_answers_of_a_second_block_are_repeats(refusal, read) -> None:
    text = long("participant,video,felt,block", lambda p, c, x: f"{p},{c},{x},1\n{p},{c},sadness,2")
    assert "9 of 18 answers repeat" in refusal(text)
    assert matrix(read(text, "rows: {keep: {block: 1}}\n")) == RIGHT


def test_rare_values_and_ragged_rows_share_a_line(refusal) -> None:
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{x}")
    message = refusal(text + "".join(f"s1,z8r4,word {i}\n" for i in range(9)) + "a,b\n" * 7)
    assert "(9 rows: 'word 0' and 8 other values not a label; expected happiness" in message
    assert "; 7 rows: ragged row: 2 cells where the header has 3)" in message


@pytest.mark.parametrize("missing", ["null", "NaN", "time out", "-77"])
def test_words_of_programs_for_nothing_are_missing_answers(read, missing) -> None:
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{x}")
    found = read(text + f"s9,z8r4,{missing}\ns9,k2m9,{missing}\n")
    assert matrix(found) == RIGHT
    assert [row.reason for row in found.rejected] == ["no answer"] * 2


def test_a_negated_label_is_no_label(refusal) -> None:
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{'not happy' if x == 'disgust' else x}")
    assert "'not happy' not a label" in refusal(text)


def test_ids_that_a_spreadsheet_has_hidden_or_left_empty_are_refused(refusal) -> None:
    assert "answers repeat" in refusal(long("participant,video,felt", lambda p, c, x: f"########,{c},{x}"))
    merged = long("participant,video,felt", lambda p, c, x: f"{p if c == 'z8r4' else ''},{c},{x}")
    assert "6 rows: 'disgust'" in refusal(merged) or "no participant" in refusal(merged)


def test_a_session_of_all_participants_names_nobody(read) -> None:
    rows = "".join(f"{p},1,{','.join(given.values())}\n" for p, given in GIVEN.items())
    found = read(f"id,session,{','.join(TRUE)}\n{rows}")
    assert (matrix(found), found.participants.index.tolist()) == (RIGHT, list(GIVEN))


def test_a_pilot_beside_a_study_is_counted_apart(read) -> None:
    text = long("participant,video,position,response,mode", lambda p, c, x: f"{p},{c},1,{x},live")
    found = read(text + "".join(f"x,{c},1,fear,pilot\n" for c in TRUE))
    assert (matrix(found), found.dropped, found.simulated) == (RIGHT, {"pilot": 1}, False)
    assert len(read(text + "x,z8r4,1,fear,pilot\n", include_pilots=True).participants) == 4


def test_one_simulated_participant_marks_the_whole_study(read) -> None:
    text = long("participant,video,response,mode", lambda p, c, x: f"{p},{c},{x},live")
    assert read(text + "x,z8r4,fear,simulated\n").simulated


def test_two_questions_about_a_video_are_no_repeats(read, refusal) -> None:
    def row(p: str, c: str, label: str) -> str:
        return f"{p},{c},emotion,{NUMBERS[label]}\n{p},{c},sure,{len(label) % 3 + 1}"

    text = long("participant,video,task,response", row)
    message = refusal(text, ANSWERS)
    assert "9 of 18 answers repeat a participant's answer to a video, and differ in 'task' ('emotion', 's" in message
    assert "expected map.yaml: rows: {keep: {task: [emotion]}}, or repeats: first, last or all if" in message
    assert matrix(read(text, f"{ANSWERS}rows: {{keep: {{task: [emotion]}}}}\n")) == RIGHT


def test_files_that_share_one_id_can_be_a_participant_each(read, refusal) -> None:
    texts = files_of("participant,stimulus,felt", lambda p: f"{p}.csv")
    texts = {name: text.replace("\n", "\n0,").removesuffix("0,") for name, text in texts.items()}
    assert "expected map.yaml: participant: each file, since no file repeats a video; or repeats:" in refusal(texts)
    assert matrix(read(texts, "participant: each file\n")) == RIGHT


def test_unanimous_answers_without_a_key_are_no_truth(read, refusal) -> None:
    unanimous = long("participant,video,choice", lambda p, c, _: f"{p},{c},{dict(TRUE, k2m9='surprise')[c]}")
    assert "expected a key, and map.yaml: response" in refusal(unanimous, key="")
    assert "unknown video; expected an emotion, or a key" in refusal(unanimous, "response: choice\n", key="")
    both = long("participant,video,target,choice", lambda p, c, _: f"{p},{c},{TRUE[c]},{dict(TRUE, k2m9='anger')[c]}")
    assert "'target' and 'choice' have one label for each video" in refusal(both, key="")
    assert matrix(read(both, "response: choice\n", key=""))["fear"] == {"anger": 3}


def test_a_video_of_the_key_that_is_lost_under_another_code_is_refused(refusal) -> None:
    people = {f"p{i}": list(GIVEN.values())[i % 3] for i in range(12)}
    key = KEY + "".join(f"v{i}x,anger\n" for i in range(9)) + "3e12,fear\n"
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{x}", people)
    text += "".join(f"{p},v{i}x,{'anger' if i % 2 else 'fear'}\n" for p in people for i in range(9))
    assert "12 rows of the unknown video '3.00E+12', and none of 3e12, which is in the key" in refusal(
        text + "".join(f"{p},3.00E+12,fear\n" for p in people), key=key
    )


def test_ids_of_tests_and_totals_and_texts_that_are_no_labels_are_warned_of(read) -> None:
    people = {**{f"p{i}": list(GIVEN.values())[i % 3] for i in range(9)}, "test": GIVEN["s1"], "pilot1": GIVEN["s2"]}
    text = long("participant,video,felt", lambda p, c, x: f"{p},{c},{x}", people).replace(
        "p1,z8r4,surprise", "p1,z8r4,awe"
    )
    odd, other = read(text).warnings
    assert odd == "participants 'test', 'pilot1' count: leave them out with the map's drop if they are not participants"
    assert other == "answers that are no labels: 'awe' (1); if the survey offered them, name all --labels"


def test_a_time_stamp_in_a_long_table_is_no_form(read) -> None:
    text = long("participant,timestamp,video,felt", lambda p, c, x: f"{p},2026-01-01 10:00,{c},{x}")
    found = read(text)
    assert (matrix(found), found.sources[0].dialect) == (RIGHT, "long table")


# 10. An analysis owns its folder


def analyzed(folder: Path, files: dict[str, bytes]) -> None:
    """Write the files of an analysis as `write_analysis` does, without drawing any."""
    files = {**files, WRITTEN: list_of_files(files)}
    _remove_former(folder, files)
    for name, data in files.items():
        (folder / name).write_bytes(data)


def test_files_of_a_former_analysis_are_removed_and_other_files_stay(tmp_path) -> None:
    analyzed(tmp_path, {"report.html": b"1", "accuracy-gender.pdf": b"1"})
    (tmp_path / "notes.md").write_text("own")
    (tmp_path / WRITTEN).write_text((tmp_path / WRITTEN).read_text() + f"{'0' * 64}  ../notes.md\n")
    analyzed(tmp_path, {"report.html": b"2"})
    assert sorted(path.name for path in tmp_path.iterdir()) == [WRITTEN, "notes.md", "report.html"]
    assert (tmp_path / "report.html").read_bytes() == b"2"


@pytest.mark.parametrize("name", ["accuracy-gender.pdf", "report.html"])
def test_a_file_that_was_edited_after_an_analysis_is_kept_and_refused(tmp_path, name) -> None:
    analyzed(tmp_path, {"report.html": b"1", "accuracy-gender.pdf": b"1"})
    (tmp_path / name).write_bytes(b"edited")
    with pytest.raises(InputError, match=f"{name}: changed since an analysis wrote it; move it"):
        analyzed(tmp_path, {"report.html": b"2"})
    assert (tmp_path / name).read_bytes() == b"edited"


def test_results_of_version_0_1_0_which_have_no_list_are_replaced(tmp_path) -> None:
    former = {"counts": [[1]], "labels": ["fear"], "emotions": ["fear"], "recognition": {}}
    (tmp_path / "results.json").write_text(json.dumps(former))
    (tmp_path / "report.html").write_bytes(b"1")
    analyzed(tmp_path, {"report.html": b"2", "results.json": b"{}"})
    assert (tmp_path / "report.html").read_bytes() == b"2"
    (tmp_path / "tests.csv").write_text("own")
    with pytest.raises(InputError, match=r"tests.csv: not written by an analysis"):
        analyzed(tmp_path, {"report.html": b"3", "tests.csv": b"3"})
