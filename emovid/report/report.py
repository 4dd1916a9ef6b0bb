"""`report.html`: the results as one page that needs nothing else, to read, to print and to send."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from emovid.responses.responses import Responses

Block = Mapping[str, Any]

_STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 62rem; margin: 2rem auto;
  padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem; text-align: right; border-bottom: 1px solid #e4e4e4; }
th:first-child, td:first-child, .said td, .said th { text-align: left; }
thead th { border-bottom: 2px solid #888; vertical-align: bottom; }
td.right { font-weight: 700; background: #eef3f8; }
figure { display: inline-block; margin: .5rem 1.5rem .5rem 0; vertical-align: top; }
figure img { max-width: 100%; zoom: 1.3; }
figcaption { font-size: .85rem; color: #555; max-width: 24rem; }
.warnings li { margin: .3rem 0; } .quiet { color: #555; font-size: .85rem; overflow-wrap: anywhere; }
.wide { overflow-x: auto; }
@media print { body { margin: 0; max-width: none; } h2 { break-after: avoid; } table, figure { break-inside: avoid; } }
"""

_STANDS_OUT = 1.96  # of a standard normal: two-sided 5 %

_DEPENDENCE = (
    ("total_recognition", "All answers against those that each participant would give at random"),
    ("cochran_q", "Cochran’s Q: do videos differ in recognition?"),
    ("fleiss_kappa", "Agreement of participants"),
    ("label_use", "Are some labels preferred, whatever is shown?"),
    ("order", "Recognition over the positions in which videos were shown"),
)


def report_html(results: Block, responses: Responses | None, figures: Mapping[str, tuple[str, bytes]]) -> str:
    """Return the page.

    Args:
        results: from `analyze` or `analyze_counts`.
        responses: the answers, if there are any.
        figures: by caption, the kind of picture ("png", "svg+xml") and its bytes.
    """
    parts = [
        _participants(results, responses),
        _hypothesis(results),
        _section("Confusion matrix", _matrix(results)),
        _section("Figures", "".join(_figure(caption, *picture) for caption, picture in figures.items())),
        _section("Tests, video by video", _videos(results)),
        _section("Tests of the whole", _whole(results)),
        *(_group(column, results["groups"][column], found) for column, found in results["group_differences"].items()),
        _section("Warnings", _list(results["warnings"], "warnings") or "<p>None.</p>"),
        _section("Where this comes from", _provenance(results)),
    ]
    body = "\n".join(part for part in parts if part)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Recognition of emotions</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f"<h1>Recognition of emotions</h1>\n{body}\n</body>\n</html>\n"
    )


def _participants(results: Block, responses: Responses | None) -> str:
    if responses is None:
        return _section("Participants", f"<p>{results['n_responses']} answers; participants are not known.</p>")
    total = len(responses.participants)
    rows = [
        [column.replace("_", " "), level or "not said", str(often), f"{100 * often / total:.1f} %"]
        for column in responses.participants.columns
        for level, often in responses.participants[column].value_counts().sort_index().items()
    ]
    table = _table(["Group", "Level", "n", "%"], rows) if rows else ""
    return _section("Participants", f"<p>{total} participants gave {results['n_responses']} answers.</p>{table}")


def _hypothesis(results: Block) -> str:
    found = {name: test for name, test in results["recognition"].items() if test["n"]}
    above = [name for name, test in found.items() if test["above_chance"]]
    said = f"{len(above)} of {len(found)} emotions were recognised above chance (exact binomial, Holm)."
    holds = "is supported" if len(above) == len(found) else "is supported in part" if above else "is not supported"
    rows = [
        [
            name.capitalize(),
            f"{test['hits']}/{test['n']}",
            "" if test["rate"] is None else f"{100 * test['rate']:.2f} %",
            test["verdict"],
            "above chance" if test["above_chance"] else "not above chance",
        ]
        for name, test in found.items()
    ]
    table = _table(["Emotion", "Hits", "Rate", "Verdict", "Against chance"], rows)
    intro = f"<p>That participants do better than chance {holds}: {said}</p>"
    return _section("H1: overall classification", intro + table)


def _matrix(results: Block) -> str:
    head = "".join(f"<th>{escape(name.capitalize())}</th>" for name in results["emotions"])
    rows = []
    for i, label in enumerate(results["labels"]):
        cells = "".join(
            f"<td{' class=right' if label == name else ''}>{_share(results['percent'][i][j])}"
            f"<br><span class=quiet>{results['counts'][i][j]}</span></td>"
            for j, name in enumerate(results["emotions"])
        )
        rows.append(f"<tr><td>{escape(label.capitalize())}</td>{cells}</tr>")
    top = f"<tr><th></th><th colspan={len(results['emotions'])}>Signaled emotion</th></tr>"
    head = f"<tr><th>Response (%)</th>{head}</tr>"
    return f"<div class=wide><table><thead>{top}{head}</thead><tbody>{''.join(rows)}</tbody></table></div>"


