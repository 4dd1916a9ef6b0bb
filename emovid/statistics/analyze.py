"""From responses to everything that `results.json` holds: the door of this room.

Each block of results is a plain dictionary, so that what is written, reported and drawn is one thing.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, is_dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.report import apa
from emovid.responses.labels import NONE
from emovid.responses.participants import MOST_LEVELS
from emovid.responses.responses import Responses
from emovid.statistics.circumplex import ANGLES, near_neighbours
from emovid.statistics.confusion import percent
from emovid.statistics.dependence import agreement, label_use, videos_differ
from emovid.statistics.goodness import adjusted_residuals, goodness_by_video
from emovid.statistics.groups import MIN_GROUP, levels_of, rates_differ, scores_differ
from emovid.statistics.permutation_tests import order_effect, total_recognition
from emovid.statistics.recognition import AROUSAL, VALENCE, Collapsed, collapse, recognise, unbiased_hit_intervals

Counts = NDArray[np.int64]
Block = dict[str, Any]

ALPHA = 0.05
# Below this expected count Pearson's test is poor; W. Cochran, Biometrics 10, 1954.
SMALL_EXPECTED = 5


def analyze(responses: Responses, by: Sequence[str] = (), seed: int = 0) -> Block:
    """Return the results of a study, ready for JSON: NaN is None, and arrays are lists.

    Args:
        responses: the answers.
        by: group columns to analyse by; if left out, all that the participants have of at most `MOST_LEVELS` levels,
            which an age in years is not.
        seed: of every bootstrap, permutation and Monte Carlo test.
    """
    choices, k = responses.choices(), len(responses.labels)
    levels = {name: len(levels_of(list(column))) for name, column in responses.participants.items()}
    columns = list(by) or [name for name in responses.participants.columns if levels[name] <= MOST_LEVELS]
    results = {
        **_matrix_results(responses.counts(), responses.labels, responses.signalled, seed),
        "n_participants": len(responses.participants),
        "n_videos": int(responses.answers["video"].nunique()),
        "dependence": _dependence(responses, choices, seed),
        "groups": {column: _groups(responses, column, seed) for column in columns},
        "group_differences": {
            column: _differences(choices, list(responses.participants[column]), responses.signalled, seed)
            for column in columns
        },
    }
    intervals = unbiased_hit_intervals(choices, k, seed)
    for name, (low, high) in zip(responses.signalled, intervals.tolist(), strict=True):
        results["recognition"][name] |= {"hu_low": _number(low), "hu_high": _number(high)}
    results["warnings"] = [*_warnings(results), *_reading_warnings(responses, choices)]
    results["warnings"] += [
        f"{name}: {levels[name]} levels, too many for a group; --by {name} compares them all the same"
        for name in responses.participants.columns
        if not by and name not in columns
    ]
    return results


def analyze_counts(counts: Counts, labels: Sequence[str], signalled: Sequence[str], seed: int = 0) -> Block:
    """Return the results that a confusion matrix (labels, signalled) alone can give: a published table, say."""
    results = _matrix_results(counts, labels, signalled, seed)
    return {
        **results,
        "n_participants": None,
        "dependence": {},
        "groups": {},
        "group_differences": {},
        "warnings": _warnings(results),
    }


def _matrix_results(counts: Counts, labels: Sequence[str], signalled: Sequence[str], seed: int) -> Block:
    by_pole = {name: collapse(counts, labels, poles) for name, poles in (("valence", VALENCE), ("arousal", AROUSAL))}
    return {
        "emotions": list(signalled),
        "labels": list(labels),
        **_block(counts, signalled, seed),
        "adjusted_residuals": in_json(adjusted_residuals(counts)),
        "collapsed": {name: _collapsed(found) for name, found in by_pole.items() if found.videos},
        "near_neighbours": _said(near_neighbours(counts, labels), apa.near_neighbours),
    }


def _collapsed(found: Collapsed) -> Block:
    """Return the recognition of a pole, video by video."""
    return {
        "table": found.table.tolist(),
        "videos": {name: _said(test, apa.binomial) for name, test in found.videos.items()},
    }


def _block(counts: Counts, signalled: Sequence[str], seed: int) -> Block:
    """Return the results that a whole study and each of its groups have."""
    fits, recognised = goodness_by_video(counts, seed), recognise(counts, ALPHA)
    return {
        "n_responses": int(counts.sum()),
        "counts": counts.tolist(),
        "percent": in_json(percent(counts)),
        "goodness_of_fit": {
            name: {**_said(fit, apa.goodness), "apa_exact": apa.goodness_exact(fit)}
            for name, fit in zip(signalled, fits, strict=True)
        },
        "recognition": {name: _said(found, apa.binomial) for name, found in zip(signalled, recognised, strict=True)},
    }


def _groups(responses: Responses, column: str, seed: int) -> Block:
    """Return a block for each level of a group column."""
    levels = responses.participants[column].dropna()
    levels = levels[levels != ""]
    blocks = {}
    for level in sorted(levels.unique()):
        members = levels.index[levels == level]
        answers = responses.answers[responses.answers["participant"].isin(members)]
        counts = count(answers, responses.labels, responses.signalled)
        blocks[str(level)] = {"n_participants": len(members), **_block(counts, responses.signalled, seed)}
    return blocks


def count(answers: pd.DataFrame, labels: Sequence[str], signalled: Sequence[str]) -> Counts:
    """Return the confusion matrix (labels, signalled) of some of the answers."""
    return Responses(tuple(signalled), tuple(labels), answers, pd.DataFrame()).counts()


def _dependence(responses: Responses, choices: Counts, seed: int) -> Block:
    """Return the tests that take a participant's answers together."""
    k = len(responses.labels)
    return {
        "fleiss_kappa": _said(agreement(choices, k), apa.fleiss_kappa),
        "cochran_q": _said(videos_differ(choices), apa.cochrans_q),
        "total_recognition": _said(total_recognition(choices), apa.total_recognition),
        "label_use": _said(label_use(choices, k, seed), apa.label_use),
        "order": _order(responses, choices, seed),
    }


