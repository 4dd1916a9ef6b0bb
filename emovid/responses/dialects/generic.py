"""Tables of no tool in particular: a row for each answer, or a column for each video."""

from collections.abc import Mapping, Sequence

import pandas as pd

from emovid.csv_reader import Table
from emovid.errors import SourceError
from emovid.responses.dialects.columns import (
    POSITION,
    TRUTH,
    answer_column,
    check_named,
    column,
    holds_answers,
    says,
    video_column,
)
from emovid.responses.dialects.identity import who_answered
from emovid.responses.dialects.parsed_export import ANSWER_TO, Column, Known, Raw, answers_long, answers_wide
from emovid.responses.dialects.people import PARTICIPANT, groups_of, who, without
from emovid.responses.dialects.videos import about_videos, no_videos, positions, video_columns
from emovid.responses.key import code_of
from emovid.responses.labels import plain

_LEFT_OUT = {
    "test run": ("test", "pilot", "debug"),
    "preview": ("preview", "survey preview"),
    "partial": ("partial", "incomplete", "abandoned", "in progress", "started", "returned", "timed out"),
    "rejected": ("rejected", "consent revoked", "data expired", "withdrawn"),
    "bot": ("bot",),
}


def recognises_long(table: Table, known: Known) -> bool:
    """Return whether a table has a row for each answer: a column of videos and one of answers."""
    video = video_column(table, known)
    return not is_mapped_wide(known) and video is not None and answer_column(table, known, video) is not None


def recognises_wide(table: Table, known: Known) -> bool:
    """Return whether a table has a column for each video."""
    return bool(video_columns(table, known))


def read_long(
    table: Table, known: Known, *ids: str, reasons: Mapping[str, Column] | None = None, skip: Sequence[str] = ()
) -> Raw:
    """Read a table with a row for each answer; arguments as in `read_wide`, but without `ids` see `who_answered`."""
    check_named(table, known)
    video = video_column(table, known)
    answer = answer_column(table, known, video)
    assert video is not None  # it was recognised by it, or is the map's
    if answer is None:
        raise SourceError(table.file, "no column of answers found; expected map.yaml: response: the column of them", 1)
    people = who(table, known, *ids) if ids else who_answered(table, known, video, answer)
    table, people = without(table, known, people, left_out(table, reasons))
    place = column(table, *POSITION)
    roles = {video: "video", answer: "answer", people.place: "participant", place: "order"}
    return Raw(
        answers_long(table, people.ids, video, answer, None if place is None else table.cells[place]),
        groups_of(table, known, people.ids, {*roles, *(i for i, name in enumerate(table.names) if name in skip)}),
        table.rejected,
        people.dropped,
        {table.names[i]: role for i, role in roles.items() if i is not None},
        people.numbered,
        {} if known.codes else stated_codes(table, known, video),
        people.note,
    )


def read_wide(
    table: Table, known: Known, *ids: str, reasons: Mapping[str, Column] | None = None, skip: Sequence[str] = ()
) -> Raw:
    """Read a table with a column for each video.

    Args:
        table: the file.
        known: what is known besides.
        ids: columns that may name the participant, else those that usually do.
        reasons: rows whose participants are left out, see `people.without`.
        skip: columns of the tool that are no answers and no groups.
    """
    if known.mapping.video:  # a form that was sent once for each video
        return read_long(table, known, reasons=reasons, skip=skip)
    people = who(table, known, *(ids or PARTICIPANT))
    table, people = without(table, known, people, left_out(table, reasons))
    tools = {place for place, name in enumerate(table.names) if plain(name) in {plain(title) for title in skip}}
    videos = video_columns(table, known, [people.place, *tools])
    if not videos:
        raise SourceError(table.file, no_videos(table, known) or "no column holds answers; expected some", 1)
    used = {*tools, *about_videos(table, known)}
    roles = {place: f"{ANSWER_TO}{code}" for place, code in videos.items()} | {people.place: "participant"}
    return Raw(
        answers_wide(table, people.ids, videos, positions(table, known)),
        groups_of(table, known, people.ids, {*roles, *used}),
        table.rejected,
        people.dropped,
        {table.names[i]: role for i, role in roles.items() if i is not None},
        people.numbered,
    )


def left_out(table: Table, reasons: Mapping[str, Column] | None = None) -> dict[str, Column]:
    """Return the rows of `reasons`, and those that a column `status` or `mode` calls a test, a preview or the like."""
    masks = {reason: says(table, words, "status") | says(table, words, "mode") for reason, words in _LEFT_OUT.items()}
    masks["test run"] |= says(table, ("true", "1", "yes"), "is_test")
    masks["bot"] |= says(table, ("true", "1", "yes"), "is_bot")
    for reason, mask in (reasons or {}).items():
        masks[reason] = masks[reason] | mask if reason in masks else mask
    return masks


def is_mapped_wide(known: Known) -> bool:
    """Return whether map.yaml says which columns are videos."""
    return bool(known.mapping.videos or known.mapping.in_order)


def stated_codes(table: Table, known: Known, video: int) -> dict[str, str]:
    """Return the emotion of each video from a column such as `true_emotion`; none where a video has two or no label."""
    place = column(table, *TRUTH)
    if place is None or not holds_answers(table, place, known):
        return {}
    pairs = pd.DataFrame({"video": table.cells[video], "truth": table.cells[place]}).drop_duplicates()
    pairs = pairs[pairs["truth"] != ""]  # rows that show no video
    codes: dict[str, str] = {}
    for code, truth in zip(pairs["video"].map(code_of), pairs["truth"].map(known.labels.find), strict=True):
        if not truth or codes.setdefault(code, truth) != truth:
            return {}
    return codes
