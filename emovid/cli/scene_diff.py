"""`emovid scene diff`: the keys that differ between two scenes."""

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import typer

from emovid.cli.options import Json, Scene

if TYPE_CHECKING:
    from emovid.scene.difference import Difference

_SHOWN = 60  # characters of a value in the table; --json has all


def diff(first: Scene, second: Scene, as_json: Json = False) -> None:
    """List the keys that differ between two scenes; exit with 1 if any does, with 0 if none.

    Every key counts with its value, written or by default; comments do not.

    Examples: emovid scene diff anger my.yaml · emovid scene diff fear disgust --json
    """
    from emovid.scene.difference import differences
    from emovid.scene.load import load_scene

    found = differences(load_scene(first), load_scene(second))
    if as_json:
        rows = [{"key": row.key} | _present(first=row.first, second=row.second) for row in found]
        typer.echo(json.dumps({"first": first, "second": second, "differences": rows}, indent=2))
    elif found:
        _show(first, second, found)
    if found:
        raise typer.Exit(1)


def _present(**values: Any) -> dict[str, Any]:
    from emovid.scene.difference import ABSENT

    return {name: value for name, value in values.items() if value is not ABSENT}


def _show(first: str, second: str, rows: "Sequence[Difference]") -> None:
    """Print a line for each key: the key, and its value in the one scene and in the other."""
    cells = [("key", first, second), *((row.key, _text(row.first), _text(row.second)) for row in rows)]
    key, value = (max(len(row[column]) for row in cells) for column in (0, 1))
    for row in cells:
        typer.echo(f"{row[0]:<{key}}  {row[1]:<{value}}  {row[2]}")


def _text(value: Any) -> str:
    """Return a value as it stands in a scene; a dash for a key that is not there."""
    from emovid.scene.difference import ABSENT

    text = "-" if value is ABSENT else value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
