"""`report.html`: the results as one self-contained page.

The text of the page is in `report.html.jinja`; this module chooses what it shows.
"""

from base64 import b64encode
from collections.abc import Iterator, Mapping
from itertools import count
from math import isnan
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined

from emovid.report import apa
from emovid.responses.responses import Responses
from emovid.statistics.analyze import beyond_popularity
from emovid.statistics.groups import Pair
from emovid.statistics.recognition import AgainstChance, Recognition
from emovid.statistics.results import AnswerResults, GroupDifferences, StudyResults

STANDS_OUT = 1.96  # of a standard normal: two-sided 5 %
_METHODS = {
    "exact": "two-sided Fisher's exact test",
    "Monte Carlo": "Fisher, Freeman and Halton's test by Monte Carlo",
    "permutation": "studentized permutation of participants",
}


class Picture(NamedTuple):
    """A figure of the page: its number, its caption, and its SVG in base64."""

    number: int
    caption: str
    data: str


class GroupTable(NamedTuple):
    """Content of the page about one group."""

    title: str
    figure: str
    found: GroupDifferences
    levels: list[dict[str, str]]
    rows: list[dict[str, Any]]
    method: str
    order: str


def report_html(
    results: StudyResults, responses: Responses | None, figures: Mapping[str, tuple[str, bytes]] | None = None
) -> str:
    """Return the page.

    Args:
        results: from `analyze` or `analyze_counts`.
        responses: the answers, if there are any.
        figures: by file name, the caption and the SVG.
    """
    tables = count(1)
    return (
        _environment()
        .get_template("report.html.jinja")
        .render(
            results=results,
            flow=results.flow,
            origin=results.flow.origin if results.flow else "",
            asked=_asked(results),
            rules=_rules(results),
            people=list(_people(responses)) if responses is not None else [],
            h1=_h1(results),
            chance=apa.number(100 / len(results.labels), 1),
            beyond=STANDS_OUT,
            stand_out=_stand_out(results),
            bias=_bias(results),
            groups=[_group(name, results, found, figures or {}) for name, found in results.group_differences.items()],
            residuals=_residuals(results),
            monte_carlo=any(fit.draws for fit in results.goodness_of_fit.values()),
            methods=methods_text(results),
            figures={
                name: Picture(number, caption, b64encode(svg).decode())
                for number, (name, (caption, svg)) in enumerate((figures or {}).items(), start=1)
            },
            table=lambda: next(tables),
        )
    )


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("emovid.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        auto_reload=False,
        keep_trailing_newline=True,
    )
    environment.filters |= {
        "apa": apa.sentence,
        "exact": apa.exact_p,
        "p": lambda p: apa.p_value(p, "").strip().removeprefix("= "),
        "number": apa.number,
        "bayes": lambda value: apa.bayes_factor(value, "").strip().removeprefix("= "),
        "rate": _rate,
        "rate_of": _rate_of,
        "hu": _hu,
        "credible": _credible,
        "points": _points,
    }
    return environment


def _asked(results: StudyResults) -> str:
    videos = f"{results.n_videos} videos" if results.n_videos else "videos"
    of = f"{len(results.emotions)} emotions"
    choices = f"one answer to each from {len(results.labels)}: {', '.join(results.labels)}"
    if results.n_participants is None:
        return f"{results.n_responses} answers to {videos} of {of}, {choices}; participants are not known."
    return f"{results.n_participants} participants gave {results.n_responses} answers to {videos} of {of}, {choices}."


def _rules(results: StudyResults) -> str:
    if results.flow is None or not results.flow.rules:
        return "No rule of exclusion was given to the analysis."
    return f"Rules of exclusion: {', '.join(results.flow.rules)}."


def _people(responses: Responses) -> Iterator[tuple[str, str, str, str]]:
    total = len(responses.participants)
    for column in responses.participants.columns:
        for level, n in responses.participants[column].value_counts().sort_index().items():
            yield column.replace("_", " "), str(level) or "not said", str(n), f"{100 * n / total:.1f}"


def _h1(results: StudyResults) -> dict[str, Any]:
    tested = [test for test in results.recognition.values() if test.n]
    above = sum(test.above_chance for test in tested)
    holds = "is supported" if above == len(tested) else "is supported in part" if above else "is not supported"
    return {"above": above, "tested": len(tested), "holds": holds, "popular": beyond_popularity(results, False)}


def _rate(test: AgainstChance) -> str:
    if not test.n:
        return "\N{EN DASH}"
    return f"{100 * test.rate:.1f} [{100 * test.ci_low:.1f}, {100 * test.ci_high:.1f}]"


def _rate_of(test: AgainstChance) -> str:
    return f"{test.hits}/{test.n}: {_rate(test)}" if test.n else "\N{EN DASH}"


def _hu(found: Recognition) -> str:
    if isnan(found.hu):
        return "\N{EN DASH}"
    return f"{found.hu:.2f}" + ("" if isnan(found.hu_low) else f" [{found.hu_low:.2f}, {found.hu_high:.2f}]")


def _credible(found: Recognition) -> str:
    if isnan(found.bayes_low):
        return "\N{EN DASH}"
    return f"[{100 * found.bayes_low:.1f}, {100 * found.bayes_high:.1f}]"


