"""`emovid study analyze`, `columns` and `compare`: from a survey's exports to tables, tests, figures and a report."""

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from emovid.cli.options import Json, Quiet, RandomSeed, refuse_beside
from emovid.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from emovid.responses.responses import Responses

_SHOWN = 200  # rejected rows on the terminal; rejected.csv has all

Key = Annotated[
    Path | None, typer.Option("--key", help="CSV with video_code,true_emotion, for blinded codes.", show_default=False)
]
Map = Annotated[Path | None, typer.Option("--map", help="YAML that says what cannot be detected.", show_default=False)]
Labels = Annotated[
    str | None,
    typer.Option("--labels", help="The answers, with commas between; default: the six emotions.", show_default=False),
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
        typer.Option("--by", help="A group to analyse by; default: all of at most 12 levels.", show_default=False),
    ] = None,
    labels: Labels = None,
    counts: Annotated[
        Path | None,
        typer.Option("--counts", help="A published confusion matrix, instead of exports.", show_default=False),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder for results, made if missing.")] = Path(
        "results"
    ),
    seed: RandomSeed = 0,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Analyze survey exports: matrix, tests, figures, report.

    Examples: emovid study analyze responses.csv · emovid study analyze exports/ --key key.csv --by gender -o results/
    """
    from emovid.atomic_io import make_folder, writing
    from emovid.figures.study import study_figures
    from emovid.figures.style import encoded
    from emovid.report.outputs import result_files
    from emovid.report.report import report_html

    if bool(sources) == bool(counts):
        raise InputError("expected exports to analyse, or --counts and a confusion matrix")
    if counts:
        refuse_beside("--counts", {"--key": key, "--map": mapping, "--by": by, "--labels": labels})
    if output.exists() and not output.is_dir():
        raise InputError(f"-o {output}: is a file; expected a folder")
    if counts:
        results, responses = _of_counts(counts, seed), None
    else:
        results, responses = _of_exports(sources or [], key, mapping, by or [], labels, seed)
    figures = study_figures(results)
    pictures = {caption: ("svg+xml", encoded(figure, "svg")) for caption, figure in figures.values()}
    files = result_files(results, responses) | {"report.html": report_html(results, responses, pictures)}
    make_folder(output)
    for name, text in files.items():
        with writing(output / name) as file:
            file.write(text.encode())
    _save_figures(figures, output)
    if as_json:
        typer.echo(files["results.json"], nl=False)
    elif not quiet:
        _show(results, responses, output)


def _of_counts(counts: Path, seed: int) -> dict[str, Any]:
    from emovid.atomic_io import file_digest
    from emovid.responses.results_files import read_matrix
    from emovid.statistics.analyze import analyze_counts

    matrix, labels, signalled = read_matrix(counts)
    inputs = [{"file": str(counts), "dialect": "confusion matrix", "sha256": file_digest(counts)}]
    return analyze_counts(matrix, labels, signalled, seed) | {"provenance": _provenance(inputs, None, seed)}


def _of_exports(
    sources: list[Path], key: Path | None, mapping: Path | None, by: list[str], labels: str | None, seed: int
) -> "tuple[dict[str, Any], Responses]":
    from dataclasses import asdict

    from emovid.responses.read import read_responses
    from emovid.statistics.analyze import analyze as run

    responses = read_responses(sources, key=key, mapping=mapping, labels=_labels(labels), groups=by)
    inputs = [asdict(source) for source in responses.sources]
    return run(responses, by, seed) | {"provenance": _provenance(inputs, key, seed)}, responses


def _labels(said: str | None) -> list[str] | None:
    return None if said is None else [label.strip() for label in said.split(",")]


def _provenance(inputs: list[dict[str, Any]], key: Path | None, seed: int) -> dict[str, Any]:
    from importlib.metadata import version

    from emovid.atomic_io import file_digest

    key_sha256 = file_digest(key) if key else None
    return {"inputs": inputs, "key_sha256": key_sha256, "version": version("emovid"), "seed": seed}


def _save_figures(figures: "Mapping[str, tuple[str, Figure]]", output: Path) -> None:
    from emovid.figures.style import save

    for name, (_, figure) in figures.items():
        for suffix in ("pdf", "png"):
            save(figure, output / f"{name}.{suffix}")


def _show(results: Mapping[str, Any], responses: "Responses | None", output: Path) -> None:
    """Print what was read, the matrix, the tests and the warnings."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from emovid.cli.terminal import show_table

    console = Console(highlight=False, markup=False)
    say = partial(console.print, soft_wrap=True)  # a line stays one line, however long its path
    if responses is not None:
        for source in responses.sources:
            say(f"{source.file}: {source.dialect}, {source.participants} participants")
        for note in responses.notes():
            say(note)
        for item in responses.rejected[:_SHOWN]:
            where = f"{item.file}:{item.row}" if item.row else item.file
            value = repr(item.value) if item.value else ""
            say(": ".join(part for part in (where, item.cell, value, item.reason) if part))
        if len(responses.rejected) > _SHOWN:
            say(f"... and {len(responses.rejected) - _SHOWN} more in rejected.csv")
    matrix = Table("response (%)", *results["emotions"], box=box.SIMPLE, title="signaled emotion")
    for label, row in zip(results["labels"], results["percent"], strict=True):
        matrix.add_row(label, *("" if share is None else f"{share:.2f}" for share in row))
    tests = Table(
        "emotion", "n", "chi2", "p", "exact p", "w", "hits", "CI %", "Holm p", "majority", box=box.SIMPLE, padding=0
    )
    for name, fit in results["goodness_of_fit"].items():
        tests.add_row(name, *_test_cells(fit, results["recognition"][name]))
    show_table(matrix)
    show_table(tests)
    if results["warnings"]:
        warnings = Table("warnings", box=box.SIMPLE)
        for warning in results["warnings"]:
            warnings.add_row(warning)
        show_table(warnings)
    say(f"results in {output}: report.html, results.json, tables and figures")


