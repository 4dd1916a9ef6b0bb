"""Rules for the shape of the code that the linters do not know: short functions, and commands that only declare."""

import ast
from collections.abc import Iterator
from pathlib import Path

from emovid.cli.main import COMMANDS, GROUPS

PACKAGE = Path(__file__).parent.parent / "emovid"
SOURCES = {
    entry.source for entries in (COMMANDS, *(listed for _, listed in GROUPS.values())) for entry in entries
}  # "module:function"


def functions() -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{path.relative_to(PACKAGE)}:{node.name}", node


def body_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return how many lines the statements of a function take, without its docstring."""
    statements = node.body[1:] if ast.get_docstring(node) else node.body
    return node.end_lineno - statements[0].lineno + 1 if statements else 0


def test_no_function_is_longer_than_sixty_lines() -> None:
    assert [name for name, node in functions() if body_lines(node) > 60] == []


def test_command_functions_are_short() -> None:
    commands = {f"cli/{source.replace(':', '.py:')}" for source in SOURCES}
    lengths = {name: body_lines(node) for name, node in functions() if name in commands}
    assert lengths.keys() == commands
    assert {name: length for name, length in lengths.items() if length >= 40} == {}
