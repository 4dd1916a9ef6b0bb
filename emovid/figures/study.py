"""The figures of a study, from its results: the mapping that `results.json` holds."""

import re
from collections.abc import Collection, Mapping, Sequence
from itertools import chain, count
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from emovid.errors import InputError
from emovid.figures.accuracy import Rates, accuracy_figure
from emovid.figures.circumplex import POSITIONS, circumplex_figure
from emovid.figures.confusion import confusion_figure

Results = Mapping[str, Any]
_LONGEST_NAME = 60  # letters; file systems take 255 bytes

Answers = tuple[NDArray[np.int64], Sequence[str], Sequence[str]]


def study_figures(results: Results) -> dict[str, tuple[str, Figure]]:
    """Return all figures that the results allow, by file name, each with its caption."""
    answers = answers_of(results)
    made = {"confusion-matrix": ("Answers to each video: percent, and counts", confusion_figure(*answers))}
    if set(results["emotions"]) <= set(POSITIONS):
        caption = "Answers on the valence-arousal plane; a bubble's diameter is proportional to the answers"
        made["circumplex"] = (caption, circumplex_figure(*answers))
    for column, levels in results["groups"].items():
        if levels:
            figure = accuracy_figure(*recognition_of(results, column))
            made[_file_name(column, made)] = (f"Recognition by {column.replace('_', ' ')}", figure)
    return made


def _file_name(column: str, taken: Collection[str]) -> str:
    """Return a name that any file system takes and no other file has: a group may be called by a whole question."""
    words = re.findall(r"[^\W_]+", column)
    name = "-".join(["accuracy", *words])[:_LONGEST_NAME]
    used = {other.casefold() for other in taken}
    numbered = (f"{name}-{i}" for i in count(2))
    return next(free for free in chain([name], numbered) if free.casefold() not in used)


def answers_of(results: Results) -> Answers:
    """Return what `confusion_figure` takes: counts (perceived, signalled), signalled and perceived labels."""
    return np.array(results["counts"]), results["emotions"], results["labels"]


def placed_answers_of(results: Results) -> Answers:
    """Return what `circumplex_figure` takes.

    Raises:
        InputError: if an emotion has no place in the plane.
    """
    if unplaced := [emotion for emotion in results["emotions"] if emotion not in POSITIONS]:
        raise InputError(f"the study has no place on the circumplex for {', '.join(unplaced)}")
    return answers_of(results)


def recognition_of(results: Results, column: str) -> tuple[Rates, Rates, Rates, Sequence[str], Sequence[str], float]:
    """Return what `accuracy_figure` takes: how many of each level of a group recognised each emotion.

    Raises:
        InputError: if the study has no such group.
    """
    levels = results["groups"].get(column)
    if not levels:
        known = ", ".join(results["groups"]) or "none"
        raise InputError(f"the study has no group {column}; its groups: {known}")
    found = [[block["recognition"][name] for name in results["emotions"]] for block in levels.values()]
    rates, low, high = (
        np.array([[np.nan if video[key] is None else video[key] for video in row] for row in found], dtype=float)
        for key in ("rate", "ci_low", "ci_high")
    )
    names = [f"{_level_name(column, level)} (n = {block['n_participants']})" for level, block in levels.items()]
    return rates, low, high, results["emotions"], names, 1 / len(results["labels"])


def _level_name(column: str, level: str) -> str:
    """Return what a legend calls a level: "no robotics background" where the level itself is only "no"."""
    name = column.replace("_", " ")
    return {"yes": name, "no": f"no {name}"}.get(level.lower(), level)
