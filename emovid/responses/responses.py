"""What a survey leaves behind, whatever tool it ran on: one answer for each participant and video."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Rejected

# The order of the rows and columns of the paper's Table III.
EMOTIONS = ("happiness", "surprise", "anger", "fear", "disgust", "sadness")


@dataclass(frozen=True)
class Source:
    """A file that was read.

    Attributes:
        file: its name as given.
        dialect: what it was recognised as, in words ("Google Forms", "long table").
        sha256: of its bytes.
        participants: kept from it.
        note: what has to be known of who they are, or "".
    """

    file: str
    dialect: str
    sha256: str
    participants: int
    note: str = ""


@dataclass(frozen=True, eq=False)
class Responses:
    """The answers of a study.

    Attributes:
        signalled: the labels that videos stand for, in the order of the tables' columns.
        labels: the answers that participants may give, in the order of the tables' rows: `signalled`, after them those
            that no video stands for, and last "none" if the survey had "none of these".
        answers: one row for each participant and video, with the columns `participant`, `video`, `signalled`,
            `perceived` (all text) and `position` (Int64, counted from 1; missing where the order is not known).
        participants: indexed by participant, one text column for each group (gender, robotics_background, age, ...).
        sources: the files.
        rejected: rows and cells that were not used.
        dropped: participants left out as a whole, by reason ("preview", "partial", "bot", "test run", ...); 0 for
            a value of the map that nobody has.
    """

    signalled: tuple[str, ...]
    labels: tuple[str, ...]
    answers: pd.DataFrame
    participants: pd.DataFrame
    sources: tuple[Source, ...] = ()
    rejected: tuple[Rejected, ...] = ()
    dropped: dict[str, int] = field(default_factory=dict)

    def notes(self) -> list[str]:
        """Return what has to be known of who the participants are, files of one note in one line."""
        files: dict[str, list[str]] = {}
        for source in self.sources:
            files.setdefault(source.note, []).append(source.file)
        more = {note: f" and {len(names) - 1} more" if len(names) > 1 else "" for note, names in files.items()}
        return [f"{names[0]}{more[note]}: {note}" for note, names in files.items() if note]

    def choices(self) -> NDArray[np.int64]:
        """Return the answers (participants, signalled) as places in `labels`, -1 where one is missing.

        Rows are in the order of `participants`. A participant who saw several videos of one emotion has the first here.
        """
        first = self._first_answers()
        return self._by_emotion(first, pd.Index(self.labels).get_indexer(first["perceived"]))

    def positions(self) -> NDArray[np.int64]:
        """Return the positions (participants, signalled) at which `choices` were made, from 1; -1 where unknown."""
        first = self._first_answers()
        return self._by_emotion(first, first["position"].fillna(-1).to_numpy(dtype=np.int64))

    def _first_answers(self) -> pd.DataFrame:
        return self.answers.drop_duplicates(["participant", "signalled"])

    def _by_emotion(self, answers: pd.DataFrame, values: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return one value for each of the answers as a table (participants, signalled), -1 elsewhere."""
        table = np.full((len(self.participants), len(self.signalled)), -1, dtype=np.int64)
        rows = self.participants.index.get_indexer(answers["participant"])
        table[rows, pd.Index(self.signalled).get_indexer(answers["signalled"])] = values
        return table

    def counts(self) -> NDArray[np.int64]:
        """Return the confusion matrix (labels, signalled): rows perceived, columns signalled, as in Table III."""
        perceived = pd.Index(self.labels).get_indexer(self.answers["perceived"])
        signalled = pd.Index(self.signalled).get_indexer(self.answers["signalled"])
        matrix = np.zeros((len(self.labels), len(self.signalled)), dtype=np.int64)
        np.add.at(matrix, (perceived, signalled), 1)
        return matrix
