"""Answers of a study: one for each participant and video, from any survey tool."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Rejected

# The order of the rows and columns of the paper's Table III.
EMOTIONS = ("happiness", "surprise", "anger", "fear", "disgust", "sadness")
# Columns of the table that our own survey exports: the first ones, and those that hold no groups of participants.
SURVEY_COLUMNS = ("participant", "video", "position", "response")
RECORDED = (
    "first_response", "changes", "confidence", "valence", "arousal", "choices", "plays", "watched_share",
    "shown_seconds", "played_seconds", "first_answer_seconds", "answer_seconds", "width", "height", "frames",
    "dropped_frames", "ended_seconds", "stalls", "stalled_ms", "play_ms", "response_ms", "playback",
    "device", "checks", "order_row", "consent_version", "language", "kit_version", "status", "mode",
)  # fmt: skip
UNSUBMITTED = "unsubmitted"  # status of a participant who answered all videos and did not submit
FAILED_CHECK = "failed check"  # status of a participant whom a failed attention check excludes
SMOOTH = "smooth"  # playback within the study's limits


@dataclass(frozen=True)
class Source:
    """A file that was read.

    Attributes:
        file: its name as given.
        dialect: the format it was recognized as, in words ("Google Forms", "long table").
        sha256: digest of its bytes.
        participants: number of participants whose answers are used.
        note: how participants were identified, if no column names them; or "".
    """

    file: str
    dialect: str
    sha256: str
    participants: int
    note: str = ""


@dataclass(frozen=True)
class Synonym:
    """A text that counts as a label although it is not the label itself, such as "joy" for happiness.

    Attributes:
        text: as in the files.
        label: that it counts as.
        count: number of answers.
        by_map: whether the map declares it.
    """

    text: str
    label: str
    count: int
    by_map: bool = False


Repeats = Literal["first", "last", "all"]


@dataclass(frozen=True, eq=False)
class Responses:
    """The answers of a study.

    Attributes:
        signalled: labels of videos, in the order of the columns of tables.
        labels: answers that participants can give, in the order of the rows of tables: `signalled`, then labels that no
            video stands for, and last "none" if the survey offers "none of these".
        answers: one row for each answer, with the columns `participant`, `video`, `signalled`, `perceived` (text) and
            `position` (Int64, counted from 1; missing where the order is unknown).
        participants: indexed by participant, one text column for each group (gender, robotics_background, age, ...).
        sources: the files.
        rejected: rows and cells that could not be used.
        dropped: number of participants left out, by reason ("preview", "partial", "bot", "test run", ...); 0 for a
            value of the map that nobody has.
        left_out: number of rows left out of the answers of participants who stay, by reason ("practice", ...).
        synonyms: texts that count as a label that they do not spell.
        repeats: which of several answers of a participant to one video count, as the map says; None without a map.
            With "all", the answers of a participant are clustered.
        simulated: whether model participants gave any of the answers.
        warnings: sentences that every reader of the results must see.
        places: file and line of each answer, if the answers come from files.
        quality: numbers beside each answer, such as watched_share and response_ms, as far as the files have them.
        rules: rules of exclusion that were applied, as on the command line (`quality.ExclusionRules`).
    """

    signalled: tuple[str, ...]
    labels: tuple[str, ...]
    answers: pd.DataFrame
    participants: pd.DataFrame
    sources: tuple[Source, ...] = ()
    rejected: tuple[Rejected, ...] = ()
    dropped: dict[str, int] = field(default_factory=dict)
    left_out: dict[str, int] = field(default_factory=dict)
    synonyms: tuple[Synonym, ...] = ()
    repeats: Repeats | None = None
    simulated: bool = False
    warnings: tuple[str, ...] = ()
    places: pd.DataFrame = field(default_factory=pd.DataFrame)
    quality: pd.DataFrame = field(default_factory=pd.DataFrame)
    rules: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"Responses({len(self.participants)} participants, {len(self.answers)} answers, {len(self.labels)} labels)"
        )

    def notes(self) -> list[str]:
        """Return the notes of the sources; files that share a note share a line."""
        files: dict[str, list[str]] = {}
        for source in self.sources:
            files.setdefault(source.note, []).append(source.file)
        more = {note: f" and {len(names) - 1} more" if len(names) > 1 else "" for note, names in files.items()}
        return [f"{names[0]}{more[note]}: {note}" for note, names in files.items() if note]

    def counts(self) -> NDArray[np.int64]:
        """Return the confusion matrix (labels, signalled): rows perceived, columns signaled, as in Table III."""
        perceived = pd.Index(self.labels).get_indexer(self.answers["perceived"])
        signalled = pd.Index(self.signalled).get_indexer(self.answers["signalled"])
        matrix = np.zeros((len(self.labels), len(self.signalled)), dtype=np.int64)
        np.add.at(matrix, (perceived, signalled), 1)
        return matrix
