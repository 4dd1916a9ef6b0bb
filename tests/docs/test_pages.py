"""Every command of every page runs and prints the output shown on the page."""

import shlex

import pytest

from emovid.cli.main import all_commands
from tests.helpers.pages import DOCS, ROOT, follow, mentioned, pages, steps

# Three test modules share the pages, so that they can run at the same time.
FOLLOWED = [
    page
    for page in pages()
    if page.stem not in ("README", "tutorial") and page.parent.name != "analyse" and any(steps(page))
]


@pytest.mark.parametrize("page", FOLLOWED, ids=lambda page: str(page.relative_to(DOCS)))
def test_commands_of_a_page_work_as_described(page, tmp_path) -> None:
    follow(page, tmp_path)


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_named_in_text_exist_with_their_options(page) -> None:
    for line in mentioned(page):
        words = shlex.split(line.replace("...", "x"))[1:]
        command = all_commands()
        while hasattr(command, "commands"):
            if not words or words[0].isupper() or words[0].startswith("-"):  # COMMAND, or a global option
                break
            assert words[0] in command.commands, line
            command = command.commands[words.pop(0)]
        known = {name for option in command.params for name in option.opts}
        given_options = {word.split("=")[0] for word in words if word.startswith("-")}
        assert given_options <= known | {"--help", "--install-completion", "--show-completion"}, line
