"""Planning a study: how many participants it needs, and simulated responses to rehearse it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.errors import InputError, nearest
from emovid.responses.responses import EMOTIONS
from emovid.responses.results_files import read_matrix
from emovid.statistics.confusions import percent
from emovid.statistics.designs import GOALS, RULES, Design, Planned, Sequential, participants_for, sequential
from emovid.statistics.planning import Plan, plan
from emovid.statistics.simulated_participants import Responders, rehearse, responders
from emovid.workflows.outputs import write_outputs

ACCURACY = 0.5
MOST_WEIGHT = 1_000_000


def plan_study(rate: float = 0.4, choices: int = 6, videos: int = 6, alpha: float = 0.05, power: float = 0.8) -> Plan:
    """Return how many participants a study needs to recognize a video above chance.

    Args:
        rate: hit rate to detect.
        choices: answers to choose from.
        videos: tests that Holm's correction covers.
        alpha: level of all tests together.
        power: desired power.

    Raises:
        InputError: for numbers out of range.
    """
    for name, share in (("rate", rate), ("alpha", alpha), ("power", power)):
        if not isinstance(share, Real) or not 0 <= float(share) <= 1:
            raise InputError(f"{name}: {share!r}: expected a share from 0 to 1")
    if choices < 2:
        raise InputError(f"choices: {choices}: expected at least 2")
    try:
        return plan(rate, choices, videos, alpha, power)
    except ValueError as error:
        raise InputError(str(error)) from None


def plan_design(design: Design, power: float, seed: int) -> Planned:
    """Return how many participants a whole study needs (`participants_for`). Raises InputError for invalid numbers."""
    try:
        return participants_for(design, power, seed)
    except ValueError as error:
        raise InputError(str(error)) from None


def planned_design(goal: str, *numbers: Any) -> Design:
    """Return a design from its goal and its other fields in their order. Raises InputError for an unknown goal."""
    for known in GOALS:
        if goal == known:
            return Design(known, *numbers)
    raise InputError(f"--goal {goal}: expected {', '.join(GOALS)}{nearest(goal, GOALS)}")


def plan_looks(rule: str, looks: str, design: Design, seed: int) -> Sequential:
    """Return a sequential test of one emotion (`sequential`); alpha is shared by the emotions of the design.

    Raises:
        InputError: for an unknown rule, and for invalid numbers.
    """
    known = next((known for known in RULES if known == rule), None)
    if known is None:
        raise InputError(f"--sequential {rule}: expected {' or '.join(RULES)}{nearest(rule, RULES)}")
    try:
        numbers = [int(look) for look in looks.split(",")]
    except ValueError:
        raise InputError(f"--looks {looks}: expected whole numbers, separated by commas") from None
    try:
        return sequential(known, numbers, design.rate, design.k, design.alpha / design.emotions, seed=seed)
    except ValueError as error:
        raise InputError(f"--looks: {error}") from None


def plan_text(found: Planned | Sequential) -> str:
    """Return a plan in a few lines."""
    if isinstance(found, Planned):
        if found.participants is None:
            return "more participants than can be planned"
        power = f"power {found.power:.3f}, standard error {found.error:.3f}, {found.studies:,} simulated studies"
        return f"{found.participants} participants in all: {power}"
    lines = [
        f"look after {n}: above chance from {above} hits" + (f", at chance up to {low}" if low >= 0 else "")
        if above <= n
        else f"look after {n}: no stop for above chance" + (f", at chance up to {low}" if low >= 0 else "")
        for n, above, low in zip(found.looks, found.above, found.chance_stop, strict=True)
    ]
    return "\n".join(
        (
            *lines,
            f"false alarms of one emotion {found.false_alarms:.4f} (simulated {found.simulated_false_alarms:.4f})",
            f"power {found.power:.3f} (simulated {found.simulated_power:.3f})",
            f"participants on average: {found.expected[0]:.1f} by chance, {found.expected[1]:.1f} at the planned rate",
        )
    )


@dataclass(frozen=True)
class Rehearsal:
    """Answers of simulated participants.

    Attributes:
        participants: number of participants.
        accuracy: probability of a right answer; `ACCURACY` if None.
        matrix: confusion matrix to answer by instead; or None.
        bias: "LABEL=WEIGHT" of labels among wrong answers.
        elimination: share who give each label once.
        dropout: probability of leaving after a video.
        seed: of everything.
    """

    participants: int
    accuracy: float | None = None
    matrix: Path | None = None
    bias: Sequence[str] = ()
    elimination: float = 0.0
    dropout: float = 0.0
    seed: int = 0


def write_rehearsal(rehearsal: Rehearsal, output: Path, *, force: bool) -> int:
    """Write the answers of simulated participants as CSV; return how many there are. See `write_outputs`."""
    table = simulated_answers(rehearsal)
    write_outputs({output: table.to_csv(index=False, lineterminator="\n").encode()}, force=force)
    return len(table)


def simulated_answers(rehearsal: Rehearsal) -> pd.DataFrame:
    """Return the answers of simulated participants, a row for each. See `rehearse`."""
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
    return rehearse(model, labels, signalled, rehearsal.participants, rehearsal.seed)


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
