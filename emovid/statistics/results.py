"""The results of a study, as the analysis makes them and tables, report and figures take them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emovid.responses.quality import QualitySign
from emovid.responses.responses import Source, Synonym
from emovid.statistics.confusions import NearNeighbors
from emovid.statistics.goodness import Goodness
from emovid.statistics.groups import RatesDiffer, ScoresDiffer
from emovid.statistics.participants import Agreement, LabelUse, Order, TotalRecognition, VideosDiffer
from emovid.statistics.recognition import Accuracy, AgainstChance, Collapsed, Recognition
from emovid.statistics.resampling import Information


@dataclass(frozen=True, eq=False)
class AnswerResults:
    """Results that a whole study and each of its groups have.

    Attributes:
        n_participants: None where they are not known.
        n_responses: answers.
        counts: confusion matrix (labels, signalled).
        percent: of the columns (labels, signalled), NaN where a column is empty.
        goodness_of_fit: of each signaled emotion.
        recognition: of each signaled emotion.
    """

    n_participants: int | None
    n_responses: int
    counts: NDArray[np.int64]
    percent: NDArray[np.float64]
    goodness_of_fit: Mapping[str, Goodness]
    recognition: Mapping[str, Recognition]


@dataclass(frozen=True, eq=False)
class VideoResults:
    """Results of one video where an emotion has several.

    Attributes:
        emotion: that it signals.
        counts: answers by label (labels,).
        goodness_of_fit: of the answers.
        recognition: hits against guessing, corrected over all videos.
    """

    emotion: str
    counts: NDArray[np.int64]
    goodness_of_fit: Goodness
    recognition: AgainstChance


@dataclass(frozen=True, eq=False)
class Dependence:
    """Tests that take the answers of a participant together; `order` is None where positions are not known."""

    fleiss_kappa: Agreement
    cochran_q: VideosDiffer
    total_recognition: TotalRecognition
    label_use: LabelUse
    order: Order | None


@dataclass(frozen=True, eq=False)
class GroupDifferences:
    """How the levels of a group differ: in their scores, and emotion by emotion.

    Attributes:
        confirmatory: whether the group was named beforehand; else it was found in the data, and is exploratory.
        scores: the mean scores.
        videos: the hits on each signaled emotion.
    """

    confirmatory: bool
    scores: ScoresDiffer
    videos: Mapping[str, RatesDiffer]


@dataclass(frozen=True)
class Provenance:
    """Source of the results.

    Attributes:
        inputs: the files.
        key_sha256: of the key of the blinded codes, None without one.
        version: of emovid.
        seed: of everything random.
    """

    inputs: tuple[Source, ...]
    key_sha256: str | None
    version: str
    seed: int


@dataclass(frozen=True)
class Flow:
    """Participants and rows from the exports to the analysis.

    Attributes:
        origin: of the answers: "participants", "simulated" (model participants) or "reconstructed" (from totals).
        enrolled: participants in the exports.
        excluded: participants left out, by reason.
        analyzed: participants with at least one answer.
        left_out: rows left out of the answers of participants who stay, by reason.
        rejected: rows and cells that could not be used.
        synonyms: texts that count as a label that they do not spell.
        repeats: which of several answers of a participant to one video count; None where nothing says it.
        rules: rules of exclusion that the analysis was told to apply.
        quality: signs of careless answers and of poor playback among what is analyzed.
    """

    origin: str
    enrolled: int
    excluded: Mapping[str, int]
    analyzed: int
    left_out: Mapping[str, int]
    rejected: int
    synonyms: tuple[Synonym, ...]
    repeats: str | None
    rules: tuple[str, ...]
    quality: tuple[QualitySign, ...]


@dataclass(frozen=True, eq=False)
class StudyResults(AnswerResults):
    """The results of a study.

    Attributes:
        emotions: signaled emotions, the columns of the matrix.
        labels: answers on offer, its rows, the emotions first.
        n_videos: None where they are not known.
        videos: results of each video by its code, where an emotion has several; else empty.
        accuracy: all answers together.
        information: what answers tell about videos.
        expected_errors: wrong answers (labels, signalled) under quasi-independence (`confusions.Errors`).
        adjusted_residuals: of the wrong answers (labels, signalled), NaN for right ones.
        collapsed: recognition of valence and arousal, for emotions that have a place on the circumplex.
        near_neighbours: whether confusions fall on near neighbors of the circumplex.
        dependence: None where participants are not known.
        groups: results of each level of each group.
        group_differences: of each group.
        flow: of participants; None where they are not known.
        warnings: what limits the results, the most important first.
        notes: what a reader of the results should know besides.
        provenance: None until the files are known.
    """

    emotions: tuple[str, ...]
    labels: tuple[str, ...]
    n_videos: int | None
    videos: Mapping[str, VideoResults]
    accuracy: Accuracy
    information: Information
    expected_errors: NDArray[np.float64]
    adjusted_residuals: NDArray[np.float64]
    collapsed: Mapping[str, Collapsed]
    near_neighbours: NearNeighbors
    dependence: Dependence | None
    groups: Mapping[str, Mapping[str, AnswerResults]]
    group_differences: Mapping[str, GroupDifferences]
    flow: Flow | None
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    provenance: Provenance | None = None

    def __repr__(self) -> str:
        return f"StudyResults({int(self.counts.sum())} answers to {len(self.emotions)} emotions)"
