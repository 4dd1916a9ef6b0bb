"""Simulated participants: answers to rehearse a study with before anyone takes part."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Probabilities = NDArray[np.float64]

SIMULATED = "simulated"  # the mode of every row, by which an analysis knows them
_CALIBRATION = 20_000  # participants who eliminate; the standard error of their hit rates is at most 0.004
_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class Responders:
    """How simulated participants answer.

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
    return Responders(_with_hits(wrong, accuracy), elimination, dropout)


def _with_hits(probabilities: Probabilities, accuracy: Probabilities) -> Probabilities:
    """Return probabilities (labels, signalled) with `accuracy` for right answers, wrong ones in their proportions."""
    right = np.arange(probabilities.shape[1])
    wrong = probabilities.copy()
    wrong[right, right] = 0.0
    total = wrong.sum(axis=0)
    changed = wrong * np.divide(1 - accuracy, total, out=np.zeros(len(total)), where=total > 0)
    changed[right, right] = accuracy
    return changed


def rehearse(
    model: Responders, labels: Sequence[str], signalled: Sequence[str], participants: int, seed: int
) -> pd.DataFrame:
    """Return the answers of simulated participants: a row for each answer, which its mode marks as simulated.

    Each participant sees the videos in a separate random order. Eliminating participants choose, one video after the
    other, among the labels not given yet. This loses right answers whose labels are already used; the probabilities of
    these participants are therefore raised until they are right as often as the others, as far as possible.

    Args:
        model: how they answer.
        labels: the answers, k.
        signalled: the labels of the videos, the first of the labels.
        participants: how many start.
        seed: of everything.
    """
    rng = np.random.default_rng(seed)
    eliminates = rng.random(participants) < model.elimination
    orders = rng.permuted(np.tile(np.arange(len(signalled)), (participants, 1)), axis=1)
    answers = np.empty_like(orders)
    answers[~eliminates] = _answers(model.probabilities, orders[~eliminates], rng, eliminate=False)
    if eliminates.any():
        raised = _raised(model.probabilities, np.random.default_rng(seed))
        answers[eliminates] = _answers(raised, orders[eliminates], rng, eliminate=True)
    stays = np.ones_like(orders, dtype=bool)
    stays[:, 1:] = (
        np.cumprod(rng.random((participants, len(signalled) - 1)) >= model.dropout, axis=1, dtype=np.int64) > 0
    )
    person, position = np.nonzero(stays)
    return pd.DataFrame(
        {
            "participant": [f"m{number:04d}" for number in (person + 1).tolist()],
            "video": np.array(signalled, dtype=object)[orders[stays]],
            "position": position + 1,
            "response": np.array(labels, dtype=object)[answers[stays]],
            "mode": SIMULATED,
        }
    )


def _answers(
    probabilities: Probabilities, orders: NDArray[np.int64], rng: np.random.Generator, eliminate: bool
) -> NDArray[np.int64]:
    """Return answers (participants, positions) to videos in these orders.

    Who eliminates gives a free label by its probability; any free one if none has one, and any at all if none is free.
    """
    people = np.arange(len(orders))
    free = np.ones((len(orders), len(probabilities)))
    answers = np.empty_like(orders)
    for position, videos in enumerate(orders.T):
        likely = probabilities[:, videos].T
        weights = likely * free
        weights = np.where(weights.any(axis=1, keepdims=True), weights, free)
        weights = np.where(weights.any(axis=1, keepdims=True), weights, likely)
        ends = np.cumsum(weights, axis=1)
        drawn = rng.random((len(orders), 1)) * ends[:, -1:]
        answers[:, position] = (drawn >= ends).sum(axis=1).clip(max=len(probabilities) - 1)
        if eliminate:
            free[people, answers[:, position]] = 0.0
    return answers


def _raised(probabilities: Probabilities, rng: np.random.Generator) -> Probabilities:
    """Return probabilities with which eliminating participants have the hit rates of `probabilities`."""
    videos = probabilities.shape[1]
    wanted, raised = probabilities[np.arange(videos), np.arange(videos)], probabilities
    orders = rng.permuted(np.tile(np.arange(videos), (_CALIBRATION, 1)), axis=1)
    for _ in range(_ROUNDS):
        hits = _answers(raised, orders, rng, eliminate=True) == orders
        found = np.bincount(orders[hits], minlength=videos) / len(orders)
        now = raised[np.arange(videos), np.arange(videos)]
        factor = np.divide(wanted, found, out=np.ones(videos), where=found > 0)
        raised = _with_hits(probabilities, np.clip(now * factor, 0.0, 1.0))
    return raised
