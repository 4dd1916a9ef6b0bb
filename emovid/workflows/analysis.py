"""From exports to a folder of results, and from two folders to a comparison."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from emovid.atomic_io import file_digest, make_folder, writing
from emovid.errors import InputError
from emovid.figures.study import figure_data, study_figures
from emovid.figures.style import encoded
from emovid.report.page import report_html
from emovid.report.tables import result_files
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses, Source
from emovid.responses.results_files import read_matrix, read_results
from emovid.statistics.analyze import analyze, analyze_counts
from emovid.statistics.compare import Compared, aligned, compare
from emovid.statistics.results import Provenance, StudyResults
from emovid.version import __version__

_PRINTED = ("pdf", "png")


@dataclass(frozen=True, eq=False)
class Analysis:
    """Results, and the answers they come from: None for a published matrix."""

    results: StudyResults
    responses: Responses | None


def analyze_exports(
    sources: Sequence[Path],
    key: Path | None = None,
    mapping: Path | None = None,
    labels: Sequence[str] | None = None,
    by: Sequence[str] = (),
    seed: int = 0,
    margin: float | None = None,
) -> Analysis:
    """Return the analysis of exports; arguments as for `read_responses` and `analyze`."""
    responses = read_responses(sources, key=key, mapping=mapping, labels=labels, groups=by)
    provenance = Provenance(responses.sources, file_digest(key) if key else None, __version__, seed)
    return Analysis(replace(analyze(responses, by, seed, margin), provenance=provenance), responses)


def analyze_matrix(counts: Path, seed: int = 0) -> Analysis:
    """Return the analysis of a published confusion matrix."""
    matrix, labels, signalled = read_matrix(counts)
    source = Source(str(counts), "confusion matrix", file_digest(counts), 0)
    provenance = Provenance((source,), None, __version__, seed)
    return Analysis(replace(analyze_counts(matrix, labels, signalled, seed), provenance=provenance), None)


def write_analysis(analysis: Analysis, output: Path) -> str:
    """Write tables, figures and report into a folder; return the text of results.json."""
    figures = study_figures(figure_data(analysis.results))
    pictures = {name: (caption, encoded(figure, "svg")) for name, (caption, figure) in figures.items()}
    texts = result_files(analysis.results, analysis.responses)
    texts["report.html"] = report_html(analysis.results, analysis.responses, pictures)
    files = {name: text.encode() for name, text in texts.items()}
    files |= {f"{name}.{kind}": encoded(figure, kind) for name, (_, figure) in figures.items() for kind in _PRINTED}
    make_folder(output)
    for name, data in files.items():
        with writing(output / name) as file:
            file.write(data)
    return texts["results.json"]


def compare_studies(
    original: Path, replication: Path, seed: int = 0, margin: float | None = None
) -> tuple[tuple[str, ...], Compared]:
    """Return the signalled emotions of two analyses, and their comparison.

    Raises:
        InputError: if the studies have different labels.
    """
    studies = read_results(original), read_results(replication)
    try:
        first, second, signalled = aligned(*studies)
    except ValueError:
        labels = ", ".join(studies[0][1])
        raise InputError(f"{replication}: other labels than {original}: expected {labels}") from None
    return signalled, compare(first, second, seed, margin)
