"""Functions for notebooks and scripts that join several packages: figures, kits, simulated responses, tables."""

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from emovid.errors import InputError, nearest
from emovid.figures.catalogue import CATALOGUE, MEASURES, STUDY
from emovid.figures.run_cache import Material
from emovid.kit.build import Built
from emovid.kit.build import build as build_files
from emovid.kit.load import load_study
from emovid.responses.responses import Responses
from emovid.statistics.results import StudyResults
from emovid.workflows.figures import measures_of, study_results
from emovid.workflows.planning import ACCURACY, Rehearsal, simulated_answers


def paper_figure(name: str, study: str | Path | None = None) -> Figure:
    """Return a figure of the paper by its name, as in `emovid figures --list`.

    Args:
        name: of the figure.
        study: results of `emovid study analyze`; None for the reference study.

    Raises:
        InputError: for an unknown name, a table, or a study that has too little data.
    """
    entry = CATALOGUE.get(name)
    if entry is None or entry.data is not None:
        figures = [known for known, found in CATALOGUE.items() if found.data is None]
        remedy = nearest(name, figures) or f"; expected one of {', '.join(figures)}"
        raise InputError(f"{name}: no such figure{remedy}")
    results = Path(study) if study is not None else None
    return entry.figure(Material((), {STUDY: lambda _: study_results(results), MEASURES: measures_of}))


def build_kit(
    study: str | Path, output: str | Path, participants: int | None = None, seed: int | None = None, force: bool = False
) -> Built:
    """Build the kit of a study, as `emovid study build`.

    Args:
        study: its study.yaml, or the folder of one.
        output: the folder of the kit.
        participants: number of orders; None for that of the study.
        seed: of codes and orders, which anyone who knows it can repeat; None for a secret one.
        force: whether to replace a kit of another study or seed.
    """
    loaded = load_study(Path(study))
    count = loaded.study.participants if participants is None else participants
    return build_files(loaded, Path(output), count, seed, _Silent(), force=force)


def simulate_responses(participants: int = 45, accuracy: float = ACCURACY, seed: int = 0) -> pd.DataFrame:
    """Return the answers of simulated participants: participant, video, position, response; a row for each answer."""
    if participants < 1:
        raise InputError(f"participants: {participants}: expected at least 1")
    if not 0 <= accuracy <= 1:
        raise InputError(f"accuracy: {accuracy}: expected a share from 0 to 1")
    return simulated_answers(Rehearsal(participants, accuracy, seed=seed))


def confusion_table(study: Responses | StudyResults) -> pd.DataFrame:
    """Return the confusion matrix of a study with its labels: counts; rows perceived, columns signaled."""
    counts = study.counts() if isinstance(study, Responses) else study.counts
    columns = study.signalled if isinstance(study, Responses) else study.emotions
    rows, columns = pd.Index(study.labels, name="perceived"), pd.Index(columns, name="signalled")
    return pd.DataFrame(counts, rows, columns)


class _Silent:
    """Ignores the progress of videos."""

    def advanced(self, frames: int) -> None:
        """See `VideoReporter`."""

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        """See `VideoReporter`."""
