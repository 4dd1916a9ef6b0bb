"""From responses to the results of a study."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from emovid.errors import InputError
from emovid.responses.labels import NONE
from emovid.responses.participants import MOST_LEVELS
from emovid.responses.quality import LEFT_OUT, quality_signs
from emovid.responses.responses import Responses
from emovid.statistics.circumplex import ANGLES, AROUSAL, VALENCE
from emovid.statistics.confusions import near_neighbors, percent, quasi_independence
from emovid.statistics.goodness import goodness_of_fit
from emovid.statistics.groups import MIN_GROUP, levels_of, rates_differ, scores_differ
from emovid.statistics.participants import agreement, label_use, order_effect, total_recognition, videos_differ
from emovid.statistics.proportions import holm
from emovid.statistics.recognition import Uses, accuracy, against_chance, collapse, corrected, recognize
from emovid.statistics.resampling import information, resampled_counts, unbiased_hit_intervals
from emovid.statistics.results import AnswerResults, Dependence, Flow, GroupDifferences, StudyResults, VideoResults
from emovid.statistics.showings import Showings, showings_of

Counts = NDArray[np.int64]
Groups = Mapping[str, Mapping[str, AnswerResults]]

ALPHA = 0.05
# Below this expected count Pearson's test is poor; W. Cochran, Biometrics 10, 1954.
SMALL_EXPECTED = 5
_POLES = {"valence": VALENCE, "arousal": AROUSAL}


def analyze(responses: Responses, by: Sequence[str] = (), seed: int = 0, margin: float | None = None) -> StudyResults:
    """Return the results of a study.

    Args:
        responses: the answers.
        by: group columns to analyze by, named beforehand; if left out, all that the participants have of at most
            `MOST_LEVELS` levels, which an age in years is not.
        seed: of every bootstrap, permutation and Monte Carlo test.
        margin: of equivalence between groups, as a share, set beforehand.
    """
    if not isinstance(responses, Responses):
        raise InputError(
            f"analyze: {responses!r} is not a Responses object; expected the result of read_responses('responses.csv')"
        )
    showings, uses = showings_of(responses), None
    levels = {name: len(levels_of(list(column))) for name, column in responses.participants.items()}
    by = [by] if isinstance(by, str) else list(by)
    for name in by:
        if name not in levels:
            raise InputError(f"by: {name}: the participants have no such group; found {', '.join(levels) or 'none'}")
    columns = by or [name for name in responses.participants.columns if levels[name] <= MOST_LEVELS]
    several = _several(showings)
    if several:
        uses = showings.by_emotion()
    samples = resampled_counts(showings, seed)
    hits, n = (showings.choices == showings.right).sum(axis=1), (showings.choices >= 0).sum(axis=1)
    results = _of_matrix(
        responses.counts(),
        responses.labels,
        responses.signalled,
        seed,
        uses,
        unbiased_hit_intervals(showings, samples),
    )
    results = replace(
        results,
        n_participants=len(responses.participants),
        n_videos=len(set(showings.videos)),
        videos=_videos(showings, responses.signalled, seed)
        if len(set(showings.videos)) > len(set(showings.right))
        else {},
        accuracy=accuracy(results.counts, hits, n),
        information=information(results.counts, samples, seed, int((n > 0).sum())),
        flow=_flow(responses),
        dependence=_dependence(showings, responses.labels, seed),
        groups=_corrected_groups({column: _groups(responses, showings, column, seed) for column in columns}),
        group_differences=_corrected_differences(
            {column: _differences(responses, showings, column, bool(by), seed, margin) for column in columns}
        ),
    )
    too_many = [name for name in responses.participants.columns if not by and name not in columns]
    return replace(
        results,
        warnings=(*responses.warnings, *_reading_warnings(responses, showings), *_warnings(results)),
        notes=(
            *_notes(results, several),
            *responses.notes(),
            *(
                f"{name}: {levels[name]} levels, too many for a group; --by {name} compares them all the same"
                for name in too_many
            ),
        ),
    )


def analyze_counts(counts: Counts, labels: Sequence[str], signalled: Sequence[str], seed: int = 0) -> StudyResults:
    """Return the results of a confusion matrix (labels, signalled) without answers, for example a published table."""
    results = _of_matrix(counts, labels, signalled, seed)
    note = "participants are not known: answers count as independent, and nothing is tested within participants"
    return replace(results, warnings=tuple(_warnings(results)), notes=(note,))


def _flow(responses: Responses) -> Flow:
    """Return the numbers of participants and rows from the exports to the analysis."""
    analyzed = len(responses.participants)
    reconstructed = all(str(name).startswith("reconstructed") for name in responses.participants.index)
    return Flow(
        origin="simulated" if responses.simulated else "reconstructed" if reconstructed else "participants",
        enrolled=analyzed + sum(responses.dropped.values()),
        excluded=dict(responses.dropped),
        analyzed=analyzed,
        left_out=dict(responses.left_out),
        rejected=sum(not row.reason.startswith(LEFT_OUT) for row in responses.rejected),
        synonyms=responses.synonyms,
        repeats=responses.repeats,
        rules=responses.rules,
        quality=quality_signs(responses),
    )


def _several(showings: Showings) -> bool:
    """Return whether a participant answered more than one showing of an emotion."""
    return any((uses.sum(axis=1) > 1).any() for uses in showings.by_emotion())


def _of_matrix(
    counts: Counts,
    labels: Sequence[str],
    signalled: Sequence[str],
    seed: int,
    uses: Uses | None = None,
    intervals: NDArray[np.float64] | None = None,
) -> StudyResults:
    """Return the results of a confusion matrix; `uses` and `intervals` as for `recognize`."""
    errors = quasi_independence(counts)
    collapsed = {name: collapse(counts, labels, poles, ALPHA, uses) for name, poles in _POLES.items()}
    return StudyResults(
        **vars(_answers(counts, signalled, seed, None, uses, intervals)),
        emotions=tuple(signalled),
        labels=tuple(labels),
        n_videos=None,
        videos={},
        accuracy=accuracy(counts),
        information=information(counts, None),
        expected_errors=errors.expected,
        adjusted_residuals=errors.residuals,
        collapsed={name: found for name, found in collapsed.items() if found.videos},
        near_neighbours=near_neighbors(counts, labels, seed, uses),
        dependence=None,
        groups={},
        group_differences={},
        flow=None,
        warnings=(),
        notes=(),
    )


def _answers(
    counts: Counts,
    signalled: Sequence[str],
    seed: int,
    people: int | None,
    uses: Uses | None,
    intervals: NDArray[np.float64] | None = None,
) -> AnswerResults:
    fits = [goodness_of_fit(column, seed, None if uses is None else uses[j]) for j, column in enumerate(counts.T)]
    return AnswerResults(
        n_participants=people,
        n_responses=int(counts.sum()),
        counts=counts,
        percent=percent(counts),
        goodness_of_fit=dict(zip(signalled, fits, strict=True)),
        recognition=dict(zip(signalled, recognize(counts, ALPHA, uses, intervals), strict=True)),
    )


def _videos(showings: Showings, signalled: Sequence[str], seed: int) -> dict[str, VideoResults]:
    """Return the results of each video by its code."""
    emotions = dict(zip(showings.videos, showings.right.tolist(), strict=True))
    uses = [showings.uses(np.array(showings.videos) == video) for video in emotions]
    counts = np.stack([used.sum(axis=0) for used in uses], axis=1)
    right = np.arange(showings.k)[:, None] == np.array(list(emotions.values()))
    tests = against_chance(counts, right, ALPHA, uses)
    return {
        video: VideoResults(
            emotion=signalled[emotion],
            counts=counts[:, j],
            goodness_of_fit=goodness_of_fit(counts[:, j], seed, uses[j]),
            recognition=tests[j],
        )
        for j, (video, emotion) in enumerate(emotions.items())
    }


def _dependence(showings: Showings, labels: Sequence[str], seed: int) -> Dependence:
    choices, positions, right = showings.choices, showings.positions, showings.right
    known = bool((positions >= 1).any())
    return Dependence(
        fleiss_kappa=agreement(choices, showings.k),
        cochran_q=videos_differ(choices, right),
        total_recognition=total_recognition(choices, right),
        label_use=label_use(showings, np.array([label != NONE for label in labels])),
        order=order_effect(choices, positions, right, seed) if known else None,
    )


def _groups(responses: Responses, showings: Showings, column: str, seed: int) -> dict[str, AnswerResults]:
    """Return the results of each level of a group column."""
    levels = responses.participants[column].to_numpy()
    found = {}
    for level in levels_of(list(levels)):
        members = showings.of(levels == level)
        uses = members.by_emotion() if _several(members) else None
        found[level] = _answers(members.counts(), responses.signalled, seed, len(members.choices), uses)
    return found


def _differences(
    responses: Responses, showings: Showings, column: str, confirmatory: bool, seed: int, margin: float | None
) -> GroupDifferences:
    """Return how the levels of a group column differ."""
    group = list(responses.participants[column])
    rates = rates_differ(showings, group, seed, margin)
    return GroupDifferences(
        confirmatory=confirmatory,
        scores=scores_differ(showings, group, seed, margin),
        videos=dict(zip(responses.signalled, rates, strict=True)),
    )


def _corrected_groups(groups: Groups) -> Groups:
    """Return groups with Holm's correction over all their tests against chance: every column, level and emotion."""
    blocks = [(column, level) for column, levels in groups.items() for level in levels]
    tests = iter(corrected([test for c, level in blocks for test in groups[c][level].recognition.values()], ALPHA))
    return {
        column: {
            level: replace(block, recognition={name: next(tests) for name in block.recognition})
            for level, block in levels.items()
        }
        for column, levels in groups.items()
    }


