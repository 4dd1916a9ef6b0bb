"""Identification of participants in tables with a row for each answer."""

import pytest

from emovid.errors import SourceError
from emovid.responses.describe_columns import describe_columns
from emovid.responses.labels import plain
from emovid.responses.participants import PARTICIPANT
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses
from emovid.statistics.analyze import analyze
from tests.helpers.exports import ADJECTIVES, ANSWERS, CODES, COUNTS, GENDER, KEY, ORDER, PEOPLE, psiturk, psychopy


def long(name: str, *more: str, every: int = 1) -> list[list[str]]:
    """Return header and rows of a study with 8 participants in column `name`; only every nth has the last answer."""
    rows = [["swarm", "felt", "sure", "sex", *([name] if name else []), *more]]
    for i, person in enumerate(PEOPLE):
        for j, code in enumerate(ORDER[person][: 6 if i % every == 0 else 5]):
            cells = [f"{code}.mp4", ADJECTIVES[ANSWERS[person][code]].strip(), f"0.{10 + 7 * i + j}", GENDER[person]]
            rows.append([*cells, *([person] if name else []), *(f"{title}{i}" for title in more)])
    return rows


@pytest.fixture
def read(tmp_path):
    """Read rows as an export, with the key and the text of a map."""

    def read(rows: list[list[str]], mapping: str = "", file: str = "x.csv") -> Responses:
        (tmp_path / file).write_text("\n".join(";".join(row) for row in rows) + "\n")
        (tmp_path / "key.txt").write_text(KEY)
        (tmp_path / "map.yaml").write_text(mapping)
        return read_responses(tmp_path / file, tmp_path / "key.txt", tmp_path / "map.yaml" if mapping else None)

    return read


@pytest.fixture
def refusal(read, tmp_path):
    def refusal(*given) -> str:
        with pytest.raises(SourceError) as error:
            read(*given)
        return str(error.value).replace(f"{tmp_path}/", "")

    return refusal


def note_of(found: Responses) -> str:
    (source,) = found.sources
    assert source.note == "" or any(source.note in warning for warning in analyze(found).notes)
    return source.note


@pytest.mark.parametrize(
    "name",
    ["subject", "Subj", "subj_nr", "SubjectID", "pid", "PROLIFIC_PID", "workerId", "VP", "VpNr", "vpn", "user",
     "user id", "Proband", "Versuchsperson", "Respondent", "participant number", "Case", "ID", "Session"],
)  # fmt: skip
def test_many_names_of_participant_columns_are_known(read, name) -> None:
    found = read(long(name))
    assert (len(found.participants), found.counts().tolist(), note_of(found)) == (8, COUNTS, "")
    assert list(found.participants) == ["sex"]


def test_known_column_names_are_distinct() -> None:
    assert len({plain(name) for name in PARTICIPANT}) == len(PARTICIPANT)


@pytest.mark.parametrize("name", ["Code", "name", "Kuerzel", "K"])
def test_unique_identifying_column_is_used_and_reported(read, name) -> None:
    found = read(long(name))
    assert found.counts().tolist() == COUNTS
    assert found.participants.index.tolist() == list(PEOPLE)
    assert list(found.participants) == ["sex"]
    said = f"participants are identified by '{name}': each of its 8 values answers all 6 videos once"
    assert note_of(found) == said


def test_two_identifying_columns_require_a_choice_in_the_map(read, refusal) -> None:
    rows = long("Code", "mail")
    assert refusal(rows) == (
        "x.csv:1: no known column identifies participants, and 'Code' or 'mail' may; expected map.yaml: participant: "
        "Code, or each row if no two are one person's (emovid study columns writes a map)"
    )
    assert read(rows, "participant: mail\n").participants.index.tolist() == [f"mail{i}" for i in range(8)]


def test_possible_participant_column_is_not_used_without_the_map(read, refusal) -> None:
    incomplete = long("Code", every=2)
    again = [*long("Code"), long("Code")[3]]
    for rows in (incomplete, again):
        assert "'Code' may; expected map.yaml: participant: Code" in refusal(rows)
        found = read(rows, "participant: Code\n")
        assert (len(found.participants), note_of(found)) == (8, "")


