"""`emovid study analyze`, `columns` and `compare`: from survey exports to tables, tests, figures and a report."""

import json
from functools import partial
from math import isnan
from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.table import Table

from emovid.cli.options import Json, Quiet, RandomSeed, output_folder, refuse_with
from emovid.cli.terminal import show_table
from emovid.errors import InputError
from emovid.report import apa
from emovid.report.results_json import as_json
from emovid.responses.describe_columns import describe_columns
from emovid.responses.quality import rules_from
from emovid.responses.read import MOST_REJECTED, grouped
from emovid.responses.responses import Responses
from emovid.statistics.compare import VideoCompared
from emovid.statistics.goodness import Goodness
from emovid.statistics.recognition import Recognition
from emovid.workflows.analysis import (
    Analysis,
    analyze_exports,
    analyze_matrix,
    compare_studies,
    gives_several_answers,
    write_analysis,
)

_SHOWN = 20  # reasons of rejected rows on the terminal; rejected.csv has all rows

Key = Annotated[
    Path | None, typer.Option("--key", help="CSV with video_code,true_emotion, for blinded codes.", show_default=False)
]
Map = Annotated[
    Path | None, typer.Option("--map", help="map.yaml, for facts that are not detected.", show_default=False)
]
Labels = Annotated[
    str | None,
    typer.Option("--labels", help="The answers, separated by commas; default: the six emotions.", show_default=False),
]
Margin = Annotated[
    float | None,
    typer.Option(
        min=0, max=100, help="Margin of equivalence in percentage points, set before the study.", show_default=False
    ),
]


def analyze(
    sources: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[EXPORT]...", help="Exports, or folders of them.", show_default=False),
    ] = None,
    key: Key = None,
    mapping: Map = None,
    by: Annotated[
        list[str] | None,
        typer.Option(
            "--by",
            help="A group to compare, named beforehand; default: all groups of at most 12 levels, as exploratory.",
            show_default=False,
        ),
    ] = None,
    labels: Labels = None,
    counts: Annotated[
        Path | None,
        typer.Option("--counts", help="A published confusion matrix, instead of exports.", show_default=False),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder for results, created if missing.")] = Path(
        "results"
    ),
    margin: Margin = None,
    include_pilots: Annotated[bool, typer.Option("--include-pilots", help="Count the answers of pilot runs.")] = False,
    rules: Annotated[
        list[str] | None,
        typer.Option(
            "--exclude",
            metavar="RULE",
            help="A rule of exclusion fixed beforehand: straightliners, failed_checks, min_response_ms=300, "
            "min_watched=0.9, max_dropped=0.1 or max_stalled_ms=1000.",
            show_default=False,
        ),
    ] = None,
    max_rejected: Annotated[
        float, typer.Option(min=0, max=1, help="Largest share of rows or participants that may be unusable.")
    ] = MOST_REJECTED,
    seed: RandomSeed = 0,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Analyze survey exports: matrix, tests, figures, report.

    Examples: emovid study analyze responses.csv · emovid study analyze exports/ --key key.csv --by gender -o results/
    """
    if bool(sources) == bool(counts):
        raise InputError("expected exports to analyze, or --counts and a confusion matrix")
    output_folder(output)
    if counts:
        others = {"--key": key, "--map": mapping, "--by": by, "--labels": labels, "--margin": margin}
        refuse_with("--counts", others | {"--exclude": rules})
        analysis = analyze_matrix(counts, seed)
    else:
        how = (seed, _share(margin), include_pilots, max_rejected, rules_from(rules or []))
        analysis = analyze_exports(sources or [], key, mapping, _labels(labels), by or [], *how)
    text = write_analysis(analysis, output)
    if as_json:
        typer.echo(text, nl=False)
    elif not quiet:
        _show(analysis, output)


def _labels(text: str | None) -> list[str] | None:
    return None if text is None else [label.strip() for label in text.split(",")]


def _share(points: float | None) -> float | None:
    return None if points is None else points / 100


def _show(analysis: Analysis, output: Path) -> None:
    """Print what was read, the matrix, the tests and the warnings."""
    results = analysis.results
    if analysis.responses is not None:
        _show_reading(analysis.responses)
    if results.flow is not None and results.flow.origin != "participants":
        typer.echo(f"{results.flow.origin.upper()}: these are not the answers of real participants")
    matrix = Table("response (%)", *results.emotions, box=box.SIMPLE, title="signaled emotion")
    for label, row in zip(results.labels, results.percent, strict=True):
        matrix.add_row(label, *("" if isnan(share) else f"{share:.2f}" for share in row))
    tests = Table(
        "emotion", "n", "chi2", "p", "exact p", "w", "hits", "CI %", "Holm p", "majority, p", box=box.SIMPLE, padding=0
    )
    for name, fit in results.goodness_of_fit.items():
        tests.add_row(name, *_test_cells(fit, results.recognition[name]))
    show_table(matrix)
    show_table(tests)
    for title, lines in (("warnings", results.warnings), ("notes", results.notes)):
        if lines:
            table = Table(title, box=box.SIMPLE)
            for line in lines:
                table.add_row(line)
            show_table(table)
    typer.echo(f"results in {output}: report.html, results.json, tables and figures")


def _show_reading(responses: Responses) -> None:
    say = partial(typer.echo, err=False)
    for source in responses.sources:
        say(f"{source.file}: {source.dialect}, {source.participants} participants")
    for note in responses.notes():
        say(note)
    for reason, number in responses.left_out.items():
        say(f"left out: {number} rows, {reason}")
    for synonym in responses.synonyms:
        say(f"{synonym.text!r} counts as {synonym.label}: {synonym.count} answers")
    lines = grouped(responses.rejected)
    for line in lines[:_SHOWN]:
        say(line)
    if len(lines) > _SHOWN:
        say(f"... and {len(lines) - _SHOWN} more in rejected.csv")


def _test_cells(fit: Goodness, found: Recognition) -> list[str]:
    """Return the numbers of one emotion's tests, as short as a terminal is wide."""

    def p(value: float) -> str:
        return "" if isnan(value) else "<.001" if value < 0.001 else f"{value:.3f}".removeprefix("0")

    return [
        str(fit.n),
        "" if isnan(fit.statistic) else f"{fit.statistic:.2f}",
        p(fit.p),
        p(fit.p_exact),
        "" if isnan(fit.cohens_w) else f"{fit.cohens_w:.2f}",
        str(found.hits),
        f"{100 * found.ci_low:.0f}-{100 * found.ci_high:.0f}",
        p(found.p_holm),
        found.verdict.removesuffix(" majority") + (f" {p(found.p_verdict)}" if found.verdict != "neither" else ""),
    ]