def _corrected_differences(found: Mapping[str, GroupDifferences]) -> dict[str, GroupDifferences]:
    """Return differences with Holm's correction over all columns: of the scores, and of the emotions."""
    scores = iter(holm(np.array([column.scores.p for column in found.values()], dtype=float)).tolist())
    videos = iter(
        holm(np.array([t.p for column in found.values() for t in column.videos.values()], dtype=float)).tolist()
    )
    return {
        name: replace(
            column,
            scores=replace(column.scores, p_holm=next(scores)),
            videos={video: replace(test, p_holm=next(videos)) for video, test in column.videos.items()},
        )
        for name, column in found.items()
    }


def _warnings(results: StudyResults) -> Iterable[str]:
    """Yield limitations of the results: small numbers, and labels other than the six of the paper."""
    yield from _fit_warnings(results)
    for column, levels in results.groups.items():
        small = [level for level, block in levels.items() if (block.n_participants or 0) < MIN_GROUP]
        if small:
            few = f"fewer than {MIN_GROUP} participants in {', '.join(small)}"
            yield f"{column}: {few}; interpret their tests with caution"
    without = [label for label in results.labels if label not in results.emotions and label != NONE]
    if without:
        yield f"no video shows {', '.join(without)}: rows of the matrix without a column"
    unplaced = [name for name in results.emotions if name not in ANGLES]
    if unplaced:
        yield (
            f"{', '.join(unplaced)}: no known position on the circumplex, so there is no figure of it, and tests of "
            "valence, arousal and near neighbors leave them out"
        )


