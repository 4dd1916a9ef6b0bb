"""What every dialect is given besides its table, and what it returns: answers as they stand in the file."""

import re
from collections.abc import Mapping as Map
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Rejected, Table
from emovid.responses.key import code_of
from emovid.responses.labels import NONE, Labels, number, plain
from emovid.responses.mapping import Mapping

Column: TypeAlias = pd.Series  # of text
ANSWER_TO = "answer to "  # the role of a video's column, before its code
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
        answers: one row for each, with `participant`, `video`, `answer` (text), `position` (Int64), `line`, and the
            columns that the answer (`cell`) and the video (`video_cell`) stand in.
        participants: indexed by participant, one text column for each group.
        rejected: ragged rows.
        dropped: participants left out, by reason.
        roles: what columns were taken as.
        numbered: whether participants are the numbers of their rows, for want of a column that names them.
        codes: the emotion of each video, where the file itself says it.
        note: what its reader has to know of who its participants are, or "".
    """

    answers: pd.DataFrame
    participants: pd.DataFrame
    rejected: tuple[Rejected, ...] = ()
    dropped: Map[str, int] = field(default_factory=dict)
    roles: Map[str, str] = field(default_factory=dict)
    numbered: bool = False
    codes: Map[str, str] = field(default_factory=dict)
    note: str = ""


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
                "video_cell": table.names[place],
            }
        )
        for place, code in videos.items()
    ]
    return pd.concat(parts, ignore_index=True) if parts else no_answers()


def answers_long(table: Table, ids: Column, video: int, answer: int, position: Column | None = None) -> pd.DataFrame:
    """Return the answers of a table with a row for each; `position` is text that counts them, from any number on."""
    return pd.DataFrame(
        {
            "participant": ids,
            "video": table.cells[video],
            "answer": table.cells[answer],
            "position": pd.NA if position is None else _places(ids, table.cells[video], whole_numbers(position)),
            "line": table.lines,
            "cell": table.names[answer],
            "video_cell": table.names[video],
        }
    ).astype({"position": "Int64"})


def _places(ids: Column, videos: Column, numbers: Column) -> Column:
    """Return the places (Int64, from 1) of videos in each participant's order, from what numbers the rows.

    Numbers that are no places are ranked: counts from 0, and of trials of which only some show a video. Who has one
    number at several videos (that of an order, say) has no known places.
    """
    rows = pd.DataFrame({"person": ids.to_numpy(), "video": videos.to_numpy(), "number": numbers.to_numpy()})
    numbered = rows.dropna().drop_duplicates(["person", "video"])
    repeated = numbered.loc[numbered.duplicated(["person", "number"]), "person"].unique()
    known = numbers.mask(rows["person"].isin(repeated).to_numpy(), pd.NA)
    is_places = known.dropna().between(1, rows["video"].nunique()).all()
    return known if is_places else _ranked(ids, known.astype("Float64").to_numpy(dtype=float, na_value=np.nan))


def no_answers() -> pd.DataFrame:
    """Return a table of answers without rows."""
    names = ("participant", "video", "answer", "position", "line", "cell", "video_cell")
    return pd.DataFrame({name: [] for name in names}).astype({"position": "Int64"})


def whole_numbers(column: Column) -> Column:
    """Return the whole numbers (Int64) that text begins with, missing where it begins otherwise."""
    codes, words = pd.factorize(column)
    plain_words = pd.Series([number(str(word)) for word in words], dtype="str")
    starts = plain_words.str.extract(r"^(\d{1,9})(?![^_.\s])", expand=False)
    values = pd.array([int(word) if isinstance(word, str) else pd.NA for word in starts], dtype="Int64")
    return pd.Series(values.take(codes), index=column.index)


def ranks(ids: Column, order: Column) -> Column:
    """Return the place (Int64, from 1) of each row among its participant's, by `order`: numbers, or times as text."""
    values = numeric(order).to_numpy(dtype=float)
    if np.isnan(values[order != ""]).any():  # digits within text, such as a block's 9_0 and 10_0, count as numbers
        codes, words = pd.factorize(order)
        keys = [_by_numbers(str(word)) for word in words]
        values = np.argsort(sorted(range(len(keys)), key=keys.__getitem__))[codes].astype(float)
        values[order == ""] = np.nan
    return _ranked(ids, values)


def _by_numbers(text: str) -> list[str | tuple[int, str]]:
    """Return a key that sorts text as people do: the numbers in it by size, however long they are."""
    parts = re.split(r"0*(\d+)", text)
    return [(len(part), part) if i % 2 else part for i, part in enumerate(parts)]


def _ranked(ids: Column, values: NDArray[np.float64]) -> Column:
    return pd.Series(values, index=ids.index).groupby(ids.to_numpy()).rank(method="first").astype("Int64")


def numeric(column: Column) -> Column:
    """Return the numbers (float) in cells, with decimal points or commas, NaN where there is none."""
    return pd.to_numeric(column.str.replace(",", "."), errors="coerce").astype(float)
