"""Input and output of every dialect: known facts besides the file, and answers as written in the file."""

import re
from collections.abc import Mapping as Map
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Rejected, Table, coded
from emovid.responses.key import code_of, code_within
from emovid.responses.labels import NONE, Labels, number, plain
from emovid.responses.mapping import ExportMap

Column: TypeAlias = pd.Series  # of text
ANSWER_TO = "answer to "  # role of the column of one video, before its code
_VIDEO_WORDS = {"video", "clip", "stimulus", "movie", "swarm", "condition"}


@dataclass(frozen=True)
class Known:
    """Facts that are known besides the file.

    Attributes:
        labels: the answers.
        codes: emotion of each video code; empty if the names of videos contain their emotion.
        mapping: content of map.yaml.
        groups: names of requested groups.
        include_pilots: whether answers of pilot runs count.
        file_names: short name of each file, by which participants of files are called.
    """

    labels: Labels = field(default_factory=Labels)
    codes: Map[str, str] = field(default_factory=dict)
    mapping: ExportMap = field(default_factory=ExportMap)
    groups: tuple[str, ...] = ()
    include_pilots: bool = False
    file_names: Map[str, str] = field(default_factory=dict)

    def code(self, video: str) -> str:
        """Return the code of a video: the whole name, or the one code of the key within it."""
        code = code_of(video)
        return code if code in self.codes else code_within(video, self.codes) or code

    def emotion(self, video: str) -> str | None:
        """Return the true emotion of a video, None for an unknown video."""
        if self.codes:
            return self.codes.get(self.code(video))
        words = [word for word in plain(code_of(video)).split() if word not in _VIDEO_WORDS]
        found = self.labels.find(" ".join(words))
        return found if found and found != NONE else None


@dataclass(frozen=True, eq=False)
class ParsedExport:
    """Answers and participants as one file states them, or several files of one format.

    Attributes:
        answers: one row for each, with `participant`, `video`, `answer` (text), `position` (Int64), `line`, `file`
            (index of the file), and the columns of the answer (`cell`) and of the video (`video_cell`).
        participants: indexed by participant, one text column for each group.
        rejected: ragged rows.
        dropped: number of participants left out, by reason.
        left_out: number of rows left out, by reason.
        roles: role of each column, by its name ("participant", "video", "answer", "answer to z8r4", "true emotion",
            "order").
        evidence: why a column has its role, by its name.
        numbered: whether participants are numbers of rows, because no column names them.
        codes: emotion of each video, if the file states it.
        note: how participants were identified, if no column names them; or "".
        warnings: sentences for readers of the results.
        simulated: whether rows are marked as simulated.
        excluded: participants and rows that were left out, to be listed one by one.
    """

    answers: pd.DataFrame
    participants: pd.DataFrame
    rejected: tuple[Rejected, ...] = ()
    dropped: Map[str, int] = field(default_factory=dict)
    left_out: Map[str, int] = field(default_factory=dict)
    roles: Map[str, str] = field(default_factory=dict)
    evidence: Map[str, str] = field(default_factory=dict)
    numbered: bool = False
    codes: Map[str, str] = field(default_factory=dict)
    note: str = ""
    warnings: tuple[str, ...] = ()
    simulated: bool = False
    excluded: tuple[Rejected, ...] = ()


_COLUMNS = ("participant", "video", "answer", "position", "line", "file", "cell", "video_cell")


def answers_wide(table: Table, ids: Column, videos: Map[int, str], positions: Map[str, Column]) -> pd.DataFrame:
    """Return the answers of a table with one column for each video.

    Args:
        table: the file.
        ids: participant of each row.
        videos: code of the video of each column.
        positions: position of each video, by code.
    """
    unknown = pd.Series(pd.NA, index=table.cells.index, dtype="Int64")
    parts = [
        pd.DataFrame(
            {
                "participant": ids,
                "video": code,
                "answer": table.cells[place],
                "position": positions.get(code, unknown),
                "line": table.lines,
                "file": 0 if table.origins is None else table.origins,
                "cell": table.names[place],
                "video_cell": table.names[place],
            }
        )
        for place, code in videos.items()
    ]
    return pd.concat(parts, ignore_index=True) if parts else no_answers()


