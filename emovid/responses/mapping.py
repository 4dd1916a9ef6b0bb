"""map.yaml: what an export does not say of itself."""

from collections.abc import Mapping as Map
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from emovid.csv_reader import read_bytes, utf8
from emovid.errors import SourceError, nearest, quoted
from emovid.responses.key import code_of
from emovid.yaml_source import read_yaml

KEYS = ("participant", "video", "response", "videos", "answers", "groups", "drop", "labels")
EACH_ROW = "each row"  # what `participant` says where no two rows are one person's
_Places = Map[tuple[str | int, ...], str]


@dataclass(frozen=True)
class Mapping:
    """What map.yaml says; columns are named as in the file, by their header or their question text.

    Attributes:
        participant: the column that tells participants apart, `EACH_ROW` where each row is another's, or "".
        video: the column of videos in a table with a row for each answer, or "".
        response: the column of answers in such a table, or "".
        videos: the code of each of these columns.
        in_order: or the codes of the columns that ask one question, in the order of the file.
        answers: the label of each cell; None where it counts as no answer.
        groups: the column of each group.
        drop: the values of a column whose participants are left out.
        labels: the labels, or none where they are the six emotions.
        places: where each key stands, ``"file:line"``.
    """

    participant: str = ""
    video: str = ""
    response: str = ""
    videos: Map[str, str] = field(default_factory=dict)
    in_order: tuple[str, ...] = ()
    answers: Map[str, str | None] = field(default_factory=dict)
    groups: Map[str, str] = field(default_factory=dict)
    drop: Map[str, tuple[str, ...]] = field(default_factory=dict)
    labels: tuple[str, ...] = ()
    places: Map[tuple[str | int, ...], str] = field(default_factory=dict)


def read_mapping(path: Path) -> Mapping:
    """Return what a map.yaml says.

    Raises:
        SourceError: for an unknown key or a value of another kind, with file, line and key.
    """
    text = utf8(read_bytes(path), str(path)).decode()
    if not text.strip():
        raise SourceError(str(path), f"empty; expected some of {', '.join(KEYS)}")
    try:
        values, places = read_yaml(text, str(path), "map", as_words=True)
    except SourceError as error:
        raise SourceError(error.where, error.message, 0, error.key) from None
    if not isinstance(values, dict):
        raise SourceError(str(path), f"no map; expected some of {', '.join(KEYS)}")
    for key in values:
        if key not in KEYS:
            raise SourceError(places[key,], f"unknown key{nearest(key, KEYS)}; expected {', '.join(KEYS)}", 0, key)
    return _mapping({key: value for key, value in values.items() if value is not None}, places)


def map_text(
    named: Map[str, str], videos: Map[str, str] | list[str], groups: Map[str, str], answers: Sequence[str]
) -> str:
    """Return a map.yaml to edit: what was found in a file, and in comments what else can be said.

    Args:
        named: the columns of `participant`, `video` and `response`, those that were found.
        videos: as in `Mapping`; left out where there is a column of videos.
        groups: as there.
        answers: cells that are no labels.
    """
    known: dict[str, Any] = dict(named)
    if "video" not in named:
        known["videos"] = videos or None
    known["answers"] = dict.fromkeys(answers) or None
    known["groups"] = dict(groups) or None
    text = yaml.safe_dump(known, sort_keys=False, allow_unicode=True, default_flow_style=False, width=10_000)
    return text.replace(": null\n", ":\n") + _COMMENTS


_COMMENTS = """\
# participant: the column that tells participants apart, "each row" where no two rows are one person's
# video, response: the columns of videos and of answers, in a table with a row for each answer
# videos: a code for each column as above, or a list of codes for columns that ask one question, in their order
# answers: the label of each cell above, none for "none of these", nothing for no answer
# drop: {column: [values]} leaves out their participants
# labels: [happiness, surprise, ...] where they are not the six emotions
"""


def _mapping(values: dict[str, Any], places: _Places) -> Mapping:
    videos, in_order = _codes(values, places)
    if "video" in values and (videos or in_order):
        message = "beside videos; expected one: video for a row for each answer, videos for a column for each video"
        raise SourceError(places["video",], message, 0, "video")
    if values.get("video") and values["video"] == values.get("response"):
        raise SourceError(places["response",], "the column of videos, too; expected another", 0, "response")
    answers = {
        cell: None if label is None else _word(label, ("answers", cell), places)
        for cell, label in _table(values, "answers", places).items()
    }
    return Mapping(
        participant=_word(values.get("participant", ""), ("participant",), places),
        video=_word(values.get("video", ""), ("video",), places),
        response=_word(values.get("response", ""), ("response",), places),
        videos=videos,
        in_order=in_order,
        answers=answers,
        groups={
            name: _word(title, ("groups", name), places)
            for name, title in _table(values, "groups", places).items()
            if title is not None
        },
        drop={
            name: _list(value if isinstance(value, list) else [value], ("drop", name), places)
            for name, value in _table(values, "drop", places).items()
        },
        labels=_list(values.get("labels", []), ("labels",), places),
        places=places,
    )


def _codes(values: dict[str, Any], places: _Places) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return the code of each column, or the codes of columns in their order."""
    videos = values.get("videos")
    if isinstance(videos, list):
        return {}, tuple(_code(code, ("videos", i), places) for i, code in enumerate(videos))
    table = _table(values, "videos", places)
    return {column: _code(code, ("videos", column), places) for column, code in table.items()}, ()


def _code(value: Any, path: tuple[str | int, ...], places: _Places) -> str:
    code = "" if value is None else code_of(_word(value, path, places))
    if not code:
        raise SourceError(_place(path, places), "no code; expected that of the video", 0, ".".join(map(str, path)))
    return code


def _table(values: dict[str, Any], key: str, places: _Places) -> dict[str, Any]:
    table = values.get(key, {})
    if not isinstance(table, dict):
        raise SourceError(places[key,], f"{quoted(str(table))} given; expected {_SHAPES[key]}", 0, key)
    return table


_SHAPES = {
    "videos": "column: code, or a list of codes (video names the one column of videos)",
    "answers": "cell: label",
    "groups": "name: column",
    "drop": "column: [values]",
}


def _list(value: Any, path: tuple[str, ...], places: _Places) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise SourceError(places[path], f"{quoted(str(value))} given; expected a list", 0, ".".join(path))
    return tuple(_word(item, (*path, i), places) for i, item in enumerate(value))


def _word(value: Any, path: tuple[str | int, ...], places: _Places) -> str:
    if isinstance(value, str):
        return value
    given = "nothing" if value is None else quoted(str(value))
    raise SourceError(_place(path, places), f"{given} given; expected a word", 0, ".".join(map(str, path)))


def _place(path: tuple[str | int, ...], places: _Places) -> str:
    """Return where a value stands, the least whole of which it is a part if its own place is not known."""
    return next(places[path[:length]] for length in range(len(path), 0, -1) if path[:length] in places)
