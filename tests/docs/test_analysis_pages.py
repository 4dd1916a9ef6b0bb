"""Every survey tool has a page whose commands are run on an export of the tool."""

import pytest

from emovid.responses.dialects.registry import DIALECTS
from tests.helpers.pages import DOCS, EXAMPLES, ROOT, follow, pages, steps

FOLLOWED = [page for page in pages() if page.parent.name == "analyse" and any(steps(page))]


@pytest.mark.parametrize("page", FOLLOWED, ids=lambda page: page.stem)
def test_commands_of_a_tool_page_work_as_described(page, tmp_path) -> None:
    follow(page, tmp_path)


def test_the_readme_counts_the_tools() -> None:
    of_no_tool = {"emovid survey", "long table", "wide table"}
    assert len({dialect.name for dialect in DIALECTS} - of_no_tool) == len(EXAMPLES) - 2 == 23
    assert "any of 23 tools" in " ".join((ROOT / "README.md").read_text().split())


def test_every_tool_has_a_page_and_every_page_an_export() -> None:
    assert {page.stem for page in (DOCS / "analyse").glob("*.md")} == set(EXAMPLES)