def answers_long(
    table: Table, ids: Column, video: int, answer: tuple[Column, str | Column], position: Column | None
) -> pd.DataFrame:
    """Return the answers of a table with one row for each answer.

    Args:
        table: the file.
        ids: participant of each row.
        video: index of the column of videos.
        answer: text of each answer, and the name of its column.
        position: position (Int64) of each row.
    """
    return pd.DataFrame(
        {
            "participant": ids,
            "video": table.cells[video],
            "answer": answer[0],
            "position": pd.NA if position is None else position,
            "line": table.lines,
            "file": 0 if table.origins is None else table.origins,
            "cell": answer[1],
            "video_cell": table.names[video],
        }
    ).astype({"position": "Int64"})


def no_answers() -> pd.DataFrame:
    """Return a table of answers without rows."""
    return pd.DataFrame({name: [] for name in _COLUMNS}).astype({"position": "Int64"})


def places_in_order(ids: Column, videos: Column, numbers: Column) -> Column:
    """Return the position (Int64, from 1) of each video among its participant's, from numbers of rows.

    Numbers that are not positions are ranked: counts from 0, and counts of trials of which only some show a video. The
    positions of a participant with one number at several videos (the number of an order, say) are unknown.
    """
    rows = pd.DataFrame({"person": ids.to_numpy(), "video": videos.to_numpy(), "number": numbers.to_numpy()})
    numbered = rows.dropna().drop_duplicates(["person", "video"])
    repeated = numbered.loc[numbered.duplicated(["person", "number"]), "person"].unique()
    known = numbers.mask(rows["person"].isin(repeated).to_numpy(), pd.NA)
    is_places = known.dropna().between(1, rows["video"].nunique()).all()
    return known if is_places else _ranked(ids, known.astype("Float64").to_numpy(dtype=float, na_value=np.nan))


def whole_numbers(column: Column) -> Column:
    """Return the whole number (Int64) at the start of each text, missing if there is none."""
    codes, words = coded(column)
    plain_words = pd.Series([number(word) for word in words], dtype="str")
    starts = plain_words.str.extract(r"^(\d{1,9})(?![^_.\s])", expand=False)
    values = pd.array([int(word) if isinstance(word, str) else pd.NA for word in starts], dtype="Int64")
    return pd.Series(values.take(codes), index=column.index)


def ranks(ids: Column, order: Column) -> Column:
    """Return the rank (Int64, from 1) of each row among its participant's, by `order`: numbers, or times as text."""
    values = numeric(order).to_numpy(dtype=float)
    if np.isnan(values[order != ""]).any():  # numbers within text, such as 9_0 and 10_0 of a block, sort as numbers
        codes, words = coded(order)
        keys = [_by_numbers(word) for word in words]
        values = np.argsort(sorted(range(len(keys)), key=keys.__getitem__))[codes].astype(float)
        values[order == ""] = np.nan
    return _ranked(ids, values)


def _by_numbers(text: str) -> list[str | tuple[int, str]]:
    """Return a key that sorts numbers within text by size, for any length."""
    parts = re.split(r"0*(\d+)", text)
    return [(len(part), part) if i % 2 else part for i, part in enumerate(parts)]


def _ranked(ids: Column, values: NDArray[np.float64]) -> Column:
    return pd.Series(values, index=ids.index).groupby(ids.to_numpy()).rank(method="first").astype("Int64")


def numeric(column: Column) -> Column:
    """Return the numbers (float) in cells, with decimal points or commas, NaN for other text."""
    return pd.to_numeric(column.str.replace(",", "."), errors="coerce").astype(float)