def _fit_warnings(results: StudyResults) -> Iterable[str]:
    yield from _bias_warnings(results)
    without = [name for name, fit in results.goodness_of_fit.items() if not fit.n]
    if without:
        yield f"{', '.join(without)}: no answers to a video of {'it' if len(without) == 1 else 'them'}"
    fits = {name: fit for name, fit in results.goodness_of_fit.items() if fit.n and fit.expected < SMALL_EXPECTED}
    if fits:
        least = min(fit.expected for fit in fits.values())
        names = "all emotions" if len(fits) == len(results.emotions) > 1 else ", ".join(fits)
        yield f"{names}: {least:.1f} answers a cell are expected, under {SMALL_EXPECTED}: use the exact p"
    for j, (name, fit) in enumerate(results.goodness_of_fit.items()):
        if fit.p_exact <= ALPHA and not results.recognition[name].above_chance:
            column = results.counts[:, j]
            most = [label for label, n in zip(results.labels, column, strict=True) if n == column.max()]
            why = (
                "yet it is not above chance"
                if name in most
                else f"but not because it was recognized: most said {' and '.join(most)}"
            )
            yield f"{name}: the answers are not uniform, {why}"


def _bias_warnings(results: StudyResults) -> Iterable[str]:
    """Yield emotions above chance that the popularity of their label may explain alone."""
    popular = beyond_popularity(results, False)
    if popular:
        yield (
            f"{', '.join(popular)}: above 1/{len(results.labels)}, but not above what the popularity of the label "
            "alone gives: the interval of the unbiased hit rate contains its chance level"
        )
    total = results.dependence.total_recognition if results.dependence else None
    if total is not None and total.p > ALPHA and any(test.above_chance for test in results.recognition.values()):
        yield (
            f"all hits together ({total.hits} of {total.n}) are not more than the same answers shuffled over the "
            f"videos give ({total.expected:.1f}, p = {total.p:.3f}): preferred labels may be all that there is"
        )


def beyond_popularity(results: StudyResults, shown: bool) -> list[str]:
    """Return emotions above chance whose unbiased hit rate is, or is not, shown to be above its chance level."""
    return [
        name
        for name, found in results.recognition.items()
        if found.above_chance and not np.isnan(found.hu_low) and (found.hu_low > found.hu_chance) == shown
    ]


def _reading_warnings(responses: Responses, showings: Showings) -> Iterable[str]:
    if responses.rejected:
        yield f"{len(responses.rejected)} rows or cells were not used: see rejected.csv"
    if responses.dropped:
        yield "participants left out: " + ", ".join(f"{number} {why}" for why, number in responses.dropped.items())
    by_video = len(set(showings.videos)) * len(showings.choices)
    missing = by_video - len(responses.answers.drop_duplicates(["participant", "video"]))
    if missing:
        yield f"{missing} of {by_video} answers are missing" + (" or were left out" if responses.left_out else "")


def _notes(results: StudyResults, several: bool) -> Iterable[str]:
    """Yield notes that apply to every study of this kind."""
    yield "answers of one participant depend on each other: tests across videos permute or resample participants"
    if several:
        yield (
            "participants answered several videos of one emotion: the results of an emotion pool all of them, tests "
            "permute each participant's answers together, and intervals use the effective number of answers"
        )
    exploratory = [name for name, found in results.group_differences.items() if not found.confirmatory]
    if exploratory:
        yield (
            f"{', '.join(exploratory)}: groups found in the data, not named with --by, so their tests are exploratory"
        )
