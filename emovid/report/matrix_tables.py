"""The confusion matrix as CSV to compute with, and as Markdown and LaTeX to print, laid out as the paper's Table III.

Rows are the perceived labels, columns the signalled ones.
"""

from collections.abc import Sequence

import numpy as np

from emovid.csv_writer import csv_text
from emovid.responses.results_files import CORNER, PERCENT
from emovid.statistics.confusion import Counts, percent


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


def latex_text(text: str) -> str:
    """Return text as LaTeX shows it, with what it would take for a command escaped."""
    words = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    return "".join(words.get(mark, f"\\{mark}" if mark in "&%$#_{}" else mark) for mark in text)


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