def test_proposed_map_names_the_likely_participant_column(read, refusal, tmp_path) -> None:
    rows = long("Code", "mail", every=2)
    refusal(rows)
    offered = describe_columns(tmp_path / "x.csv", tmp_path / "key.txt")
    assert "no known column identifies participants" in offered.problem
    roles = {column.name: column.role for column in offered.columns}
    assert roles == {"swarm": "video?", "felt": "answer?", "sure": "", "sex": "", "Code": "participant?", "mail": ""}
    assert offered.map_yaml.startswith("# To decide: no known column identifies participants, and 'Code' or 'mail' may")
    assert "\nparticipant: Code\nvideo: swarm\nresponse: felt\nanswers:\n" in offered.map_yaml
    assert len(read(rows, offered.map_yaml).participants) == 8
    (tmp_path / "map.yaml").write_text("participant: kode\n")
    wrong = describe_columns(tmp_path / "x.csv", tmp_path / "key.txt", tmp_path / "map.yaml")
    assert wrong.problem == "no such column (did you mean Code?); expected the one of the map's participant"
    assert not any(column.role == "participant?" for column in wrong.columns)


def test_description_shows_participants_although_reading_fails(read, refusal, tmp_path) -> None:
    assert "changes within a participant" in refusal(long("VP"), "groups: {certainty: sure}\n")
    found = describe_columns(tmp_path / "x.csv", tmp_path / "key.txt", tmp_path / "map.yaml")
    assert {column.name: column.role for column in found.columns}["VP"] == "participant?"


def test_rows_without_repeats_are_one_participant_each_with_a_note(read) -> None:
    found = read(long(""))
    assert (len(found.participants), found.counts().tolist()) == (48, COUNTS)
    assert note_of(found) == "no known column identifies participants: each row is taken as another participant"
    numbered = [[*row, str(i) if i else "id"] for i, row in enumerate(long(""))]
    found = read(numbered)
    assert len(found.participants) == 48
    assert note_of(found) == "'id' differs in each row: each row is taken as another participant"
    assert note_of(read(numbered, "participant: id\n")) == ""


def test_column_of_row_numbers_does_not_identify_participants(read, refusal) -> None:
    rows = [[*row, str(i) if i else "id"] for i, row in enumerate(long("Code"))]
    message = refusal(rows)
    assert message.startswith(
        "x.csv:1: 'id' differs in each row, and 'Code' may; expected map.yaml: participant: Code,"
    )
    found = read(rows, "participant: each row\n")
    assert (len(found.participants), note_of(found)) == (48, "")


def test_shared_session_column_does_not_identify_participants(read, refusal) -> None:
    rows = [[*row, "1" if i else "session"] for i, row in enumerate(long("Code"))]
    assert refusal(rows).startswith("x.csv:1: 'session' has many answers to one video, and 'Code' may; expected map.y")
    assert len(read(rows, "participant: Code\n").participants) == 8
    alone = [[*row[:2], row[-1]] for row in rows]
    assert refusal(alone).startswith(
        "x.csv:8: 42 of 48 answers repeat a participant's answer to a video; expected map.y"
    )
    first = read(alone, "repeats: first\n")
    assert (len(first.participants), len(first.answers), len(first.rejected)) == (1, 6, 42)


def test_table_with_the_answers_of_one_person_is_one_participant(read, tmp_path) -> None:
    rows = long("")
    found = read(rows[:7], file="P01.csv")
    assert found.participants.index.tolist() == ["P01"]
    assert "all answers are taken as those of one person" in note_of(found)
    paths = []
    for i in range(8):
        paths.append(tmp_path / f"{i}.csv")
        paths[i].write_text("\n".join(";".join(row) for row in [rows[0], *rows[1 + 6 * i : 7 + 6 * i]]))
    together = read_responses(paths, tmp_path / "key.txt")
    assert (len(together.participants), together.counts().tolist()) == (8, COUNTS)
    (note,) = together.notes()
    assert note.startswith(f"{tmp_path / '0.csv'} and 7 more: no column identifies participants, and no video")
    assert len(read(rows[:7], "participant: each row\n").participants) == 6


