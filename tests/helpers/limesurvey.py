"""A structure file as LimeSurvey reads it: rows as parsed by PHP, and texts as participants see them."""

import csv
import html
import io
import re
from html.parser import HTMLParser


def rows_of(text: str) -> list[dict[str, str]]:
    r"""Return the rows of a structure file as LimeSurvey imports them.

    In quotes, fgetcsv of PHP reads \" as two characters rather than the end, and the importer removes quotes around a
    cell once more, for files from Excel. Both are done here by hand, to compare with the csv module of Python.
    """
    lines = [_cells(line) for line in re.sub(r"\r\n?", "\n", text).split("\n") if line]
    header = [re.sub(r"^\W+", "", lines[0][0]), *lines[0][1:]]
    rows = [{name: _unquoted(cell) for name, cell in zip(header, cells, strict=True)} for cells in lines[1:]]
    plain = csv.DictReader(io.StringIO(text.removeprefix("\ufeff")), delimiter="\t")
    assert rows == list(plain), "PHP and Python read other cells"
    return rows


def _cells(line: str) -> list[str]:
    """Split a line as fgetcsv($handle, 0, "\\t", '"') does, with its escape character."""
    cells, cell, quoted, place = [], "", False, 0
    while place < len(line):
        mark = line[place]
        if quoted and mark == "\\" and line[place + 1 : place + 2] == '"':
            cell, place = cell + '\\"', place + 1
        elif quoted and mark == '"' and line[place + 1 : place + 2] == '"':
            cell, place = cell + '"', place + 1
        elif mark == '"' and (quoted or not cell):
            quoted = not quoted
        elif mark == "\t" and not quoted:
            cells.append(cell)
            cell = ""
        else:
            cell += mark
        place += 1
    return [*cells, cell]


def _unquoted(cell: str) -> str:
    return cell[1:-1].replace('""', '"') if re.fullmatch(r'".*"', cell, re.DOTALL) else cell


class _Seen(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.paragraphs: list[str] = [""]
        self.hidden, self.links = "", []
        self._in_hidden = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._in_hidden = tag == "span" and ("style", "display:none") in attrs
        if tag in ("p", "br"):
            self.paragraphs.append("")
        self.links += [value for name, value in attrs if name in ("href", "src")]

    def handle_endtag(self, tag: str) -> None:
        if tag == "span":
            self._in_hidden = False

    def handle_data(self, data: str) -> None:
        if self._in_hidden:
            self.hidden += data
        else:
            self.paragraphs[-1] += data


def seen(text: str) -> list[str]:
    """Return the paragraphs displayed by a browser."""
    page = _Seen()
    page.feed(text)
    page.close()
    return [part for part in page.paragraphs if part]


def links(text: str) -> list[str]:
    """Return the addresses of links and videos."""
    page = _Seen()
    page.feed(text)
    return page.links


def heading(text: str) -> str:
    """Return the header of a question in an export with full question texts: the text without tags."""
    return re.sub(r"<[^>]*>", "", text)


_META = {
    "code": ("id", "submitdate", "lastpage", "startlanguage", "seed"),
    "full": ("Antwort ID", "Datum Abgeschickt", "Letzte Seite", "Start-Sprache", "Zufallsgeneratorstartwert"),
}


def answers_text(rows: list[dict[str, str]], people: list[dict[str, str]], headings: str, *, full: bool) -> str:
    """Return the export of answers as LimeSurvey writes it: BOM, semicolons, quotes everywhere, CRLF.

    Args:
        rows: of the structure file.
        people: for each participant, the answer code or text to each question that was shown, by its name.
        headings: "code" for question codes, "full" for question texts (here with a German interface), "codetext".
        full: whether answers are texts rather than codes.
    """
    asked = [row for row in rows if row["class"] == "Q" and row["type/scale"] != "*"]
    codes = {row["name"]: _answers_of(rows, row["name"]) for row in asked}
    meta = _META["full" if headings == "full" else "code"]
    header = [f"{name}. {name}" if headings == "codetext" else name for name in meta]
    header += [_title(rows, row, headings) for row in asked]
    lines = [header]
    for number, given in enumerate(people, start=1):
        cells = [given.get(row["name"], "") for row in asked]
        if full:
            cells = [html.unescape(codes[row["name"]].get(cell, cell)) for row, cell in zip(asked, cells, strict=True)]
        lines.append([str(number), "1980-01-01 00:00:00", "9", "de", str(500 + number), *cells])
    text = io.StringIO()
    csv.writer(text, delimiter=";", quoting=csv.QUOTE_ALL, lineterminator="\r\n").writerows(lines)
    return "\ufeff" + text.getvalue()


def _answers_of(rows: list[dict[str, str]], question: str) -> dict[str, str]:
    found, inside = {}, False
    for row in rows:
        inside = row["name"] == question if row["class"] == "Q" else inside
        if inside and row["class"] == "A":
            found[row["name"]] = row["text"]
    return found


def _title(rows: list[dict[str, str]], row: dict[str, str], headings: str) -> str:
    name, text = row["name"], heading(row["text"])
    if row["type/scale"] == "K":  # a slider, with its subquestion
        ends = next(other["text"] for other in rows[rows.index(row) :] if other["class"] == "SQ")
        name, text = f"{name}[SQ1]", f"{text} [{ends}]"
    return {"code": name, "full": text, "codetext": f"{name}. {text}"}[headings]
