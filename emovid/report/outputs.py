"""The files of `results/`: tables to compute with and to print."""

import json
from collections.abc import Mapping
from dataclasses import astuple
from typing import Any

import numpy as np

from emovid.csv_writer import csv_text
from emovid.report.matrix_tables import latex_text, matrix_csv, matrix_latex, matrix_markdown
from emovid.responses.responses import Responses

Block = Mapping[str, Any]

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
    ("cohens_w", "cohens_w", "{:.3f}"),
    ("p_binomial", "p_binomial", "{:.3g}"),
    ("p_holm", "p_holm", "{:.3g}"),
    ("hu", "hu", "{:.3f}"),
    ("verdict", "verdict", "{}"),
)


def result_files(results: Block, responses: Responses | None) -> dict[str, str]:
    """Return the text of each file of the results folder, by name.

    Args:
        results: from `analyze` or `analyze_counts`.
        responses: the answers, if there are any.
    """
    counts = np.array(results["counts"], dtype=np.int64)
    labels, signalled = results["labels"], results["emotions"]
    files = {
        "results.json": json.dumps(results, indent=2, ensure_ascii=False, allow_nan=False) + "\n",
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
    rows = table.astype(object).where(table.notna(), "").itertuples(index=False, name=None)
    return csv_text(list(map(str, table.columns)), rows)


def test_rows(results: Block) -> list[list[str]]:
    """Return a row of tests for each emotion, of the whole study and of each level of each group."""
    rows = _rows("", "", results)
    for column, levels in results["groups"].items():
        for level, block in levels.items():
            rows += _rows(column, level, block)
    return rows


def tests_latex(results: Block) -> str:
    """Return the tests of the whole study as a booktabs table."""
    lines = []
    for name, fit in results["goodness_of_fit"].items():
        found = results["recognition"][name]
        cells = (
            latex_text(name.capitalize()),
            f"{found['hits']}/{found['n']}",
            _interval(found),
            _fixed(fit["statistic"], 2),
            _p(fit["p"]),
            _p(fit["p_exact"]),
            _fixed(fit["cohens_w"], 2),
            _p(found["p_holm"]),
            _fixed(found["hu"], 2),
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


def _rows(column: str, level: str, block: Block) -> list[list[str]]:
    rows = []
    for name, fit in block["goodness_of_fit"].items():
        values = {**fit, **block["recognition"][name]}
        cells = ["" if values[key] is None else form.format(values[key]) for key, _, form in _TESTS]
        rows.append([column, level, name, *cells])
    return rows


def _interval(found: Block) -> str:
    if found["rate"] is None:
        return "--"
    return f"{100 * found['rate']:.1f} [{100 * found['ci_low']:.1f}, {100 * found['ci_high']:.1f}]"


def _fixed(value: float | None, decimals: int) -> str:
    return "--" if value is None else f"{value:.{decimals}f}"


def _p(p: float) -> str:
    return "$<$ .001" if p < 0.001 else f"{p:.3f}".removeprefix("0")