def _differences(choices: Counts, group: list[object], signalled: Sequence[str], seed: int) -> Block:
    """Return how the levels of a group differ: in their scores, and video by video."""
    scores = scores_differ(choices, group, seed)
    rates = rates_differ(choices, group, seed)
    return {
        "scores": {**_said(scores, apa.scores_differ), "pairs": [_said(pair, apa.difference) for pair in scores.pairs]},
        "videos": {
            name: {**_said(test, apa.rates_differ), "pairs": [_said(pair, apa.difference) for pair in test.pairs]}
            for name, test in zip(signalled, rates, strict=True)
        },
    }


def _order(responses: Responses, choices: Counts, seed: int) -> Block | None:
    """Return the effect of the position in which a video was shown, None where positions are not known."""
    if responses.answers["position"].isna().all():
        return None
    return _said(order_effect(choices, responses.positions(), seed), apa.order_effect)


def _warnings(results: Block) -> list[str]:
    """Return what the statistics of the whole study warn of, and those of small groups."""
    said = [*_label_warnings(results), *_fit_warnings(results)]
    for column, levels in results.get("groups", {}).items():
        small = [level for level, block in levels.items() if block["n_participants"] < MIN_GROUP]
        if small:
            said.append(
                f"{column}: fewer than {MIN_GROUP} participants in {', '.join(small)}; read their tests as hints"
            )
    if results.get("n_participants"):
        said.append(
            "answers of one participant depend on each other: tests across videos permute or resample participants"
        )
    return said


def _label_warnings(results: Block) -> Iterable[str]:
    """Yield what labels have that are other than the paper's six, each with a video of its own."""
    without = [label for label in results["labels"] if label not in results["emotions"] and label != NONE]
    if without:
        yield f"no video stands for {', '.join(without)}: rows of the matrix without a column"
    unplaced = [name for name in results["emotions"] if name not in ANGLES]
    if unplaced:
        yield (
            f"{', '.join(unplaced)}: no known place on the circumplex, so there is no figure of it, and tests of "
            "valence, arousal and near neighbours leave them out"
        )


def _fit_warnings(results: Block) -> Iterable[str]:
    for j, (name, fit) in enumerate(results["goodness_of_fit"].items()):
        found = results["recognition"][name]
        if not fit["n"]:
            yield f"{name}: no answers to a video of it"
        elif fit["expected"] < SMALL_EXPECTED:
            yield f"{name}: {fit['expected']:.1f} answers a cell are expected, under {SMALL_EXPECTED}: use the exact p"
        if fit["p_exact"] <= ALPHA and not found["above_chance"]:
            column = [row[j] for row in results["counts"]]
            most = [label for label, n in zip(results["labels"], column, strict=True) if n == max(column)]
            why = (
                "yet it is not above chance"
                if name in most
                else f"but not because it was recognised: most said {' and '.join(most)}"
            )
            yield f"{name}: the answers are not uniform, {why}"


def _reading_warnings(responses: Responses, choices: Counts) -> Iterable[str]:
    shown = choices[:, (choices >= 0).any(axis=0)]
    missing = int((shown < 0).sum())
    if missing:
        yield f"{missing} of {shown.size} answers are missing"
    more = len(responses.answers) - int((choices >= 0).sum())
    if more:
        yield (
            f"{more} answers are a participant's second or later to one emotion: tests of single emotions take them as "
            "independent, those that take a participant's answers together leave them out"
        )
    yield from responses.notes()
    if responses.rejected:
        yield f"{len(responses.rejected)} rows or cells were not used: see rejected.csv"
    if responses.dropped:
        yield "participants left out: " + ", ".join(f"{number} {why}" for why, number in responses.dropped.items())


def _said(test: Any, say: Callable[[Any], str]) -> Block:
    """Return a test's results, and beside them the sentence that reports it."""
    return {**in_json(test), "apa": say(test)}


def in_json(value: Any) -> Any:
    """Return a result in JSON's types, None for what is no number."""
    if is_dataclass(value) and not isinstance(value, type):
        return {name: in_json(item) for name, item in asdict(value).items()}
    if isinstance(value, dict):
        return {str(name): in_json(item) for name, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [in_json(item) for item in value]
    return _number(value)


def _number(value: Any) -> Any:
    single = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(single, float) and not math.isfinite(single) else single
