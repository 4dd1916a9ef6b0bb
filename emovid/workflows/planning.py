"""Planning a study: how many participants it needs, and simulated responses to rehearse it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emovid.atomic_io import make_folder, writing
from emovid.errors import InputError, nearest
from emovid.responses.responses import EMOTIONS
from emovid.responses.results_files import read_matrix
from emovid.statistics.confusions import percent
from emovid.statistics.planning import Plan, plan
from emovid.statistics.simulated_participants import Responders, rehearse, responders

ACCURACY = 0.5
MOST_WEIGHT = 1_000_000


def plan_study(rate: float, k: int, videos: int, alpha: float, power: float) -> Plan:
    """Return how many participants a study needs (`plan`). Raises InputError for numbers that cannot be."""
    try:
        return plan(rate, k, videos, alpha, power)
    except ValueError as error:
        raise InputError(str(error)) from None


@dataclass(frozen=True)
class Rehearsal:
    """How simulated participants answer.

    Attributes:
        participants: how many.
        accuracy: probability of a right answer; `ACCURACY` if None.
        matrix: confusion matrix to answer by instead; or None.
        bias: "LABEL=WEIGHT" of labels among wrong answers.
        elimination: share who give each label once.
        dropout: probability of leaving after a video.
        seed: of everything.
    """

    participants: int
    accuracy: float | None
    matrix: Path | None
    bias: Sequence[str]
    elimination: float
    dropout: float
    seed: int


def write_rehearsal(rehearsal: Rehearsal, output: Path) -> int:
    """Write the answers of simulated participants as CSV; return how many there are."""
    labels: tuple[str, ...] = EMOTIONS
    signalled: tuple[str, ...] = EMOTIONS
    if rehearsal.matrix:
        counts, labels, signalled = read_matrix(rehearsal.matrix)
        shares = np.nan_to_num(percent(counts) / 100, nan=1 / len(labels))
        model = Responders(shares, rehearsal.elimination, rehearsal.dropout)
    else:
        accuracy = np.full(len(signalled), ACCURACY if rehearsal.accuracy is None else rehearsal.accuracy)
        weights = _weights(rehearsal.bias, labels)
        model = responders(accuracy, len(labels), weights, rehearsal.elimination, rehearsal.dropout)
    table = rehearse(model, labels, signalled, rehearsal.participants, rehearsal.seed)
    make_folder(output.parent)
    with writing(output) as file:
        file.write(table.to_csv(index=False, lineterminator="\n").encode())
    return len(table)


def _weights(pairs: Sequence[str], labels: Sequence[str]) -> NDArray[np.float64]:
    """Return the weight of each label among wrong answers."""
    weights = np.ones(len(labels))
    for pair in pairs:
        label, _, value = pair.partition("=")
        if label not in labels:
            raise InputError(f"--bias {pair}: expected one of {', '.join(labels)}{nearest(label, labels)}")
        try:
            weight = float(value)
        except ValueError:
            weight = nan
        if not 0 <= weight <= MOST_WEIGHT:
            raise InputError(f"--bias {pair}: expected LABEL=WEIGHT, a weight from 0 to {MOST_WEIGHT}")
        weights[labels.index(label)] = weight
    return weights
