"""What every dialect is given besides its table, and what it returns: answers as they stand in the file."""

from collections.abc import Mapping as Map
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import pandas as pd

from emovid.study.key import code_of
from emovid.study.labels import NONE, Labels, plain
from emovid.study.mapping import Mapping
from emovid.study.responses import Rejected
from emovid.study.tables import Table

Column: TypeAlias = pd.Series  # of text
_ABOUT_VIDEOS = {"video", "clip", "stimulus", "movie", "swarm", "condition"}


@dataclass(frozen=True)
class Known:
    """What is known besides the file.

    Attributes:
        labels: the answers.
        codes: the emotion of each video code; empty where codes name their emotions.
        mapping: what map.yaml says.
        groups: names of groups that are asked for.
    """

    labels: Labels = field(default_factory=Labels)
    codes: Map[str, str] = field(default_factory=dict)
    mapping: Mapping = field(default_factory=Mapping)
    groups: tuple[str, ...] = ()

    def emotion(self, video: str) -> str | None:
        """Return the emotion that a video stands for, None for an unknown one."""
        code = code_of(video)
        if self.codes:
            return self.codes.get(code)
        words = [word for word in plain(code).split() if word not in _ABOUT_VIDEOS]
        found = self.labels.find(" ".join(words))
        return found if found and found != NONE else None


@dataclass(frozen=True, eq=False)
class Raw:
    """What one file says.

    Attributes:
        answers: one row for each, with `participant`, `video`, `answer` (text), `position` (Int64), `line`, `cell`.
        participants: indexed by participant, one text column for each group.
        rejected: ragged rows.
        dropped: participants left out, by reason.
        roles: what columns were taken as.
        numbered: whether participants are the numbers of their rows, for want of a column that names them.
        codes: the emotion of each video, where the file itself says it.
    """

    answers: pd.DataFrame
    participants: pd.DataFrame
    rejected: tuple[Rejected, ...] = ()
    dropped: Map[str, int] = field(default_factory=dict)
    roles: Map[str, str] = field(default_factory=dict)
    numbered: bool = False
    codes: Map[str, str] = field(default_factory=dict)


def answers_wide(table: Table, ids: Column, videos: Map[int, str], positions: Map[str, Column]) -> pd.DataFrame:
    """Return the answers of a table with a column for each video: its place to its code."""
    unknown = pd.Series(pd.NA, index=table.cells.index, dtype="Int64")
    parts = [
        pd.DataFrame(
            {
                "participant": ids,
                "video": code,
                "answer": table.cells[place],
                "position": positions.get(code, unknown),
                "line": table.lines,
                "cell": table.names[place],
            }
        )
        for place, code in videos.items()
    ]
    return pd.concat(parts, ignore_index=True) if parts else no_answers()


def answers_long(table: Table, ids: Column, video: int, answer: int, position: Column | None = None) -> pd.DataFrame:
    """Return the answers of a table with a row for each; `position` is text."""
    return pd.DataFrame(
        {
            "participant": ids,
            "video": table.cells[video],
            "answer": table.cells[answer],
            "position": whole_numbers(position) if position is not None else pd.NA,
            "line": table.lines,
            "cell": table.names[answer],
        }
    ).astype({"position": "Int64"})


def no_answers() -> pd.DataFrame:
    """Return a table of answers without rows."""
    return pd.DataFrame(
        {"participant": [], "video": [], "answer": [], "position": pd.array([], "Int64"), "line": [], "cell": []}
    )


def whole_numbers(column: Column) -> Column:
    """Return the positive whole numbers (Int64) that text begins with, missing where it begins otherwise."""
    codes, words = pd.factorize(column)
    starts = pd.Series(words, dtype="str").str.extract(r"^(\d{1,9})(?![^_.\s])", expand=False).str.replace("_", "")
    values = pd.array([int(word) if isinstance(word, str) else pd.NA for word in starts], dtype="Int64")
    if not len(values):
        return pd.Series(pd.NA, index=column.index, dtype="Int64")
    return pd.Series(values.take(codes), index=column.index)


def ranks(ids: Column, order: Column) -> Column:
    """Return the place (Int64, from 1) of each row among its participant's, by `order`: numbers, or times as text."""
    numbers = pd.Series(np.asarray(pd.to_numeric(order, errors="coerce"), dtype=float), index=order.index)
    if numbers.isna().all():
        numbers = pd.Series(pd.factorize(order, sort=True)[0], index=order.index)
    return numbers.groupby(ids.to_numpy()).rank(method="first").astype("Int64")
