"""The figures of a study: flow of participants, confusion matrix, circumplex, and accuracy by group."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from emovid.errors import InputError
from emovid.figures.accuracy import Rates, accuracy_figure
from emovid.figures.circumplex import POSITIONS, circumplex_figure
from emovid.figures.confusion import confusion_figure
from emovid.figures.participant_flow import flow_figure
from emovid.statistics.results import Flow, StudyResults

_LONGEST_NAME = 60  # letters; file systems take 255 bytes

Answers = tuple[NDArray[np.int64], Sequence[str], Sequence[str]]
Recognition = tuple[Rates, Rates, Rates, Sequence[str], Sequence[str], float, NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class LevelAccuracy:
    """Recognition rates of one level of a group.

    Attributes:
        n_participants: of the level.
        rates: (emotions, 3) share of right answers and the ends of its interval; NaN where nobody answered.
        answers: (emotions,) number of answers.
    """

    n_participants: int
    rates: Rates
    answers: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class FigureData:
    """Data shown by the figures of a study.

    Attributes:
        counts: (labels, emotions) answers.
        emotions: signaled labels.
        labels: answers on offer, the emotions first.
        groups: levels of each group.
        flow: of participants; None where they are not known.
    """

    counts: NDArray[np.int64]
    emotions: tuple[str, ...]
    labels: tuple[str, ...]
    groups: Mapping[str, Mapping[str, LevelAccuracy]]
    flow: Flow | None = None


def figure_data(results: StudyResults) -> FigureData:
    """Return the results of a study that figures show."""
    groups = {
        column: {
            level: LevelAccuracy(
                block.n_participants or 0,
                np.array([[test.rate, test.ci_low, test.ci_high] for test in block.recognition.values()]),
                np.array([test.n for test in block.recognition.values()]),
            )
            for level, block in levels.items()
        }
        for column, levels in results.groups.items()
    }
    return FigureData(results.counts, results.emotions, results.labels, groups, results.flow)


def study_figures(data: FigureData) -> dict[str, tuple[str, Figure]]:
    """Return all figures that the results allow, by file name, each with its caption."""
    answers, made = answers_of(data), {}
    if data.flow is not None:
        caption = "Participants and answers from the exports to the analysis."
        made["participant-flow"] = (caption, flow_figure(data.flow, int(data.counts.sum())))
    made["confusion-matrix"] = (_caption(data), confusion_figure(*answers))
    if set(data.emotions) <= set(POSITIONS):
        caption = (
            "Answers on the circumplex of valence and arousal: at each signaled emotion (cross), a bubble for each "
            "label that was given; its diameter is proportional to the number in it."
        )
        made["circumplex"] = (caption, circumplex_figure(*answers))
    for column, levels in data.groups.items():
        if levels:
            name = column.replace("_", " ")
            caption = (
                f"Share of right answers by {name}, with 95% Wilson intervals; numbers below the bars are answers, the "
                "dashed line is guessing."
            )
            made[_file_name(column, made)] = (caption, accuracy_figure(*recognition_of(data, column)))
    return made


def _caption(data: FigureData) -> str:
    n = [str(total) for total in data.counts.sum(axis=0).tolist()]
    each = f"n = {n[0]} each" if len(set(n)) == 1 else f"n = {', '.join(n)}"
    return (
        f"Confusion matrix of {data.counts.sum()} answers: percent of the answers to each signaled emotion (columns, "
        f"{each}), and counts in brackets. Right answers are bold."
    )


def _file_name(column: str, taken: Collection[str]) -> str:
    """Return a valid and unique file name: the name of a group may be a complete question."""
    words = re.findall(r"[^\W_]+", column)
    name = "-".join(["accuracy", *words])[:_LONGEST_NAME]
    used = {other.casefold() for other in taken}
    numbered = (f"{name}-{i}" for i in count(2))
    return next(free for free in chain([name], numbered) if free.casefold() not in used)


def answers_of(data: FigureData) -> Answers:
    """Return the arguments of `confusion_figure`: counts (perceived, signalled), signalled and perceived labels."""
    return data.counts, data.emotions, data.labels


def placed_answers_of(data: FigureData) -> Answers:
    """Return the arguments of `circumplex_figure`.

    Raises:
        InputError: if an emotion has no position in the plane.
    """
    if unplaced := [emotion for emotion in data.emotions if emotion not in POSITIONS]:
        raise InputError(f"the study has no place on the circumplex for {', '.join(unplaced)}")
    return answers_of(data)


def recognition_of(data: FigureData, column: str) -> Recognition:
    """Return what `accuracy_figure` takes: how many of each level of a group recognized each emotion.

    Raises:
        InputError: if the study has no such group.
    """
    levels = data.groups.get(column)
    if not levels:
        raise InputError(f"the study has no group {column}; its groups: {', '.join(data.groups) or 'none'}")
    rates, low, high = np.moveaxis(np.array([level.rates for level in levels.values()]), -1, 0)
    names = [f"{_level_name(column, level)} (n = {found.n_participants})" for level, found in levels.items()]
    answers = np.array([level.answers for level in levels.values()])
    return rates, low, high, data.emotions, names, 1 / len(data.labels), answers


def _level_name(column: str, level: str) -> str:
    """Return the name of a level in a legend: "no robotics background" where the level itself is only "no"."""
    name = column.replace("_", " ")
    return {"yes": name, "no": f"no {name}"}.get(level.lower(), level)
