"""Simulated participants: answers to rehearse a study with before anyone takes part."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Probabilities = NDArray[np.float64]


@dataclass(frozen=True)
class Responders:
    """How model participants answer.

    Attributes:
        probabilities: (labels, signalled) of each answer to each video; columns add to 1.
        elimination: share of participants who never give a label twice, as who can go back and change answers may.
        dropout: probability of leaving after each video.
    """

    probabilities: Probabilities
    elimination: float = 0.0
    dropout: float = 0.0


def responders(
    accuracy: Probabilities,
    labels: int,
    bias: Probabilities | None = None,
    elimination: float = 0.0,
    dropout: float = 0.0,
) -> Responders:
    """Return responders who are right with probability `accuracy` (signalled,) and else answer by `bias`.

    Args:
        accuracy: of each video, 0 to 1.
        labels: how many there are, k.
        bias: weight (k,) of each label among wrong answers; equal if left out, and to a video for which no wrong label
            has weight.
        elimination: as in `Responders`.
        dropout: as in `Responders`.
    """
    weights = np.ones(labels) if bias is None else np.asarray(bias, dtype=float)
    right = np.arange(len(accuracy))
    others = np.ones((labels, len(accuracy)))
    others[right, right] = 0.0
    wrong = others * weights[:, None]
    wrong = np.where(wrong.any(axis=0), wrong, others)
    probabilities = wrong / wrong.sum(axis=0) * (1 - accuracy)
    probabilities[right, right] = accuracy
    return Responders(probabilities, elimination, dropout)


def rehearse(
    model: Responders, labels: Sequence[str], signalled: Sequence[str], participants: int, seed: int
) -> pd.DataFrame:
    """Return the answers of model participants: one row for each answer, with participant, video, position, response.

    Every participant sees the videos in an order of their own. Who eliminates chooses, one video after the other, among
    the labels not given yet, in proportion to their probabilities.

    Args:
        model: how they answer.
        labels: the answers, k.
        signalled: the labels of the videos, the first of the labels.
        participants: how many start.
        seed: of everything.
    """
    rng = np.random.default_rng(seed)
    rows: list[tuple[str, str, int, str]] = []
    for person in range(1, participants + 1):
        eliminates = rng.random() < model.elimination
        free = np.ones(len(labels))
        for position, video in enumerate(rng.permutation(len(signalled)), start=1):
            answer = _answer(model.probabilities[:, video], free, rng)
            rows.append((f"m{person:04d}", signalled[video], position, labels[answer]))
            if eliminates:
                free[answer] = 0.0
            if rng.random() < model.dropout:
                break
    return pd.DataFrame(rows, columns=["participant", "video", "position", "response"])


def _answer(probabilities: Probabilities, free: Probabilities, rng: np.random.Generator) -> int:
    """Return a free label by its probability; any free one if none has one, and any at all if none is free."""
    weights = next(option for option in (probabilities * free, free, probabilities) if option.sum() > 0)
    return int(rng.choice(len(weights), p=weights / weights.sum()))