def columns(
    source: Annotated[Path, typer.Argument(metavar="EXPORT", help="A survey's export, or a folder of them.")],
    key: Key = None,
    mapping: Map = None,
    labels: Labels = None,
) -> None:
    """Show the role of each column of an export, and the evidence for it.

    The output is a map.yaml to edit, with the columns as comments.

    Example: emovid study columns export.csv > map.yaml
    """
    found = describe_columns(source, key, mapping, _labels(labels))
    said = "; ".join(part for part in (found.dialect, found.problem) if part)
    typer.echo(f"# {found.file}: {said}")
    for column in found.columns:
        name = " ".join(f"{column.name} ({column.text})".removesuffix(" ()").split())  # a question may have lines
        why = f" [{column.evidence}]" if column.evidence else ""
        typer.echo(f"# {column.role or 'not used':<12} {name}: {', '.join(map(repr, column.examples))}{why}")
    typer.echo(found.map_yaml, nl=False)


def compare(
    original: Annotated[Path, typer.Argument(help="The results of an analysis, or a confusion matrix as CSV.")],
    replication: Annotated[Path, typer.Argument(help="The results of another, with the same labels.")],
    margin: Margin = None,
    seed: RandomSeed = 0,
    print_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Compare a replication with the original study.

    Prints the difference of each recognition rate with its confidence interval and test, and a test of the whole
    matrix. Folders of two analyses let it shuffle participants; a matrix does not say who gave which answers.

    Examples: emovid study compare original/results.json results/results.json · emovid study compare a/ b/ --margin 15
    """
    signalled, found = compare_studies(original, replication, seed, _share(margin))
    videos = dict(zip(signalled, found.videos, strict=True))
    if print_json:
        typer.echo(json.dumps({**as_json(found), "videos": as_json(videos)}, indent=2, allow_nan=False))
        return
    for name, video in videos.items():
        typer.echo(
            f"{name:<11}{video.hits[0]}/{video.n[0]} and {video.hits[1]}/{video.n[1]}".ljust(30) + _compared(video)
        )
    typer.echo(f"whole matrix: {apa.compared(found)}")
    for study in dict.fromkeys((original, replication) if found.shuffled == "answers" else ()):
        if gives_several_answers(study):
            typer.echo(
                f"{study}: participants gave several answers to an emotion, which count as independent here, so p "
                "values and intervals are too small; expected the folders of both analyses, with responses_tidy.csv"
            )


def _compared(video: VideoCompared) -> str:
    """Return the sentences that compare one emotion in two studies."""
    if not all(video.n):
        return "no answers to compare"
    pair = video.rates
    low, high, points = (100 * value for value in (pair.ci_low, pair.ci_high, pair.difference))
    parts = [
        f"{points:+6.1f} points [{low:+.1f}, {high:+.1f}]",
        apa.p_value(video.p_holm, "Holm p"),
        apa.equivalence(pair),
        apa.bayes_factor(video.replication_bf, "replication BF"),
        f"pooled {100 * video.pooled:.1f}% [{100 * video.pooled_low:.1f}, {100 * video.pooled_high:.1f}]",
    ]
    return ", ".join(parts)
