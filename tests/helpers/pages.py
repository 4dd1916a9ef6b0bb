"""The commands of a page, with what the page says they print."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
DOCS = ROOT / "docs"

_BLOCKS = re.compile(
    r'^```(?P<kind>[a-z]+)(?: title="(?P<title>[^"]*)")?\n(?P<text>.*?)^```$|(?P<indented>(?:^    emovid [^\n]*\n)+)',
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Command:
    """A command line; what is printed is None where the page does not say."""

    line: str
    printed: str | None = None


@dataclass(frozen=True)
class Keys:
    """Keys to write into a YAML file, over those that are there."""

    file: str
    text: str


def pages() -> list[Path]:
    """Return the README and the pages of the documentation."""
    return [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


def mentioned(page: Path) -> list[str]:
    """Return the commands that a page names within its text or a table."""
    return re.findall(r"`(emovid [^`]*)`", page.read_text().replace("\n", " "))


def in_tables(page: Path) -> list[str]:
    """Return the commands in the cells of a page's tables."""
    rows = re.findall(r"^\|.*\|$", page.read_text(), re.MULTILINE)
    return [command for row in rows for command in re.findall(r"`(emovid [^`]*)`", row)]


def steps(page: Path) -> Iterator[Command | Keys]:
    """Yield what a reader of the page does, in order."""
    for block in _BLOCKS.finditer(page.read_text()):
        if block["indented"]:
            for line in block["indented"].splitlines():
                yield Command(line.split(" #")[0].strip())
        elif block["kind"] == "console":
            for part in re.split(r"^\$ ", block["text"], flags=re.MULTILINE)[1:]:
                line, _, printed = part.partition("\n")
                yield Command(line, printed)
        elif block["kind"] == "yaml" and (block["title"] or "").split(":")[0].endswith(".yaml"):
            yield Keys(block["title"].split(":")[0], block["text"])


def agrees(said: str, printed: str) -> bool:
    """Return whether a command said what a page prints, where `...` stands for anything, as may columns of spaces."""
    parts = [re.escape(" ".join(part.split())) for part in printed.split("...")]
    return re.fullmatch(r".*".join(parts), " ".join(said.split()), re.DOTALL) is not None
