"""The answers of a study as one table: a row for each participant, a column for each showing of a video."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.responses.responses import Responses

Choices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Showings:
    """Answers by participant and showing.

    A showing is a video, or a video shown again. All answers of a participant are in one row, so what is shuffled or
    resampled by row keeps whatever dependence they have.

    Attributes:
        choices: (participants, showings) places in the k labels, -1 where there is no answer.
        positions: (participants, showings) from 1, -1 where unknown.
        right: (showings,) place of the right answer.
        videos: (showings,) codes of the videos.
        k: labels.
        emotions: signaled labels, the first of the k; some may have no showing.
    """

    choices: Choices
    positions: Choices
    right: NDArray[np.int64]
    videos: tuple[str, ...]
    k: int
    emotions: int

    def counts(self) -> Choices:
        """Return the confusion matrix (labels, signalled) of all answers."""
        matrix = np.zeros((self.k, self.emotions), dtype=np.int64)
        given = self.choices >= 0
        np.add.at(matrix, (self.choices[given], np.broadcast_to(self.right, given.shape)[given]), 1)
        return matrix

    def uses(self, columns: NDArray[np.bool_]) -> Choices:
        """Return how often each participant gave each label (participants, k) in some of the showings."""
        used = np.zeros((len(self.choices), self.k), dtype=np.int64)
        rows = np.arange(len(used))
        for column in self.choices.T[columns]:
            given = column >= 0
            used[rows[given], column[given]] += 1  # once a row: no index comes twice
        return used

    def by_emotion(self) -> list[Choices]:
        """Return `uses` of each signaled emotion."""
        return [self.uses(self.right == emotion) for emotion in range(self.emotions)]

    def of(self, people: NDArray[np.bool_]) -> "Showings":
        """Return the answers of some participants."""
        return Showings(self.choices[people], self.positions[people], self.right, self.videos, self.k, self.emotions)


def showings_of(responses: Responses) -> Showings:
    """Return the answers of a study, showings in the order of the signaled emotions."""
    answers = responses.answers
    emotion = pd.Index(responses.signalled).get_indexer(answers["signalled"])
    again = answers.groupby(["participant", "video"], sort=False).cumcount().to_numpy()
    video, names = pd.factorize(answers["video"], sort=True)
    showings, column = np.unique(np.column_stack([emotion, video, again]), axis=0, return_inverse=True)
    rows = responses.participants.index.get_indexer(answers["participant"])
    choices, positions = (np.full((len(responses.participants), len(showings)), -1, dtype=np.int64) for _ in range(2))
    choices[rows, column.reshape(-1)] = pd.Index(responses.labels).get_indexer(answers["perceived"])
    positions[rows, column.reshape(-1)] = answers["position"].fillna(-1).to_numpy(dtype=np.int64)
    return Showings(
        choices,
        positions,
        right=showings[:, 0],
        videos=tuple(str(names[code]) for code in showings[:, 1]),
        k=len(responses.labels),
        emotions=len(responses.signalled),
    )