def _videos(results: Block) -> str:
    rows = [
        [
            name.capitalize(),
            fit["apa"],
            fit["apa_exact"],
            results["recognition"][name]["apa"],
            _hu(results["recognition"][name]),
        ]
        for name, fit in results["goodness_of_fit"].items()
    ]
    heads = ["Emotion", "Against equal shares", "The same, exact", "Recognition against chance", "Unbiased hit rate"]
    return f'<div class="wide said">{_table(heads, rows)}</div>'


def _whole(results: Block) -> str:
    rows = [[what, results["dependence"][key]["apa"]] for key, what in _DEPENDENCE if results["dependence"].get(key)]
    rows.append(["Do confusions fall on near neighbours of the circumplex?", results["near_neighbours"]["apa"]])
    rows.append([f"Answers that stand out (adjusted residual beyond {_STANDS_OUT})", _residuals(results) or "none"])
    for pole, found in results["collapsed"].items():
        rows += [[f"Right {pole} of {name}", test["apa"]] for name, test in found["videos"].items()]
    return f"<div class=said>{_table(['What', 'Result'], rows)}</div>"


def _residuals(results: Block) -> str:
    """Return the wrong answers that were given more often than rows and columns alone would have it."""
    found = [
        (residual, f"{name} as {label} ({residual:.1f})")
        for label, row in zip(results["labels"], results["adjusted_residuals"], strict=True)
        for name, residual in zip(results["emotions"], row, strict=True)
        if label != name and residual is not None and residual > _STANDS_OUT
    ]
    return ", ".join(words for _, words in sorted(found, reverse=True))


def _group(column: str, levels: Block, found: Block) -> str:
    """Return each level's own tests, as in the paper, and those of the differences between levels."""
    heads = ["Emotion", *(f"{level} (n = {block['n_participants']})" for level, block in levels.items())]
    own = [[name.capitalize(), *(_own_test(block, name) for block in levels.values())] for name in found["videos"]]
    rows = [["All videos", found["scores"]["apa"], _pairs(found["scores"])]]
    rows += [[name.capitalize(), test["apa"], _pairs(test)] for name, test in found["videos"].items()]
    body = f"<p>Each group against equal shares:</p>{_table(heads, own)}<p>Differences between groups:</p>"
    body += _table(["Video", "Test", "Difference"], rows)
    return _section(f"By {column.replace('_', ' ')}", f'<div class="wide said">{body}</div>')


def _own_test(block: Block, name: str) -> str:
    found, fit = block["recognition"][name], block["goodness_of_fit"][name]
    return f"{found['hits']}/{found['n']}, {fit['apa']}"


def _pairs(test: Block) -> str:
    return "; ".join(f"{pair['levels'][0]} less {pair['levels'][1]}: {pair['apa']}" for pair in test["pairs"])


def _provenance(results: Block) -> str:
    known = results.get("provenance", {})
    lines = [f"{item['file']}: {item['dialect']}, SHA-256 {item['sha256']}" for item in known.get("inputs", [])]
    if known.get("key_sha256"):
        lines.append(f"key: SHA-256 {known['key_sha256']}")
    if known.get("version"):
        lines.append(f"emovid {known['version']}, seed {known.get('seed')}")
    return _list(lines, "quiet")


def _figure(caption: str, kind: str, data: bytes) -> str:
    source = f"data:image/{kind};base64,{b64encode(data).decode()}"
    text = escape(caption)
    return f'<figure><img src="{source}" alt="{text}"><figcaption>{text}</figcaption></figure>'


def _section(title: str, body: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{body}</section>" if body else ""


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _list(items: Sequence[str], kind: str) -> str:
    return f"<ul class={kind}>" + "".join(f"<li>{escape(item)}</li>" for item in items) + "</ul>" if items else ""


def _share(share: float | None) -> str:
    return "" if share is None else f"{share:.2f}"


def _hu(found: Block) -> str:
    if found["hu"] is None:
        return ""
    if found.get("hu_low") is None:
        return f"{found['hu']:.2f}"
    return f"{found['hu']:.2f} [{found['hu_low']:.2f}, {found['hu_high']:.2f}]"
