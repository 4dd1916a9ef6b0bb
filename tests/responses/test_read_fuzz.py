"""Every file gives `Responses` or a one-line error message."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from emovid.errors import SourceError
from emovid.responses.describe_columns import describe_columns
from emovid.responses.mapping import ExportMap
from emovid.responses.read import read_responses
from tests.helpers.exports import EXPORTS, KEY

FILES = [
    (make.__name__, name, data, export.map)
    for make in EXPORTS
    for export in [make()]
    for name, data in list(export.files.items())[:3]
]
MARKS = ['"', ",", ";", "\t", "\n", "\r", "[", "}", "{", "|", "None", "null", "anger", "z8r4", "'", "=", "\ufeff", "é"]
SNIPPETS = [mark.encode() for mark in MARKS] + [b"\xff", b"\x00", b"\xff\xfe", b"sep=;\n"]
WORDS = [
    "participant",
    "video",
    "response",
    "position",
    "anger",
    "fear",
    "z8r4",
    "status",
    "test",
    "Timestamp",
    "trial_type",
    "trial_index",
    "participant.code",
    "trials.thisN",
    "expName",
    "sender",
    "sender_type",
    "session",
    "created",
    "ended",
    "ResponseId",
    "Finished",
    "RecordedDate",
    "V1",
    "Respondent ID",
    "id",
    "submitdate",
    "seed",
    "a:b",
    "{}",
    "trialId",
    "participantId",
    "responseId",
    "answer",
    "responses_stimulus",
    "ID",
    "Completion time",
    "1",
    "",
    "Q_DO",
    "s.1.player.video",
    "s.2.player.video",
    "s.2.player.response",
    '{"a": 1}',
    '{"ImportId"}',
    "videos/z8r4.mp4",
    "FL_DO_z8r4",
]


def tolerant(examples: int) -> settings:
    """Suppress the health check for slow examples, since reading files takes time."""
    return settings(max_examples=examples, suppress_health_check=[HealthCheck.too_slow])


def check(data: bytes, mapping: str = "", name: str = "x.csv") -> None:
    """Read bytes with and without a key; a result is consistent, and an error is one line."""
    with TemporaryDirectory() as folder:
        file, key, said = (Path(folder) / title for title in (name, "key.csv", "map.yaml"))
        file.write_bytes(data)
        key.write_text(KEY)
        said.write_text(mapping)
        for known in ({}, {"key": key}, {"key": key, "mapping": said} if mapping else {}):
            try:
                found = read_responses(file, **known)
            except SourceError as error:
                is_one_line(error)
            else:
                assert found.counts().sum() == len(found.answers) > 0
                assert found.answers["participant"].isin(found.participants.index).all()
                assert not found.answers.duplicated(["participant", "video"]).any()
                assert not found.participants.isna().any(axis=None)
            try:
                assert describe_columns(file, **known).map_yaml
            except SourceError as error:
                is_one_line(error)


def is_one_line(error: SourceError) -> None:
    assert str(error).isprintable()
    assert str(error).strip()


@tolerant(40)
@given(st.binary(max_size=200))
def test_any_bytes_give_responses_or_a_one_line_error(data) -> None:
    check(data)


@tolerant(80)
@given(
    st.lists(st.lists(st.sampled_from(WORDS), min_size=1, max_size=6), min_size=1, max_size=6),
    st.sampled_from(",;\t"),
    st.dictionaries(st.sampled_from(["participant", "video", "response"]), st.sampled_from([*WORDS, "each row"])),
)
def test_any_table_of_known_words_gives_responses_or_a_one_line_error(rows, delimiter, mapping) -> None:
    check("\n".join(delimiter.join(row) for row in rows).encode(), yaml.safe_dump(mapping) if mapping else "")


@tolerant(60)
@given(st.data())
def test_any_damage_to_a_real_export_gives_responses_or_a_one_line_error(data) -> None:
    _, name, content, mapping = data.draw(st.sampled_from(FILES))
    content = content[:2000] if data.draw(st.booleans()) else content
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(content)))
        stop = data.draw(st.integers(start, min(len(content), start + 30)))
        content = content[:start] + data.draw(st.sampled_from([b"", *SNIPPETS])) + content[stop:]
    check(content, mapping, name)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(WORDS), inner, max_size=4),
    max_leaves=8,
)


@tolerant(40)
@given(st.lists(st.dictionaries(st.sampled_from(WORDS), json_values, max_size=6), max_size=5))
def test_any_list_of_trials_gives_responses_or_a_one_line_error(trials) -> None:
    check(json.dumps(trials).encode(), name="x.json")


@tolerant(50)
@given(st.text(max_size=80) | st.sampled_from(list(ExportMap.model_fields)).flatmap(
    lambda key: json_values.map(lambda value: f"{key}: {value!r}")
))  # fmt: skip
def test_any_map_gives_responses_or_a_one_line_error(mapping) -> None:
    check(b"participant,video,response\na,z8r4,happy\n", mapping or " ")


@pytest.mark.parametrize("key", ["", "a", '"', "video_code,true_emotion\n\xff,\n", "video_code\ttrue_emotion\n\t"])
def test_any_invalid_key_gives_a_one_line_error(tmp_path, key) -> None:
    (tmp_path / "x.csv").write_text("participant,video,response\na,z8r4,happy\n")
    (tmp_path / "key.csv").write_text(key, encoding="latin-1")
    with pytest.raises(SourceError) as error:
        read_responses(tmp_path / "x.csv", tmp_path / "key.csv")
    is_one_line(error.value)
