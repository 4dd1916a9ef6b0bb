"""From exports to a folder of results, and from two folders to a comparison."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from emovid.atomic_io import file_digest, make_folder, writing
from emovid.errors import InputError
from emovid.figures.study import figure_data, study_figures
from emovid.figures.style import encoded
from emovid.report.page import report_html
from emovid.report.tables import result_files
from emovid.responses.quality import NO_RULES, ExclusionRules, exclude
from emovid.responses.read import MOST_REJECTED, read_responses
from emovid.responses.responses import Responses, Source
from emovid.responses.results_files import (
    WRITTEN,
    files_of_analysis,
    is_results,
    list_of_files,
    read_matrix,
    read_participants,
    read_results,
)
from emovid.statistics.analyze import analyze, analyze_counts
from emovid.statistics.compare import Compared, aligned, arranged, compare
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
    include_pilots: bool = False,
    max_rejected: float = MOST_REJECTED,
    rules: ExclusionRules = NO_RULES,
) -> Analysis:
    """Return the analysis of exports; arguments as for `read_responses` and `analyze`, and rules of exclusion."""
    responses = read_responses(sources, key, mapping, labels, by, include_pilots, max_rejected)
    responses = exclude(responses, rules) if rules != NO_RULES else responses
    provenance = Provenance(responses.sources, file_digest(key) if key else None, __version__, seed)
    return Analysis(replace(analyze(responses, by, seed, margin), provenance=provenance), responses)


def analyze_matrix(counts: Path, seed: int = 0) -> Analysis:
    """Return the analysis of a published confusion matrix."""
    matrix, labels, signalled = read_matrix(counts)
    source = Source(str(counts), "confusion matrix", file_digest(counts), 0)
    provenance = Provenance((source,), None, __version__, seed)
    return Analysis(replace(analyze_counts(matrix, labels, signalled, seed), provenance=provenance), None)


def write_analysis(analysis: Analysis, output: Path) -> str:
    """Write tables, figures and report into a folder; return the text of results.json.

    Files of a former analysis in the folder are removed.

    Raises:
        InputError: if one of the files exists and no analysis wrote it.
    """
    figures = study_figures(figure_data(analysis.results))
    flow = analysis.results.flow
    origin = "" if flow is None or flow.origin == "participants" else flow.origin.upper()
    pictures = {name: (caption, encoded(figure, "svg", origin)) for name, (caption, figure) in figures.items()}
    texts = result_files(analysis.results, analysis.responses)
    texts["report.html"] = report_html(analysis.results, analysis.responses, pictures)
    files = {name: text.encode() for name, text in texts.items()}
    files |= {
        f"{name}.{kind}": encoded(figure, kind, origin) for name, (_, figure) in figures.items() for kind in _PRINTED
    }
    files[WRITTEN] = list_of_files(files)
    _remove_former(output, files)
    make_folder(output)
    for name, data in files.items():
        with writing(output / name) as file:
            file.write(data)
    return texts["results.json"]


def _remove_former(output: Path, files: Mapping[str, bytes]) -> None:
    """Remove the files of a former analysis; refuse to overwrite any other file."""
    former = files_of_analysis(output)
    is_listed = (output / WRITTEN).exists() or not (output / "results.json").exists()
    if is_listed or not is_results(output / "results.json"):  # results of version 0.1.0 have no list of files
        for name, data in files.items():
            target = output / name
            if name != WRITTEN and target.exists() and name not in former and target.read_bytes() != data:
                raise InputError(f"{target}: not written by an analysis; move it, or choose another folder with -o")
    for name, digest in former.items():
        target = output / name
        if target.is_file() and file_digest(target) != digest:
            raise InputError(f"{target}: changed since an analysis wrote it; move it, or choose another folder with -o")
    for name in former:
        if name not in files:
            (output / name).unlink(missing_ok=True)


def compare_studies(
    original: Path, replication: Path, seed: int = 0, margin: float | None = None
) -> tuple[tuple[str, ...], Compared]:
    """Return the signaled emotions of two analyses, and their comparison.

    Participants are shuffled over the studies where both have them, in the responses_tidy.csv of an analysis.

    Raises:
        InputError: if the studies have different labels.
    """
    studies = read_results(original), read_results(replication)
    try:
        first, second, order, signalled = aligned(*studies)
    except ValueError:
        labels = ", ".join(studies[0][1])
        raise InputError(f"{replication}: other labels than {original}: expected {labels}") from None
    uses = read_participants(original), read_participants(replication)
    people = None
    if uses[0] is not None and uses[1] is not None:
        people = (
            arranged(uses[0], *studies[0][1:], order, signalled),
            arranged(uses[1], *studies[1][1:], order, signalled),
        )
    return signalled, compare(first, second, seed, margin, people)


def gives_several_answers(study: Path) -> bool:
    """Return whether participants gave several answers to an emotion, as far as the results.json tells."""
    file = study / "results.json" if study.is_dir() else study
    if file.suffix.lower() != ".json":
        return False
    tests = json.loads(file.read_bytes()).get("recognition", {}).values()
    return any(test.get("participants", test["n"]) < test["n"] for test in tests)