def _test_cells(fit: Mapping[str, Any], found: Mapping[str, Any]) -> list[str]:
    """Return the numbers of one video's tests, as short as a terminal is wide."""

    def p(value: float) -> str:
        return "<.001" if value < 0.001 else f"{value:.3f}".removeprefix("0")

    return [
        str(fit["n"]),
        f"{fit['statistic']:.2f}",
        p(fit["p"]),
        p(fit["p_exact"]),
        "" if fit["cohens_w"] is None else f"{fit['cohens_w']:.2f}",
        str(found["hits"]),
        f"{100 * found['ci_low']:.0f}-{100 * found['ci_high']:.0f}",
        p(found["p_holm"]),
        found["verdict"].removesuffix(" majority"),
    ]


def columns(
    source: Annotated[Path, typer.Argument(metavar="EXPORT", help="A survey's export, or a folder of them.")],
    key: Key = None,
    mapping: Map = None,
    labels: Labels = None,
) -> None:
    """Show which columns of an export are recognized.

    The output is a map.yaml to edit, with the columns as comments.

    Example: emovid study columns export.csv > map.yaml
    """
    from emovid.responses.describe_columns import describe_columns

    found = describe_columns(source, key, mapping, _labels(labels))
    said = "; ".join(part for part in (found.dialect, found.problem) if part)
    typer.echo(f"# {found.file}: {said}")
    for column in found.columns:
        name = " ".join(f"{column.name} ({column.text})".removesuffix(" ()").split())  # a question may have lines
        typer.echo(f"# {column.role or 'not used':<12} {name}: {', '.join(map(repr, column.examples))}")
    typer.echo(found.map_yaml, nl=False)


def compare(
    original: Annotated[Path, typer.Argument(help="The results of an analysis, or a confusion matrix as CSV.")],
    replication: Annotated[Path, typer.Argument(help="Others, with the same labels.")],
    seed: RandomSeed = 0,
    as_json: Json = False,
) -> None:
    """Compare a replication with the original study.

    Prints differences with confidence intervals, and a test of the whole matrix.

    Example: emovid study compare original/results.json results/results.json
    """
    from emovid.report import apa
    from emovid.responses.results_files import read_results
    from emovid.statistics.analyze import in_json
    from emovid.statistics.compare import aligned
    from emovid.statistics.compare import compare as run

    studies = read_results(original), read_results(replication)
    try:
        first, second, signalled = aligned(*studies)
    except ValueError:
        labels = ", ".join(studies[0][1])
        raise InputError(f"{replication}: other labels than {original}: expected {labels}") from None
    found = run(first, second, seed)
    if as_json:
        from dataclasses import asdict

        named = dict(zip(signalled, map(asdict, found.videos), strict=True))
        said = in_json(asdict(found) | {"videos": named, "apa": apa.compared(found)})
        typer.echo(json.dumps(said, indent=2, allow_nan=False))
        return
    for name, video in zip(signalled, found.videos, strict=True):
        rates = f"{video.hits[0]}/{video.n[0]} and {video.hits[1]}/{video.n[1]}"
        if not all(video.n):
            typer.echo(f"{name:<11}{rates:<19}no answers to compare")
            continue
        low, high, points = (100 * value for value in (video.ci_low, video.ci_high, video.difference))
        holm = apa.p_value(video.p_holm, "Holm p")
        typer.echo(f"{name:<11}{rates:<19}{points:+6.1f} points [{low:+.1f}, {high:+.1f}], {holm}")
    typer.echo(f"whole matrix: {apa.compared(found)}")