def _points(pair: Pair, named: bool = False) -> str:
    if named:
        return f"{pair.levels[0]} \N{MINUS SIGN} {pair.levels[1]}: {_points(pair)}"
    if isnan(pair.difference):
        return "\N{EN DASH}"
    low, high, points = (apa.number(100 * value, 1) for value in (pair.ci_low, pair.ci_high, pair.difference))
    shown = "" if pair.equivalent is None else f", {apa.equivalence(pair)}"
    return f"{points} [{low}, {high}]{shown}"


def _stand_out(results: StudyResults) -> str:
    """Return the wrong answers that were given more often than their margins have it, the clearest first."""
    found = [
        (float(residual), f"{name} as {label} ({residual:.1f})")
        for label, row in zip(results.labels, results.adjusted_residuals, strict=True)
        for name, residual in zip(results.emotions, row, strict=True)
        if residual > STANDS_OUT
    ]
    return ", ".join(words for _, words in sorted(found, reverse=True))


def _bias(results: StudyResults) -> str:
    if results.dependence is None:
        return ""
    bias = results.dependence.label_use.bias
    return ", ".join(f"{name} {apa.number(value)}" for name, value in zip(results.labels, bias, strict=True))


def _residuals(results: StudyResults) -> list[tuple[str, list[str]]]:
    return [
        (label, ["" if isnan(cell) else apa.number(float(cell), 1) for cell in row])
        for label, row in zip(results.labels, results.adjusted_residuals, strict=True)
    ]


def _group(
    name: str, results: StudyResults, found: GroupDifferences, figures: Mapping[str, tuple[str, bytes]]
) -> GroupTable:
    levels: Mapping[str, AnswerResults] = results.groups[name]
    title = name.replace("_", " ")
    methods = dict.fromkeys(_METHODS[test.method] for test in found.videos.values() if not isnan(test.p))
    orders = [f"{pair.levels[0]} minus {pair.levels[1]}" for pair in next(iter(found.videos.values())).pairs]
    return GroupTable(
        title=title,
        figure=next(
            (key for key, (caption, _) in figures.items() if caption.startswith(f"Share of right answers by {title},")),
            "",
        ),
        found=found,
        levels=[{"title": f"{level} (n = {block.n_participants})"} for level, block in levels.items()],
        rows=[
            {"emotion": emotion, "levels": [block.recognition[emotion] for block in levels.values()], "test": test}
            for emotion, test in found.videos.items()
        ],
        method=" or ".join(methods) or "nothing to compare",
        order="; ".join(orders) or "of one level alone",
    )


def _goodness_method(results: StudyResults, several: bool) -> str:
    if several:
        return (
            "Goodness of fit to equal shares was tested by permuting each participant's answers over the labels "
            "(quadratic statistic, 9,999 Monte Carlo draws)."
        )
    drawn = any(fit.draws for fit in results.goodness_of_fit.values())
    return "Goodness of fit to equal shares was tested by Pearson's chi-squared with an exact p value" + (
        " or 9,999 Monte Carlo draws." if drawn else "."
    )


def methods_text(results: StudyResults) -> str:
    """Return a paragraph on the methods, to paste into a paper."""
    seed = results.provenance.seed if results.provenance else 0
    version = f" (version {results.provenance.version})" if results.provenance else ""
    several = any(test.method != "exact binomial" for test in results.recognition.values())
    parts = [
        f"Answers were analyzed with emovid{version}; the seed of all random draws was {seed}.",
        "Recognition of each emotion was tested against guessing "
        f"(1/{len(results.labels)}) by a one-sided exact "
        + ("permutation test that keeps each participant's answers together" if several else "binomial test")
        + f", with Holm's (1979) correction over {_h1(results)['tested']} emotions at an alpha of .05.",
        "Rates have Wilson's (1927) two-sided 95% intervals"
        + (", with the effective number of answers (Korn & Graubard, 1998)" if several else "")
        + ", which are not corrected for multiple comparisons.",
        _goodness_method(results, several),
    ]
    if results.flow is not None and results.flow.rules:
        parts.append(f"Rules of exclusion were set beforehand ({', '.join(results.flow.rules)}).")
    if results.dependence is not None:
        parts.append(
            "Unbiased hit rates (Wagner, 1993) and mutual information have 95% intervals from "
            f"{results.information.draws:,} bootstrap samples of participants."
        )
    parts.append(
        "Confusions were compared with quasi-independence (Goodman, 1968); their distance on the circumplex (Russell, "
        "1980) was tested one-sided with both margins of the errors given."
    )
    if results.group_differences:
        planned = {found.confirmatory for found in results.group_differences.values()}
        role = "named beforehand" if planned == {True} else "not named beforehand, so these tests are exploratory"
        parts.append(
            f"Groups ({', '.join(name.replace('_', ' ') for name in results.group_differences)}) were {role}; mean "
            "scores were compared by a two-sided studentized permutation test, rates by Fisher's exact test or by "
            "permutation, with Newcombe's (1998) intervals and Holm's correction over all groups and emotions."
        )
    return " ".join(parts)
