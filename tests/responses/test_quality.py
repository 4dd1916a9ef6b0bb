"""Quality of the data: signs, rules of exclusion fixed beforehand, and the numbers that they leave out."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from emovid.errors import InputError
from emovid.figures.study import figure_data, study_figures
from emovid.responses.quality import NO_RULES, ExclusionRules, exclude, quality_signs, rules_from
from emovid.responses.read import read_responses
from emovid.responses.responses import EMOTIONS, Responses
from emovid.statistics.analyze import analyze

HEAD = [
    *("participant", "video", "position", "response", "watched_share", "frames", "dropped_frames", "stalls"),
    *("stalled_ms", "response_ms", "playback", "checks", "status", "mode"),
]


def rows(person: str, **changes: Any) -> list[dict[str, Any]]:
    """Return six answers of a careful participant, with changes; a list changes the answers one by one."""
    usual = {"watched_share": "1.000", "frames": 450, "dropped_frames": 0, "stalls": 0, "stalled_ms": 0}
    usual |= {"response_ms": 2000, "playback": "smooth", "checks": "1 of 1", "status": "finished", "mode": "study"}
    found = []
    for place, emotion in enumerate(EMOTIONS):
        now = {name: value[place] if isinstance(value, list) else value for name, value in changes.items()}
        found.append(
            {"participant": person, "video": emotion, "position": place + 1, "response": emotion} | usual | now
        )
    return found


@pytest.fixture
def export(tmp_path: Path) -> Callable[..., Path]:
    def write(*people: list[dict[str, Any]]) -> Path:
        path = tmp_path / "responses.csv"
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, HEAD)
            writer.writeheader()
            writer.writerows(row for person in people for row in person)
        return path

    return write


def plain_export(folder: Path) -> Path:
    """Write an export with answers alone, one in six of them wrong."""
    lines = [f"p{i},{emotion},{emotion if i else 'fear'}" for i in range(6) for emotion in EMOTIONS[:5]]
    path = folder / "plain.csv"
    path.write_text("participant,video,response\n" + "\n".join(lines))
    return path


@pytest.fixture
def mixed(export: Callable[..., Path]) -> Responses:
    """Twelve participants: seven careful ones and one of each kind of trouble."""
    careful = [rows(f"p{i}") for i in range(7)]
    return read_responses(
        export(
            *careful,
            rows("straight", response="anger"),
            rows("fast", response_ms=[90, 100, 110, 5000, 100, 90]),
            rows("failed", checks="0 of 1"),
            rows("half", watched_share=["1.000", "0.400", "1.000", "1.000", "1.000", "0.899"]),
            rows(
                "jerky",
                dropped_frames=[0, 46, 45, 0, 0, 0],
                stalls=[1, 0, 0, 0, 0, 2],
                stalled_ms=[300, 0, 0, 0, 0, 1001],
            ),
        )
    )


def test_no_one_is_left_out_without_a_rule(mixed) -> None:
    found = analyze(mixed).flow
    assert (found.enrolled, found.excluded, found.analyzed, found.rules) == (12, {}, 12, ())


@pytest.mark.parametrize(
    ("rule", "excluded", "left_out"),
    [
        ("straightliners", {"straightliner": 1}, {}),
        ("failed_checks", {"failed check": 1}, {}),
        ("min_response_ms=300", {"speeder": 1}, {}),
        ("min_response_ms=100", {}, {}),  # the median of the fast one is 100
        ("min_watched=0.9", {}, {"not watched": 2}),
        ("max_dropped=0.1", {}, {"dropped frames": 1}),  # 45 of 450 is not over a tenth
        ("max_stalled_ms=1000", {}, {"stalled": 1}),
        ("max-stalled-ms=200", {}, {"stalled": 2}),
    ],
)
def test_each_rule_leaves_out_what_it_names(mixed, rule, excluded, left_out) -> None:
    found = exclude(mixed, rules_from([rule]))
    assert (found.dropped, found.left_out) == (excluded, left_out)
    assert len(found.answers) == 72 - 6 * sum(excluded.values()) - sum(left_out.values())
    assert len(found.participants) == 12 - sum(excluded.values())
    assert len(found.quality) == len(found.places) == len(found.answers)
    assert found.sources[0].participants == len(found.participants)


def test_all_rules_together_count_each_participant_and_answer_once(mixed) -> None:
    words = ["straightliners", "failed_checks", "min_response_ms=300", "min_watched=0.9", "max_dropped=0.1"]
    found = exclude(mixed, rules_from(words))
    flow = analyze(found).flow
    assert (flow.enrolled, flow.analyzed, flow.rules) == (12, 9, tuple(words))
    assert flow.excluded == {"straightliner": 1, "speeder": 1, "failed check": 1}
    assert flow.left_out == {"not watched": 2, "dropped frames": 1}
    assert flow.rejected == 0
    listed = {(row.row, row.value, row.reason) for row in found.rejected}
    assert (44, "straight", "left out: straightliner") in listed
    assert (63, "half", "left out: not watched") in listed
    assert len(found.rejected) == 3 + 3


def test_participant_of_whom_no_answer_stays_is_excluded(export) -> None:
    found = exclude(read_responses(export(rows("a"), rows("b", watched_share="0.5"))), rules_from(["min_watched=0.9"]))
    assert (found.dropped, found.left_out, list(found.participants.index)) == (
        {"no usable answer": 1},
        {"not watched": 6},
        ["a"],
    )


def test_rules_that_leave_nothing_are_refused(export) -> None:
    read = read_responses(export(rows("a", watched_share="0.5")))
    with pytest.raises(InputError, match=r"min_watched=0\.9: no answer is left"):
        exclude(read, rules_from(["min_watched=0.9"]))


def test_unknown_number_leaves_nothing_out(export) -> None:
    read = read_responses(export(rows("a"), rows("b", watched_share="", response_ms="")))
    found = exclude(read, rules_from(["min_watched=0.9", "min_response_ms=300"]))
    assert len(found.answers) == 12


@pytest.mark.parametrize(
    "rule", ["failed_checks", "min_response_ms=1", "min_watched=1", "max_dropped=0", "max_stalled_ms=0"]
)
def test_rule_needs_the_column_that_it_is_about(rule, tmp_path) -> None:
    plain = read_responses(plain_export(tmp_path))
    with pytest.raises(InputError, match="no export has numbers in"):
        exclude(plain, rules_from([rule]))
    assert exclude(plain, rules_from(["straightliners"])).dropped == {"straightliner": 1}


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("straightliner", r"unknown rule \(did you mean straightliners\?\)"),
        ("straightliners=yes", "without a value"),
        ("min_watched", "a share from 0 to 1, as in min_watched=0.9"),
        ("min_watched=90", "a share from 0 to 1"),
        ("max_stalled_ms=-1", "milliseconds, as in"),
        ("min_response_ms=nan", "milliseconds, as in"),
        ("min_response_ms=inf", "milliseconds, as in"),
    ],
)
def test_rules_that_say_nothing_are_refused(word, message) -> None:
    with pytest.raises(InputError, match=message):
        rules_from([word])


def test_rules_keep_their_words() -> None:
    assert rules_from([]) == NO_RULES == ExclusionRules()
    assert rules_from(["max_dropped=0.25", "straightliners"]).words() == ("straightliners", "max_dropped=0.25")
    assert rules_from(["max_dropped=0"]).words() == ("max_dropped=0",)


def test_signs_count_what_rules_could_leave_out(mixed) -> None:
    found = [(sign.number, sign.of, sign.unit) for sign in quality_signs(mixed)]
    assert found == [
        (1, 12, "participants"),  # straightliners
        (1, 12, "participants"),  # attention checks
        (1, 12, "participants"),  # speeders
        (2, 72, "answers"),  # not watched: 0.400 and 0.899
        (1, 72, "answers"),  # dropped frames
        (2, 72, "answers"),  # stalls
    ]


def test_signs_are_those_that_the_export_tells(tmp_path) -> None:
    (sign,) = quality_signs(read_responses(plain_export(tmp_path)))
    assert (sign.number, sign.of) == (1, 6)


def test_flow_is_drawn_with_every_number(mixed) -> None:
    found = exclude(mixed, rules_from(["straightliners", "failed_checks", "min_watched=0.9"]))
    _, figure = study_figures(figure_data(analyze(found)))["participant-flow"]
    drawn = [text.get_text() for text in figure.axes[0].texts if text.get_text()]
    assert drawn == [
        "Enrolled", "n = 12", "Excluded: 2 participants", "1 straightliner", "1 failed check",
        "Analyzed", "n = 10", "Left out: 2 rows or cells", "2 not watched", "Answers", "58",
    ]  # fmt: skip


def test_survey_export_names_the_reason_of_its_rules(export) -> None:
    read = read_responses(export(rows("a"), rows("b", status="speeder"), rows("c", status="straightliner")))
    assert {name: n for name, n in read.dropped.items() if n} == {"speeder": 1, "straightliner": 1}
