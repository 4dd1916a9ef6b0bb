"""The files of the results folder: tables to compute with, as CSV, and to print, as Markdown and LaTeX.

The confusion matrix is laid out as the paper's Table III: rows are the perceived labels, columns the signaled ones.
"""

from collections.abc import Sequence
from dataclasses import astuple
from math import isnan

import numpy as np

from emovid.csv_writer import csv_of_columns, csv_text
from emovid.latex import latex_text
from emovid.report.results_json import results_json
from emovid.responses.responses import Responses
from emovid.responses.results_files import CORNER, PERCENT
from emovid.statistics.confusions import Counts, percent
from emovid.statistics.results import AnswerResults, StudyResults

_TESTS = (
    ("n", "n", "{:d}"),
    ("hits", "hits", "{:d}"),
    ("rate", "rate", "{:.4f}"),
    ("ci_low", "ci_low", "{:.4f}"),
    ("ci_high", "ci_high", "{:.4f}"),
    ("statistic", "chi_squared", "{:.3f}"),
    ("dof", "dof", "{:d}"),
    ("p", "p", "{:.3g}"),
    ("p_exact", "p_exact", "{:.3g}"),
    ("p_method", "p_exact_method", "{}"),
    ("cohens_w", "cohens_w", "{:.3f}"),
    ("p_binomial", "p_binomial", "{:.3g}"),
    ("p_holm", "p_holm", "{:.3g}"),
    ("hu", "hu", "{:.3f}"),
    ("verdict", "verdict", "{}"),
)


def result_files(results: StudyResults, responses: Responses | None) -> dict[str, str]:
    """Return the text of each file of the results folder, by name.

    Args:
        results: from `analyze` or `analyze_counts`.
        responses: the answers, if there are any.
    """
    counts, labels, signalled = results.counts, results.labels, results.emotions
    files = {
        "results.json": results_json(results),
        "confusion_matrix.csv": matrix_csv(counts, labels, signalled),
        "confusion_matrix.md": matrix_markdown(counts, labels, signalled),
        "confusion_matrix.tex": matrix_latex(counts, labels, signalled),
        "tests.csv": csv_text(["group", "level", "emotion", *(name for _, name, _ in _TESTS)], test_rows(results)),
        "tests.tex": tests_latex(results),
    }
    if responses is not None:
        rejected = map(astuple, responses.rejected)
        files["responses_tidy.csv"] = tidy_csv(responses)
        files["rejected.csv"] = csv_text(["file", "row", "cell", "value", "reason"], rejected)
    return files


def tidy_csv(responses: Responses) -> str:
    """Return one row for each participant and video, the participant's groups repeated in it.

    A group whose name is that of another column of the table has "(group)" after it.
    """
    taken = {*responses.answers.columns, "correct"}
    groups = responses.participants.rename(columns=lambda name: f"{name} (group)" if name in taken else name)
    table = responses.answers.merge(groups, left_on="participant", right_index=True, how="left")
    table = table.assign(correct=(table["signalled"] == table["perceived"]).astype(int))
    cells = (table[name].astype(object).where(table[name].notna(), "") for name in table)
    return csv_of_columns(list(map(str, table.columns)), cells)


def test_rows(results: StudyResults) -> list[list[str]]:
    """Return a row of tests for each emotion, of the whole study and of each level of each group."""
    rows = _rows("", "", results)
    for column, levels in results.groups.items():
        for level, block in levels.items():
            rows += _rows(column, level, block)
    return rows


def _rows(column: str, level: str, block: AnswerResults) -> list[list[str]]:
    rows = []
    for name, fit in block.goodness_of_fit.items():
        values = {**vars(fit), **vars(block.recognition[name]), "p_method": fit.method}
        cells = ["" if _is_undefined(values[key]) else form.format(values[key]) for key, _, form in _TESTS]
        rows.append([column, level, name, *cells])
    return rows


def _is_undefined(value: float | str) -> bool:
    return isinstance(value, float) and isnan(value)