@pytest.mark.parametrize("make", [psychopy, psiturk], ids=lambda make: make.__name__)
def test_rows_of_several_files_may_be_one_participant_each(make, tmp_path) -> None:
    export = make()
    said = {"key.csv": KEY.encode(), "map.yaml": f"{export.map}participant: each row\n".encode()}
    for name, data in (export.files | said).items():
        (tmp_path / name).write_bytes(data)
    found = read_responses(tmp_path, tmp_path / "key.csv", tmp_path / "map.yaml")
    assert len(found.participants) == len(found.answers) >= 48
    assert not any("answered twice" in row.reason for row in found.rejected)


def test_groups_and_measures_do_not_identify_participants(read) -> None:
    two = [row for row in long("") if row[0] == "swarm" or float(row[2]) < 0.24]  # a woman's answers and a man's
    assert len({row[3] for row in two[1:]}) == 2
    found = read([[*row, "4" if i else "Schule"] for i, row in enumerate(two)])
    assert note_of(found) == "no known column identifies participants: each row is taken as another participant"
    found = read([[*row, row[3] if i else "Geschlecht"] for i, row in enumerate(two)], "groups: {g: Geschlecht}\n")
    assert note_of(found) == "no known column identifies participants: each row is taken as another participant"


def test_the_map_names_the_columns_of_videos_and_answers(read, refusal) -> None:
    rows = [["felt too", *row] for row in long("VP")]
    rows[1:] = [[list(CODES.values())[i % 6], *row[1:]] for i, row in enumerate(rows[1:])]
    assert (
        refusal(rows)
        == "x.csv:1: videos in 'swarm', answers in 'felt too' and 'felt'; expected map.yaml: response: one of them"
    )
    assert read(rows, "response: felt\n").counts().tolist() == COUNTS
    rows = [["seen before", *row] for row in long("VP")]
    rows[1:] = [[list(CODES)[i % 6], *row[1:]] for i, row in enumerate(rows[1:])]
    assert (
        refusal(rows)
        == "x.csv:1: columns 'seen before' and 'swarm' hold codes of the key; expected map.yaml: video: one of them"
    )
    assert read(rows, "video: swarm\nresponse: felt\n").counts().tolist() == COUNTS
    rows = [[row[0], "x" if i else "Antwort", *row[2:]] for i, row in enumerate(long("VP"))]
    assert refusal(rows) == (
        "x.csv:1: videos in 'swarm', but no column holds answers (happiness, surprise, anger, ...); expected map.yaml: "
        "response: their column, and answers: the label of each cell, or other --labels"
    )
    assert len(read(rows, "response: Antwort\nanswers: {x: fear}\n").answers) == 48
    named = [[CODES.get(row[0][:4], row[0]), *row[1:]] for row in long("VP")]
    assert refusal(named) == (
        "x.csv:1: 2 columns hold answers ('swarm' ...), and none is named by a code of the key; expected map.yaml: "
        "videos (or "
        "video and response, if each row is one answer)"
    )
    named[1:] = [[f"{row[0]}.mp4", *row[1:]] for row in named[1:]]
    message = refusal(named)
    assert "looked for the headers of Qualtrics" in message
    assert "and for the key's codes (z8r4, k2m9, p5t1, ...) in a column of videos or in the names of columns" in message
    assert message.endswith(
        "expected map.yaml: video and response (a row for each answer) or videos (a column for each video)"
    )


def test_form_submitted_once_per_video_is_read_by_rows(read, refusal) -> None:
    rows = [["2026/03/01 9:00" if i else "Timestamp", *row] for i, row in enumerate(long("Code"))]
    refusal(rows)
    found = read(rows, "video: swarm\n")
    assert (found.sources[0].dialect, found.counts().tolist()) == ("Google Forms", COUNTS)
    assert "identified by 'Code'" in note_of(found)
    assert "no column holds answers (happiness, surprise, anger, ...); expected map.yaml: response" in refusal(
        [[*row[:2], "?", *row[3:]] for row in rows], "video: swarm\n"
    )
