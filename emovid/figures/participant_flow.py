"""The flow of participants from the exports to the analysis, like CONSORT's (K. Schulz et al., BMJ 340, 2010)."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emovid.figures.style import INK, POINTS, QUIET, SINGLE_COLUMN, TEXT, in_style, settle, wrapped
from emovid.statistics.results import Flow

_LINE, _PAD, _GAP = 1.35 * TEXT, 5.0, 16.0  # height of a line, margin in a box, and gap between boxes [pt]
_MAIN = 0.4  # share of the width that the boxes of the main flow take
_BESIDE = 14.0  # from the main flow to the boxes beside it [pt]
_MARGIN = 1.0  # around the figure [pt]


@in_style()
def flow_figure(flow: Flow, answers: int, *, width: float = SINGLE_COLUMN) -> Figure:
    """Draw the numbers of participants enrolled, excluded by reason and analyzed, and the numbers of answers.

    Args:
        flow: the numbers.
        answers: number of answers that are analyzed.
        width: of the figure [in].
    """
    across = width * POINTS
    room = across * (1 - _MAIN) - _BESIDE - 2 * _PAD - 2 * _MARGIN
    reasons = {reason: n for reason, n in flow.excluded.items() if n}
    out = _lines("Excluded", "participants", reasons, room) if reasons else []
    rows = {reason: n for reason, n in flow.left_out.items() if n}
    if flow.rejected:
        rows["could not be used"] = flow.rejected
    left = _lines("Left out", "rows or cells", rows, room) if rows else []
    main = [["Enrolled", f"n = {flow.enrolled}"], ["Analyzed", f"n = {flow.analyzed}"], ["Answers", f"{answers}"]]
    gaps = [max(_GAP, _height(side) + _GAP) if side else _GAP for side in (out, left)]
    height = 3 * _height(main[0]) + sum(gaps) + 2 * _MARGIN
    figure = Figure(figsize=(width, height / POINTS))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, across)
    axes.set_ylim(height, 0)
    axes.set_axis_off()
    top, middle = _MARGIN, _MARGIN + across * _MAIN / 2
    for lines, gap, side in zip(main, [*gaps, 0.0], [out, left, []], strict=True):
        _box(axes, _MARGIN, top, across * _MAIN, lines, "center")
        top += _height(lines)
        if gap:
            _arrow(axes, (middle, top), (middle, top + gap))
        if side:
            at = top + (gap - _height(side)) / 2
            _arrow(axes, (middle, top + gap / 2), (across * _MAIN + _BESIDE, top + gap / 2))
            _box(axes, across * _MAIN + _BESIDE, at, across - _MARGIN - across * _MAIN - _BESIDE, side, "left")
        top += gap
    return settle(figure)


def _lines(head: str, unit: str, reasons: dict[str, int], room: float) -> list[str]:
    """Return the lines of a box beside the flow: the sum, then each reason with its number, within a room [pt]."""
    lines = [f"{head}: {sum(reasons.values())} {unit}"]
    for reason, n in reasons.items():
        first, *more = wrapped(f"{n} {reason}", room)
        lines += [first, *(f"   {line}" for line in more)]
    return lines


def _height(lines: list[str]) -> float:
    return len(lines) * _LINE + 2 * _PAD


def _box(axes: Axes, left: float, top: float, width: float, lines: list[str], align: str) -> None:
    edges = [left, left + width, left + width, left, left], [top, top, top + _height(lines), top + _height(lines), top]
    axes.plot(*edges, color=INK, linewidth=0.6)
    at = left + width / 2 if align == "center" else left + _PAD
    for i, line in enumerate(lines):
        weight = "bold" if i == 0 else "normal"
        axes.text(at, top + _PAD + (i + 0.5) * _LINE, line, ha=align, va="center_baseline", weight=weight)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate(
        "", end, start, arrowprops={"arrowstyle": "-|>", "color": QUIET, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    )