def tests_latex(results: StudyResults) -> str:
    """Return the tests of the whole study as a booktabs table."""
    lines = []
    for name, fit in results.goodness_of_fit.items():
        found = results.recognition[name]
        interval = f"{100 * found.rate:.1f} [{100 * found.ci_low:.1f}, {100 * found.ci_high:.1f}]" if found.n else "--"
        cells = (
            latex_text(name.capitalize()),
            f"{found.hits}/{found.n}",
            interval,
            _fixed(fit.statistic, 2),
            _p(fit.p),
            _p(fit.p_exact),
            _fixed(fit.cohens_w, 2),
            _p(found.p_holm),
            _fixed(found.hu, 2),
        )
        lines.append("  " + " & ".join(cells) + r" \\")
    head = r"  Emotion & Hits & \% [95\% CI] & $\chi^2$ & $p$ & exact $p$ & $w$ & $p$ (chance, Holm) & $H_u$ \\"
    return "\n".join(
        (
            r"\begin{tabular}{lrrrrrrrr}",
            r"  \toprule",
            head,
            r"  \midrule",
            *lines,
            r"  \bottomrule",
            r"\end{tabular}",
            "",
        )
    )


def _fixed(value: float, decimals: int) -> str:
    return "--" if isnan(value) else f"{value:.{decimals}f}"


def _p(p: float) -> str:
    return "--" if isnan(p) else "$<$ .001" if p < 0.001 else f"{p:.3f}".removeprefix("0")


def matrix_csv(counts: Counts, labels: Sequence[str], signalled: Sequence[str]) -> str:
    """Return the counts, and after them the percentages, as CSV text."""
    shares = percent(counts).tolist()
    rows = (
        [label, *row, *map(_two_decimals, of_column)]
        for label, row, of_column in zip(labels, counts.tolist(), shares, strict=True)
    )
    return csv_text([CORNER, *signalled, *(name + PERCENT for name in signalled)], rows)


def matrix_markdown(counts: Counts, labels: Sequence[str], signalled: Sequence[str]) -> str:
    """Return the matrix as a Markdown table: percent, the diagonal bold, and counts in brackets."""
    heads = [name.capitalize().replace("|", r"\|") for name in labels]
    lines = [
        "| Response | " + " | ".join(heads[: len(signalled)]) + " |",
        "|---|" + "--:|" * len(signalled),
    ]
    for head, row in zip(heads, _cells(counts, labels, signalled, "**{}**"), strict=True):
        lines.append(f"| {head} | " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n"


def matrix_latex(counts: Counts, labels: Sequence[str], signalled: Sequence[str]) -> str:
    """Return the matrix as a booktabs table, the diagonal bold."""
    heads = [latex_text(name.capitalize()) for name in labels]
    body = "\n".join(
        f"  {head} & " + " & ".join(row) + r" \\"
        for head, row in zip(heads, _cells(counts, labels, signalled, r"\textbf{{{}}}"), strict=True)
    )
    return "\n".join(
        (
            r"\begin{tabular}{l" + "r" * len(signalled) + "}",
            r"  \toprule",
            rf"  & \multicolumn{{{len(signalled)}}}{{c}}{{Signaled Emotion}} \\",
            rf"  Response (\%) & {' & '.join(heads[: len(signalled)])} \\",
            r"  \midrule",
            body,
            r"  \bottomrule",
            r"\end{tabular}",
            "",
        )
    )


def _cells(counts: Counts, labels: Sequence[str], signalled: Sequence[str], bold: str) -> list[list[str]]:
    shares = percent(counts)
    return [
        [
            (bold if label == name else "{}").format(_two_decimals(shares[i, j])) + f" ({counts[i, j]})"
            for j, name in enumerate(signalled)
        ]
        for i, label in enumerate(labels)
    ]


def _two_decimals(share: float) -> str:
    return "" if np.isnan(share) else f"{share:.2f}"
